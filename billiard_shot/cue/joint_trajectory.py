"""Trajectories of joints with constant jerk between knots; the stroke; a safe beginning."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.mechanism import BASE_Z, check_range, Mechanism, raise_violations, STROKE
from billiard_shot.records import Array

MIN_MOVE_TIME = 1e-6  # s: shorter moves are left out; times in messages are whole nanoseconds


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """Motion of n joints through k knots."""

    times: Array  # (k,) s, ascending from 0
    positions: Array  # (k, n) m or rad
    velocities: Array  # (k, n) m/s or rad/s
    accelerations: Array  # (k, n) m/s^2 or rad/s^2

    @property
    def duration(self) -> float:
        """Time of the last knot [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> tuple[Array, Array, Array]:
        """
        Positions, velocities and accelerations (n,) at a time [s].

        Before 0 these are the values of the first knot. After the end the joints rest at the last
        knot.
        """
        if time >= self.times[-1]:
            still = np.zeros(self.positions.shape[1])
            return self.positions[-1], still, still
        i = int(np.searchsorted(self.times, time, side='right')) - 1
        if i < 0:
            return self.positions[0], self.velocities[0], self.accelerations[0]
        dt = time - self.times[i]
        begin = self.accelerations[i]
        jerk = (self.accelerations[i + 1] - begin) / (self.times[i + 1] - self.times[i])
        velocity = self.velocities[i] + (begin + 0.5 * jerk * dt) * dt
        position = (
            self.positions[i] + (self.velocities[i] + (0.5 * begin + jerk * (dt / 6.0)) * dt) * dt
        )
        return position, velocity, begin + jerk * dt


class TrajectoryBuilder:
    """Builds a trajectory piece by piece, from rest at `start` (n,)."""

    def __init__(self, start: Sequence[float] | Array) -> None:
        position = np.array(start, dtype=float)
        still = np.zeros(len(position))
        self._knots = [(0.0, position, still, still)]

    @property
    def time(self) -> float:
        """Time of the last knot so far [s]."""
        return self._knots[-1][0]

    @property
    def position(self) -> Array:
        """Position of the last knot so far (n,)."""
        return self._knots[-1][1]

    def piece(self, duration: float, jerk: Array) -> None:
        """Append a piece of `duration` [s] at constant jerk (n,)."""
        if duration <= 0.0:
            return
        t, x, v, a = self._knots[-1]
        self._knots.append(
            (
                t + duration,
                x + (v + (0.5 * a + jerk * (duration / 6.0)) * duration) * duration,
                v + (a + 0.5 * jerk * duration) * duration,
                a + jerk * duration,
            )
        )

    def ramp(self, change: Array, rise: float, hold: float) -> None:
        """
        Change the velocity by `change` (n,).

        The acceleration rises for `rise` [s], holds for `hold` [s], and falls for `rise` [s].
        """
        t, x, v, _ = self._knots[-1]
        jerk = change / (rise * (rise + hold))
        self.piece(rise, jerk)
        self.piece(hold, 0.0 * jerk)
        self.piece(rise, -jerk)
        # The pieces add rounding errors; the next piece must start at the exact speed, without
        # acceleration.
        total = 2 * rise + hold
        self._knots[-1] = (t + total, x + (v + 0.5 * change) * total, v + change, 0.0 * jerk)

    def move(self, target: Array, speeds: Array, accelerations: Array, jerks: Array) -> None:
        """
        Move from rest to rest at `target` (n,); all joints take the same time.

        The move has four pieces of equal duration with jerk +, -, -, +. It is as short as the
        limits (n,) allow.
        """
        way = target - self.position
        distance = np.abs(way)
        duration = float(
            np.max(
                (
                    2.0 * distance / speeds,
                    np.sqrt(8.0 * distance / accelerations),
                    np.cbrt(32.0 * distance / jerks),
                )
            )
        )
        if duration < MIN_MOVE_TIME:
            t, _, v, a = self._knots[-1]
            self._knots[-1] = (t, target.copy(), v, a)
            return
        jerk = 32.0 * way / duration**3
        for sign in (1.0, -1.0, -1.0, 1.0):
            self.piece(duration / 4.0, sign * jerk)
        t, _, _, _ = self._knots[-1]
        self._knots[-1] = (t, target.copy(), 0.0 * way, 0.0 * way)

    def trajectory(self) -> JointTrajectory:
        """Return the trajectory built so far."""
        times, *rows = zip(*self._knots, strict=True)
        return JointTrajectory(np.array(times), *(np.array(row) for row in rows))


def ramp_times(change: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """
    Find the rise and hold times of the acceleration in the fastest change of speed [s].

    The speed changes by |change| [m/s] at no more than `acceleration` [m/s^2] and `jerk` [m/s^3].
    The whole ramp lasts 2 rise + hold; its length is that time times the mean of both speeds.
    """
    change = abs(change)
    if change * jerk < acceleration * acceleration:
        return math.sqrt(change / jerk), 0.0
    rise = acceleration / jerk
    return rise, change / acceleration - rise


MIN_BRAKE_TIME = 0.02
"""Shortest brake [s]; a controller should receive no points that are closer together."""

PEAK = 1.5
"""Largest deceleration of `braked`, relative to the mean deceleration."""


def excerpt(trajectory: JointTrajectory, end: float, accelerations: Array) -> JointTrajectory:
    """
    Follow a trajectory until the time `end` [s], and then brake.

    Parameters
    ----------
    trajectory : JointTrajectory
    end : float
    accelerations : (n,) float array
        Largest decelerations in the brake [m/s^2, rad/s^2].

    Returns
    -------
    JointTrajectory
        The whole trajectory if it ends earlier. The brake takes quintic interpolation, as the
        joint_trajectory_controller of ros2_control has it: its velocity is a cubic polynomial.

    """
    if end >= trajectory.duration:
        return trajectory
    position, velocity, acceleration = trajectory.at(end)
    time, target = braked(position, velocity, acceleration, accelerations)
    kept = trajectory.times < end
    still = np.zeros_like(target)

    def rows(before: Array, at_end: Array, after: Array) -> Array:
        return np.vstack([before[kept], at_end, after])

    return JointTrajectory(
        np.append(trajectory.times[kept], (end, end + time)),
        rows(trajectory.positions, position, target),
        rows(trajectory.velocities, velocity, still),
        rows(trajectory.accelerations, acceleration, still),
    )


def braked(
    position: Array, velocity: Array, acceleration: Array, limits: Array
) -> tuple[float, Array]:
    """
    Find the time [s] in which joints (n,) come to rest, and where.

    The velocity falls as a cubic polynomial, with the given `acceleration` at its beginning.
    """
    time = max(float((PEAK * np.abs(velocity) / limits).max()), MIN_BRAKE_TIME)
    return time, position + velocity * time / 2.0 + acceleration * time**2 / 12.0


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
