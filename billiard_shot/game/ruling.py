"""Rulings of the referee."""

from collections.abc import Callable
from dataclasses import dataclass

from billiard_shot.game.state import State


@dataclass(frozen=True, slots=True)
class Foul:
    """
    A foul.

    Parameters
    ----------
    rule : str
        Number of its rule in the edition that its game follows, such as `6.2`.
    text : str
        What happened, in one line.

    """

    rule: str
    text: str

    def __str__(self) -> str:
        return f'{self.rule}: {self.text}'


@dataclass(frozen=True, slots=True)
class Ruling:
    """
    What follows from a shot by the rules.

    Parameters
    ----------
    state : State
        The game after the shot. A rule of a game leaves the balls where they were before; `judge`
        puts them where they came to rest, spots balls, and arranges them.
    fouls : tuple of Foul
    text : str
        The ruling in one line.
    spot : tuple of str
        Balls that go back onto the table.
    restore : bool
        The balls go back to where they were before the shot.
    miscue : bool
        The tip slid on the cue ball, as the outcome says.
    arrange : callable, optional
        Takes the state with the balls where they rest, and moves balls as the rules say, such as
        into a new rack.

    """

    state: State
    fouls: tuple[Foul, ...] = ()
    text: str = ''
    spot: tuple[str, ...] = ()
    restore: bool = False
    miscue: bool = False
    arrange: Callable[[State], State] | None = None

    @property
    def legal(self) -> bool:
        """Whether there was no foul."""
        return not self.fouls
