"""
The paper's Table 1 as printed, by the model, and under variants that come near it.

The model as written does not give the printed rows. Each row is recomputed here under variants
that are stated one by one. The solver does not contain the variants, and nothing is tuned to the
printed numbers. `VariantStrike` applies the variants to the same strike in SciPy.

    python studies/paper.py
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Flag
import math
from pathlib import Path
import sys
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/paper.py`
from collections.abc import Sequence

from billiard_shot.cli.output import (
    Column,
    numbers,
    OfFormat,
    print_footer,
    print_rows,
)
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from studies.command import run_study
from studies.problem import ContactProblem
from studies.scipy_strike import EventFunction, ScipyStrike

ACCURACY = 1e-8  # of the strikes in SciPy, relative


class Variant(Flag):
    """Changes of the model as written."""

    NONE = 0
    INVERSE_RATIO = 1
    POISSON = 2
    NOT_REACTIVATED = 4
    STOP = 8
    WHOLE_SLIP = 16
    GROWING_PEAK = 32


VARIANT_MEANINGS: Mapping[Variant, str] = {
    Variant.INVERSE_RATIO: 'stiffness of tip over table 1/1.5',
    Variant.POISSON: "Poisson's law",
    Variant.NOT_REACTIVATED: 'the cue does not hit the ball again after it has left it',
    Variant.STOP: 'the impact ends when the cue would hit the ball again',
    Variant.WHOLE_SLIP: 'table alone: friction acts until its impulse is m v, not 2/7 m v',
    Variant.GROWING_PEAK: 'a recompression adds its gain to E_max',
}


# Printed velocities [m/s] and spins [rad/s]; the sign of the jump's normal is corrected.
PRINTED: Mapping[str, tuple[Stroke, tuple[float, ...]]] = {
    'vertical': (Stroke((-1, -2, 1), (0, 0, -2)), (0.3963, 0.7926, 0.4506, 27.97, -13.98, 0.0)),
    'horizontal': (Stroke((-1, -1, 0), (0.8, 0, 0)), (0.6299, 0.4614, 0.0, 0.0, 0.0, 10.42)),
    'jump': (Stroke((-1, 0, 1), (1, 0, -1)), (1.169, 0.0, 0.1883, 0.0, 13.15, 0.0)),
    'massé': (Stroke((-2, -1, 12), (4, 0, -16)), (-0.3253, 0.2938, 6.232, -88.48, 179.8, -3.178)),
}
ATTEMPTS: Mapping[str, tuple[Variant, ...]] = {
    'vertical': (
        Variant.NONE,
        Variant.INVERSE_RATIO,
        Variant.INVERSE_RATIO | Variant.NOT_REACTIVATED,
    ),
    'horizontal': (Variant.NONE, Variant.POISSON),
    'jump': (Variant.NONE, Variant.INVERSE_RATIO, Variant.INVERSE_RATIO | Variant.STOP),
    'massé': (
        Variant.NONE,
        Variant.INVERSE_RATIO,
        Variant.INVERSE_RATIO | Variant.WHOLE_SLIP,
        Variant.INVERSE_RATIO | Variant.WHOLE_SLIP | Variant.GROWING_PEAK,
    ),
}


class VariantStrike(ScipyStrike):
    """A strike under variants of the model."""

    def __init__(self, problem: ContactProblem, variant: Variant) -> None:
        super().__init__(problem)
        self.variant = variant
        self.peak, self.again = [0.0, 0.0], [0.0, 0.0]  # energies
        self.begun: tuple[Array, float] | None = None  # S2: direction of slip, friction left

    def forces_at(self, normal: Array, u: Array) -> Array:
        """Find the forces; with WHOLE_SLIP, in S2, along the slip that S2 began with."""
        force = super().forces_at(normal, u)
        if self.begun is not None and self.active == [False, True]:
            force[4:] = -self.mu[1] * normal[1] * self.begun[0]
        return force

    def events(self) -> tuple[list[tuple[str, int]], list[EventFunction]]:
        """Events, without those that the variant excludes."""
        names, functions = super().events()
        kept = [
            i
            for i, name in enumerate(names)
            if not (
                (Variant.NOT_REACTIVATED in self.variant and name == ('join', 0) and self.left)
                or (self.begun is not None and name in (('stop', 1), ('slip', 1)))
            )
        ]
        return [names[i] for i in kept], [functions[i] for i in kept]

    @property
    def left(self) -> bool:
        """Whether the cue has left the ball before."""
        return self.peak[0] > 0.0

    def handle(self, name: str, j: int, state: Array) -> None:
        """Change the state after an event, as the variant says."""
        energy = 0.5 * self.k[j] * state[j] ** 2
        if name == 'join' and j == 0 and self.left and Variant.STOP in self.variant:
            self.active = [False, False]
            return
        if name == 'again':
            self.again[j] = energy
        super().handle(name, j, state)
        if name == 'turn':
            gained = self.peak[j] + energy - self.again[j] if self.again[j] > 0.0 else energy
            self.peak[j] = gained
            if Variant.GROWING_PEAK in self.variant:
                kept = (1.0 - self.e[j] ** 2) * gained
                self.goal[j] = float(np.sqrt(2.0 * kept / self.k[j]))
        if name == 'end':
            self.again[j] = 0.0
        slip = self.velocity(state)[4:]
        alone = self.active == [False, True]
        if Variant.WHOLE_SLIP in self.variant and alone and self.begun is None:
            size = float(np.hypot(*slip))
            if size > self.still:
                self.begun = slip / size, size
        if not alone:
            self.begun = None


def variant_label(variant: Variant) -> str:
    """Say what a variant changes."""
    return '; '.join(VARIANT_MEANINGS[part] for part in variant) or 'as written'


@dataclass(frozen=True, slots=True)
class ReproducedRow:
    """A row of Table 1 under a variant: velocity and spin, and residuals from the printed ones."""

    name: str
    variant: Variant
    numbers: Array  # (6,)
    velocity: float  # residual over the printed velocity's length
    spin: float  # residual over the printed spin's length


def reproduce(name: str, variant: Variant) -> ReproducedRow:
    """Recompute a row under a variant."""
    stroke, printed = PRINTED[name]
    scene = Scene.load('paper')
    if Variant.INVERSE_RATIO in variant:
        tip = replace(scene.contacts.cue_ball, stiffness=1 / 1.5)
        scene = replace(scene, contacts=replace(scene.contacts, cue_ball=tip))
    if Variant.POISSON in variant:
        scene = replace(scene, law='poisson')
    problem = ContactProblem.of(scene, stroke)
    if variant & ~(Variant.INVERSE_RATIO | Variant.POISSON):
        impulse = VariantStrike(problem, variant).solve(ACCURACY)
    else:  # the library has these variants as parameters
        impulse, _, _ = problem.adaptive(1e-12)
    velocity, spin, _ = problem.motion(impulse)
    v, w = np.array(printed[:3]), np.array(printed[3:])
    return ReproducedRow(
        name,
        variant,
        np.concatenate([velocity, spin]),
        float(np.linalg.norm(velocity - v) / np.linalg.norm(v)),
        float(np.linalg.norm(spin - w) / np.linalg.norm(w)),
    )


def _off(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.1g}'


PAPER_COLUMNS = (
    Column('shot'),
    Column('variant'),
    Column('velocity', '  velocity (m/s)', '  x y z', lambda vector: numbers(vector, 4)),
    Column('spin', 'spin (rad/s)', 'x y z', lambda vector: numbers(vector, 3)),
    Column('off_velocity', 'off by', 'velocity', _off),
    Column('off_spin', ' ', 'spin', _off),
)
FOOTER = (
    'velocity and spin: of the ball after the strike. off by: distance from the printed vector, '
    'relative to its length. The law of all rows is energetic, unless the row names another.'
)


OPTIONS = (OfFormat(),)


def run(options: argparse.Namespace) -> int:
    """Recompute and print."""
    rows = []
    for name, variants in ATTEMPTS.items():
        rows.append(_row(name, 'printed', PRINTED[name][1], math.nan, math.nan))
        for variant in variants:
            row = reproduce(name, variant)
            rows.append(_row(name, variant_label(variant), row.numbers, row.velocity, row.spin))
    print_rows(PAPER_COLUMNS, rows, options, 'title')
    print_footer(FOOTER, options)
    return 0


def _row(
    shot: str, variant: str, values: Iterable[float], off_velocity: float, off_spin: float
) -> dict[str, Any]:
    numbers = [float(value) for value in values]
    return {
        'title': f'{shot}, {variant}',
        'shot': shot,
        'variant': variant,
        'velocity': numbers[:3],
        'spin': numbers[3:],
        'off_velocity': off_velocity,
        'off_spin': off_spin,
    }


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())
