"""Kinematics of the mechanical cue, and models of it: a chain of frames, and its URDF."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math
import xml.etree.ElementTree as ET

import numpy as np

from billiard_shot.cue.mechanism import (
    AZIMUTH_JOINT,
    BASE_Z,
    check_range,
    INCLINE,
    JOINTS,
    Mechanism,
    min_travel_height,
    MovingPart,
    raise_violations,
    STROKE,
    UNITS,
)
from billiard_shot.records import Array, Triple
from billiard_shot.scene.equipment import STANDARD_GRAVITY
from billiard_shot.shot.stroke import axes


@dataclass(frozen=True, slots=True, eq=False)
class TipPose:
    """Pose of the cue's tip in the frame `table`."""

    position: Array  # (3,) m
    azimuth: float  # of the stroke, rad
    elevation: float  # of the stroke, rad; a positive one points down

    @property
    def along(self) -> Array:
        """Unit vector along the stroke (3,)."""
        return np.array(axes(self.elevation, self.azimuth)[2])

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Orientation of the tip frame, x y z w: +x along the stroke, +y level."""
        yaw, pitch = self.azimuth / 2, self.elevation / 2
        return (
            -math.sin(yaw) * math.sin(pitch),
            math.cos(yaw) * math.sin(pitch),
            math.sin(yaw) * math.cos(pitch),
            math.cos(yaw) * math.cos(pitch),
        )


def inverse_kinematics(mechanism: Mechanism, contact: TipPose, stroke: float) -> Array:
    """
    Find the joints (6,) that bring the tip to `contact` with the joint `stroke` at `stroke` [m].

    Raises
    ------
    LimitError
        With every joint that would be out of its range, and the elevation if it would be.

    """
    joints = np.empty(len(JOINTS))
    pose = pose_by_encoders(mechanism, contact)
    _, up, along = np.array(axes(pose.elevation, pose.azimuth))
    joints[:AZIMUTH_JOINT] = (
        pose.position - (mechanism.reach + stroke) * along + mechanism.axis_drop * up
    )
    joints[AZIMUTH_JOINT] = math.remainder(pose.azimuth, 2 * math.pi)
    joints[INCLINE] = mechanism.incline_geometry.length(pose.elevation)
    joints[STROKE] = stroke
    violations = check_range('elevation', contact.elevation, *mechanism.elevations, 'rad')
    for name, value, axis, unit in zip(JOINTS, joints, mechanism.axes, UNITS, strict=True):
        violations += check_range(name, float(value), axis.min, axis.max, unit)
    raise_violations(violations)
    return joints


def forward_kinematics(mechanism: Mechanism, joints: Sequence[float] | Array) -> TipPose:
    """Find the pose of the tip for joints (6,), aligned as the mechanism says."""
    elevation = mechanism.incline_geometry.elevation(float(joints[INCLINE]))
    azimuth = float(joints[AZIMUTH_JOINT])
    _, up, along = np.array(axes(elevation, azimuth))
    pivot = np.array(joints[:AZIMUTH_JOINT])
    position = pivot - mechanism.axis_drop * up + (mechanism.reach + joints[STROKE]) * along
    return TipPose(*mechanism.alignment.on_table(position, azimuth, elevation))


def pose_by_encoders(mechanism: Mechanism, tip: TipPose) -> TipPose:
    """Find where the tip would be without the alignment, for the joints of a pose."""
    return TipPose(*mechanism.alignment.by_encoders(tip.position, tip.azimuth, tip.elevation))


def travel_pivot_height(mechanism: Mechanism, *heights: float) -> float:
    """
    Find the height of the pivot [m] for travel between positions of these pivot heights [m].

    At this height the tip of the drawn-back cue is above `travel_height`, whatever the elevation.
    """
    return min(max(min_travel_height(mechanism), *heights), mechanism.base_z.max)


def home(mechanism: Mechanism) -> Array:
    """Joints (6,) of a mechanism at rest above the centre of the table, at the travel height."""
    low, high = np.array([(axis.min, axis.max) for axis in mechanism.axes]).T
    joints = np.clip(0.0, low, high)
    joints[BASE_Z] = travel_pivot_height(mechanism, mechanism.base_z.min)
    joints[INCLINE] = 0.5 * (low + high)[INCLINE]
    return joints


FRAMES = ('bridge', 'trolley', 'base_link', 'turntable', 'incline', 'cue')
"""Frames that the joints of `JOINTS` move, in their order."""

MACHINE = 'machine'
"""Frame in which the joints are measured: that of the table, but for the alignment."""

X_AXIS, Y_AXIS, Z_AXIS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
JOINT_AXES = (X_AXIS, Y_AXIS, Z_AXIS, Z_AXIS, Y_AXIS, X_AXIS)
REVOLUTE, PRISMATIC, FIXED = 'revolute', 'prismatic', 'fixed'
JOINT_KINDS = (PRISMATIC, PRISMATIC, PRISMATIC, REVOLUTE, REVOLUTE, PRISMATIC)

ACTUATOR_MASS = 0.01
"""Mass of the part that the actuator moves in the model [kg]; simulators refuse a mass of 0."""


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint between two frames, with the part that it moves."""

    name: str
    kind: str  # REVOLUTE, PRISMATIC or FIXED
    parent: str
    child: str
    axis: Triple = X_AXIS  # unit vector in both frames, about or along which it moves
    min: float = 0.0  # m or rad
    max: float = 0.0  # m or rad
    speed: float = 0.0  # largest, m/s or rad/s
    effort: float = 0.0  # N or N m, which suffices for the accelerations of the mechanism
    part: MovingPart | None = None
    centre: Triple = (0.0, 0.0, 0.0)  # of the part in the frame `child`, m
    has_shape: bool = True  # whether the part is to be seen
    origin: Triple = (0.0, 0.0, 0.0)  # of `child` in `parent` when the joint is at 0, m
    yaw: float = 0.0  # of `child` in `parent` when the joint is at 0, rad; of fixed joints only


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """Pose of the frame `child` in the frame `parent`: translation [m], quaternion x y z w."""

    parent: str
    child: str
    translation: Array
    quaternion: tuple[float, float, float, float]


