"""Paths of recorded balls as lines, for pictures."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.strikes import Array
from billiard_shot.table.simulate import BatchRecording

PIECES = 6  # straight lines by which a segment is approximated


class Paths(NamedTuple):
    """Paths of the cue balls of n tables."""

    moved: NDArray[np.bool_]  # (n, balls) whether the ball moved
    cue: tuple[Array, ...]  # n paths (., 2) [m]


def paths_of(recording: BatchRecording) -> Paths:
    """Find which balls moved, and the corners of the paths of the cue balls."""
    counts = np.diff(recording.tables['segments'], prepend=0)
    table = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((recording.segments['ball'], table))  # stable: in the order of time
    rows, table = recording.segments[order], table[order]
    owner, time = rows['ball'], rows['time']
    duration = np.zeros(len(rows))
    goes_on = (table[1:] == table[:-1]) & (owner[1:] == owner[:-1])
    duration[:-1] = np.where(goes_on, time[1:] - time[:-1], 0.0)
    moved = np.zeros(recording.balls.shape, np.bool_)
    moved[table[duration > 0.0], owner[duration > 0.0]] = True
    cue = owner == 0
    rows, table = rows[cue], table[cue]
    dt = duration[cue, np.newaxis, np.newaxis] * np.linspace(0.0, 1.0, PIECES + 1)[:, np.newaxis]
    corners = rows['position'][:, np.newaxis, :2] + dt * (
        rows['velocity'][:, np.newaxis, :2] + 0.5 * dt * rows['acceleration'][:, np.newaxis, :2]
    )
    return Paths(moved, tuple(corners[table == i].reshape(-1, 2) for i in range(len(counts))))
