"""Measured joints, from messages that may have some of the joints."""

from collections.abc import Sequence
import math

import numpy as np

from billiard_shot.records import Array


class JointFeedback:
    """
    Collects messages until every joint has been measured again.

    Parameters
    ----------
    names : sequence of str
        Names of the joints in messages, in the order of `mechanism.JOINTS`.

    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        count = len(self._names)
        self._position, self._velocity = np.full(count, math.nan), np.full(count, math.nan)
        self._open = set(range(count))  # joints that are still missing

    @property
    def missing(self) -> str:
        """Names of the joints that have not been measured since the last complete set."""
        return ', '.join(self._names[i] for i in sorted(self._open))

    def update(
        self, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[Array, Array] | None:
        """
        Take a message; return positions and velocities (6,) once all joints were measured again.

        A missing velocity is NaN, as joint_state_broadcaster of ros2_control sends it. It is not
        computed from positions: at 100 Hz, stamps that are 0.2 ms off give a speed at the contact
        that is 3 % off.

        Parameters
        ----------
        names : sequence of str
            Joints of the message, in any order; other joints are ignored.
        positions, velocities : sequence of float
            As long as `names`, or empty [m, rad; per s].

        """
        if len(velocities) == 0:
            velocities = (math.nan,) * len(positions)
        for name, position, velocity in zip(names, positions, velocities, strict=False):
            if name in self._names:
                i = self._names.index(name)
                self._position[i], self._velocity[i] = position, velocity
                self._open.discard(i)
        if self._open:
            return None
        self._open = set(range(len(self._names)))
        return self._position.copy(), self._velocity.copy()