def elevation_joint(names: Sequence[str]) -> str:
    """Name of the joint of the cue's elevation, if `names` are those of `JOINTS`."""
    return f'{names[INCLINE]}_angle'


def joints_of(
    mechanism: Mechanism, frame: str = 'table', names: Sequence[str] = JOINTS
) -> tuple[Joint, ...]:
    """
    List the fixed joint of the machine, those to the cue, the actuator's, and that of the tip.

    The incline is where it is when the cue is level and drawn back, see `transforms`.

    Parameters
    ----------
    mechanism : Mechanism
    frame : str
        Name of the table's frame; the prefix of `cell1/table` is added to all frames.
    names : sequence of str
        Names of the joints, in the order of `JOINTS`.

    """
    prefix = frame[: frame.rfind('/') + 1]
    frames = [prefix + name for name in (MACHINE, *FRAMES)]
    alignment = mechanism.alignment
    ends = (mechanism.incline.min, mechanism.incline.max)
    # The actuator turns the incline fastest at one end of its range, where its lever is shortest.
    per_length = 1.0 / min(map(mechanism.length_per_elevation, ends))
    joints = []
    for i, (name, axis) in enumerate(zip(names, mechanism.axes, strict=True)):
        joint = Joint(
            name,
            JOINT_KINDS[i],
            frames[i],
            frames[i + 1],
            JOINT_AXES[i],
            axis.min,
            axis.max,
            axis.speed,
            _effort(mechanism, i, axis.acceleration),
            getattr(mechanism.parts, JOINTS[i]),
            _centres(mechanism)[i],
        )
        joints.append(joint)
    low, high = map(mechanism.elevation, ends)
    torque = _effort(mechanism, INCLINE, per_length * mechanism.incline.acceleration)
    actuator = joints[INCLINE]
    assert actuator.part
    level = mechanism.incline_geometry.length(0.0)
    joints[INCLINE] = replace(
        actuator,
        origin=_incline_shift(mechanism, level, 0.0),
        name=elevation_joint(names),
        min=low,
        max=high,
        speed=per_length * actuator.speed,
        effort=torque,
    )
    joints.append(
        replace(
            actuator,
            kind=PRISMATIC,
            child=f'{prefix}incline_actuator',
            axis=X_AXIS,
            effort=torque * per_length,
            part=replace(actuator.part, mass=ACTUATOR_MASS),
            centre=(0.0, 0.0, 0.0),
            has_shape=False,
        )
    )
    offset = (mechanism.reach, 0.0, -mechanism.axis_drop)
    joints.append(Joint('tip', FIXED, joints[STROKE].child, f'{prefix}tip', origin=offset))
    place = (alignment.machine_x, alignment.machine_y, 0.0)
    yaw = math.radians(alignment.machine_angle_deg)
    return (Joint(MACHINE, FIXED, frame, frames[0], origin=place, yaw=yaw), *joints)


