"""Orders to play a shot: valid once, for a while, and for the table they were made for."""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
import math
from typing import TypeVar

from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.plan import ShotPlan

REMEMBERED = 10_000
"""Nonces and shot ids that are remembered; the oldest is forgotten first."""

V = TypeVar('V')
Balls = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Order:
    """
    An order to play a plan.

    Parameters
    ----------
    plan : ShotPlan
    seal : str
        The plan's, as it was when the plan was made.
    nonce : str
        Not empty, and never used before.
    remaining : float
        For how long the order is valid from now on [s].

    """

    plan: ShotPlan
    seal: str
    nonce: str
    remaining: float


class OrderBook:
    """
    Remembers what has been ordered, and refuses what must not be played (again).

    Parameters
    ----------
    longest : float
        For how long an order may be valid [s].

    """

    def __init__(self, longest: float) -> None:
        self._longest = longest
        self._nonces: OrderedDict[str, None] = OrderedDict()
        self._seals: OrderedDict[str, str] = OrderedDict()

    def enter(self, order: Order) -> None:
        """
        Check an order and use up its nonce, whatever becomes of it.

        Raises
        ------
        RefusedError
            INVALID_PLAN, NONCE_REPEATED, PLAN_CHANGED or ALREADY_EXPIRED, with the reason.

        """
        if not order.nonce:
            raise RefusedError(Outcome.INVALID_PLAN, "nonce: '' is not allowed")
        if order.nonce in self._nonces:
            raise RefusedError(
                Outcome.NONCE_REPEATED, f'nonce: {order.nonce!r} has been used before'
            )
        _remember(self._nonces, order.nonce, None)
        if not order.remaining > 0.0:
            raise RefusedError(Outcome.ALREADY_EXPIRED, f'expiry: {-order.remaining:.3g} s ago')
        if order.remaining > self._longest:
            raise RefusedError(
                Outcome.INVALID_PLAN,
                (
                    f'expiry: in {order.remaining:.6g} s is not allowed; it must be at most '
                    f'{self._longest:g} s ahead'
                ),
            )
        if order.seal != order.plan.seal:
            raise RefusedError(
                Outcome.PLAN_CHANGED,
                (
                    f'seal: {order.seal!r} is not that of the plan, {order.plan.seal}: it changed '
                    'after it was made'
                ),
            )
        known = self._seals.get(order.plan.shot_id, order.seal)
        if known != order.seal:
            raise RefusedError(
                Outcome.PLAN_CHANGED,
                (f'shot_id: {order.plan.shot_id!r} stood for another plan before, {known}'),
            )
        _remember(self._seals, order.plan.shot_id, order.seal)


def moved(planned: Balls, seen: Balls, tolerance: float) -> str:
    """Say which balls are not within `tolerance` [m] of where the plan has them; '' if none."""
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
