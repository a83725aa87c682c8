"""The robot model and the transforms put the tip where the mechanism has it."""

from dataclasses import replace
import math
from pathlib import Path
import xml.etree.ElementTree as ET

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
import yaml

from billiard_shot import Scene
from billiard_shot.cli import main
from billiard_shot.cue.mechanism import (
    Alignment,
    Axis,
    AZIMUTH_JOINT,
    BASE_X,
    BASE_Y,
    BASE_Z,
    INCLINE,
    Incline,
    JOINTS,
    Mechanism,
    MovingPart,
    STROKE,
)
from billiard_shot.cue.model import (
    forward_kinematics,
    home,
    joints_of,
    transforms,
    travel_pivot_height,
    urdf_of,
)

OTHER = Mechanism(
    reach=0.2,
    axis_drop=0.11,
    incline=Axis(0.35, 0.6, 0.1, 0.5, 5.0),
    max_elevation=0.8,
    incline_geometry=Incline(base=0.4, arm=0.25, level_angle=1.1),
)
ALIGNED = Mechanism(alignment=Alignment(0.01, -0.02, 2.0, 0.004, -0.003, 0.97, 0.0, 1.02, 0.5))
MECHANISMS = pytest.mark.parametrize('mechanism', [Mechanism(), OTHER])


def numbers(text):
    return np.array([float(word) for word in (text or '0 0 0').split()])


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def matrix(turn, way):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn, way
    return result


def rotation_of(quaternion):
    *vector, w = quaternion
    angle = 2 * math.atan2(np.linalg.norm(vector), w)
    return rotation(np.array(vector) / (np.linalg.norm(vector) or 1.0), angle)


def poses_of(urdf, positions):
    """Pose (4, 4) of every link of a URDF in its root, as the format defines it."""
    robot = ET.fromstring(urdf)
    joints = {joint.find('child').get('link'): joint for joint in robot.findall('joint')}

    def pose(link):
        if link not in joints:
            return np.eye(4)
        joint = joints[link]
        origin, axis = joint.find('origin'), joint.find('axis')
        if origin is not None:
            roll, pitch, yaw = numbers(origin.get('rpy'))
            assert roll == pitch == 0.0  # not read here
        turn = rotation(np.array([0.0, 0.0, 1.0]), 0.0 if origin is None else yaw)
        fixed = matrix(turn, numbers(None if origin is None else origin.get('xyz')))
        if joint.get('type') != 'fixed':
            value, axis = positions[joint.get('name')], numbers(axis.get('xyz'))
            fixed = fixed @ (
                matrix(rotation(axis, value), np.zeros(3))
                if joint.get('type') == 'revolute'
                else matrix(np.eye(3), value * axis)
            )
        return pose(joint.find('parent').get('link')) @ fixed

    return {link.get('name'): pose(link.get('name')) for link in robot.findall('link')}


def joint_positions(mechanism, fractions):
    return np.array(
        [
            axis.min + fraction * (axis.max - axis.min)
            for axis, fraction in zip(mechanism.axes, fractions, strict=True)
        ]
    )


@MECHANISMS
@given(st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6))
def test_the_model_puts_the_tip_where_the_mechanism_does(mechanism, fractions):
    joints = joint_positions(mechanism, fractions)
    tip = forward_kinematics(mechanism, joints)
    positions = dict(zip(JOINTS, joints, strict=True))
    positions['incline_angle'] = mechanism.elevation(positions['incline'])
    poses = poses_of(urdf_of(mechanism), positions)
    np.testing.assert_allclose(poses['tip'][:3, 3], tip.position, atol=1e-12)
    np.testing.assert_allclose(poses['tip'][:3, :3], rotation_of(tip.quaternion), atol=1e-12)
    pivot = np.linalg.inv(poses['machine']) @ poses['base_link']
    np.testing.assert_allclose(pivot[:3, 3], joints[:3], atol=1e-12)
    # The transforms have the same frames, in the same places.
    found = {'table': np.eye(4)}
    for each in transforms(mechanism, joints_of(mechanism), joints):
        found[each.child] = found[each.parent] @ matrix(
            rotation_of(each.quaternion), each.translation
        )
    assert set(found) == set(poses)
    for frame, pose in found.items():
        np.testing.assert_allclose(pose, poses[frame], atol=1e-12)


