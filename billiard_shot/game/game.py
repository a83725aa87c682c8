"""Games: a game is data and a few pure functions, in one module."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

from billiard_shot.game.call import Call
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.plugins import find_plugin, names_in
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.values import positive, whole


@dataclass(frozen=True, slots=True)
class Game:
    """
    The rules of a game.

    Parameters
    ----------
    name : str
        The name of its module: in the package as `eight_ball`, elsewhere as `package.module`.
    edition : str
        The published rules that it follows, with their date.
    rule : callable
        Takes a `State`, a `Call` and an `Outcome`, and returns the `Ruling`, see there.
    targets : callable
        Takes a state, and returns the balls that the cue ball may meet first. In games with
        pockets the pot of such a ball keeps the turn.
    rack : callable
        Takes a state and the names of balls, and returns their places (x, y) [m].
    balls : tuple of str
        Names of the object balls.
    needs : callable
        Takes a state and a player, and returns the balls that this player has to pot to win.
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

    """

    name: str
    edition: str
    rule: Callable[[State, Call, Outcome], Ruling]
    targets: Callable[[State], tuple[str, ...]]
    rack: Callable[[State, tuple[str, ...]], Mapping[str, tuple[float, float]]]
    balls: tuple[str, ...]
    needs: Callable[[State, int], tuple[str, ...]] = lambda state, player: state.object_balls
    shared: bool = True
    in_hand: str = 'kitchen'
    phase: str = 'break'
    calls: bool = True
    players: int = 2
    goal: int = 0
    pockets: bool = True


def game_names() -> list[str]:
    """Names of the games of the package, in alphabetical order."""
    return names_in('rules')


@cache  # every new state asks for its game
def find_game(name: str) -> Game:
    """
    Return a game.

    Parameters
    ----------
    name : str
        One of `game_names`; or `package.module`, a module of your own with a constant `GAME`.

    Raises
    ------
    ValueError
        If there is no such game.

    """
    game = find_plugin(name, 'rules', 'GAME', 'game')
    if not isinstance(game, Game):
        raise refused(game, 'a Game', f'{name}.GAME')
    return game


def start(
    game: str,
    scene: SceneLike,
    seed: int = 0,
    breaker: int = 0,
    balls: int | None = None,
    target: int | None = None,
    time_limit: float | None = None,
) -> State:
    """
    Rack the balls, and return the first state of a game.

    Parameters
    ----------
    game : str
        See `find_game`.
    scene : Scene, str or Path
        Its table and the radius of its balls; its `balls` do not count here.
    seed : int
        Of the rack, at least 0.
    breaker : int
        Who plays first, 0 or 1.
    balls : int, optional
        How many of the balls of the game are racked, the first ones; by default all.
    target : int, optional
        Points that win, in games with points; by default those of the game.
    time_limit : float, optional
        Time of each player for the rack [s], above 0; by default there is no limit.

    Raises
    ------
    ValueError
        If the request is invalid, or the table is not one for this game.

    """
    rules, scene = find_game(game), Scene.load(scene)
    if scene.table is None or scene.table.pockets != rules.pockets:
        needed = 'with' if rules.pockets else 'without'
        raise ValueError(f'scene: {game} needs a table {needed} pockets')
    count = len(rules.balls) if balls is None else whole('balls', balls, 1)
    if count > len(rules.balls):
        raise refused(balls, f'at most {len(rules.balls)}', 'balls')
    state = State(
        game=game,
        length=scene.table.length,
        width=scene.table.width,
        radius=scene.ball.radius,
        player=breaker,
        breaker=breaker,
        phase=rules.phase,
        in_hand=rules.in_hand,
        target=rules.goal if target is None else whole('target', target, 1),
        time_left=None if time_limit is None else 2 * (positive('time_limit', time_limit, 's'),),
        seed=seed,
    )
    return rack_state(state, rules.balls[:count])


def rack_state(state: State, balls: tuple[str, ...] = ()) -> State:
    """Return a state with the balls of its game, or some of them, racked by its seed."""
    rules = find_game(state.game)
    return replace(state, balls=dict(rules.rack(state, balls or rules.balls)))