def transforms(
    mechanism: Mechanism, joints: Sequence[Joint], positions: Sequence[float] | Array
) -> tuple[Transform, ...]:
    """
    Find the transforms of all frames, from the table to the tip.

    The cue is at its aligned elevation. So that its tip is at the aligned place, too, the incline
    is a little beside its pivot, depending on the elevation and the stroke.

    Parameters
    ----------
    mechanism : Mechanism
    joints : sequence of Joint
        Its joints (`joints_of`).
    positions : (6,) sequence of float
        Positions of the joints of `JOINTS` [m, rad].

    Raises
    ------
    ValueError
        If a position is not finite, or if the actuator of the incline cannot have that length.

    """
    values = [float(value) for value in positions]
    for name, value in zip(JOINTS, values, strict=True):
        if not math.isfinite(value):
            raise ValueError(f'{name}: position {value} is not finite')
    length, shift = values[INCLINE], _incline_shift(mechanism, values[INCLINE], values[STROKE])
    values[INCLINE] = mechanism.elevation(length)
    found = []
    for joint, value in zip(joints, (0.0, *values, length, 0.0), strict=True):
        axis = np.array(Z_AXIS if joint.kind == FIXED else joint.axis)
        angle, distance = (value, 0.0) if joint.kind == REVOLUTE else (joint.yaw, value)
        x, y, z = (math.sin(0.5 * angle) * axis).tolist()
        origin = shift if joint is joints[1 + INCLINE] else joint.origin
        place, turn = distance * axis + origin, (x, y, z, math.cos(0.5 * angle))
        found.append(Transform(joint.parent, joint.child, place, turn))
    return tuple(found)


def _incline_shift(mechanism: Mechanism, length: float, stroke: float) -> Triple:
    """Place of the incline's frame in that of the turntable [m] for two joints [m]."""
    alignment, reach = mechanism.alignment, mechanism.reach + stroke
    encoder = mechanism.incline_geometry.elevation(length)
    right, up, along = np.array(axes(mechanism.elevation(length), 0.0))
    _, up_before, along_before = np.array(axes(encoder, 0.0))
    moved = reach * (along_before - along) - mechanism.axis_drop * (up_before - up)
    x, y, z = (moved + alignment.tip_right * right + alignment.tip_up * up).tolist()
    return x, y, z


def _centres(mechanism: Mechanism) -> tuple[Triple, ...]:
    """Centres of the parts in their frames [m]; the bridge lies on the trolley."""
    parts, top = mechanism.parts, mechanism.base_z.max
    return (
        (0.0, 0.0, top + parts.base_y.height + 0.5 * parts.base_x.height),
        (0.0, 0.0, top + 0.5 * parts.base_y.height),
        (0.0, 0.0, 0.5 * (parts.azimuth.height + parts.base_z.height)),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.5 * (parts.incline.height - parts.stroke.height) - mechanism.axis_drop),
        (mechanism.reach - 0.5 * parts.stroke.length, 0.0, -mechanism.axis_drop),
    )


