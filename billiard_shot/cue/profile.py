"""
The stroke: from rest to the wanted speed, through the ball, and back.

The drive accelerates the cue, holds its speed until the cue meets the ball, releases the cue
during contact, brakes it and draws it back. During contact only the ball changes the speed of the
cue. `predict` computes that change, and the trajectory contains it as a ramp.
"""

from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.joint_trajectory import JointTrajectory, ramp_times, TrajectoryBuilder
from billiard_shot.cue.limits import check_range, raise_violations
from billiard_shot.cue.mechanism import BASE_Z, Mechanism, STROKE
from billiard_shot.records import Array

MIN_BRAKED_SPEED = 1e-6  # m/s: a slower cue is not braked


@dataclass(frozen=True, slots=True)
class StrokeProfile:
    """
    The stroke as numbers: speeds in m/s, positions of the joint `stroke` in m.

    The cue meets the ball at `contact_at`, the ball leaves and the brake starts at `leave_at`, and
    the cue stops at `stop_at`.
    """

    mechanism: Mechanism
    speed: float
    speed_after: float  # as the ball leaves; negative if the cue recoils
    contact_time: float  # s, for which the drive releases the cue
    acceleration: float  # m/s^2, before the contact
    deceleration: float  # m/s^2, of the brake

    @property
    def steady_way(self) -> float:
        """Distance at constant speed before the cue meets the ball."""
        return self.speed * self.mechanism.steady_time

    @property
    def contact_at(self) -> float:
        """Position at which the cue meets the ball: the length of the run-up."""
        return self._way(0.0, self.speed, self.acceleration) + self.steady_way

    @property
    def leave_at(self) -> float:
        """Position at which the ball leaves the cue."""
        mean = 0.5 * (self.speed + self.speed_after)
        return self.contact_at + mean * self.contact_time

    @property
    def stop_at(self) -> float:
        """Position at which the cue stops."""
        return self.leave_at + self._way(self.speed_after, 0.0, self.deceleration)

    @property
    def worst_case_stop(self) -> float:
        """Position at which the cue stops if there is no ball to slow it down."""
        through = self.contact_at + self.speed * self.contact_time
        return max(through + self._way(self.speed, 0.0, self.deceleration), self.stop_at)

    def _way(self, before: float, after: float, acceleration: float) -> float:
        rise, hold = ramp_times(after - before, acceleration, self.mechanism.stroke.jerk)
        return 0.5 * (before + after) * (2 * rise + hold)


def stroke_profile(
    mechanism: Mechanism,
    mass: float,
    gravity: float,
    elevation: float,
    speed: float,
    speed_after: float,
    touch_time: float,
    clearance: float,
) -> StrokeProfile:
    """
    Find the shortest stroke of a given speed within the limits of acceleration, jerk and force.

    Parameters
    ----------
    mechanism : Mechanism
    mass : float
        Mass of the cue [kg].
    gravity : float
        [m/s^2]; it accelerates a stroke that points down, and works against the brake.
    elevation : float
        [rad]
    speed, speed_after : float
        Speeds of the cue as it meets the ball and as the ball leaves [m/s]; the latter is negative
        if the cue recoils.
    touch_time : float
        For how long the tip will touch the ball [s]; the drive releases the cue for that long, or
        for the mechanism's `contact_time` if that is longer.
    clearance : float
        Distance that the cue can move after meeting the ball before it touches the cloth [m].

    Raises
    ------
    LimitError
        With all violated limits: speed, force, travel, cloth.

    """
    drive = mechanism.stroke
    raise_violations(check_range('stroke.speed', speed, mechanism.min_speed, drive.speed, 'm/s'))
    weight = mass * gravity * math.sin(elevation)
    # a drive that only holds the cue could not brake it
    strongest = math.nextafter(mechanism.max_force, 0.0)
    raise_violations(
        check_range('force', weight, -math.inf, strongest, 'N', 'weight along the stroke')
    )
    deceleration = min(drive.acceleration, (mechanism.max_force - weight) / mass)
    acceleration = min(drive.acceleration, (mechanism.max_force + weight) / mass)
    if abs(speed_after) <= MIN_BRAKED_SPEED:
        speed_after = 0.0
    contact_time = max(mechanism.contact_time, touch_time)
    profile = StrokeProfile(
        mechanism, speed, speed_after, contact_time, acceleration, deceleration
    )
    why = (
        f'braking from {speed:.3g} m/s at {deceleration:.3g} m/s^2, limited by '
        f'{"stroke.acceleration" if deceleration == drive.acceleration else "max_force"}'
    )
    raise_violations(
        [
            *check_range('travel', profile.worst_case_stop, 0.0, drive.max, 'm', why),
            *check_range(
                'travel',
                min(profile.stop_at, profile.leave_at),
                0.0,
                drive.max,
                'm',
                'the cue recoils',
            ),
            *check_range(
                'cloth', profile.worst_case_stop - profile.contact_at, 0.0, clearance, 'm', why
            ),
        ]
    )
    return profile


@dataclass(frozen=True, slots=True, eq=False)
class StrokeTrajectory:
    """Trajectory of all joints for a stroke; times in s from its start."""

    trajectory: JointTrajectory
    contact: float  # the cue meets the ball
    leave: float  # the ball leaves the cue, the brake starts
    stop: float  # the cue has stopped
    home: float  # the cue is drawn back fully; after that it is raised off the table


def stroke_trajectory(profile: StrokeProfile, start: Array, raised: float) -> StrokeTrajectory:
    """
    Build the trajectory: accelerate, hold the speed, meet the ball, brake, draw back, rise.

    Parameters
    ----------
    profile : StrokeProfile
    start : (6,) float array
        Joints, aimed and drawn back.
    raised : float
        Height of the pivot at the end [m].

    """
    mechanism, stroke = profile.mechanism, np.eye(len(start))[STROKE]
    jerk = mechanism.stroke.jerk
    builder = TrajectoryBuilder(start)
    builder.ramp(profile.speed * stroke, *ramp_times(profile.speed, profile.acceleration, jerk))
    builder.piece(mechanism.steady_time, 0.0 * stroke)
    contact = builder.time
    change = profile.speed_after - profile.speed
    builder.ramp(change * stroke, 0.5 * profile.contact_time, 0.0)
    leave = builder.time
    if profile.speed_after != 0.0:
        brake = ramp_times(profile.speed_after, profile.deceleration, jerk)
        builder.ramp(-profile.speed_after * stroke, *brake)
    stop = builder.time
    accelerations = np.where(stroke > 0.0, profile.deceleration, mechanism.accelerations)
    target = builder.position.copy()
    target[STROKE] = start[STROKE]
    builder.move(target, mechanism.speeds, accelerations, mechanism.jerks)
    home = builder.time
    target[BASE_Z] = raised
    builder.move(target, mechanism.speeds, accelerations, mechanism.jerks)
    return StrokeTrajectory(builder.trajectory(), contact, leave, stop, home)
