"""The result of a search: strokes with their success probabilities."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from billiard_shot.planning.kind import kind_of
from billiard_shot.planning.limits import Limits
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.planning.targets import Target
from billiard_shot.scene import Noise, Scene
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status


@dataclass(frozen=True, eq=False)
class RankedStroke:
    """
    A stroke with its success probability under execution noise.

    Attributes
    ----------
    stroke : Stroke
    success : float
        Fraction of the trials that reached the target.
    interval : (float, float)
        95 % confidence interval of the success probability (Wilson).
    trials : int
        Simulated strokes with random errors behind `success`. They are held-out trials, which had
        no part in the choice of the stroke. If the search was cancelled, they are the samples of
        the search itself: `success` can then be too large, and their errors too widely spread.

    """

    scene: Scene = field(repr=False)
    target: Target = field(repr=False)
    limits: Limits = field(repr=False)
    stroke: Stroke
    successes: int = field(repr=False)
    trials: int

    @property
    def success(self) -> float:
        """Estimated success probability."""
        return self.successes / self.trials

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the success probability."""
        return wilson_interval(self.successes, self.trials)

    @cached_property
    def shot(self) -> Shot:
        """Prediction of the stroke without errors; computed when first used."""
        return predict(self.scene, self.stroke)

    @cached_property
    def warning(self) -> str:
        """What the stroke does wrong even without errors; empty if it reaches its target."""
        problem = problem_of(self.scene, self.target, self.limits, self.scene.noise)
        shot = self.shot
        if shot.table is None:
            return ''
        faults = [
            f'ball {ball!r} falls into a pocket'
            for ball in shot.table.pocketed
            if problem.rules['must_stay'][problem.names.index(ball)]
        ]
        met = shot.table.first_met.get(problem.names[0])
        if met is not None and not problem.may_meet(problem.names.index(met)):
            faults.append(f'the cue ball meets ball {met!r} first')
        faults += [f'ball {ball!r} leaves the table' for ball in shot.table.off_table]
        return f'without errors {" and ".join(faults)}' if faults else ''

    @cached_property
    def kind(self) -> str:
        """What players call the shot: cut, bank, kick, massé ..."""
        return kind_of(self.shot, self.target)


@dataclass(frozen=True, eq=False)
class PlanResult:
    """
    Result of a search.

    Attributes
    ----------
    status : Status
        OK, NO_PLAN, CANCELLED (with the best so far, if any), or INVALID_REQUEST.
    message : str
        The same in one line; for an invalid request, what to change.
    ranking : tuple of RankedStroke
        First the winner of a race under common errors, in which held-out trials have no part; then
        the others by the lower end of the interval of their success.
    simulations : int
        Number of simulated strokes.
    wall_time : float
        [s]
    noise : Noise
        Execution noise under which the success was estimated.
    converged : bool
        Whether two searches from different random numbers agree on the success of the best stroke.

    """

    status: Status
    message: str
    ranking: tuple[RankedStroke, ...]
    simulations: int
    wall_time: float
    noise: Noise
    converged: bool = False

    @property
    def best(self) -> RankedStroke | None:
        """The best stroke, None if no stroke was found."""
        return self.ranking[0] if self.ranking else None
