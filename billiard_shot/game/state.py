"""A game and its state: all that rules and players need to know before and after a shot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
import copy
import dataclasses
from dataclasses import dataclass, field, replace
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
import json
import math
from pathlib import Path
from typing import Any, ClassVar, Self, TypeAlias, TypeVar

import numpy as np

from billiard_shot.scene import fields, Scene
from billiard_shot.scene.errors import (
    found_in,
    InputError,
    Mistake,
    must_be,
    must_be_one_of,
    reason,
    refused,
    suggestion,
)
from billiard_shot.scene.placement import CUE_BALL, head_string, no_place, overlaps
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.motion import FROZEN
from billiard_shot.table.run import results


def names_in(folder: str) -> list[str]:
    """Names of the modules of a folder of this package, in alphabetical order."""
    return sorted(path.stem for path in Path(__file__).with_name(folder).glob('[a-z]*.py'))


def find_plugin(name: str, folder: str, attribute: str, what: str) -> Any:
    """
    Return the attribute of a module.

    Parameters
    ----------
    name : str
        One of `names_in(folder)`; or `package.module` or the path of a file `.py`, of somebody
        else.
    folder, attribute : str
    what : str
        What the module defines, in one word: the field that messages name; '' for none.

    Raises
    ------
    ValueError
        If there is no such module, or it has no such attribute.

    """
    names = names_in(folder)
    if Path(name).suffix == '.py':
        return _of_file(Path(name), attribute, what)
    if name in names:
        name = f'billiard_shot.game.{folder}.{name}'
    elif '.' not in name or not all(map(str.isidentifier, name.split('.'))):
        allowed = f'one of {", ".join(names)}, or a module such as package.module or its path'
        raise refused(name, allowed, what, hint=suggestion(names, name))
    try:
        return getattr(import_module(name), attribute)
    except (ImportError, AttributeError) as error:
        text = f': {name!r} is not a module with {attribute}: {error}'
        raise InputError([Mistake((what,) if what else (), text)]) from None


def _of_file(path: Path, attribute: str, what: str) -> Any:
    """Return the attribute of a file; ValueError as of `find_plugin`."""
    spec = spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        return getattr(module, attribute)
    except (OSError, ImportError, AttributeError) as error:
        text = f': {str(path)!r} is not a file with {attribute}: {error}'
        raise InputError([Mistake((what,) if what else (), text)]) from None


@dataclass(frozen=True, slots=True)
class Call(fields.CheckedRecord):
    """
    The call of a player before a shot.

    Parameters
    ----------
    ball : str, optional
        The ball that is to fall; None if the game needs no call.
    pocket : str
        The pocket into which it is to fall, one of `POCKET_NAMES`; '' if the game needs no call.
    safety : bool
        The turn ends with the shot, even if a ball falls.
    push_out : bool
        The shot is a push-out; only on the shot after the break of nine-ball.

    """

    ball: str | None = fields.name(nullable=True)
    pocket: str = fields.choice(*results.POCKET_NAMES, '', default='')
    safety: bool = fields.boolean(default=False)
    push_out: bool = fields.boolean(default=False)

    @property
    def passes(self) -> bool:
        """Whether the turn passes to the other player even if a ball falls."""
        return self.safety or self.push_out


NO_CALL = Call()


@dataclass(frozen=True, slots=True)
class Decision:
    """
    One of the choices of a state, or a stroke with its call.

    Parameters
    ----------
    stroke : Stroke, optional
        None if the player takes a choice, or concedes because it finds no stroke.
    call : Call
    choice : str
        One of `State.choices`; '' for a stroke.
    success : float, optional
        The probability, as the player states it, of a legal shot that keeps its turn.
    reason : str
        Of the decision, in one line.

    """

    stroke: Stroke | None = None
    call: Call = field(default=NO_CALL)
    choice: str = ''
    success: float | None = None
    reason: str = ''


NOSE_SAMPLES = 33  # times at which the distance from a nose is looked at


@dataclass(frozen=True, slots=True)
class Outcome:
    """
    What a shot did, as far as rules ask.

    Equal outcomes have the same ruling; miscues and the places of the balls do not count for that.

    Parameters
    ----------
    first_contact : str, optional
        The ball that the cue ball met first; None if it met none.
    pocketed : tuple of (str, str)
        Ball and pocket, in the order of time, with the cue ball. The pocket is '' if
        nobody saw it.
    off_table : tuple of str
        Balls that left the table, with the cue ball.
    to_cushion : frozenset of str
        Balls that were driven to a cushion after the first contact (WPA 8.4), with the cue ball.
    from_kitchen : bool
        The first ball met was behind the head string, and the cue ball had not crossed it before
        (WPA 6.11).
    double_hit : bool
        The cue hit the cue ball again.
    refused : str
        Why the stroke could not be played; '' if it was played.
    met : tuple of str
        The balls that the cue ball met, each once, in the order of time.
    cushions_before : tuple of int
        For each ball in `met`, how often the cue ball had met a cushion before.
    miscue : bool
        The tip slid on the cue ball; that is legal (WPA 8.18).
    places : mapping of str to (x, y)
        Where the balls that are left rest [m].

    Raises
    ------
    ValueError
        If a ball fell into a pocket that does not exist.

    """

    first_contact: str | None = None
    pocketed: tuple[tuple[str, str], ...] = ()
    off_table: tuple[str, ...] = ()
    to_cushion: frozenset[str] = frozenset()
    from_kitchen: bool = False
    double_hit: bool = False
    refused: str = ''
    met: tuple[str, ...] = ()
    cushions_before: tuple[int, ...] = ()
    miscue: bool = field(default=False, compare=False)
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for pair in self.pocketed:
            if isinstance(pair, str) or len(pair) != 2:
                raise refused(pair, 'a ball and a pocket', 'pocketed')
            if pair[1] not in (*results.POCKET_NAMES, ''):
                near = suggestion(results.POCKET_NAMES, pair[1])
                allowed = f'a pocket, one of {", ".join(results.POCKET_NAMES)}'
                raise refused(pair[1], allowed, 'pocketed', hint=near)

    @property
    def gone(self) -> frozenset[str]:
        """The balls that are no longer on the table."""
        return frozenset(ball for ball, _ in self.pocketed) | frozenset(self.off_table)

    @property
    def scratched(self) -> bool:
        """Whether the cue ball fell into a pocket or left the table."""
        return CUE_BALL in self.gone

    @property
    def fallen(self) -> tuple[str, ...]:
        """The object balls that fell into pockets, in the order of time."""
        return tuple(ball for ball, _ in self.pocketed if ball != CUE_BALL)


ShotLike: TypeAlias = Shot | Outcome
"""A predicted shot; or its outcome, as another simulator or an observer tells it."""


def outcome_of(shot: ShotLike) -> Outcome:
    """Read the outcome of a prediction; an outcome is returned as it is."""
    if isinstance(shot, Outcome):
        return shot
    if shot.status.refused:
        places = {CUE_BALL: shot.scene.cue_ball[:2], **shot.scene.balls}
        return Outcome(refused=shot.message, places=places)
    outcome = outcome_of_run(shot.run, shot.scene, double_hit=shot.double_hit is not None)
    return replace(outcome, miscue=shot.miscue)


def outcome_of_run(run: results.TableRun, scene: Scene, *, double_hit: bool = False) -> Outcome:
    """Read the outcome of a simulated table whose cue ball is called `cue`."""
    kitchen_end = head_string(scene.table) if scene.table else -np.inf
    first = run.first_met.get(CUE_BALL)
    met: dict[str, int] = {}
    to_cushion: set[str] = set()
    from_kitchen = crossed = False
    cushions = 0
    for event in run.events:
        if (
            event.kind in (results.EventKind.BALL, results.EventKind.CLUSTER)
            and CUE_BALL in event.balls
        ):
            if not met and first is not None:
                x = run.balls[first].at(event.time).position[0]
                from_kitchen = bool(x < kitchen_end) and not crossed
                met[first] = cushions  # several balls may be met at once
            met |= {ball: cushions for ball in event.balls if ball not in {CUE_BALL, *met}}
        elif event.kind == results.EventKind.CUSHION:
            ball = event.balls[0]
            cushions += ball == CUE_BALL
            crossed |= ball == CUE_BALL and bool(event.position[0] >= kitchen_end)
            if met and _was_driven(run, event, scene):
                to_cushion.add(ball)
    return Outcome(
        first_contact=first,
        pocketed=tuple(run.pocketed.items()),
        off_table=run.off_table,
        to_cushion=frozenset(to_cushion),
        from_kitchen=from_kitchen,
        double_hit=double_hit,
        met=tuple(met),
        cushions_before=tuple(met.values()),
        places=run.places_left,
    )


def _was_driven(run: results.TableRun, event: results.TableEvent, scene: Scene) -> bool:
    """Whether a ball that meets a cushion was not frozen to it from the beginning."""
    if event.place not in results.NOSE_NAMES or scene.table is None:
        return True
    ball = run.balls[event.balls[0]]
    axis = 0 if event.place in ('foot', 'head') else 1
    half = 0.5 * (scene.table.length, scene.table.width)[axis]
    sign = 1.0 if event.place in ('foot', 'left') else -1.0
    # The nose is above the middle of the ball: a frozen ball is nearer to it than its radius.
    nearest = half - sign * float(event.position[axis])
    start = half - sign * float(ball.at(0.0).position[axis])
    if start > nearest + FROZEN:
        return True
    times = np.linspace(0.0, event.time, NOSE_SAMPLES)
    away = half - sign * ball.at(times).position[:, axis]
    return bool((away > nearest + FROZEN).any())


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

    return dataclasses.field(default=default, metadata={fields.TAKES: checked})


def _two_whole(value: Any, minimum: int) -> tuple[int, int]:
    one, two = (fields.whole('', each, minimum) for each in value)
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
    one, two = map(fields.as_float, value)
    if not (math.isfinite(one) and math.isfinite(two)):
        raise ValueError
    return one, two


def _player(value: Any) -> int:
    if isinstance(value, bool) or value not in (0, 1):
        raise ValueError
    return int(value)


def _game(value: object) -> Game:
    return find_game(value if isinstance(value, Game) else str(value), field='')


def _of_its_game(state: Any) -> Iterator[Mistake]:
    game = state.game
    for each, allowed in ALONE.items() if game.players == 1 else ():
        if (value := getattr(state, each)) not in allowed:
            yield from found_in(refused(value, f'{allowed[0]} in {game.name}', each))
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
class State(fields.CheckedRecord):
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
    game: Game = dataclasses.field(metadata={fields.TAKES: _game})
    length: float = fields.number('m', above=0)
    width: float = fields.number('m', above=0)
    radius: float = fields.number('m', above=0)
    balls: Mapping[str, tuple[float, float]] = fields.places()
    player: int = _field('0 or 1', _player, 0)
    phase: str = fields.choice(*PHASES, default='break')
    in_hand: str = fields.choice(*IN_HAND, default='')
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
    target: int = fields.whole_number(minimum=0, default=0)
    time_left: tuple[float, float] | None = _field('two finite numbers (s)', _times)
    over: bool = fields.boolean(default=False)
    winner: int | None = _field(
        '0, 1 or None', lambda value: None if value is None else _player(value)
    )
    breaker: int = _field('0 or 1', _player, 0)
    shots: int = fields.whole_number(minimum=0, default=0)
    seed: int = fields.whole_number(minimum=0, default=0)

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
        return self.but(balls={name: at for name, at in self.balls.items() if name != ball})

    def but(self, **changes: Any) -> Self:
        """Return the state with changes that nobody checks: players rule on many strokes."""
        changed = copy.copy(self)
        for field_name, value in changes.items():
            object.__setattr__(changed, field_name, value)
        return changed

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
        return {**fields.write(self), 'game': self.game.name}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], game: Game | None = None) -> Self:
        """
        Make a state from such a dict; ValueError lists all mistakes.

        A game that no module has is to be given.
        """
        try:
            return fields.read(cls, data if game is None else {**data, 'game': game})
        except InputError as error:
            raise InputError(error.mistakes, 'state') from None

    def save(self, path: str | Path) -> None:
        """Write the state as JSON."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=1) + '\n', encoding='utf-8')

    @classmethod
    def load(cls, path: str | Path, game: Game | None = None) -> Self:
        """
        Read a state that `save` wrote.

        Parameters
        ----------
        path : str or Path
        game : Game, optional
            Needed if it is not in a module or file of its name.

        Raises
        ------
        ValueError
            Naming the file, and each mistake in it.

        """
        try:
            return cls.from_dict(json.loads(Path(path).read_text(encoding='utf-8')), game)
        except InputError as error:
            raise InputError(error.mistakes, f'state {path}') from None
        except (OSError, ValueError) as error:
            raise ValueError(f'state {path}: {reason(error)}') from None


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


