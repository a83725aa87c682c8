"""Racks of games: the first state of a game, and the balls racked again."""

from dataclasses import replace

from billiard_shot.game.game import find_game
from billiard_shot.game.state import State
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.values import positive, whole


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
        game=rules,
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
    game = state.game
    return replace(state, balls=dict(game.rack(state, balls or game.balls)))
