"""The state of a game: all that rules and players need to know before a shot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
import dataclasses
from dataclasses import dataclass, replace
import json
import math
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

from billiard_shot.game.game import find_game, Game
from billiard_shot.scene.checks import check, read, write
from billiard_shot.scene.errors import (
    found_in,
    InputError,
    Mistake,
    must_be,
    must_be_one_of,
    reason,
    refused,
)
from billiard_shot.scene.fields import boolean, choice, number, places, TAKES, whole_number
from billiard_shot.scene.placement import CUE_BALL, head_string, no_place, overlaps
from billiard_shot.scene.values import as_float, whole

T = TypeVar('T', int, float)

PHASES = ('break', 'second', 'play')
IN_HAND = ('', 'kitchen', 'anywhere')
GROUPS = ('', ''), ('solids', 'stripes'), ('stripes', 'solids')
CHOICES = {  # names of the choices that rules offer, and their meanings
    'accept': 'play on',
    'kitchen': 'take the cue ball in hand behind the head string',
    'break': 'break a new rack',
    'rebreak': 'let the other player break again',
    'pass': 'let the other player shoot',
}

# Values of fields in a game of one player.
ALONE = {'player': (0,), 'breaker': (0,), 'winner': (0, None), 'choices': ((),)}


def _field(wanted: str, convert: Callable[[Any], Any], default: Any = None) -> Any:
    """Field that a function converts; it raises TypeError or ValueError for a wrong value."""

    def checked(value: object) -> Any:
        try:
            return convert(value)
        except (TypeError, ValueError):
            raise refused(value, wanted) from None

    return dataclasses.field(default=default, metadata={TAKES: checked})


def _two_whole(value: Any, minimum: int) -> tuple[int, int]:
    one, two = (whole('', each, minimum) for each in value)
    return one, two


def _choices(value: Any) -> tuple[str, ...]:
    if isinstance(value, str) or not len(value) == len({*value} & {*CHOICES}):
        raise ValueError
    return tuple(value)


def _groups(value: Any) -> tuple[str, str]:
    return GROUPS[GROUPS.index(tuple(value))]


def _times(value: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    one, two = map(as_float, value)
    if not (math.isfinite(one) and math.isfinite(two)):
        raise ValueError
    return one, two


def _player(value: Any) -> int:
    if isinstance(value, bool) or value not in (0, 1):
        raise ValueError
    return int(value)


def _game(value: object) -> Game:
    return value if isinstance(value, Game) else find_game(str(value), field='')


def _of_its_game(state: Any) -> Iterator[Mistake]:
    game = state.game
    for field, allowed in ALONE.items() if game.players == 1 else ():
        if (value := getattr(state, field)) not in allowed:
            yield from found_in(refused(value, f'{allowed[0]} in {game.name}', field))
    balls = dict.fromkeys((CUE_BALL, *game.balls))
    if others := [ball for ball in state.balls if ball not in balls]:
        yield Mistake(('balls',), must_be_one_of(balls, others[0]))
    else:
        for _, ball, why in overlaps(state.balls, state.radius):
            yield Mistake(('balls', ball), must_be(why, state.balls[ball], 'm'))


def added(pair: tuple[T, T], player: int, amount: T) -> tuple[T, T]:
    """Add an amount to the number of one player."""
    one, two = pair
    return (one + amount, two) if player == 0 else (one, two + amount)


@dataclass(frozen=True, slots=True)
class State:
    """
    A game before a shot.

    Parameters
    ----------
    game : Game
        Or its name, see `find_game`.
    length, width, radius : float
        Of the table between the noses, and of the balls [m], above 0.
    balls : mapping of str to (x, y)
        The balls on the table [m]; the cue ball is `cue`, and is missing while it is in hand.
    player : int
        Who plays next, 0 or 1.
    phase : str
        `break`, `second` (the shot after the break, if it may be a push-out), or `play`.
    in_hand : str
        `kitchen` (behind the head string) or `anywhere` if the player places the cue ball; ''
        if the player does not. It stays until the shot, because rule 6.11 needs it.
    choices : tuple of str
        If not empty, the player takes one of these before anything else, see `CHOICES`.
    groups : (str, str)
        Eight-ball: `solids` and `stripes`, by player; '' while the table is open.
    fouls : (int, int)
        Consecutive fouls of each player.
    scores : (int, int)
        Points.
    target : int
        Points that win, in games with points.
    time_left : (float, float), optional
        What is left of the players' times for the rack [s]; None without a limit.
    over : bool
        The rack or the game is decided.
    winner : int, optional
        0 or 1; None if nobody has won.
    breaker : int
        Who broke the rack first.
    shots : int
        Shots so far.
    seed : int
        Of this rack.

    """

    RULES: ClassVar = (_of_its_game,)
    game: Game = dataclasses.field(metadata={TAKES: _game})
    length: float = number('m', above=0)
    width: float = number('m', above=0)
    radius: float = number('m', above=0)
    balls: Mapping[str, tuple[float, float]] = places()
    player: int = _field('0 or 1', _player, 0)
    phase: str = choice(*PHASES, default='break')
    in_hand: str = choice(*IN_HAND, default='')
    choices: tuple[str, ...] = _field(
        f'a list of {", ".join(map(repr, CHOICES))}, each at most once', _choices, ()
    )
    groups: tuple[str, str] = _field(f'one of {", ".join(map(str, GROUPS))}', _groups, ('', ''))
    fouls: tuple[int, int] = _field(
        'two whole numbers, at least 0', lambda value: _two_whole(value, 0), (0, 0)
    )
    scores: tuple[int, int] = _field(
        'two whole numbers', lambda value: _two_whole(value, -(10**9)), (0, 0)
    )
    target: int = whole_number(minimum=0, default=0)
    time_left: tuple[float, float] | None = _field('two finite numbers (s)', _times)
    over: bool = boolean(default=False)
    winner: int | None = _field(
        '0, 1 or None', lambda value: None if value is None else _player(value)
    )
    breaker: int = _field('0 or 1', _player, 0)
    shots: int = whole_number(minimum=0, default=0)
    seed: int = whole_number(minimum=0, default=0)

    def __post_init__(self) -> None:
        check(self)

    @property
    def other(self) -> int:
        """The player who does not play next."""
        return 1 - self.player

    @property
    def object_balls(self) -> tuple[str, ...]:
        """The balls on the table without the cue ball."""
        return tuple(ball for ball in self.balls if ball != CUE_BALL)

    @property
    def places_cue_ball(self) -> bool:
        """Whether the player has to place the cue ball first."""
        return bool(self.in_hand) and CUE_BALL not in self.balls and not self.choices

    def with_cue_ball(self, x: float, y: float) -> Self:
        """
        Place the cue ball that is in hand.

        Parameters
        ----------
        x, y : float
            [m]

        Raises
        ------
        ValueError
            If the cue ball is not in hand, or cannot lie there by the rules (6.10).

        """
        if not self.places_cue_ball:
            raise ValueError('the cue ball cannot be placed: it is not in hand')
        if why := self.no_place(x, y):
            raise ValueError(f'cue ball must be {why}, got ({x!r}, {y!r}) (m)')
        return replace(self, balls={**self.balls, CUE_BALL: (float(x), float(y))})

    def without(self, ball: str) -> Self:
        """Return the state without a ball."""
        return replace(self, balls={name: at for name, at in self.balls.items() if name != ball})

    def no_place(self, x: float, y: float) -> str:
        """Say where the cue ball in hand must be, if not at (x, y) [m]; empty if there."""
        r = self.radius
        along, across = 0.5 * self.length - r, 0.5 * self.width - r
        if not (abs(x) <= along and abs(y) <= across):
            return f'at x {-along:.4g} to {along:.4g} and y {-across:.4g} to {across:.4g}'
        # The base of the ball has to be behind the head string, not on it (WPA 8.1, 6.10).
        if self.in_hand == 'kitchen' and x >= head_string(self):
            return f'behind the head string, x below {head_string(self):.4g}'
        others = {ball: self.balls[ball] for ball in self.object_balls}
        return no_place(None, x, y, r, others)

    def to_dict(self) -> dict[str, Any]:
        """Plain dict that `from_dict` turns into an equal state."""
        return {**write(self), 'game': self.game.name}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Make a state from such a dict; ValueError lists all mistakes."""
        try:
            return read(cls, data)
        except InputError as error:
            raise InputError(error.mistakes, 'state') from None

    def save(self, path: str | Path) -> None:
        """Write the state as JSON."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=1) + '\n', encoding='utf-8')

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """
        Read a state that `save` wrote.

        Raises
        ------
        ValueError
            Naming the file, and each mistake in it.

        """
        try:
            return read(cls, json.loads(Path(path).read_text(encoding='utf-8')))
        except InputError as error:
            raise InputError(error.mistakes, f'state {path}') from None
        except (OSError, ValueError) as error:
            raise ValueError(f'state {path}: {reason(error)}') from None
