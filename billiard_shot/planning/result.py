"""What a search gives back: strokes with their chances."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from billiard_shot.planning.chance import wilson
from billiard_shot.planning.kind import kind_of
from billiard_shot.planning.limits import Limits
from billiard_shot.planning.targets import Target
from billiard_shot.scene import Noise, Scene
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status


@dataclass(frozen=True, eq=False)
class RankedStroke:
    """
    A stroke, and how surely it reaches the target under noise.

    Attributes
    ----------
    stroke : Stroke
    success : float
        Part of the trials that reached the target.
    interval : (float, float)
        That holds the true chance in 95 % of all cases (Wilson).
    trials : int
        Simulated strokes with errors that this rests on. They had no part in choosing the stroke
        unless the search was cancelled, which can flatter it, or was still widely spread.

    """

    scene: Scene = field(repr=False)
    target: Target = field(repr=False)
    limits: Limits = field(repr=False)
    stroke: Stroke
    successes: int = field(repr=False)
    trials: int

    @property
    def success(self) -> float:
        """Estimated chance of success."""
        return self.successes / self.trials

    @property
    def interval(self) -> tuple[float, float]:
        """Interval of 95 % around it."""
        return wilson(self.successes, self.trials)

    @cached_property
    def shot(self) -> Shot:
        """What the stroke does if it is played exactly; computed when first asked for."""
        return predict(self.scene, self.stroke)

    @cached_property
    def kind(self) -> str:
        """What players call it: cut, bank, kick, massé ..."""
        return kind_of(self.shot, self.target)


@dataclass(frozen=True, eq=False)
class PlanResult:
    """
    What came of a search.

    Attributes
    ----------
    status : Status
        OK, NO_PLAN, CANCELLED (with the best so far, if any), or INVALID_REQUEST.
    message : str
        The same in a line; for a request that makes no sense, what to change.
    ranking : tuple of RankedStroke
        The best first; the others by their chances.
    simulations : int
        Strokes that were simulated.
    wall_time : float
        [s]
    noise : Noise
        That the chances are about.

    """

    status: Status
    message: str
    ranking: tuple[RankedStroke, ...]
    simulations: int
    wall_time: float
    noise: Noise

    @property
    def best(self) -> RankedStroke | None:
        """The most successful stroke, None if there is none."""
        return self.ranking[0] if self.ranking else None
