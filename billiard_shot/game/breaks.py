"""Breaks: searched once for a table, a game and a player's limits, and remembered."""

from dataclasses import replace
from functools import lru_cache
import itertools
import math

import numpy as np

from billiard_shot.game.agent import scene_of
from billiard_shot.game.batch_outcomes import rule_on, RuledBatch
from billiard_shot.game.call import NO_CALL
from billiard_shot.game.playable import raised
from billiard_shot.game.racking import start
from billiard_shot.game.state import State
from billiard_shot.game.valuation import values
from billiard_shot.planning.within_noise import play_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import with_errors
from billiard_shot.scene.rack import Place
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.table_states import TableStates

# Places of the cue ball: distances behind the head string and beside the long string, relative to
# length and width. Points that are aimed at: sideways of the apex ball, in ball radii. Points of
# contact of the tip: b, in ball radii. Speeds, relative to the largest one.
PLACES_BEHIND, PLACES_BESIDE = (0.01, 0.12), (0.0, 0.15, 0.3, 0.44)
AIMS, BREAK_TIPS, BREAK_SPEEDS = (-0.3, 0.0, 0.3), (-0.15, 0.1), (1.0, 0.85)
# Racks that the best breaks so far are tried on, and how many breaks go on to the next round.
BREAK_ROUNDS = ((3, 24), (8, 8), (24, 3), (60, 1))


def best_break(scene: Scene, game: str) -> tuple[Place, Stroke]:
    """
    Return the place of the cue ball (x, y) [m] and the stroke of the break that is best.

    The best break has the largest mean value of the states that it leaves.
    """
    return _search(replace(scene, balls={}), game)


@lru_cache(maxsize=16)
def _search(scene: Scene, game: str) -> tuple[Place, Stroke]:
    strokes = break_strokes(scene, start(game, scene))
    found = np.zeros((len(strokes), 0))
    for racks, best in BREAK_ROUNDS:
        seeds = range(found.shape[1], found.shape[1] + racks)
        batch = break_racks(scene, game, strokes, seeds)
        new = values(scene, 0, batch).reshape(len(strokes), racks)
        found = np.column_stack([found, new])
        kept = np.argsort(-found.mean(axis=1), kind='stable')[:best]
        strokes, found = strokes[kept], found[kept]
    x, y, *offsets = strokes[0].tolist()
    return (x, y), Stroke.from_offsets(*offsets)


def break_strokes(scene: Scene, state: State) -> Array:
    """List breaks (n, 7): place x, y of the cue ball [m], and the offsets of the stroke."""
    balls = (place for ball, place in state.balls.items() if ball != CUE_BALL)
    apex = min(balls, key=lambda place: place[0])
    found = []
    for behind, beside in itertools.product(PLACES_BEHIND, PLACES_BESIDE):
        x, y = -(0.25 + behind) * state.length, beside * state.width
        rows = [
            (0.0, b, 0.0, math.atan2(apex[1] + aim * state.radius - y, apex[0] - x), speed)
            for aim, b, speed in itertools.product(AIMS, BREAK_TIPS, BREAK_SPEEDS)
        ]
        offsets = np.array(rows) * (1.0, 1.0, 1.0, 1.0, scene.robot.speed_max)
        offsets, playable = raised(scene_of(scene, state.with_cue_ball(x, y)), offsets)
        places = np.broadcast_to((x, y), (len(offsets), 2))
        found.append(np.column_stack([places, offsets])[playable])
    return np.concatenate(found)


def break_racks(scene: Scene, game: str, strokes: Array, seeds: range) -> RuledBatch:
    """
    Play breaks with the errors of the player; a stroke without room for the cue is refused.

    Parameters
    ----------
    scene : Scene
    game : str
    strokes : (n, 7) float array
        See `break_strokes`.
    seeds : range
        Of racks and errors, the same ones for each break.

    Returns
    -------
    RuledBatch
        (n racks,), all racks of the first break, then of the next one.

    """
    states = [start(game, scene, seed).with_cue_ball(*strokes[0, :2].tolist()) for seed in seeds]
    names = tuple(sorted(states[0].balls, key=lambda ball: ball != CUE_BALL))
    position = np.full((len(strokes), len(states), len(names), 3), scene.ball.radius)
    position[..., :2] = [[state.balls[name] for name in names] for state in states]
    position[:, :, 0, :2] = strokes[:, np.newaxis, :2]
    draws = [np.random.default_rng(seed).standard_normal(5) for seed in seeds]
    sigmas = scene.noise.sigmas(scene.ball.radius)
    errors = np.array(draws) * sigmas
    played = with_errors(strokes[:, np.newaxis, 2:], errors).reshape(-1, 5)
    tables = TableStates(names, position.reshape(-1, len(names), 3))
    run = play_within_noise(scene, played, sigmas, tables)
    return rule_on(states[0], [NO_CALL] * len(played), run)
