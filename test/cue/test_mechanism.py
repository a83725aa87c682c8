from pathlib import Path

from hypothesis import assume, given
from hypothesis import strategies as st
import numpy as np
from plans import contact_of, MECHANISM, SHOTS
import pytest

from billiard_shot.cue.mechanism import Axis, JOINTS, LimitError, Mechanism, STROKE
from billiard_shot.cue.model import (
    forward_kinematics,
    inverse_kinematics,
    TipPose,
    travel_pivot_height,
)
from billiard_shot.cue.plan import aim_trajectory
from billiard_shot.shot.stroke import Stroke

ROOT = Path(__file__).resolve().parents[2]


@given(SHOTS, st.floats(-1.2, 1.2), st.floats(-0.6, 0.6), st.floats(0.0, 0.4))
def test_placed_joints_put_the_tip_where_it_was_wanted(shot, x, y, stroke):
    wanted = contact_of(shot, (x, y))
    try:
        joints = inverse_kinematics(MECHANISM, wanted, stroke)
    except LimitError:
        assume(False)
    tip = forward_kinematics(MECHANISM, joints)
    np.testing.assert_allclose(tip.position, wanted.position, atol=1e-12)
    assert tip.elevation == pytest.approx(wanted.elevation, abs=1e-12)
    assert tip.azimuth == pytest.approx(wanted.azimuth, abs=1e-12)
    # and moving the stroke alone moves the tip along its axis
    joints[STROKE] -= 0.1
    np.testing.assert_allclose(
        forward_kinematics(MECHANISM, joints).position,
        wanted.position - 0.1 * wanted.along,
        atol=1e-12,
    )


@given(SHOTS)
def test_quaternion_points_along_the_stroke(shot):
    tip = contact_of(shot)
    stroke = Stroke.from_pose(
        tip.position - 0.1 * tip.along, tip.quaternion, 1.0, (0.0, 0.0, 0.0286)
    )
    np.testing.assert_allclose(np.array(stroke.velocity), tip.along, atol=1e-12)


def test_out_of_reach_names_every_joint():
    with pytest.raises(LimitError) as caught:
        inverse_kinematics(MECHANISM, TipPose(np.array([9.0, -9.0, 0.03]), 0.0, 0.0), 0.1)
    assert [violation.limit for violation in caught.value.violations] == ['base_x', 'base_y']
    with pytest.raises(LimitError, match=r'elevation: 1\.205 rad is 0\.005 rad above'):
        inverse_kinematics(MECHANISM, TipPose(np.zeros(3), 0.0, 1.205), 0.1)
    with pytest.raises(LimitError, match=r'elevation: -0\.01 rad is 0\.01 rad below'):
        inverse_kinematics(MECHANISM, TipPose(np.array([0, 0, 0.03]), 0.0, -0.01), 0.1)


@given(SHOTS, SHOTS)
def test_the_tip_travels_above_the_balls(first, second):
    try:
        start, target = (
            inverse_kinematics(MECHANISM, contact_of(shot), 0.2) for shot in (first, second)
        )
    except LimitError:
        assume(False)
    target[STROKE] = 0.0
    trajectory = aim_trajectory(MECHANISM, start, target)
    np.testing.assert_array_equal(trajectory.positions[-1], target)
    height = travel_pivot_height(MECHANISM, start[2], target[2])
    for time in np.linspace(0.0, trajectory.duration, 200):
        position, velocity, acceleration = trajectory.at(time)
        assert (np.abs(velocity) <= MECHANISM.speeds * (1 + 1e-9)).all()
        assert (np.abs(acceleration) <= MECHANISM.accelerations * (1 + 1e-9)).all()
        aside = position[[0, 1, 3, 4]]
        if (aside != start[[0, 1, 3, 4]]).any() and (aside != target[[0, 1, 3, 4]]).any():
            assert position[2] == pytest.approx(height, abs=1e-12)
            assert (
                forward_kinematics(MECHANISM, position).position[2]
                >= MECHANISM.travel_height - 1e-12
            )


def test_a_move_over_nothing_takes_no_time():
    """Nor knots so near each other that a message could not tell their times apart."""
    start = inverse_kinematics(MECHANISM, contact_of((0, 0, 0, 0, 1)), 0.0)
    near = start.copy()
    near[STROKE] = -7e-62
    trajectory = aim_trajectory(MECHANISM, near, start)
    assert np.diff(trajectory.times).min(initial=1.0) > 1e-7
    np.testing.assert_array_equal(trajectory.positions[-1], start)


def test_paths_are_joined_without_jumps():
    trajectory = aim_trajectory(
        MECHANISM,
        inverse_kinematics(MECHANISM, contact_of((0, 0, 0, 0, 1)), 0.2),
        inverse_kinematics(MECHANISM, contact_of((0.1, 0.2, 0.5, 2, 1)), 0.0),
    )
    for i, knot in enumerate(trajectory.times[:-1]):
        before = trajectory.at(knot - 1e-9)
        np.testing.assert_allclose(before[0], trajectory.positions[i], atol=1e-7)
        np.testing.assert_allclose(before[1], trajectory.velocities[i], atol=1e-6)
        jerk = np.diff(trajectory.accelerations, axis=0)[i] / np.diff(trajectory.times)[i]
        assert (np.abs(jerk) <= MECHANISM.jerks * (1 + 1e-9)).all()


def test_settings_are_checked(tmp_path):
    with pytest.raises(ValueError, match='min must be below max, 0, got 1'):
        Axis(1.0, 0.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match='max_force must be a finite number above 0, got 0'):
        Mechanism(max_force=0)
    with pytest.raises(ValueError, match=r'max_elevation must .* within -0\.07.*, got 1\.3'):
        Mechanism(max_elevation=1.3)
    with pytest.raises(ValueError, match=r'incline must be between 0\.2 and 0\.8, .* got 0\.1'):
        Mechanism(incline=Axis(0.1, 0.7, 1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match=r'base_z\.max must be at least 0\.4105.*, got 0\.4'):
        Mechanism(base_z=Axis(0.0, 0.4, 0.5, 2.0, 20.0))
    path = tmp_path / 'mine.yaml'
    path.write_text('max_force: 80\nspeed: 3\nstroke: {min: 0, max: -1}')
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (looked at below)
        Mechanism.load(path)
    for words in (
        'mine.yaml: 5 mistakes',
        'line 2: speed is unknown',
        'line 3: stroke.speed is missing',
    ):
        assert words in str(caught.value)
    path.write_text('max_force: 80\n')
    assert Mechanism.load(str(path)) == Mechanism(max_force=80)
    assert Mechanism.load('') == Mechanism()
    assert Mechanism.load(ROOT / 'config' / 'mechanism.yaml') == Mechanism()
    assert len(Mechanism().axes) == len(JOINTS)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('incline_geometry: {base: 0}', r'line 1: incline_geometry\.base must be'),
        ('min_speed: [1', r'line 1, column 14: while parsing a flow sequence: expected'),
        ('min_speed: *a', r"line 1, column 12: found undefined alias 'a'"),
        ('min_speed: "\0"', 'unacceptable character'),
    ],
)
def test_a_mistake_in_a_file_is_told_in_a_line(tmp_path, text, words):
    file = tmp_path / 'mechanism.yaml'
    file.write_text(text)
    with pytest.raises(ValueError, match=words) as caught:
        Mechanism.load(file)
    assert len(str(caught.value).splitlines()) == 1
    assert str(file) in str(caught.value)
