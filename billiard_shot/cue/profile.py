"""
The stroke: from rest to the wanted speed, through the ball, and back.

The drive accelerates the cue, holds its speed until it meets the ball, lets go of it while they
touch, brakes it and draws it back. While they touch, the ball alone changes the cue's speed, by
what `predict` says; the path has that change as a ramp, for the drive to go along with.
"""

from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.limits import Excess, outside, refuse
from billiard_shot.cue.mechanism import BASE_Z, Mechanism, STROKE
from billiard_shot.cue.path import Array, Path, PathBuilder, ramp_times

STILL = 1e-6  # m/s: slower needs no brake


@dataclass(frozen=True, slots=True)
class StrokeProfile:
    """
    The stroke as numbers: speeds in m/s, distances along the stroke in m, times in s.

    `contact_at` is where the joint `stroke` stands as the cue meets the ball, `leave_at` as the
    ball leaves it and the brake sets in, `stop_at` where the brake has stopped it.
    """

    speed: float
    speed_after: float  # as the ball leaves; negative: the cue recoils
    acceleration: float  # m/s^2, while it speeds up
    deceleration: float  # m/s^2, while it brakes
    jerk: float  # m/s^3
    steady_time: float
    contact_time: float

    @property
    def contact_at(self) -> float:
        """Run-up: where the cue meets the ball."""
        return self._way(0.0, self.speed, self.acceleration) + self.speed * self.steady_time

    @property
    def leave_at(self) -> float:
        """Where the ball leaves."""
        return self.contact_at + 0.5 * (self.speed + self.speed_after) * self.contact_time

    @property
    def stop_at(self) -> float:
        """Where the cue stops."""
        return self.leave_at + self._way(self.speed_after, 0.0, self.deceleration)

    @property
    def farthest(self) -> float:
        """Where the cue stops if no ball was there to slow it down."""
        through = self.contact_at + self.speed * self.contact_time
        return max(through + self._way(self.speed, 0.0, self.deceleration), self.stop_at)

    def _way(self, before: float, after: float, acceleration: float) -> float:
        rise, hold = ramp_times(after - before, acceleration, self.jerk)
        return 0.5 * (before + after) * (2 * rise + hold)


def stroke_profile(
    mechanism: Mechanism,
    mass: float,
    gravity: float,
    elevation: float,
    speed: float,
    speed_after: float,
    room: float,
) -> StrokeProfile:
    """
    Find the quickest stroke within the limits of acceleration, jerk and force.

    Parameters
    ----------
    mechanism : Mechanism
    mass : float
        Of the cue [kg].
    gravity : float
        [m/s^2]; it helps a stroke that points down to speed up and hinders its brake.
    elevation : float
        [rad]
    speed, speed_after : float
        Of the cue as it meets the ball and as the ball leaves it [m/s]; the latter is negative if
        the cue recoils.
    room : float
        How far the cue may move on from where it meets the ball, until it touches the cloth [m].

    Raises
    ------
    LimitError
        With all limits that are broken: speed, force, travel, cloth.

    """
    drive = mechanism.stroke
    refuse(outside('stroke.speed', speed, mechanism.least_speed, drive.speed, 'm/s'))
    weight = mass * gravity * math.sin(elevation)
    if weight >= mechanism.force:
        refuse([Excess('force', weight, mechanism.force, 'N', 'weight along the stroke')])
    deceleration = min(drive.acceleration, (mechanism.force - weight) / mass)
    acceleration = min(drive.acceleration, (mechanism.force + weight) / mass)
    profile = StrokeProfile(
        speed,
        speed_after if abs(speed_after) > STILL else 0.0,
        acceleration,
        deceleration,
        drive.jerk,
        mechanism.steady_time,
        mechanism.contact_time,
    )
    why = (
        f'braking from {speed:.3g} m/s at {deceleration:.3g} m/s^2, as far as '
        f'{"stroke.acceleration" if deceleration == drive.acceleration else "force"} allows'
    )
    refuse(
        [
            *outside('travel', profile.farthest, 0.0, drive.most, 'm', why),
            *outside(
                'travel',
                min(profile.stop_at, profile.leave_at),
                0.0,
                drive.most,
                'm',
                'the cue recoils',
            ),
            *outside('cloth', profile.farthest - profile.contact_at, 0.0, room, 'm', why),
        ]
    )
    return profile


@dataclass(frozen=True, slots=True, eq=False)
class StrokePath:
    """The stroke as a path of all joints; times in s from its start."""

    path: Path
    contact: float  # the cue meets the ball
    leave: float  # the ball leaves it, the brake sets in
    stop: float  # the cue has stopped
    home: float  # it is drawn back fully; what follows raises it off the table


def stroke_path(
    mechanism: Mechanism, profile: StrokeProfile, start: Array, raised: float
) -> StrokePath:
    """
    Write the path: speed up, hold, meet the ball, brake, draw back, rise.

    Parameters
    ----------
    mechanism : Mechanism
    profile : StrokeProfile
    start : (6,) float array
        Joints, aimed and drawn back.
    raised : float
        Height of the pivot in the end [m].

    """
    stroke = np.eye(len(start))[STROKE]
    builder = PathBuilder(start)
    builder.ramp(
        profile.speed * stroke, *ramp_times(profile.speed, profile.acceleration, profile.jerk)
    )
    builder.piece(profile.steady_time, 0.0 * stroke)
    contact = builder.time
    builder.ramp((profile.speed_after - profile.speed) * stroke, 0.5 * profile.contact_time, 0.0)
    leave = builder.time
    if profile.speed_after != 0.0:
        builder.ramp(
            -profile.speed_after * stroke,
            *ramp_times(profile.speed_after, profile.deceleration, profile.jerk),
        )
    stop = builder.time
    accelerations = np.where(stroke > 0.0, profile.deceleration, mechanism.accelerations)
    target = builder.position.copy()
    target[STROKE] = start[STROKE]
    builder.move(target, mechanism.speeds, accelerations, mechanism.jerks)
    home = builder.time
    target[BASE_Z] = raised
    builder.move(target, mechanism.speeds, accelerations, mechanism.jerks)
    return StrokePath(builder.path(), contact, leave, stop, home)