def any_ball(state: State, player: int = 0) -> tuple[str, ...]:
    """Return all object balls."""
    return state.object_balls


@dataclass(frozen=True, slots=True)
class Game:
    """
    The rules of a game.

    Parameters
    ----------
    name : str
        The name of its module: in the package as `eight_ball`, elsewhere as `package.module`, or
        the path of its file.
    balls : tuple of str
        Names of the object balls.
    rack : callable
        Takes a state and the names of balls, and returns their places (x, y) [m].
    rule : callable
        Takes a `State`, a `Call` and an `Outcome`, and returns the `Ruling`, see there.
    targets : callable
        Takes a state, and returns the balls that the cue ball may meet first; by default all. In
        games with pockets the pot of such a ball keeps the turn.
    needs : callable
        Takes a state and a player, and returns the balls that this player has to pot to win; by
        default all.
    shared : bool
        Whether both players pot the same balls, so that a pot brings both nearer to the end.
    in_hand, phase : str
        Of the first state, see `State`.
    calls : bool
        Ball and pocket must be called; else any ball that falls legally keeps the turn.
    players : int
        1 or 2.
    goal : int
        Points that win; 0 if the game has no points.
    pockets : bool
        False for a game on a table without pockets.
    decisive : str
        Ball that stays on the table until the rack is decided; '' for none.
    reracked : int
        Number of object balls with which the others are racked again; 0 if they never are.

    """

    name: str
    balls: tuple[str, ...]
    rack: Callable[[State, tuple[str, ...]], Mapping[str, tuple[float, float]]]
    rule: Callable[[State, Call, Outcome], Ruling]
    targets: Callable[[State], tuple[str, ...]] = any_ball
    needs: Callable[[State, int], tuple[str, ...]] = any_ball
    shared: bool = True
    in_hand: str = 'kitchen'
    phase: str = 'break'
    calls: bool = True
    players: int = 2
    goal: int = 0
    pockets: bool = True
    decisive: str = ''
    reracked: int = 0


def game_names() -> list[str]:
    """Names of the games of the package, in alphabetical order."""
    return names_in('rules')


def find_game(name: str | Game, field: str = 'game') -> Game:
    """
    Return a game.

    Parameters
    ----------
    name : str or Game
        One of `game_names`; or `package.module`, or the path of a file `.py`, of your own with a
        constant `GAME`. A game is returned as it is.
    field : str
        That holds the name, for messages.

    Raises
    ------
    ValueError
        If there is no such game.

    """
    if isinstance(name, Game):
        return name
    game = find_plugin(name, 'rules', 'GAME', field)
    if not isinstance(game, Game):
        raise refused(game, 'a Game', f'{name}.GAME')
    if name.endswith('.py'):
        return replace(game, name=name)
    if game.name != name:  # by which a saved state finds it again
        raise refused(game.name, repr(name), f'{name}.GAME.name')
    return game