def _effort(mechanism: Mechanism, number: int, acceleration: float) -> float:
    """
    Force [N] or torque [N m] for an acceleration [m/s^2, rad/s^2] of a joint.

    This is an upper bound: all turning mass is taken to be at the far end of the stroke.
    """
    name = JOINTS[number]
    if name == 'stroke':
        return mechanism.max_force
    mass = sum(getattr(mechanism.parts, each).mass for each in JOINTS[number:])
    gravity = STANDARD_GRAVITY if name in ('base_z', 'incline') else 0.0
    if JOINT_KINDS[number] == PRISMATIC:
        return float(mass * (acceleration + gravity))
    far = math.hypot(mechanism.reach + mechanism.stroke.max, mechanism.axis_drop)
    return float(mass * far * (far * acceleration + gravity))


def urdf_of(
    mechanism: Mechanism,
    frame: str = 'table',
    names: Sequence[str] = JOINTS,
    hardware: str = 'mock_components/GenericSystem',
) -> str:
    """
    Return the URDF of a mechanism on a table.

    Parameters
    ----------
    mechanism, frame, names
        Those of `model.joints_of`.
    hardware : str
        Plugin in the tag `ros2_control` that drives the joints `names`.

    """
    robot = ET.Element('robot', name='mechanical_cue')
    ET.SubElement(robot, 'link', name=frame)
    for joint in joints_of(mechanism, frame, names):
        _add_joint(robot, joint)
        _add_link(robot, joint)
    _add_control(robot, mechanism, names, hardware)
    ET.indent(robot)
    # No encoding is declared, because parsers of strings refuse an encoding declaration.
    return f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'


def _add_joint(robot: ET.Element, joint: Joint) -> None:
    element = ET.SubElement(robot, 'joint', name=joint.name, type=joint.kind)
    ET.SubElement(element, 'origin', xyz=_text(joint.origin), rpy=_text((0.0, 0.0, joint.yaw)))
    ET.SubElement(element, 'parent', link=joint.parent)
    ET.SubElement(element, 'child', link=joint.child)
    if joint.kind != FIXED:
        ET.SubElement(element, 'axis', xyz=_text(joint.axis))
        limits = {
            'lower': joint.min,
            'upper': joint.max,
            'velocity': joint.speed,
            'effort': joint.effort,
        }
        ET.SubElement(element, 'limit', {name: repr(value) for name, value in limits.items()})


def _add_link(robot: ET.Element, joint: Joint) -> None:
    link = ET.SubElement(robot, 'link', name=joint.child)
    if joint.part is None:
        return
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=_text(joint.centre))
    ET.SubElement(inertial, 'mass', value=repr(joint.part.mass))
    ixx, iyy, izz = map(repr, joint.part.inertia.tolist())
    ET.SubElement(inertial, 'inertia', ixx=ixx, iyy=iyy, izz=izz, ixy='0.0', ixz='0.0', iyz='0.0')
    for purpose in ('visual', 'collision') if joint.has_shape else ():
        element = ET.SubElement(link, purpose)
        ET.SubElement(element, 'origin', xyz=_text(joint.centre))
        geometry = ET.SubElement(element, 'geometry')
        ET.SubElement(geometry, 'box', size=_text(joint.part.size.tolist()))


def _add_control(
    robot: ET.Element, mechanism: Mechanism, names: Sequence[str], hardware: str
) -> None:
    """Add the interfaces of the joints for ros2_control; they start at rest above the table."""
    control = ET.SubElement(robot, 'ros2_control', name='mechanical_cue', type='system')
    plugin = ET.SubElement(control, 'hardware')
    ET.SubElement(plugin, 'plugin').text = hardware
    ET.SubElement(plugin, 'param', name='calculate_dynamics').text = 'true'  # measured velocities
    for name, position in zip(names, home(mechanism).tolist(), strict=True):
        joint = ET.SubElement(control, 'joint', name=name)
        ET.SubElement(joint, 'command_interface', name='position')
        state = ET.SubElement(joint, 'state_interface', name='position')
        ET.SubElement(state, 'param', name='initial_value').text = repr(position)
        ET.SubElement(joint, 'state_interface', name='velocity')


def _text(numbers: Iterable[float]) -> str:
    return ' '.join(map(repr, numbers))
