"""Where the joints must be for the cue to meet the ball, and where the tip is for given joints."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.cue.limits import LimitError, outside, refuse
from billiard_shot.cue.mechanism import (
    AZIMUTH,
    BASE_X,
    BASE_Y,
    BASE_Z,
    INCLINE,
    JOINTS,
    Mechanism,
    STROKE,
    UNITS,
)
from billiard_shot.shot.stroke import axes

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class TipPose:
    """
    The tip of the cue, frame `table`.

    Parameters
    ----------
    position : (3,) float array
        Of the tip [m].
    azimuth, elevation : float
        Of the stroke [rad]; a positive elevation points down.

    """

    position: Array
    azimuth: float
    elevation: float

    @property
    def along(self) -> Array:
        """Unit vector along the stroke (3,)."""
        return axes(self.elevation, self.azimuth)[2]

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


def place(mechanism: Mechanism, contact: TipPose, stroke: float) -> Array:
    """
    Joints (6,) that bring the tip to `contact` when the stroke has come to `stroke` [m].

    Raises
    ------
    LimitError
        With every joint, and the elevation, that would be out of its range.

    """
    joints = np.empty(len(JOINTS))
    _, up, along = axes(contact.elevation, contact.azimuth)
    joints[:AZIMUTH] = contact.position - (mechanism.reach + stroke) * along + mechanism.drop * up
    joints[AZIMUTH] = math.remainder(contact.azimuth, 2 * math.pi)
    joints[STROKE] = stroke
    excesses = outside(
        'elevation', contact.elevation, mechanism.least_elevation, mechanism.most_elevation, 'rad'
    )
    try:
        joints[INCLINE] = mechanism.triangle.length(contact.elevation)
    except LimitError as error:
        refuse([*excesses, *error.excesses])
    for name, value, axis, unit in zip(JOINTS, joints, mechanism.axes, UNITS, strict=True):
        excesses += outside(name, float(value), axis.least, axis.most, unit)
    refuse(excesses)
    return joints


def tip_of(mechanism: Mechanism, joints: Sequence[float] | Array) -> TipPose:
    """Where joints (6,) put the tip."""
    elevation = mechanism.triangle.elevation(float(joints[INCLINE]))
    azimuth = float(joints[AZIMUTH])
    _, up, along = axes(elevation, azimuth)
    pivot = np.array([joints[BASE_X], joints[BASE_Y], joints[BASE_Z]])
    position = pivot - mechanism.drop * up + (mechanism.reach + joints[STROKE]) * along
    return TipPose(position, azimuth, elevation)


def travel_base(mechanism: Mechanism, *heights: float) -> float:
    """
    Height of the pivot [m] at which the carriage may travel between such heights [m].

    There the tip, cue drawn back, is above `travel_height` at whatever elevation.
    """
    hang = math.hypot(mechanism.reach, mechanism.drop)
    return min(max(mechanism.travel_height + hang, *heights), mechanism.base_z.most)
