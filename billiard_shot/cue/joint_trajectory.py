"""
Joint trajectories: knots, with constant jerk between them.

A controller that interpolates positions, velocities and accelerations between the knots (as the
joint_trajectory_controller of ros2_control does, with quintic splines) follows such a trajectory
exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

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
