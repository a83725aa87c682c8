"""
The mechanical cue as a chain of frames, from which its URDF and its transforms are made.

Each frame is connected to the one before it by a joint: `table`, the bridge (`base_x`), the
trolley (`base_y`), `base_link` at the pivot (`base_z`), the turntable (`azimuth`), the incline,
and the cue (`stroke`). The tip is fixed to the cue, with +x along the stroke. The incline turns
about its pivot by the elevation of the cue. The length of its actuator, the joint `incline`, is
not part of the chain, because the actuator closes a kinematic loop. It moves a frame of its own,
`incline_actuator`, which carries nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism
from billiard_shot.cue.parts import MovingPart
from billiard_shot.records import Array, Triple
from billiard_shot.scene.equipment import STANDARD_GRAVITY

FRAMES = ('bridge', 'trolley', 'base_link', 'turntable', 'incline', 'cue', 'tip')
"""Frames of the chain after that of the table, in their order."""

ACTUATOR = 'incline_actuator'
"""Frame that the actuator of the incline moves along x."""

X_AXIS, Y_AXIS, Z_AXIS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AXES = (X_AXIS, Y_AXIS, Z_AXIS, Z_AXIS, Y_AXIS, X_AXIS)
REVOLUTE = ('azimuth', 'incline')


@dataclass(frozen=True, slots=True)
class Joint:
    """
    One joint of the chain, with the part that it moves.

    Parameters
    ----------
    name : str
    parent, child : str
        Names of the frames that it connects.
    revolute : bool
        Whether the joint turns about its axis; otherwise it moves along the axis.
    axis : (3,) floats
        Unit vector in both frames.
    min, max, speed : float
        Range and largest speed [m, m/s; rad, rad/s].
    effort : float
        Force [N] or torque [N m] that suffices for the accelerations of the mechanism.
    part : MovingPart
    centre : (3,) floats
        Centre of the part in the frame `child` [m].

    """

    name: str
    parent: str
    child: str
    revolute: bool
    axis: Triple
    min: float
    max: float
    speed: float
    effort: float
    part: MovingPart
    centre: Triple


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """Pose of the frame `child` in the frame `parent`: translation [m], quaternion x y z w."""

    parent: str
    child: str
    translation: Array
    quaternion: tuple[float, float, float, float]


def frame_names(frame: str) -> tuple[str, ...]:
    """Names of all frames, the table's first; the prefix of `cell1/table` is added to all."""
    prefix = frame[: frame.rfind('/') + 1]
    return (frame, *(prefix + name for name in FRAMES))


def actuator_frame(frame: str) -> str:
    """Name of the frame of the incline's actuator, if the frame of the table is `frame`."""
    return frame[: frame.rfind('/') + 1] + ACTUATOR


def tip_offset(mechanism: Mechanism) -> Triple:
    """Position of the tip in the frame of the cue [m]."""
    return mechanism.reach, 0.0, -mechanism.axis_drop


def chain(
    mechanism: Mechanism,
    frame: str = 'table',
    names: Sequence[str] = JOINTS,
    incline_joint: str = 'incline_angle',
) -> tuple[Joint, ...]:
    """
    Joints of the mechanism, from the table to the cue.

    Parameters
    ----------
    mechanism : Mechanism
    frame : str
        Name of the table's frame.
    names : sequence of str
        Names of the joints, in the order of `JOINTS`.
    incline_joint : str
        Name of the joint of the cue's elevation, used instead of that of the incline's actuator.

    """
    names = [incline_joint if i == INCLINE else name for i, name in enumerate(names)]
    frames = frame_names(frame)
    geometry, ends = mechanism.incline_geometry, (mechanism.incline.min, mechanism.incline.max)
    low, high = map(geometry.elevation, ends)
    # The actuator turns the incline fastest at one end of its range, where its lever is shortest.
    per_length = 1.0 / min(map(geometry.length_per_elevation, ends))
    joints = []
    for i, joint in enumerate(JOINTS):
        axis = mechanism.axes[i]
        factor = per_length if i == INCLINE else 1.0
        lower, upper = (low, high) if i == INCLINE else (axis.min, axis.max)
        joints.append(
            Joint(
                names[i],
                frames[i],
                frames[i + 1],
                joint in REVOLUTE,
                AXES[i],
                lower,
                max=upper,
                speed=factor * axis.speed,
                effort=_effort(mechanism, i, factor * axis.acceleration),
                part=getattr(mechanism.parts, joint),
                centre=_centres(mechanism)[i],
            )
        )
    return tuple(joints)


def transforms(
    mechanism: Mechanism,
    joints: Sequence[float] | Array,
    frame: str = 'table',
) -> tuple[Transform, ...]:
    """
    Find the transforms of all frames, from the table to the tip, for joints (6,).

    Raises
    ------
    ValueError
        If a joint is not finite, or if the actuator of the incline cannot have that length.

    """
    values = [float(value) for value in joints]
    for name, value in zip(JOINTS, values, strict=True):
        if not math.isfinite(value):
            raise ValueError(f'{name}: position {value} is not finite')
    length = values[INCLINE]
    values[INCLINE] = mechanism.incline_geometry.elevation(length)
    frames = frame_names(frame)
    level = (0.0, 0.0, 0.0, 1.0)
    found = []
    for i, (joint, axis) in enumerate(zip(JOINTS, AXES, strict=True)):
        angle, distance = (values[i], 0.0) if joint in REVOLUTE else (0.0, values[i])
        x, y, z = (math.sin(0.5 * angle) * np.array(axis)).tolist()
        found.append(
            Transform(
                frames[i],
                frames[i + 1],
                distance * np.array(axis),
                (x, y, z, math.cos(0.5 * angle)),
            )
        )
    found.append(
        Transform(frames[INCLINE], actuator_frame(frame), length * np.array(X_AXIS), level)
    )
    found.append(Transform(frames[-2], frames[-1], np.array(tip_offset(mechanism)), level))
    return tuple(found)


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
    if name not in REVOLUTE:
        return float(mass * (acceleration + gravity))
    far = math.hypot(mechanism.reach + mechanism.stroke.max, mechanism.axis_drop)
    return float(mass * far * (far * acceleration + gravity))
