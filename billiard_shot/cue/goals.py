"""Goals to play a shot: each is valid once, for a limited time, for one layout of the balls."""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import TypeVar

from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.plan import ShotPlan

REMEMBERED = 10_000
"""Number of nonces, and of shot ids, that are remembered; the oldest is dropped first."""

V = TypeVar('V')
Balls = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class ShotGoal:
    """
    A goal to play a plan.

    Parameters
    ----------
    plan : ShotPlan
    seal : str
        Seal of the plan when the plan was made.
    nonce : str
        Not empty, and never used before.
    remaining : float
        Time for which the goal remains valid [s].

    """

    plan: ShotPlan
    seal: str
    nonce: str
    remaining: float


class GoalRegistry:
    """
    Remembers goals, and refuses goals that must not be played, or not a second time.

    Parameters
    ----------
    max_validity : float
        Longest time for which a goal may be valid [s].

    """

    def __init__(self, max_validity: float) -> None:
        self._max_validity = max_validity
        self._nonces: OrderedDict[str, None] = OrderedDict()
        self._seals: OrderedDict[str, str] = OrderedDict()

    def take_over(self, before: 'GoalRegistry') -> None:
        """Remember what `before` remembers."""
        self._nonces, self._seals = before._nonces, before._seals

    def register(self, goal: ShotGoal) -> None:
        """
        Check a goal and use up its nonce, even if the goal is refused.

        Raises
        ------
        RefusedError
            INVALID_PLAN, NONCE_REPEATED, PLAN_CHANGED or ALREADY_EXPIRED, with the reason.

        """
        if not goal.nonce:
            raise RefusedError(Outcome.INVALID_PLAN, "nonce: '' is not allowed")
        if goal.nonce in self._nonces:
            raise RefusedError(
                Outcome.NONCE_REPEATED, f'nonce: {goal.nonce!r} has been used before'
            )
        _remember(self._nonces, goal.nonce, None)
        if not goal.remaining > 0.0:
            raise RefusedError(Outcome.ALREADY_EXPIRED, f'expiry: {-goal.remaining:.3g} s ago')
        if goal.remaining > self._max_validity:
            raise RefusedError(
                Outcome.INVALID_PLAN,
                (
                    f'expiry: in {goal.remaining:.6g} s is not allowed; it must be at most '
                    f'{self._max_validity:g} s ahead'
                ),
            )
        if goal.seal != goal.plan.seal:
            raise RefusedError(
                Outcome.PLAN_CHANGED,
                (
                    f'seal: {goal.seal!r} is not the seal of the plan, {goal.plan.seal}: the plan '
                    'was changed after it was sealed'
                ),
            )
        known = self._seals.get(goal.plan.shot_id, goal.seal)
        if known != goal.seal:
            raise RefusedError(
                Outcome.PLAN_CHANGED,
                f'shot_id: {goal.plan.shot_id!r} was used before, for the plan with seal {known}',
            )
        _remember(self._seals, goal.plan.shot_id, goal.seal)


def moved(planned: Balls, seen: Balls, tolerance: float) -> str:
    """Return which ball is farther than `tolerance` [m] from its planned place; '' if none is."""
    for name in sorted(planned.keys() | seen.keys()):
        if name not in seen:
            return f'ball {name!r} of the plan is not on the table'
        if name not in planned:
            return f'ball {name!r} is on the table, but not in the plan'
        distance = math.dist(planned[name], seen[name])
        if not distance <= tolerance:
            return (
                f'ball {name!r} lies {1e3 * distance:.3g} mm from where the plan has it, more '
                f'than {1e3 * tolerance:g} mm'
            )
    return ''


def _remember(memory: OrderedDict[str, V], key: str, value: V) -> None:
    memory[key] = value
    if len(memory) > REMEMBERED:
        memory.popitem(last=False)
