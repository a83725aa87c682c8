"""Limits of the mechanism: which limits a stroke violates, and by how much."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LimitViolation:
    """
    One violated limit.

    Parameters
    ----------
    limit : str
        Name of the limit, such as `stroke.speed`.
    value, allowed : float
        Requested value, and the bound of the allowed range that it violates.
    unit : str
        Unit of both numbers.
    reason : str
        Where the limit or the requested value comes from, if that is not obvious.

    """

    limit: str
    value: float
    allowed: float
    unit: str
    reason: str = ''

    @property
    def by(self) -> float:
        """Distance of the value from the allowed bound."""
        return abs(self.value - self.allowed)

    def __str__(self) -> str:
        side = 'above' if self.value > self.allowed else 'below'
        text = (
            f'{self.limit}: {self.value:.4g} {self.unit} is {self.by:.3g} {self.unit} '
            f'{side} the limit of {self.allowed:.4g} {self.unit}'
        )
        return f'{text} ({self.reason})' if self.reason else text


class LimitError(ValueError):
    """A request that the mechanism cannot fulfil; `violations` lists all violated limits."""

    def __init__(self, violations: Iterable[LimitViolation]) -> None:
        self.violations = tuple(violations)
        super().__init__('; '.join(map(str, self.violations)))


def check_range(
    limit: str, value: float, low: float, high: float, unit: str, reason: str = ''
) -> list[LimitViolation]:
    """Return a list of one violation if a value is outside [low, high]; else an empty list."""
    if low <= value <= high:
        return []
    return [LimitViolation(limit, value, high if value > high else low, unit, reason)]


def raise_violations(violations: Iterable[LimitViolation]) -> None:
    """Raise a `LimitError` if there are any violations."""
    found = tuple(violations)
    if found:
        raise LimitError(found)
