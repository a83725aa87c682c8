"""The recorded motion of many tables as arrays: one entry a stretch of constant acceleration."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.strikes import Rows
from billiard_shot.table.motion import BALL, CLUSTER, POCKETED
from billiard_shot.table.simulate import BatchRecording

PIECES = 6  # straight ones, into which a stretch is cut
FAR = 1e3  # m: a distance that stands for no distance at all


class Motions(NamedTuple):
    """Stretches in the order of tables, of balls, and of time."""

    tables: int
    table: NDArray[np.int64]  # (n,) which table
    ball: NDArray[np.int64]  # (n,) which ball
    time: Rows  # (n,) s, when it begins
    duration: Rows  # (n,) s; 0 for the last one of a ball
    after_ball: NDArray[np.bool_]  # (n,) whether it began as balls met
    place: Rows  # (n, 3) m, at the beginning
    velocity: Rows  # (n, 3) m/s
    corners: Rows  # (n, PIECES + 1, 2) m: points of the path, seen from above

    def of(self, which: NDArray[np.bool_]) -> 'Motions':
        """Pick some of the stretches."""
        fields: Any = (field[which] for field in self[1:])
        return Motions(self.tables, *fields)

    def met(self, ball: int) -> Rows:
        """When a ball first meets another one (tables,) [s]; infinite: never."""
        first = np.full(self.tables, np.inf)
        which = (self.ball == ball) & self.after_ball
        np.minimum.at(first, self.table[which], self.time[which])
        return first

    def least(self, values: Rows) -> Rows:
        """Least of the values (n,) of each table (tables,), `FAR` where there is none."""
        found = np.full(self.tables, FAR)
        np.minimum.at(found, self.table, values)
        return found

    def nearest(self, point: Rows) -> Rows:
        """How near the paths come to a point (tables,) [m], seen from above."""
        return self.least(self.distances(point))

    def distances(self, point: Rows) -> Rows:
        """How near each stretch comes to a point (n,) [m]; `point` (2,) or (n, 2)."""
        begin = self.corners[:, :-1] - np.reshape(point, (-1, 1, 2))
        along = np.diff(self.corners, axis=1)
        square = (along**2).sum(axis=2)
        with np.errstate(invalid='ignore', divide='ignore'):
            part = np.clip(-(begin * along).sum(axis=2) / square, 0.0, 1.0)
        nearest = begin + np.where(square > 0.0, part, 0.0)[:, :, np.newaxis] * along
        distances: Rows = np.sqrt((nearest**2).sum(axis=2).min(axis=1))
        return distances


def motions_of(recording: BatchRecording) -> Motions:
    """Sort what was recorded."""
    counts = np.diff(recording.tables['segments'], prepend=0)
    table = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((recording.segments['ball'], table))  # stable: in the order of time
    rows, table = recording.segments[order], table[order]
    owner, time = rows['ball'], rows['time']
    duration = np.zeros(len(rows))
    goes_on = (table[1:] == table[:-1]) & (owner[1:] == owner[:-1])
    duration[:-1] = np.where(goes_on, time[1:] - time[:-1], 0.0)
    place, velocity = rows['position'], rows['velocity']
    acceleration = rows['acceleration'][:, :2]
    dt = duration[:, np.newaxis, np.newaxis] * np.linspace(0.0, 1.0, PIECES + 1)[:, np.newaxis]
    corners = place[:, np.newaxis, :2] + dt * (
        velocity[:, np.newaxis, :2] + 0.5 * dt * acceleration[:, np.newaxis]
    )
    met = np.isin(rows['cause'], (BALL, CLUSTER)) & (rows['motion'] < POCKETED)
    return Motions(len(counts), table, owner, time, duration, met, place, velocity, corners)