@given(st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6))
def test_the_transforms_show_the_aligned_cue(fractions):
    """Its tip is where the driver has it, at every elevation; in the model, if it is level."""
    joints = joint_positions(ALIGNED, fractions)
    tip = forward_kinematics(ALIGNED, joints)
    found = {'table': np.eye(4)}
    for each in transforms(ALIGNED, joints_of(ALIGNED), joints):
        found[each.child] = found[each.parent] @ matrix(
            rotation_of(each.quaternion), each.translation
        )
    np.testing.assert_allclose(found['tip'][:3, 3], tip.position, atol=1e-12)
    np.testing.assert_allclose(found['tip'][:3, :3], rotation_of(tip.quaternion), atol=1e-12)
    joints[INCLINE], joints[STROKE] = ALIGNED.incline_geometry.length(0.0), 0.0
    positions = dict(zip(JOINTS, joints, strict=True))
    positions['incline_angle'] = ALIGNED.elevation(positions['incline'])
    place = poses_of(urdf_of(ALIGNED), positions)['tip'][:3, 3]
    np.testing.assert_allclose(place, forward_kinematics(ALIGNED, joints).position, atol=1e-12)


@MECHANISMS
def test_limits_are_those_of_the_mechanism(mechanism):
    joints = joints_of(mechanism)[1:7]
    for i, (joint, axis) in enumerate(zip(joints, mechanism.axes, strict=True)):
        if i != INCLINE:
            assert joint.name == JOINTS[i]
            assert (joint.min, joint.max, joint.speed) == (axis.min, axis.max, axis.speed)
    incline = joints[INCLINE]
    lengths = np.linspace(mechanism.incline.min, mechanism.incline.max, 1001)
    angles = np.array([mechanism.incline_geometry.elevation(length) for length in lengths])
    assert (incline.min, incline.max) == (angles[0], angles[-1])
    fastest = (np.diff(angles) / np.diff(lengths)).max() * mechanism.incline.speed
    assert incline.speed == pytest.approx(fastest, rel=2e-3)
    assert joints[STROKE].effort == mechanism.max_force
    limits = [
        joint.find('limit').attrib
        for joint in ET.fromstring(urdf_of(mechanism)).findall('joint')
        if joint.get('type') != 'fixed' and joint.get('name') != 'incline'
    ]
    assert [
        (
            float(each['lower']),
            float(each['upper']),
            float(each['velocity']),
            float(each['effort']),
        )
        for each in limits
    ] == [(joint.min, joint.max, joint.speed, joint.effort) for joint in joints]


def test_masses_come_from_the_mechanism():
    part = MovingPart(mass=2.0, length=0.3, width=0.2, height=0.1)
    np.testing.assert_allclose(part.inertia, np.array([0.05, 0.1, 0.13]) / 6)
    mechanism = Mechanism(parts=replace(Mechanism().parts, incline=part))
    link = next(
        link
        for link in ET.fromstring(urdf_of(mechanism)).findall('link')
        if link.get('name') == 'incline'
    )
    assert float(link.find('inertial/mass').get('value')) == 2.0
    inertia = link.find('inertial/inertia')
    np.testing.assert_allclose(
        [float(inertia.get(name)) for name in ('ixx', 'iyy', 'izz')], part.inertia
    )
    assert inertia.get('ixy') == inertia.get('ixz') == inertia.get('iyz') == '0.0'
    np.testing.assert_allclose(numbers(link.find('visual/geometry/box').get('size')), part.size)


@MECHANISMS
def test_the_centre_of_mass_of_each_link_is_that_of_its_box(mechanism):
    centres = {joint.child: joint.centre for joint in joints_of(mechanism)}
    boxes = 0
    for link in ET.fromstring(urdf_of(mechanism)).findall('link'):
        if (box := link.find('visual')) is not None:
            boxes += 1
            centre = numbers(link.find('inertial/origin').get('xyz'))
            np.testing.assert_allclose(centre, numbers(box.find('origin').get('xyz')))
            np.testing.assert_allclose(centre, centres[link.get('name')])
    assert boxes == len(JOINTS)


@MECHANISMS
def test_at_home_the_tip_is_above_the_middle_of_the_table(mechanism):
    joints = home(mechanism)
    tip = forward_kinematics(mechanism, joints)
    assert joints[BASE_Z] == travel_pivot_height(mechanism, mechanism.base_z.min)
    assert (joints[[BASE_X, BASE_Y, AZIMUTH_JOINT, STROKE]] == 0.0).all()
    assert joints[INCLINE] == 0.5 * (mechanism.incline.min + mechanism.incline.max)
    assert tip.position[1] == pytest.approx(0.0)
    assert tip.position[2] >= mechanism.travel_height - 1e-9


