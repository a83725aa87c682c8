"""
The value of states: an estimate of the probability to win the rack.

Two equal players are assumed, who pot each ball with the probability `SHOT`. Then the probability
to win from the table with n balls to pot, while the other needs m, follows by a recursion. The
next shot of a state is not an average one: its chance is that of the best direct shot, `shots`.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from billiard_shot.game.batch_outcomes import RuledBatch
from billiard_shot.game.game import find_game
from billiard_shot.game.state import State
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.records import Array
from billiard_shot.scene import Scene

SHOT = 0.9  # probability that a shot of the rest of the rack pots and leaves the next one
AFTER_SAFETY = 0.5  # the same for the other player's shot after a safety
IN_HAND_CHANCE, IN_KITCHEN = 0.97, 0.85  # chance of the first shot with the cue ball in hand


@lru_cache(maxsize=4096)
def win_probability(mine: int, others: int, shared: bool) -> float:
    """
    Probability that the player at the table wins, between equal players and average positions.

    Parameters
    ----------
    mine, others : int
        Balls that the player at the table, and the other one, have to pot.
    shared : bool
        Whether these are the same balls.

    """
    if mine <= 0:
        return 1.0
    # w = s u + (1 - s) (1 - v), where v is the same for the other: solve both equations
    up = win_probability(mine - 1, mine - 1 if shared else others, shared)
    if shared:
        return (SHOT * up + 1.0 - SHOT) / (2.0 - SHOT)
    if others <= 0:
        return 0.0
    other_up = win_probability(others - 1, mine, shared)
    miss = 1.0 - SHOT
    # w = s up + miss (1 - v),  v = s other_up + miss (1 - w)
    return (SHOT * up + miss * (1.0 - SHOT * other_up - miss)) / (1.0 - miss * miss)


def at_table(chance: Array, state: State) -> Array:
    """
    Value a state for the player at the table, whose next shot has a chance.

    Parameters
    ----------
    chance : (n,) float array
        Of n tables with the same state but for the places.
    state : State
        Which balls are left, and who has to pot which.

    """
    rules = find_game(state.game)
    mine, others = rules.needs(state, state.player), rules.needs(state, state.other)
    if mine <= 0:
        return np.ones(len(chance))
    if rules.players == 1:
        return chance * SHOT ** (mine - 1)
    shared = rules.shared
    pot = win_probability(mine - 1, mine - 1 if shared else others, shared)
    theirs = win_probability(others - 1, others - 1 if shared else mine, shared)
    missed = win_probability(mine, others, shared)
    safety = AFTER_SAFETY * (1.0 - theirs) + (1.0 - AFTER_SAFETY) * missed
    return np.maximum(chance * pot + (1.0 - chance) * miss_value(state), safety)


def miss_value(state: State) -> float:
    """Value of a miss for the player at the table: the other one plays from an average place."""
    rules = find_game(state.game)
    if rules.players == 1:
        return 0.0
    mine, others = rules.needs(state, state.player), rules.needs(state, state.other)
    return 1.0 - win_probability(others, mine, rules.shared)


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
    found = np.zeros(len(batch.kind))
    for number, after in enumerate(batch.after):
        rows = batch.kind == number
        found[rows] = value(after, player, chance[rows])
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
    targets = find_game(state.game).targets(state)
    return [name in targets for name in names]


def value(state: State, player: int, chance: Array) -> Array:
    """Value a state for a player, with chances (n,) of the next shot."""
    if state.over:
        return np.full(len(chance), float(state.winner == player))
    if state.in_hand:
        chance = np.full(
            len(chance), IN_HAND_CHANCE if state.in_hand == 'anywhere' else IN_KITCHEN
        )
    own = at_table(chance, state)
    if 'pass' in state.choices:  # after a push-out the other player takes the better part
        own = np.maximum(own, 1.0 - own)
    return own if state.player == player else 1.0 - own
