"""Goals to play a shot: each shot is played once, and within a limited time."""

from collections import OrderedDict
from dataclasses import dataclass

from billiard_shot.cue.outcome import GoalOutcome, RefusedError
from billiard_shot.cue.plan import ShotPlan

REMEMBERED = 10_000
"""Number of shot ids that are remembered; the oldest is dropped first."""


@dataclass(frozen=True, slots=True)
class ShotGoal:
    """
    A goal to play a plan.

    Parameters
    ----------
    plan : ShotPlan
    remaining : float
        Time for which the goal remains valid [s].

    """

    plan: ShotPlan
    remaining: float


class GoalRegistry:
    """
    Remembers shots, and refuses goals that must not be played, or not a second time.

    Parameters
    ----------
    max_validity : float
        Longest time for which a goal may be valid [s].

    """

    def __init__(self, max_validity: float) -> None:
        self._max_validity = max_validity
        self._played: OrderedDict[str, None] = OrderedDict()

    def take_over(self, before: 'GoalRegistry') -> None:
        """Remember what `before` remembers."""
        self._played = before._played

    def check(self, goal: ShotGoal) -> None:
        """
        Check whether a goal may be played.

        Raises
        ------
        RefusedError
            ALREADY_PLAYED, ALREADY_EXPIRED or INVALID_PLAN, with the reason.

        """
        if goal.plan.shot_id in self._played:
            raise RefusedError(
                GoalOutcome.ALREADY_PLAYED,
                f'shot_id must be new, got {goal.plan.shot_id!r}: the cue has been aimed for it '
                'before',
            )
        if not goal.remaining > 0.0:
            raise RefusedError(
                GoalOutcome.ALREADY_EXPIRED,
                f'expiry must be ahead of now, got {-goal.remaining:.3g} s ago',
            )
        if goal.remaining > self._max_validity:
            raise RefusedError(
                GoalOutcome.INVALID_PLAN,
                f'expiry must be at most {self._max_validity:g} s ahead, got {goal.remaining:.6g} '
                's',
            )

    def use(self, shot_id: str) -> None:
        """Refuse every later goal for a shot, because the cue is aimed for it."""
        self._played[shot_id] = None
        if len(self._played) > REMEMBERED:
            self._played.popitem(last=False)
