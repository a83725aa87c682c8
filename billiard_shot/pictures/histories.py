"""Speed, spin and energy of balls over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from billiard_shot.pictures.trails import Trails
from billiard_shot.records import Array
from billiard_shot.table.motion import Cause

SAMPLES_PER_MOTION = 12  # of each motion of each ball


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """
    Motion and energy of balls at n times, in order; at an event, just before it and just after.

    Attributes
    ----------
    time : (n,) float array
        [s].
    speeds : mapping of str to (n,) float array
        Speed of every ball that ever moves [m/s].
    rims : mapping of str to (n,) float array
        Surface speed of a ball's rotation about a level axis [m/s]: its speed, if it rolls.
    spins : mapping of str to (n, 3) float array
        [rad/s], frame `table`.
    translation, rotation, height : (n,) float arrays
        Energies of all balls together [J]. The energy of height is relative to lying on the cloth.
        A ball in a pocket or off the table has no energy.

    """

    time: Array
    speeds: Mapping[str, Array]
    rims: Mapping[str, Array]
    spins: Mapping[str, Array]
    translation: Array
    rotation: Array
    height: Array


def history_of(trails: Trails) -> History:
    """Sample the motion of all moving balls over the time that is shown."""
    ball, gravity = trails.scene.ball, trails.scene.cloth.gravity
    moving = [name for name in trails.balls if trails.moved(name)]
    time = _times(trails, moving)
    states = {name: trails.balls[name].at(time) for name in moving}
    speeds = {name: np.linalg.norm(s.velocity, axis=1) for name, s in states.items()}
    sizes = {name: np.linalg.norm(s.spin, axis=1) for name, s in states.items()}
    nothing = np.zeros(len(time))
    heights = [
        np.where(s.motion < 5, s.position[:, 2] - ball.radius, 0.0) for s in states.values()
    ]
    return History(
        time,
        speeds,
        {name: ball.radius * np.hypot(*s.spin[:, :2].T) for name, s in states.items()},
        {name: s.spin for name, s in states.items()},
        sum((0.5 * ball.mass * v**2 for v in speeds.values()), nothing),
        sum((0.5 * ball.inertia * w**2 for w in sizes.values()), nothing),
        height=sum((ball.mass * gravity * z for z in heights), nothing),
    )


def _times(trails: Trails, names: list[str]) -> Array:
    """
    Find times just before and just after all events, and between them.

    During an impact, its balls move at constant velocities that stand for the impact. Their speeds
    and energies have no meaning then, so there are no times within an impact.
    """
    starts = np.concatenate(
        [[0.0, trails.until], *(trails.balls[name].rows['time'] for name in names)]
    )
    ends = np.unique(starts[starts <= trails.until])
    inner = ends[:-1, np.newaxis] + np.diff(ends)[:, np.newaxis] * np.linspace(
        0.0, 1.0, SAMPLES_PER_MOTION, endpoint=False
    )
    before = np.nextafter(ends[1:], 0.0)
    times = np.unique(np.concatenate([ends, inner.ravel(), before]))
    for name in names:
        rows = trails.balls[name].rows
        for end in np.flatnonzero(rows['cause'] == Cause.RELEASE):
            times = times[(times < rows['time'][end - 1]) | (times >= rows['time'][end])]
    return times