def test_the_cue_is_as_heavy_as_that_of_the_paper():
    assert Mechanism().parts.stroke.mass == Scene.load('paper').cue.mass


def test_the_cue_ends_at_its_tip():
    mechanism = Mechanism()
    cue = joints_of(mechanism)[1 + STROKE]
    assert cue.centre[0] + 0.5 * cue.part.length == pytest.approx(mechanism.reach)


def test_a_level_cue_can_play_a_ball_on_the_cloth():
    """No part reaches below the cloth where the tip is at the height of the ball's centre."""
    mechanism, radius = Mechanism(), Scene.load('paper').ball.radius
    joints = np.array(
        [
            0.0,
            0.0,
            radius + mechanism.axis_drop,
            0.0,
            mechanism.incline_geometry.length(0.0),
            mechanism.stroke.max,
        ]
    )
    heights = {'table': 0.0}
    model = joints_of(mechanism)
    for each in transforms(mechanism, model, joints):
        heights[each.child] = heights[each.parent] + each.translation[2]
    assert heights['tip'] == pytest.approx(radius)
    for joint in model[1:7]:
        assert heights[joint.child] + joint.centre[2] - 0.5 * joint.part.height > 0.0


@pytest.mark.parametrize(
    ('frame', 'prefix'), [('table', ''), ('cell1/table', 'cell1/'), ('a/b/pool', 'a/b/')]
)
def test_frames_of_two_robots_have_different_names(frame, prefix):
    links = [
        link.get('name') for link in ET.fromstring(urdf_of(Mechanism(), frame)).findall('link')
    ]
    assert links[0] == frame
    assert links[1:] == [
        f'{prefix}{name}'
        for name in (
            'machine',
            'bridge',
            'trolley',
            'base_link',
            'turntable',
            'incline',
            'cue',
            'incline_actuator',
            'tip',
        )
    ]


def test_a_prefix_of_the_joints_is_that_of_the_elevation_too():
    names = [f'left_{name}' for name in JOINTS]
    joints = [joint.name for joint in joints_of(Mechanism(), names=names)]
    assert joints[1 + INCLINE] == 'left_incline_angle'
    assert sorted(joints) == sorted(['machine', *names, 'left_incline_angle', 'tip'])


def test_the_command_prints_the_model(capsys, tmp_path):
    assert main(['urdf']) == 0
    assert capsys.readouterr().out == urdf_of(Mechanism())
    (tmp_path / 'mine.yaml').write_text('reach: 0.25\n')
    file = tmp_path / 'cue.urdf'
    words = f'urdf --mechanism {tmp_path}/mine.yaml --frame cell1/table --output {file}'
    assert main(words.split()) == 0
    assert file.read_text() == urdf_of(Mechanism(reach=0.25), 'cell1/table')


def test_masses_are_checked():
    with pytest.raises(ValueError, match=r'mass must be .*above 0, got 0 \(kg\)'):
        MovingPart(mass=0, length=1, width=1, height=1)


@MECHANISMS
def test_ros2_control_commands_joints_of_the_model(mechanism):
    """Every commanded joint is in the URDF, and starts at rest within its range."""
    robot = ET.fromstring(urdf_of(mechanism))
    limits = {joint.get('name'): joint.find('limit') for joint in robot.findall('joint')}
    control = robot.find('ros2_control')
    assert control.find('hardware/plugin').text == 'mock_components/GenericSystem'
    joints = control.findall('joint')
    assert [joint.get('name') for joint in joints] == list(JOINTS)
    for joint, axis in zip(joints, mechanism.axes, strict=True):
        limit = limits[joint.get('name')]
        assert [float(limit.get(end)) for end in ('lower', 'upper')] == [axis.min, axis.max]
        assert [each.get('name') for each in joint.findall('command_interface')] == ['position']
        states = {each.get('name'): each for each in joint.findall('state_interface')}
        assert set(states) == {'position', 'velocity'}
        start = float(states['position'].find("param[@name='initial_value']").text)
        assert axis.min <= start <= axis.max


def test_the_controllers_have_the_joints_of_the_model():
    file = Path(__file__).resolve().parents[2] / 'config' / 'controllers.yaml'
    settings = yaml.safe_load(file.read_text())
    controller = settings['/**/joint_trajectory_controller']['ros__parameters']
    assert controller['joints'] == list(JOINTS)
    assert set(controller['state_interfaces']) == {'position', 'velocity'}
    manager = settings['/**/controller_manager']['ros__parameters']
    assert manager['joint_trajectory_controller']['type'] == (
        'joint_trajectory_controller/JointTrajectoryController'
    )
