"""Places for the cue ball in hand, and the direct shots of a state."""

from typing import NamedTuple

import numpy as np

from billiard_shot.game.call import Call
from billiard_shot.game.state import State
from billiard_shot.planning.in_hand import cue_ball_at, places_all_over
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import AZIMUTH, SPEED
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.table_states import TableStates


def places_to_try(state: State) -> Array:
    """List places (n, 2) [m], all over the table, where the cue ball in hand may lie."""
    places = places_all_over(state, state.in_hand)
    return places[[not state.no_place(x, y) for x, y in places.tolist()]]


def direct_shots(scene: Scene, state: State, places: Array | None = None) -> DirectShots:
    """
    Find the direct shots of the player at the table.

    Parameters
    ----------
    scene : Scene
        Table, noise and limits.
    state : State
    places : (n, 2) float array, optional
        Places of the cue ball [m], one for each table; by default that of the state.

    """
    return shots(scene, placed(state, places), state.game.targets(state))


class ListedShot(NamedTuple):
    """A direct shot as people choose it."""

    call: Call
    chance: float  # that the ball falls
    azimuth: float  # of the path of the cue ball [rad]
    speed: float  # of the cue [m/s]


def listed_shots(scene: Scene, state: State) -> list[ListedShot]:
    """List the direct shots of a state, the best chance first; none without pockets."""
    if not state.game.pockets:
        return []
    direct = direct_shots(scene, state)
    best_first = np.argsort(-direct.chance, kind='stable').tolist()
    return [
        ListedShot(
            call_of(direct, i),
            float(direct.chance[i]),
            *direct.offsets[i, [AZIMUTH, SPEED]].tolist(),
        )
        for i in best_first
    ]


def call_of(direct: DirectShots, number: int) -> Call:
    """Call a direct shot."""
    ball, pocket = int(direct.ball[number]), int(direct.pocket[number])
    return Call(ball=direct.names[ball], pocket=POCKET_NAMES[pocket])


def placed(state: State, places: Array | None = None) -> TableStates:
    """Return the balls of a state as an array of tables; see `direct_shots`."""
    if places is None:
        places = np.array([state.balls[CUE_BALL]])
    others = {ball: state.balls[ball] for ball in state.object_balls}
    return cue_ball_at(places, others, state.radius)
