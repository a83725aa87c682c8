"""
The mechanical cue as a chain of frames, from which its URDF and its transforms are made.

Each frame is connected to the one before it by a joint: `table`, `machine` (fixed, where the
alignment has it), the bridge (`base_x`), the trolley (`base_y`), `base_link` at the pivot
(`base_z`), the turntable (`azimuth`), the incline, and the cue (`stroke`). The tip is fixed to
the cue, where the alignment has it, with +x along the stroke. The incline turns about its pivot by
the elevation of the cue. The length of its actuator, the joint `incline`, is not part of the
chain, because the actuator closes a kinematic loop. It moves a frame of its own,
`incline_actuator`, which carries nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE
from billiard_shot.cue.parts import MovingPart
from billiard_shot.records import Array, Triple
from billiard_shot.scene.equipment import STANDARD_GRAVITY
from billiard_shot.shot.stroke_vectors import axes

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
