"""
The value of states: an estimate of the probability to win the rack.

Two equal players are assumed, who make each shot with the probability `SHOT`, and who need a shot
for each ball, and `BLOCKED` more for a ball that no pocket is open to. Then the probability to win
from the table with n shots to make, while the other needs m, follows by a recursion. The next shot
of a state is not an average one: its chance is that of the best direct shot, `shots`.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.batch_outcomes import RuledBatch
from billiard_shot.game.game import Game
from billiard_shot.game.state import State
from billiard_shot.planning.open_pockets import open_pockets
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.table_states import TableStates

SHOT = 0.9  # probability that a shot of the rest of the rack pots and leaves the next one
BLOCKED = 3  # shots that a ball costs beside its own if no pocket is open to it
MOST_SHOTS = 15 * (1 + BLOCKED)  # that a player needs
AFTER_SAFETY = 0.5  # probability of the other player's shot after a safety
IN_HAND_CHANCE, IN_KITCHEN = 0.97, 0.85  # chance of the first shot with the cue ball in hand


@cache
def win_probabilities(shared: bool) -> Array:
    """
    Tabulate the probability that the player at the table wins, between equal players.

    Parameters
    ----------
    shared : bool
        Whether both players pot the same balls.

    Returns
    -------
    (MOST_SHOTS + 1, MOST_SHOTS + 1) float array
        By the shots that the player at the table has to make, and the other one.

    """
    miss = 1.0 - SHOT
    won = np.zeros((MOST_SHOTS + 1, MOST_SHOTS + 1))
    won[0] = 1.0
    if shared:
        for mine in range(1, MOST_SHOTS + 1):  # w = s u + (1 - s) (1 - w), with u after the shot
            won[mine] = (SHOT * won[mine - 1] + miss) / (1.0 + miss)
        return won
    for total in range(2, 2 * MOST_SHOTS + 1):
        for mine in range(max(1, total - MOST_SHOTS), min(total, MOST_SHOTS + 1)):
            others = total - mine
            # w = s up + miss (1 - v),  v = s down + miss (1 - w), with v of the other player
            up, down = won[mine - 1, others], won[others - 1, mine]
            won[mine, others] = (SHOT * up + miss * (1.0 - SHOT * down - miss)) / (1.0 - miss**2)
    return won


def shots_left(
    scene: Scene, after: Sequence[State], kind: NDArray[np.int64], states: TableStates
) -> NDArray[np.int64]:
    """
    Count the shots that the players need.

    Parameters
    ----------
    scene : Scene
    after : sequence of State
        States of the game.
    kind : (n,) int array
        Which of these belongs to each table; -1: none.
    states : TableStates
        (n,) where the balls lie.

    Returns
    -------
    (n, 2) int array
        Of the player at the table, and of the other one.

    """
    needed = np.zeros((2, *states.present.shape), np.bool_)
    for number, state in enumerate(after):
        needs = state.game.needs
        for who, player in enumerate((state.player, state.other)):
            balls = needs(state, player)
            needed[who, kind == number] = [name in balls for name in states.names]
    needed &= states.present
    lying = states.present & (np.array(states.names) != CUE_BALL)
    others = TableStates(states.names, states.position, present=lying)
    count = open_pockets(scene, others, needed[0] | needed[1])
    return (needed * np.where(count, 1, 1 + BLOCKED)).sum(axis=2).T


def at_table(chance: Array, game: Game, left: NDArray[np.int64]) -> Array:
    """
    Value states for the player at the table.

    Parameters
    ----------
    chance : (n,) float array
        Of the next shot.
    game : Game
    left : (n, 2) int array
        As of `shots_left`.

    """
    mine, others = left.T
    rest = np.maximum(mine - 1, 0)
    if game.players == 1:
        return np.where(mine > 0, chance * SHOT**rest, 1.0)
    won = win_probabilities(game.shared)
    missed = won[mine, others]
    theirs = won[np.maximum(others - 1, 0), rest if game.shared else mine]
    safety = AFTER_SAFETY * (1.0 - theirs) + (1.0 - AFTER_SAFETY) * missed
    pot = chance * won[rest, rest if game.shared else others]
    return np.where(
        mine > 0, np.maximum(pot + (1.0 - chance) * miss_value(game, left), safety), 1.0
    )


def miss_value(game: Game, left: NDArray[np.int64]) -> Array:
    """Value a miss for the player at the table: the other one plays from an average place."""
    mine, others = left.T
    if game.players == 1:
        return np.zeros(len(left))
    return 1.0 - win_probabilities(game.shared)[others, mine]


def values(scene: Scene, player: int, batch: RuledBatch) -> Array:
    """
    Value each row of a batch for a player.

    Parameters
    ----------
    scene : Scene
        Table and noise.
    player : int
    batch : RuledBatch
        (n,)

    Returns
    -------
    (n,) float array
        Estimated probabilities to win.

    """
    goes_on = [not after.over and not after.in_hand for after in batch.after]
    chance = next_shots(scene, batch, goes_on).best
    left = shots_left(scene, batch.after, batch.kind, batch.states)
    found = np.zeros(len(batch.kind))
    for number, after in enumerate(batch.after):
        rows = batch.kind == number
        found[rows] = value(after, player, chance[rows], left[rows])
    return found


def next_shots(scene: Scene, batch: RuledBatch, kinds: Sequence[bool]) -> DirectShots:
    """Find the direct shots that follow a batch, of the rulings that `kinds` tells."""
    masks = np.zeros(batch.states.present.shape, np.bool_)
    for number, after in enumerate(batch.after):
        if kinds[number]:
            masks[batch.kind == number] = may_pot(after, batch.states.names)
    return shots(scene, batch.states, masks)


def may_pot(state: State, names: tuple[str, ...]) -> list[bool]:
    """Which balls the player at the table may pot."""
    targets = state.game.targets(state)
    return [name in targets for name in names]


def value(state: State, player: int, chance: Array, left: NDArray[np.int64]) -> Array:
    """Value a state for a player, with chances (n,) of the next shot, and `shots_left`."""
    if state.over:
        return np.full(len(chance), float(state.winner == player))
    if state.in_hand:
        chance = np.full(
            len(chance), IN_HAND_CHANCE if state.in_hand == 'anywhere' else IN_KITCHEN
        )
    own = at_table(chance, state.game, left)
    if 'pass' in state.choices:  # after a push-out the other player takes the better part
        own = np.maximum(own, 1.0 - own)
    return own if state.player == player else 1.0 - own
