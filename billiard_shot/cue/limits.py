"""What the mechanism cannot do: every limit that a stroke breaks, and by how much."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Excess:
    """
    One limit that is broken.

    Parameters
    ----------
    limit : str
        Its name, such as `stroke.speed`.
    value, allowed : float
        What is asked for, and the largest (or, where the value is below it, smallest) allowed.
    unit : str
        Of both.
    reason : str
        What sets the limit or asks for so much, if it is not plain.

    """

    limit: str
    value: float
    allowed: float
    unit: str
    reason: str = ''

    @property
    def by(self) -> float:
        """How much is too much."""
        return abs(self.value - self.allowed)

    def __str__(self) -> str:
        side = 'above' if self.value > self.allowed else 'below'
        text = (
            f'{self.limit}: {self.value:.4g} {self.unit} is {self.by:.3g} {self.unit} '
            f'{side} the limit of {self.allowed:.4g} {self.unit}'
        )
        return f'{text} ({self.reason})' if self.reason else text


class LimitError(ValueError):
    """Something that the mechanism cannot do; `excesses` are all limits in its way."""

    def __init__(self, excesses: Iterable[Excess]) -> None:
        self.excesses = tuple(excesses)
        super().__init__('; '.join(map(str, self.excesses)))


def outside(
    limit: str, value: float, least: float, most: float, unit: str, reason: str = ''
) -> list[Excess]:
    """List the excess of a value that is not within [least, most]; empty if it is."""
    if least <= value <= most:
        return []
    return [Excess(limit, value, most if value > most else least, unit, reason)]


def refuse(excesses: Iterable[Excess]) -> None:
    """Raise a `LimitError` if there are any."""
    found = tuple(excesses)
    if found:
        raise LimitError(found)
