"""
The paper's section 2, for its Figs. 3 to 5: a ball falls onto another one on a table.

Impulses are upward, I1 on the falling ball and I2 on the lower one; velocities are upward, too.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import cumulative_trapezoid

from billiard_shot.pictures.history import CollisionTrace, STATE_NAMES, trace_of_collision
from billiard_shot.records import Array
from studies.collisions import stacked

PING_PONG = (0.807755, 0.846529)  # restitution of ball on ball and of ball on plexiglass (2.4)


@dataclass(frozen=True, slots=True)
class ImpactState:
    """
    A state of the collision.

    Attributes
    ----------
    name : str
        S1: both impacts act; S2: only the impact on the table; S3: only that of the balls.
    events : str
        In their order. C1, C2: end of compression of the balls' or of the table's impact; R1, R2:
        end of its restitution.
    samples : slice
        Samples of the trace.

    """

    name: str
    events: str
    samples: slice


@dataclass(frozen=True, slots=True)
class TwoBalls:
    """A ball of mass m1 [kg] falls at v0 < 0 [m/s] onto one of m2; by default that of Fig. 4."""

    masses: tuple[float, float] = (1.0, 1.0)
    restitution: tuple[float, float] = (math.sqrt(0.9), math.sqrt(0.4))
    ratio: float = 10.0  # k2 / k1
    v0: float = -3.0
    law: str = 'energetic'

    def trace(self) -> CollisionTrace:
        """Trace the collision."""
        balls = stacked(self.masses, self.restitution, self.ratio, -self.v0)
        return trace_of_collision(balls.bodies, balls.contacts, self.law)

    def outcome(self) -> tuple[float, float]:
        """Velocities of the two balls after the collision [m/s]."""
        result = stacked(self.masses, self.restitution, self.ratio, -self.v0).solve(
            self.law, 1e-12
        )
        return float(result.velocities[0, 2]), float(result.velocities[1, 2])

    def velocities(self, impulses: ArrayLike) -> Array:
        """Velocities (n, 2) [m/s] after impulses (n, 2) [N s]: the paper's equation 13."""
        first, second = np.transpose(impulses)
        return np.column_stack(
            [self.v0 + first / self.masses[0], (second - first) / self.masses[1]]
        )

    def kinetic_energy(self, impulses: ArrayLike) -> Array:
        """Kinetic energy (n,) [J] after impulses (n, 2) [N s]."""
        energy: Array = 0.5 * self.velocities(impulses) ** 2 @ np.array(self.masses)
        return energy

    def losses(self, impulses: ArrayLike) -> Array:
        """
        Energies (n, 2) [J] that the impacts have taken until each of the impulses (n, 2) [N s].

        Each is the work -∫ u dI of its impact, where u is the velocity at which its bodies part.
        It includes the elastic energy.
        """
        upper, lower = self.velocities(impulses).T
        parting = np.column_stack([upper - lower, lower])
        work: Array = cumulative_trapezoid(-parting, impulses, axis=0, initial=0.0)
        return work

    def ellipse(self, count: int = 361) -> Array:
        """
        Impulses (count, 2) [N s] that leave the kinetic energy as it was: equation 15.

        Impulses outside this ellipse are impossible: they would need more energy than there was.
        """
        angle = np.linspace(0.0, 2.0 * math.pi, count)
        m1, m2 = self.masses
        first = -m1 * self.v0 * (1.0 + np.cos(angle))
        return np.column_stack([first, first + self.v0 * math.sqrt(m1 * m2) * np.sin(angle)])

    def compression_lines(self, first: ArrayLike) -> tuple[Array, Array]:
        """I2 [N s] at the end of compression of the balls, and of ball and table: equation 12."""
        i1 = np.asarray(first, float)
        m1, m2 = self.masses
        return m2 * (self.v0 + (1.0 / m1 + 1.0 / m2) * i1), i1.copy()

    def states(self, trace: CollisionTrace) -> list[ImpactState]:
        """Name the states that the collision went through, and what happened in each."""
        parts = trace.phases()
        return [
            ImpactState(
                STATE_NAMES[tuple(trace.active[part][0].tolist())],
                '-'.join(_turns(trace, part) + _ends(trace, part, after)),
                part,
            )
            for part, after in zip(parts, [*parts[1:], None], strict=True)
        ]


def normal_impulses(trace: CollisionTrace) -> Array:
    """I1 and I2 (n, 2) [N s]."""
    return trace.impulses[:, [0, 3]]


def _turns(trace: CollisionTrace, part: slice) -> list[str]:
    """Find the ends of compression within a state, in order of time."""
    found = []
    for j in (0, 1):
        approach = trace.velocities[part, 3 * j]
        turn = np.flatnonzero((approach[:-1] < 0.0) & (approach[1:] >= 0.0))
        if trace.active[part, j].all():
            found += [(int(i), f'C{j + 1}') for i in turn]
    return [name for _, name in sorted(found)]


def _ends(trace: CollisionTrace, part: slice, after: slice | None) -> list[str]:
    """Find the ends of restitution with which a state ends."""
    active = trace.active[part][-1]
    then = trace.active[after][0] if after else np.zeros_like(active)
    return [f'R{j + 1}' for j in (0, 1) if active[j] and not then[j]]
