"""Places for the cue ball in hand, and states as arrays."""

import math

import numpy as np

from billiard_shot.game.game import find_game
from billiard_shot.game.state import State
from billiard_shot.records import Array
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.table_states import TableStates

DISTANCES = 0.15, 0.3, 0.5, 0.8  # m, of the cue ball from the ball
CUTS = np.radians([0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0])
SPREAD = 0.02  # m: random changes of the places
FEW = 40  # places that are drawn at random beside these


def places_to_try(state: State, draw: np.random.Generator) -> Array:
    """
    List places (n, 2) [m] from which a ball that may be potted can be, and random ones.

    Parameters
    ----------
    state : State
        With `places_cue_ball`.
    draw : numpy.random.Generator

    """
    found = []
    half_length, half_width = 0.5 * state.length, 0.5 * state.width
    pockets = [(x, y) for x in (-half_length, 0.0, half_length) for y in (-half_width, half_width)]
    for ball in find_game(state.game).targets(state):
        x, y = state.balls[ball]
        for pocket in pockets:
            back = math.atan2(y - pocket[1], x - pocket[0])
            for cut in CUTS.tolist():
                for distance in DISTANCES:
                    angle = back + cut
                    found.append((x + distance * math.cos(angle), y + distance * math.sin(angle)))
    half = np.array([half_length, half_width]) - state.radius
    around = np.array(found).reshape(-1, 2)
    around = around + SPREAD * draw.standard_normal(around.shape)
    anywhere = half * draw.uniform(-1.0, 1.0, (FEW, 2))
    if state.in_hand == 'kitchen':
        anywhere[:, 0] = -half[0] + (half[0] - 0.251 * state.length) * draw.uniform(size=FEW)
    places = np.concatenate([around, anywhere])
    allowed = [not state.no_place(x, y) for x, y in places.tolist()]
    return places[np.array(allowed)]


def placed(state: State, places: Array | None = None) -> TableStates:
    """
    Return the balls of a state as an array of tables.

    Parameters
    ----------
    state : State
    places : (n, 2) float array, optional
        Places of the cue ball [m], one for each table; by default that of the state.

    """
    names = (CUE_BALL, *state.object_balls)
    if places is None:
        places = np.array([state.balls[CUE_BALL]])
    position = np.full((len(places), len(names), 3), state.radius)
    position[:, 1:, :2] = [state.balls[name] for name in names[1:]]
    position[:, 0, :2] = places
    return TableStates(names, position)
