"""Limits of the mechanism: which limits a stroke violates, and by how much."""

from collections.abc import Iterable
from typing import NamedTuple


class LimitViolation(NamedTuple):
    """A violated limit, such as `stroke.speed`, and a text that says by how much."""

    limit: str
    text: str


class LimitError(ValueError):
    """A request that the mechanism cannot fulfil; `violations` lists all violated limits."""

    def __init__(self, violations: Iterable[LimitViolation]) -> None:
        self.violations = tuple(violations)
        super().__init__('; '.join(each.text for each in self.violations))


def check_range(
    limit: str, value: float, low: float, high: float, unit: str, reason: str = ''
) -> list[LimitViolation]:
    """
    Return a list of one violation if a value is outside [low, high]; else an empty list.

    `reason` says where the value or the limit comes from, if that is not obvious.
    """
    if low <= value <= high:
        return []
    side, allowed = ('above', high) if value > high else ('below', low)
    text = (
        f'{limit}: {value:.4g} {unit} is {abs(value - allowed):.3g} {unit} {side} the limit of '
        f'{allowed:.4g} {unit}'
    )
    return [LimitViolation(limit, f'{text} ({reason})' if reason else text)]


def raise_violations(violations: Iterable[LimitViolation]) -> None:
    """Raise a `LimitError` if there are any violations."""
    if found := tuple(violations):
        raise LimitError(found)
