"""
Racks that follow each other: how well the ball that is left breaks the next one.

In straight pool the last ball stays while the others are racked again. A run goes on if the shot
at that ball sends the cue ball into the rack.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from billiard_shot.game.referee import start
from billiard_shot.game.state import Game, State
from billiard_shot.planning.plan import cue_ball_all_over
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.table.run.states import TableStates

# The cue ball leaves a contact with its velocity across the line of centres, and with a share of
# its velocity before: a stun shot, and two with follow. A cushion keeps some of the speed.
FOLLOW, REBOUND = np.array([0.0, 0.15, 0.3]), 0.7
# The chance that the run goes on by the mean speed of these three into the rack, relative to that
# of the cue ball before; speeds above the largest do not help. In 3,402 simulated breaks the
# speed's correlation with the best of nine strokes was .76. Of 14 breaks each with chances of .2,
# .3, .4, .6, and more, 1, 7, 6, 9 and 8 were followed by three more pots.
LEAST, FOR_SPEED, LARGEST = 0.2, 1.5, 0.35
BLOCKED = 0.05  # the chance if the rack will be in the way
TINY = 1e-12  # m2
AXES = np.array([1.0, 1.0j])  # of complex numbers
CELL = 0.1  # m: places of a ball in the same cell are valued alike
PLACES, BEST = 96, 12  # of the cue ball that are tried for each cell, and how many of them count


def run_goes_on(scene: Scene, state: State, direct: DirectShots, states: TableStates) -> Array:
    """
    Estimate the chances that a run goes on over the next rack, after direct shots that pot.

    Parameters
    ----------
    scene : Scene
        Without balls.
    state : State
        Tells the game and the points.
    direct : DirectShots
        Of the tables.
    states : TableStates
        Where the balls lie.

    Returns
    -------
    (n,) float array
        For a shot at the last ball by its geometry, for others by the best ball that they leave.
        1 if no rack follows, or a player can win with the balls on the table.

    """
    game, present = state.game, states.present.copy()
    present[:, states.names.index(CUE_BALL)] = False
    missing = state.target - max(state.scores)
    if not (game.reracked and len(direct)) or missing <= len(state.object_balls):
        return np.ones(len(direct))
    racked = _racked(scene, game)
    cells = np.round(states.position[present, :2] / CELL).astype(int)
    different, cell = np.unique(cells, axis=0, return_inverse=True)
    of_cell = [_from_good_places(scene, game, x, abs(y)) for x, y in different.tolist()]
    quality = np.zeros(present.shape)
    quality[present] = np.array(of_cell)[cell]
    others = quality[direct.table]
    others[np.arange(len(direct)), direct.ball] = 0.0
    found: Array = others.max(axis=1)
    last = present.sum(axis=1)[direct.table] <= game.reracked
    found[last] = into_rack(racked, replace(direct, rows=direct.rows[last]), states)
    return found


def into_rack(racked: State, direct: DirectShots, states: TableStates) -> Array:
    """
    Estimate the chances (n,) that runs go on after direct shots at the last ball.

    Parameters
    ----------
    racked : State
        With the balls of the next rack.
    direct : DirectShots
    states : TableStates
        Before the other balls are racked.

    """
    # Places and directions are complex numbers.
    rack = _next_rack(racked) @ AXES
    cue = states.position[direct.table, states.names.index(CUE_BALL), :2] @ AXES
    ball = states.position[direct.table, direct.ball, :2] @ AXES
    path = np.exp(1j * direct.offsets[:, AZIMUTH])
    contact = cue + direct.distance * path
    line = (ball - contact) / np.abs(ball - contact)
    across = path - (path * line.conj()).real * line
    velocity = across[:, np.newaxis] + FOLLOW * path[:, np.newaxis]
    # After a cushion the cue ball goes as if it met the mirror image of the rack.
    x, y = (length - 2.0 * racked.radius for length in (racked.length, racked.width))
    mirrored = (x - rack.conj(), -x - rack.conj(), rack.conj() + 1j * y, rack.conj() - 1j * y)
    to = np.concatenate([rack, *mirrored]) - contact[:, np.newaxis]
    along = to[:, np.newaxis] * velocity.conj()[..., np.newaxis]  # and across it
    speed, reach = np.abs(velocity), 2.0 * racked.radius
    meets = (along.real > 0.0) & (np.abs(along.imag) < reach * speed[..., np.newaxis])
    kept = np.repeat([1.0, REBOUND], [len(rack), 4 * len(rack)])
    into = np.minimum(speed * (meets * kept).max(axis=2), LARGEST).mean(axis=1)
    pocketed = ball + direct.way * line
    blocked = np.minimum(_nearest(rack, cue, contact), _nearest(rack, ball, pocketed)) < reach
    return np.where(blocked, BLOCKED, LEAST + FOR_SPEED * into)


def _nearest(rack: Array, start: Array, end: Array) -> Array:
    """Return how near paths (n,) come to balls; all places are complex numbers."""
    path, to = (end - start)[:, np.newaxis], rack - start[:, np.newaxis]
    share = (to * path.conj()).real / np.maximum(np.abs(path) ** 2, TINY)
    nearest: Array = np.abs(to - np.clip(share, 0.0, 1.0) * path).min(axis=1)
    return nearest


def _next_rack(racked: State) -> Array:
    """Return where the balls (n, 2) lie that are racked again [m]."""
    return np.array([racked.balls[ball] for ball in racked.object_balls[racked.game.reracked :]])


@lru_cache(maxsize=16)
def _racked(scene: Scene, game: Game) -> State:
    return start(game, scene)


@lru_cache(maxsize=4096)
def _from_good_places(scene: Scene, game: Game, along: int, aside: int) -> float:
    """Estimate the chance that a run goes on by a ball in a cell, from good places."""
    racked, (ball, *others) = _racked(scene, game), game.balls
    rack, reach = _next_rack(racked), 2.0 * racked.radius
    half = 0.5 * (np.array([racked.length, racked.width]) - reach)
    place = np.clip([along * CELL, aside * CELL], -half, half)
    if np.hypot(*(rack - place).T).min() < reach:
        return LEAST
    lying = {ball: place, **dict(zip(others, rack, strict=False))}
    tables = cue_ball_all_over(racked, lying, racked.radius, PLACES)
    direct, best = shots(scene, tables, [ball]), np.zeros(PLACES)
    np.maximum.at(best, direct.table, direct.chance * into_rack(racked, direct, tables))
    return float(np.sort(best)[-BEST:].mean())
