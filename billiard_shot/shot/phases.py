"""stand-in until billiard_shot.impact has Phase."""
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Phase:
    """One state of a collision."""

    active: tuple[int, ...]
    ended: int
    contact: int
    impulses: NDArray[np.float64]
    energies: NDArray[np.float64]


def phases_of(log: NDArray[np.float64]) -> tuple[Phase, ...]:
    """Read the rows of a log (see kernel.solve)."""
    count = (log.shape[1] - 2) // 5
    return tuple(
        Phase(
            tuple(np.flatnonzero(row[2:2 + count]).tolist()), int(row[0]), int(row[1]),
            row[2 + count:2 + 4 * count].reshape(count, 3), row[2 + 4 * count:],
        )
        for row in log
    )
