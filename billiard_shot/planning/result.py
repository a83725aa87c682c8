"""The result of a search: strokes with their success probabilities."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.notebook import Shown
from billiard_shot.planning.evaluate import evaluate_strokes
from billiard_shot.planning.kind import kind_of
from billiard_shot.planning.limits import Limits
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.statistics import chance_in_words, estimate_in_words, wilson_interval
from billiard_shot.planning.targets import Target
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.player import OFFSETS
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.data_frame import data_frame


@dataclass(frozen=True, eq=False)
class RankedStroke:
    """
    A stroke with its success probability under execution noise.

    Attributes
    ----------
    stroke : Stroke
        As it is to be executed.
    command : Stroke
        The stroke to command: the bias of the player's errors is corrected.
    success : float
        Fraction of the trials that reached the target.
    interval : (float, float)
        95 % confidence interval of the success probability (Wilson).
    trials : int
        Number of simulated strokes with random errors that `success` comes from. They are held-out
        trials, which had no part in the choice of the stroke. If the search was cancelled, they
        are the samples of the search itself. Then `success` can be too large, and the errors can
        be larger than the execution noise.
    value : float
        Mean value of the outcomes of these trials, see `plan`; the success, if nothing else is
        asked for.
    value_error : float
        Standard error of that mean.

    """

    scene: Scene = field(repr=False)
    target: Target = field(repr=False)
    limits: Limits = field(repr=False)
    stroke: Stroke
    command: Stroke = field(repr=False)
    successes: int = field(repr=False)
    trials: int
    value: float = field(repr=False)
    value_error: float = field(repr=False)

    def __repr__(self) -> str:
        return f'RankedStroke({self.kind}: success {self.estimate}, {self.stroke!r})'

    @property
    def success(self) -> float:
        """Estimated success probability."""
        return self.successes / self.trials

    @property
    def chance(self) -> str:
        """`success` in words, such as `85 %`; as a count if trials are few or all succeeded."""
        return chance_in_words(self.success, self.trials)

    @property
    def estimate(self) -> str:
        """`chance` with its interval, such as `85 % (95 % CI 79 to 89 %)`."""
        return estimate_in_words(self.success, self.trials, self.interval)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the success probability."""
        return wilson_interval(self.successes, self.trials)

    @property
    def surely(self) -> float:
        """Lower end of the 95 % interval of the value (Wilson)."""
        return wilson_interval(self.value * self.trials, self.trials)[0]

    @property
    def width(self) -> float:
        """Width of the 95 % interval of the value."""
        low, high = wilson_interval(self.value * self.trials, self.trials)
        return high - low

    @cached_property
    def shot(self) -> Shot:
        """Prediction of the stroke without errors; computed when first used."""
        return predict(self.scene, self.stroke)

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the stroke without errors, see `Shot.plot`."""
        return self.shot.plot(path)

    def view(self, path: str | Path | None = None) -> Path:
        """Write the page of the stroke without errors, see `Shot.view`."""
        return self.shot.view(path)

    @cached_property
    def warning(self) -> str:
        """Faults of the stroke even without errors; empty if it reaches its target."""
        problem = problem_of(self.scene, self.target, self.limits, self.scene.noise)
        shot = self.shot
        faults = [
            f'ball {ball!r} falls into a pocket'
            for ball in shot.pocketed
            if problem.rules['must_stay'][problem.names.index(ball)]
        ]
        met = shot.first_contact
        if met is not None and not problem.may_meet(problem.names.index(met)):
            faults.append(f'the cue ball meets ball {met!r} first')
        faults += [f'ball {ball!r} leaves the table' for ball in shot.off_table]
        if shot.miscue:
            faults.append('the tip slides on the cue ball')
        if shot.double_hit is not None:
            faults.append('the cue hits the cue ball again')
        exactly = np.array([self.stroke.offsets])
        if not faults and not evaluate_strokes(problem, exactly).success[0]:
            faults = ['the target is missed']
        return f'without errors {" and ".join(faults)}' if faults else ''

    @cached_property
    def kind(self) -> str:
        """Players' name for the shot: cut, bank, kick, massé ..."""
        return kind_of(self.shot, self.target)


@dataclass(frozen=True, eq=False)
class PlanResult(Shown):
    """
    Result of a search.

    Attributes
    ----------
    status : Status
        OK, NO_PLAN, or CANCELLED (with the best so far, if any).
    message : str
        The same in one line.
    ranking : tuple of RankedStroke
        A race under common errors has a winner, in which held-out trials have no part. First come
        the strokes whose interval contains its success or lies above it, the slowest first; then
        the others by the lower end of their interval. If `plan` has a `value`, the winner is
        first.
    simulations : int
        Number of simulated strokes.
    wall_time : float
        [s]
    noise : Noise
        Execution noise under which the success was estimated.
    converged : bool
        Whether two searches from different random numbers agree on the success of the best stroke,
        and its interval is not wider than 0.1.
    place : (x, y), optional
        Where to put a cue ball in hand [m], if the plan was asked for that.

    """

    status: Status
    message: str
    ranking: tuple[RankedStroke, ...]
    simulations: int
    wall_time: float
    noise: Noise
    converged: bool = False
    place: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return f'PlanResult({self.status.name}: {self.message}; strokes: {len(self.ranking)})'

    @property
    def best(self) -> RankedStroke | None:
        """The best stroke, None if no stroke was found."""
        return self.ranking[0] if self.ranking else None

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each stroke, the best first; angles in radians.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        strokes = [each.stroke.offsets for each in self.ranking]
        columns = {
            'kind': [each.kind for each in self.ranking],
            'success': [each.success for each in self.ranking],
            'low': [each.interval[0] for each in self.ranking],
            'high': [each.interval[1] for each in self.ranking],
            'trials': [each.trials for each in self.ranking],
            'warning': [each.warning for each in self.ranking],
        }
        columns |= {name: [stroke[i] for stroke in strokes] for i, name in enumerate(OFFSETS)}
        return data_frame(columns)
