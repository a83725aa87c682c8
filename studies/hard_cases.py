"""
Hard cases, solved by both laws and checked; `hard_case_families` has the cases.

The checks: no exception, no NaN, a status that the case allows, the value that the case states, no
energy gained, one answer for all orders of contacts, errors within the tolerances, and a small
change of the answer if the numbers change a little. A hopeless case may end at the budget of
steps. Its result must then be finite and without a gain of energy, and it must not go on beyond
the budget. The stated values in hard_cases.csv come from test/studies/stated_values.py, which
shares no code with the solver.

    python studies/hard_cases.py [WORD ...] [--list]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
import csv
from dataclasses import dataclass, replace
import functools
import math
from pathlib import Path
import sys
from time import perf_counter
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/hard_cases.py`
from collections.abc import Sequence

from billiard_shot.cli.options import positional
from billiard_shot.cli.output import Column, OfFormat, print_rows, progress, wants_text
from billiard_shot.cli.workers import mapped, OfWork
from billiard_shot.impact.integrator import steps_allowed
from billiard_shot.records import Array
from billiard_shot.shot.predict import predict
from billiard_shot.status import Status
from studies.collisions import Collision, StrikeCollision
from studies.command import run_study
from studies.hard_case_families import families, Family

CHECKED_LAWS = ('bistiffness', 'energetic')
TIGHT = 1e-12
CHECKED_TOLERANCES = (1e-10, 1e-8, 1e-6, 1e-4)
GAIN = 1e-12  # energy at the tight tolerance, relative to the energy before
# Relative change of all numbers, and of the answer at most.
DISTURBANCE, MAX_ANSWER_CHANGE = 1e-10, 1e-6
SAME = 1e-9  # between orders of contacts, and between `collide` and `predict`
SUM_ERROR_FACTOR = 10.0  # errors of a velocity that is a sum of several, in tolerances
STRICTEST_TOLERANCE = 1e-14  # m at 1 m/s, below the error that `predict` reaches


@dataclass(frozen=True, slots=True)
class CaseOutcome:
    """Result of a collision: its motion as in `Collision.motion`, and its relative energy gain."""

    status: Status
    states: int
    steps: int
    motion: Array
    gain: float

    @classmethod
    def of(cls, case: Collision, law: str, tolerance: float) -> CaseOutcome:
        """Solve a case."""
        result = case.solve(law, tolerance)
        before = case.energy(*case.start)
        return cls(
            result.status,
            len(result.phases),
            result.evaluations,
            case.motion(result.velocities, result.spins),
            (case.energy(result.velocities, result.spins) - before) / before,
        )

    def from_(self, other: CaseOutcome | Array) -> float:
        """Largest difference from another motion; infinite if it is not finite."""
        numbers = other.motion if isinstance(other, CaseOutcome) else other
        gap = float(np.abs(self.motion - numbers).max())
        return gap if np.isfinite(gap) else np.inf


@dataclass(frozen=True, slots=True)
class CaseResult:
    """
    Result of a case under one law.

    Attributes
    ----------
    family, member, law : str
    outcome : CaseOutcome
        At the tight tolerance.
    seconds : float
        Time of this solution [s].
    off : float
        Difference from the stated value; NaN if the case states no value.
    order : float
        Change of the answer with the order of contacts.
    sensitivity : float
        Change of the answer per relative change of the collision's numbers.
    faults : tuple of str
        Checks that failed.

    """

    family: str
    member: str
    law: str
    outcome: CaseOutcome
    seconds: float
    off: float
    order: float
    sensitivity: float
    faults: tuple[str, ...]


def examine(family: Family, member: str, law: str) -> CaseResult:
    """Solve a case in all variants, and compare the results."""
    case = family.members[member]
    begin = perf_counter()
    tight = CaseOutcome.of(case, law, TIGHT)
    seconds = perf_counter() - begin
    if member in family.hopeless:
        outcomes = (
            tight,
            *(CaseOutcome.of(case, law, tolerance) for tolerance in CHECKED_TOLERANCES),
        )
        if any(outcome.status == Status.BUDGET_EXCEEDED for outcome in outcomes):
            return _of_hopeless(family, member, law, case, outcomes, seconds)
    moved = CaseOutcome.of(case.disturbed(DISTURBANCE, seed=1), law, TIGHT).from_(tight)
    sensitivity = moved / DISTURBANCE
    order = max(
        (
            CaseOutcome.of(case.reordered(permutation), law, TIGHT).from_(tight)
            for permutation in _orders(len(case.contacts))
        ),
        default=0.0,
    )
    within, stated = stated_values().get((family.name, member, law), (np.inf, ()))
    values = [np.array(value) for value in stated]
    off = min((tight.from_(value) for value in values), default=np.nan)
    faults = [*_of_outcome(family, tight, GAIN)]
    for tolerance in CHECKED_TOLERANCES:
        allowed = SUM_ERROR_FACTOR * tolerance * (1.0 + sensitivity)
        loose = CaseOutcome.of(case, law, tolerance)
        found = [*_of_outcome(family, loose, allowed)]
        error = loose.from_(tight)
        if len(values) > 1:  # the law jumps here: a solution may be on either side
            error = min(error, *(loose.from_(value) - within for value in values))
        if not error <= allowed:
            found.append(f'off by {error:.1g}')
        faults += [f'{fault} at tolerance {tolerance:g}' for fault in found]
    if not moved <= MAX_ANSWER_CHANGE and not family.sensitive:
        faults.append(f'moves by {moved:.1g} where its numbers change by {DISTURBANCE:g}')
    # the rounding of every step adds up
    if not order <= SAME * (1.0 + sensitivity) * max(1.0, tight.steps / 100):
        faults.append(f'moves by {order:.1g} with the order of contacts')
    if off > within:
        faults.append(f'is off the stated value by {off:.1g}, more than {within:g}')
    # Under `bistiffness` the bodies of a prediction move during the strike.
    if isinstance(case, StrikeCollision) and law != 'bistiffness':
        faults += _of_prediction(case, tight, law, SAME * (1.0 + sensitivity))
    return CaseResult(
        family.name,
        member,
        law,
        tight,
        seconds,
        off,
        order=order,
        sensitivity=sensitivity,
        faults=tuple(faults),
    )


def _of_hopeless(
    family: Family,
    member: str,
    law: str,
    case: Collision,
    outcomes: tuple[CaseOutcome, ...],
    seconds: float,
) -> CaseResult:
    """Check a case that exceeds the budget at some tolerance."""
    most = 1.01 * steps_allowed(len(case.contacts))
    faults = []
    for outcome, tolerance in zip(outcomes, (TIGHT, *CHECKED_TOLERANCES), strict=True):
        allowed = replace(family, status=(*family.status, Status.BUDGET_EXCEEDED))
        faults += [
            f'{fault} at tolerance {tolerance:g}'
            for fault in _of_outcome(allowed, outcome, SUM_ERROR_FACTOR * tolerance)
        ]
        if outcome.steps > most:
            faults.append(f'takes {outcome.steps} steps at tolerance {tolerance:g}')
    return CaseResult(
        family.name,
        member,
        law,
        outcomes[0],
        seconds,
        np.nan,
        order=np.nan,
        sensitivity=np.nan,
        faults=tuple(faults),
    )


def _orders(count: int) -> Iterator[tuple[int, ...]]:
    """Orders of contacts to try: backwards, and two where neighbours are no longer neighbours."""
    if count > 1:
        yield tuple(reversed(range(count)))
    if count > 2:
        yield (*range(0, count, 2), *range(1, count, 2))
        yield (*range(1, count, 2), *range(0, count, 2))


def _of_outcome(family: Family, outcome: CaseOutcome, gain: float) -> Iterator[str]:
    if outcome.status not in family.status:
        yield f'ends in {outcome.status.name}'
    if not np.isfinite(outcome.motion).all():
        yield 'is not finite'
    if not outcome.gain <= gain:
        yield f'gains {outcome.gain:.1g} of its energy'


def _of_prediction(
    case: StrikeCollision, tight: CaseOutcome, law: str, allowed: float
) -> Iterator[str]:
    """Compare with `predict`, which finds contact space independently; without double hits."""
    effects = replace(case.scene.effects, double_hit='off')
    scene = replace(case.scene, law=law, effects=effects)
    shot = predict(scene, case.stroke, tolerance=STRICTEST_TOLERANCE * case.speed**2)
    radius = np.sqrt(scene.ball.inertia / scene.ball.mass)
    motion = np.concatenate([shot.velocity, radius * shot.spin]) / case.speed
    gap = np.abs(motion - tight.motion[3:]).max()
    if not gap <= allowed:
        yield f'`predict` differs by {gap:.1g}'
    shot = predict(scene, case.stroke)
    if shot.status.refused or shot.status == Status.BUDGET_EXCEEDED:
        yield f'`predict` ends in {shot.status.name}'
    if not np.isfinite((*shot.trajectory.final_position, shot.error_estimate)).all():
        yield '`predict` is not finite'


ReferenceValue = tuple[float, tuple[tuple[float, ...], ...]]


@functools.cache
def stated_values() -> dict[tuple[str, str, str], ReferenceValue]:
    """
    Return the results that the cases must give, by family, member and law.

    Returns
    -------
    dict
        Largest error allowed, relative to the speed, and the alternatives (two if law `energetic`
        is discontinuous) of the motion as in `Collision.motion`.

    """
    values: dict[tuple[str, str, str], ReferenceValue] = {}
    with Path(__file__).with_name('hard_cases.csv').open() as file:
        for row in csv.DictReader(file):
            key = row['family'], row['member'], row['law']
            _, alternatives = values.get(key, (0.0, ()))
            motion = tuple(float(number) for number in row['motion'].split())
            values[key] = float(row['within']), (*alternatives, motion)
    return values


LEGEND = """
Steps: at tolerance 1e-12. off: error relative to the speed; gain: relative
energy gain; order: change with the order of contacts; sens (sensitivity):
change of the result per relative change of the input. States and times: --csv
or --json."""


def _power(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.0e}'


CASE_COLUMNS = (
    Column('case'),
    Column('law', 'case, law'),
    Column('steps', 'steps'),
    Column('off', 'off', '', _power),
    Column('gain', 'gain', '', _power),
    Column('order', 'order', '', _power),
    Column('sensitivity', 'sens', '', _power),
    Column('holds', 'holds', '', lambda holds: 'yes' if holds else 'no'),
    Column('status', 'status'),
    Column('states'),
    Column('seconds'),
)


@dataclass(frozen=True)
class OfCases:
    """
    The cases.

    Parameters
    ----------
    words : WORD
        Solve only cases with all these words in family and name.
    list_ : bool
        Describe each family and why it breaks other solvers; solve nothing.

    """

    words: list[str] = positional('*')
    list_: bool = False


OPTIONS = OfCases(), OfFormat(), OfWork()


def run(options: argparse.Namespace) -> int:
    """Solve and print; 1 if a check fails."""
    chosen = [
        (family, member)
        for family in families()
        for member in family.members
        if all(word in f'{family.name}: {member}' for word in options.words)
    ]
    if not chosen:
        raise ValueError(f'WORD: {" ".join(options.words)!r} is not part of any case; see --list')
    if options.list:
        for family in dict.fromkeys(family.name for family, _ in chosen):
            about = next(entry for entry, _ in chosen if entry.name == family)
            print(f'{family}: {about.breaks}')
            print(*(f'    {member}' for entry, member in chosen if entry.name == family), sep='\n')
        return 0
    tasks = [(family, member, law) for family, member in chosen for law in CHECKED_LAWS]
    results = list(progress(mapped(options, _examined, tasks), 'hard cases', len(tasks)))
    print_rows(CASE_COLUMNS, [_row(result) for result in results], options, 'case')
    bad = [v for v in results if v.faults]
    if not wants_text(options):
        return 1 if bad else 0
    print(LEGEND)
    for v in bad:
        print(f'\n{v.family}: {v.member}, {v.law}')
        print(*(f'    {fault}' for fault in v.faults), sep='\n')
    print(f'\n{len(results) - len(bad)} of {len(results)} cases hold')
    return 1 if bad else 0


def _examined(task: tuple[Family, str, str]) -> CaseResult:
    return examine(*task)


def _row(v: CaseResult) -> dict[str, Any]:
    return {
        'case': f'{v.family}: {v.member}',
        'law': v.law,
        'steps': v.outcome.steps,
        'off': v.off,
        'gain': max(v.outcome.gain, 0.0),
        'order': v.order,
        'sensitivity': v.sensitivity,
        'holds': not v.faults,
        'status': v.outcome.status.name,
        'states': v.outcome.states,
        'seconds': v.seconds,
    }


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())
