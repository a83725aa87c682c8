"""
The mechanical cue as a chain of frames: the one description of its URDF and of its transforms.

The frames, each moved in the one before it by a joint: `table`, the bridge (`base_x`), the trolley
(`base_y`), `base_link` at the pivot (`base_z`), the turntable (`azimuth`), the incline, the cue
(`stroke`), and fixed to it the tip, with +x along the stroke. The incline turns about its pivot,
by the elevation of the cue. The length of its actuator, the joint `incline`, is not part of the
chain: the actuator closes a loop, which a chain cannot describe.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism
from billiard_shot.cue.parts import Part
from billiard_shot.scene.equipment import STANDARD_GRAVITY

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

FRAMES = ('bridge', 'trolley', 'base_link', 'turntable', 'incline', 'cue', 'tip')
"""Frames of the chain below the table's, in its order."""

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AXES = (X, Y, Z, Z, Y, X)
TURNS = ('azimuth', 'incline')


@dataclass(frozen=True, slots=True)
class Joint:
    """
    One joint of the chain, with the part that it moves.

    Parameters
    ----------
    name : str
    parent, child : str
        Names of the frames that it joins.
    turns : bool
        Whether it turns about its axis, instead of moving along it.
    axis : (3,) floats
        Unit vector in both frames.
    least, most, speed : float
        Range and largest speed [m, m/s; rad, rad/s].
    effort : float
        Force [N] or torque [N m] that is enough for the accelerations in the mechanism.
    part : Part
    centre : (3,) floats
        Centre of the part in the frame `child` [m].

    """

    name: str
    parent: str
    child: str
    turns: bool
    axis: Triple
    least: float
    most: float
    speed: float
    effort: float
    part: Part
    centre: Triple


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """Where the frame `child` is in the frame `parent`: translation [m], quaternion x y z w."""

    parent: str
    child: str
    translation: Array
    quaternion: tuple[float, float, float, float]


def frame_names(frame: str) -> tuple[str, ...]:
    """Names of all frames, the table's first; `cell1/table` puts `cell1/` before the others."""
    prefix = frame[: frame.rfind('/') + 1]
    return (frame, *(prefix + name for name in FRAMES))


def tip_offset(mechanism: Mechanism) -> Triple:
    """Tip in the frame of the cue [m]."""
    return mechanism.reach, 0.0, -mechanism.drop


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
        Name of the joint of the cue's elevation, which replaces that of the incline's actuator.

    """
    names = [incline_joint if i == INCLINE else name for i, name in enumerate(names)]
    frames = frame_names(frame)
    low, high = (
        mechanism.triangle.elevation(length)
        for length in (mechanism.incline.least, mechanism.incline.most)
    )
    # The actuator turns the incline fastest where its lever is shortest: at an end of its range.
    per_length = max(_turn_per_length(mechanism, low), _turn_per_length(mechanism, high))
    joints = []
    for i, joint in enumerate(JOINTS):
        axis = mechanism.axes[i]
        factor = per_length if i == INCLINE else 1.0
        least, most = (low, high) if i == INCLINE else (axis.least, axis.most)
        joints.append(
            Joint(
                names[i],
                frames[i],
                frames[i + 1],
                joint in TURNS,
                AXES[i],
                least,
                most,
                factor * axis.speed,
                _effort(mechanism, i, factor * axis.acceleration),
                getattr(mechanism.parts, joint),
                _centres(mechanism)[i],
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
        If a joint is not known, or the actuator of the incline cannot have that length.

    """
    values = [float(value) for value in joints]
    for name, value in zip(JOINTS, values, strict=True):
        if not math.isfinite(value):
            raise ValueError(f'{name}: its position is {value}')
    values[INCLINE] = mechanism.triangle.elevation(values[INCLINE])
    frames = frame_names(frame)
    found = []
    for i, (joint, axis) in enumerate(zip(JOINTS, AXES, strict=True)):
        turn, way = (values[i], 0.0) if joint in TURNS else (0.0, values[i])
        x, y, z = (math.sin(0.5 * turn) * np.array(axis)).tolist()
        found.append(
            Transform(
                frames[i], frames[i + 1], way * np.array(axis), (x, y, z, math.cos(0.5 * turn))
            )
        )
    found.append(
        Transform(frames[-2], frames[-1], np.array(tip_offset(mechanism)), (0.0, 0.0, 0.0, 1.0))
    )
    return tuple(found)


def _centres(mechanism: Mechanism) -> tuple[Triple, ...]:
    """Centres of the parts in their frames [m]; the bridge lies on the trolley."""
    parts, top = mechanism.parts, mechanism.base_z.most
    return (
        (0.0, 0.0, top + parts.base_y.height + 0.5 * parts.base_x.height),
        (0.0, 0.0, top + 0.5 * parts.base_y.height),
        (0.0, 0.0, 0.5 * (parts.azimuth.height + parts.base_z.height)),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.5 * (parts.incline.height - parts.stroke.height) - mechanism.drop),
        (mechanism.reach - 0.5 * parts.stroke.length, 0.0, -mechanism.drop),
    )


def _turn_per_length(mechanism: Mechanism, elevation: float) -> float:
    """How far the incline turns per length of its actuator, at an elevation [rad/m]."""
    base, arm = mechanism.triangle.base, mechanism.triangle.arm
    angle = mechanism.triangle.level_angle + elevation
    length = math.sqrt(base**2 + arm**2 - 2 * base * arm * math.cos(angle))
    return length / (base * arm * math.sin(angle))


def _effort(mechanism: Mechanism, number: int, acceleration: float) -> float:
    """
    Force [N] or torque [N m] for an acceleration [m/s^2, rad/s^2] of a joint.

    It is an upper bound: what turns counts as if all of it was at the far end of the stroke.
    """
    name = JOINTS[number]
    if name == 'stroke':
        return mechanism.force
    mass = sum(getattr(mechanism.parts, each).mass for each in JOINTS[number:])
    gravity = STANDARD_GRAVITY if name in ('base_z', 'incline') else 0.0
    if name not in TURNS:
        return float(mass * (acceleration + gravity))
    far = math.hypot(mechanism.reach + mechanism.stroke.most, mechanism.drop)
    return float(mass * far * (far * acceleration + gravity))
