"""
A fit with horizons that grow, until its numbers stay, and the progress of that.

A few seconds after the strike, the smallest change of a number may lead elsewhere. So the numbers
are fitted to the first second, then to longer parts of the shots. With the last horizon, launches
are searched and numbers fitted in turn, until they move no more.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.calibration.fit import (
    fit,
    FitProblem,
    followed,
    JointFit,
    Launch,
    MapFunction,
    rescaled,
    searched,
    with_all_samples,
)
from billiard_shot.calibration.launch import FIRST_SCALES
from billiard_shot.calibration.recording import Floats

FEW_STEPS, STEPS = 4, 10
"""Most steps of the common numbers at a horizon, and at the last one."""

ROUNDS = 8
"""How often launches are searched at the last horizon, and common numbers fitted, at most."""

SETTLED = 0.25
"""
A fit has settled if launches that are searched anew, all over, move each common number by less
than this part of its standard deviation, and the next step would not either. It has converged if
then numbers elsewhere are not better.
"""

LEAST_SHOTS = 5
"""Number of shots that a fit needs."""


class FitProgress(NamedTuple):
    """The step that is being done, and the part of all steps that is done."""

    text: str
    done: int
    total: int


class Work:
    """Does the work of a calibration, and tells how much of it is done."""

    def __init__(
        self,
        mapped: MapFunction,
        progress: Callable[[FitProgress], object] | None = None,
        total: int = 0,
    ) -> None:
        self.mapped, self.text = mapped, ''
        self._progress, self._done, self._total = progress, 0, total

    def ticking(self, work: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """Do work for items; each of them counts."""
        for each in self.mapped(work, items):
            yield each
            self._done += 1
            self._say(self.text)

    def begin(self, text: str, steps: int = 0) -> None:
        """Tell what begins; it counts as a number of steps."""
        self.text = text
        self._say(text)
        self._done += steps

    def say_error(self, error: float) -> None:
        """Tell the median error of a fit [m]."""
        self._say(f'{self.text}, median error {1e3 * error:.1f} mm')

    def reach(self, done: int) -> None:
        """Count the steps before this one as done: some were not needed."""
        self._done = done
        self._say(self.text)

    def _say(self, text: str) -> None:
        if self._progress is not None:
            self._progress(FitProgress(text, self._done, self._total))


Elsewhere = Callable[[JointFit, Sequence[int]], tuple[Floats | None, list[str]]]


def fit_settled(
    problem: FitProblem,
    values: Floats,
    launches: Sequence[Launch],
    horizons: Sequence[float],
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
    wide: Floats | None = None,
    work: Work | None = None,
    elsewhere: Elsewhere = lambda *_: (None, []),
) -> tuple[JointFit, list[str]]:
    """
    Fit with all horizons in turn, with the last one until the numbers stay.

    Parameters
    ----------
    problem : FitProblem
        Its horizon does not count.
    values : (common,) float array
        With which the fit begins.
    launches : sequence of Launch
    horizons : sequence of float
        Ascending [s].
    seed : int
        Of the searches of launches.
    rounds : int
        How often launches are searched at the last horizon, and common numbers fitted, at most.
    wide : (knots,) float array, optional
        Scales of errors [m] until the last horizon, which leave no sample out; by default scales
        are those of the errors.
    work : Work, optional
        Is told each step.
    elsewhere : callable
        Returns, for a fit whose numbers stay and a seed, numbers that are better, if there are
        any, and doubts.

    Returns
    -------
    JointFit
    doubts : list of str
        The reasons if the numbers do not stay, else the doubts of `elsewhere`.

    """
    work = work or Work(problem.mapped)
    values, is_new = np.clip(values, *problem.bounds), False
    scales = FIRST_SCALES if wide is None else wide
    last = len(horizons) - 1
    for stage in range(len(horizons) + rounds):
        again = stage > last
        # Later, the same samples count in the same way.
        adapts = stage <= last + 1 or is_new
        problem = problem._replace(horizon=horizons[min(stage, last)])
        work.begin(f'first {problem.horizon:g} s')
        begun = launches if again and not is_new else with_all_samples(launches)
        ticking = problem._replace(mapped=work.ticking)
        moved = searched(ticking, values, begun, scales, (seed, stage), adapts)
        if len(moved) < LEAST_SHOTS:
            raise ValueError(
                f'recordings must have at least {LEAST_SHOTS} shots that the scene can simulate, '
                f'got {len(moved)} of {len(launches)}: are their places in m, in the frame of the '
                'table?'
            )
        found = followed(problem, values, moved, scales)
        found = rescaled(found) if adapts and (again or wide is None) else found
        found = fit(found, STEPS if stage >= last else FEW_STEPS, work.say_error)
        change = np.abs(found.values - values) / found.deviations
        better = None
        if again and max(change.max(initial=0.0), found.next_step()[1]) < SETTLED:
            better, doubts = elsewhere(found, (seed, stage))
            if better is None:
                return found, doubts
        known = {each.samples.key: each.numbers for each in begun}
        restless = [
            each.samples.name
            for each in moved
            if not np.array_equal(each.numbers, known[each.samples.key])
        ]
        is_new = better is not None
        values = found.values if better is None else better
        scales, launches = found.scales, found.launches
    shots = f'unsettled: shots {", ".join(restless)}'
    return found, [shots if restless else 'unsettled: the numbers still move']
