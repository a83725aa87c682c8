"""The second ply: what the best shots of an end state leave in turn."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.batch_outcomes import RuledBatch
from billiard_shot.game.state import State
from billiard_shot.game.valuation import (
    at_table,
    may_pot,
    miss_value,
    next_shots,
    shots_left,
)
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.planning.strikes import along_azimuth
from billiard_shot.planning.within_noise import play_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import A, B, ELEVATION, SPEED
from billiard_shot.shot.effects import model_of
from billiard_shot.table.table_states import TableStates

FOLLOWED_SHOTS = 2  # direct shots of each end state that are followed
# a, b [ball radii] and the speed relative to that of the direct shot
STROKES = np.array(
    [(0.0, b, speed) for b in (0.0, 0.3, -0.3) for speed in (1.0, 1.6)]
    + [(0.25, 0.1, 1.0), (-0.25, 0.1, 1.0)]
)
LIFT_STEP = 0.02  # rad: elevations are rounded to multiples of it, so that few strikes are solved


class Followed(NamedTuple):
    """Strokes that follow end states."""

    row: NDArray[np.int64]  # (n,) of the end state
    shot: NDArray[np.int64]  # (n,)
    strokes: Array  # (n, 5)
    states: TableStates  # n tables


def second_ply(scene: Scene, player: int, batch: RuledBatch, first: Array) -> Array:
    """
    Value end states in which a player goes on by its next two shots.

    Parameters
    ----------
    scene : Scene
    player : int
    batch : RuledBatch
        (n,) of strokes that kept the turn.
    first : (n,) float array
        Their values by the next shot alone, see `values`.

    Returns
    -------
    (n,) float array
        The largest value of the strokes that follow, without errors but with the chance of their
        shots; `first` where none of them pots. A stroke without room for the cue is refused, and
        one whose cue hits the cue ball again is a foul.

    """
    names = batch.states.names
    goes_on = [
        not after.over and not after.in_hand and after.player == player for after in batch.after
    ]
    direct = next_shots(scene, batch, goes_on)
    if not len(direct):
        return first
    followed = _follow(scene, batch.states, direct)
    sigmas = scene.noise.sigmas(scene.ball.radius)
    played = play_within_noise(scene, followed.strokes, sigmas, followed.states)
    cue = names.index(CUE_BALL)
    ball = direct.ball[followed.shot]
    rows = np.arange(len(ball))
    potted = (
        (played.pocket[rows, ball] == direct.pocket[followed.shot])
        & (played.first_met[:, cue] == ball)
        & played.states.present[:, cue]
        & ~played.double_hit
    )
    found = np.full(len(first), -np.inf)
    value = _values_after(scene, batch, direct, followed, potted, played.states)
    np.maximum.at(found, followed.row[potted], value[potted])
    return np.where(np.isfinite(found), found, first)


def _follow(scene: Scene, states: TableStates, direct: DirectShots) -> Followed:
    """Make strokes at the best direct shots of each table."""
    order = np.lexsort((-direct.chance, direct.table))
    rank = np.arange(len(order)) - np.searchsorted(direct.table[order], direct.table[order])
    chosen = order[rank < FOLLOWED_SHOTS]
    shot = np.repeat(chosen, len(STROKES))
    row = direct.table[shot]
    strokes = direct.offsets[shot]
    a, b, faster = np.tile(STROKES, (len(chosen), 1)).T
    strokes[:, A], strokes[:, B] = a, b
    strokes[:, ELEVATION] = np.ceil(strokes[:, ELEVATION] / LIFT_STEP) * LIFT_STEP
    strokes[:, SPEED] = np.minimum(strokes[:, SPEED] * faster, scene.robot.speed_max)
    strokes = along_azimuth(model_of(scene), strokes)
    return Followed(row, shot, strokes, states.take(row))


def _values_after(
    scene: Scene,
    batch: RuledBatch,
    direct: DirectShots,
    followed: Followed,
    potted: NDArray[np.bool_],
    ends: TableStates,
) -> Array:
    """Value strokes that pot, by the chance of the shot, and the best shot that they leave."""
    before, ball = batch.kind[followed.row], direct.ball[followed.shot]
    ways = set(zip(before[potted].tolist(), ball[potted].tolist(), strict=True))
    after: list[State] = []
    kind = np.full(len(before), -1)
    masks = np.zeros(ends.present.shape, np.bool_)
    for number, fallen in ways:
        rows = potted & (before == number) & (ball == fallen)
        kind[rows] = len(after)
        after.append(batch.after[number].without(ends.names[fallen]))
        if after[-1].object_balls:
            masks[rows] = may_pot(after[-1], ends.names)
    chance = shots(scene, ends, masks).best
    game = batch.after[0].game
    missed = miss_value(game, shots_left(scene, batch.after, batch.kind, batch.states))
    p = direct.chance[followed.shot]
    then = at_table(chance, game, shots_left(scene, after, kind, ends))
    return p * then + (1.0 - p) * missed[followed.row]
