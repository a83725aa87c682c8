"""Recorded motion of many tables as arrays, one entry per segment of constant acceleration."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.strikes import Array
from billiard_shot.table.motion import BALL, CLUSTER, POCKETED
from billiard_shot.table.simulate import BatchRecording

PIECES = 6  # straight lines by which a segment is approximated
FAR = 1e3  # m: stands for "no distance"


class Segments(NamedTuple):
    """Segments ordered by table, then by ball, then by time."""

    tables: int  # how many there are
    table: NDArray[np.int64]  # (n,) index of the table
    ball: NDArray[np.int64]  # (n,) index of the ball
    time: Array  # (n,) s, start
    duration: Array  # (n,) s; 0 for the last segment of a ball
    after_ball: NDArray[np.bool_]  # (n,) whether it starts with a collision of balls
    place: Array  # (n, 3) m, at the start
    velocity: Array  # (n, 3) m/s
    corners: Array  # (n, PIECES + 1, 2) m: points of the path, seen from above

    def of(self, which: NDArray[np.bool_]) -> 'Segments':
        """Select some of the segments."""
        fields: Any = (field[which] for field in self[1:])
        return Segments(self.tables, *fields)

    def met(self, ball: int) -> Array:
        """Time at which a ball first meets another one (tables,) [s]; infinite if never."""
        first = np.full(self.tables, np.inf)
        which = (self.ball == ball) & self.after_ball
        np.minimum.at(first, self.table[which], self.time[which])
        return first

    def minimum(self, values: Array) -> Array:
        """Smallest of the values (n,) of each table (tables,), `FAR` if it has none."""
        found = np.full(self.tables, FAR)
        np.minimum.at(found, self.table, values)
        return found

    def nearest(self, point: Array) -> Array:
        """Smallest horizontal distance of the paths from a point (tables,) [m]."""
        return self.minimum(self.distances(point))

    def distances(self, point: Array) -> Array:
        """Smallest horizontal distance of each segment (n,) from a point (2,) or (n, 2) [m]."""
        begin = self.corners[:, :-1] - np.reshape(point, (-1, 1, 2))
        along = np.diff(self.corners, axis=1)
        square = (along**2).sum(axis=2)
        with np.errstate(invalid='ignore', divide='ignore'):
            part = np.clip(-(begin * along).sum(axis=2) / square, 0.0, 1.0)
        nearest = begin + np.where(square > 0.0, part, 0.0)[:, :, np.newaxis] * along
        distances: Array = np.sqrt((nearest**2).sum(axis=2).min(axis=1))
        return distances


def segments_of(recording: BatchRecording) -> Segments:
    """Sort the recorded segments."""
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
    return Segments(len(counts), table, owner, time, duration, met, place, velocity, corners)
