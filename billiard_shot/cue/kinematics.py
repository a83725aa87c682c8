"""Kinematics of the mechanical cue: joints for a pose of the tip, and the tip for given joints."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.limits import check_range, raise_violations
from billiard_shot.cue.mechanism import (
    AZIMUTH_JOINT,
    BASE_X,
    BASE_Y,
    BASE_Z,
    INCLINE,
    JOINTS,
    Mechanism,
    min_travel_height,
    STROKE,
    UNITS,
)
from billiard_shot.records import Array
from billiard_shot.shot.stroke_vectors import axes


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
    pivot = np.array([joints[BASE_X], joints[BASE_Y], joints[BASE_Z]])
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
