"""Breaks: searched once for a table, a game and a player's limits, and remembered."""

from dataclasses import replace
from functools import lru_cache
import math

import numpy as np

from billiard_shot.game.agent import scene_of, simulated
from billiard_shot.game.call import Call
from billiard_shot.game.clearance import raised
from billiard_shot.game.game import start
from billiard_shot.game.referee import judge
from billiard_shot.game.spots import Place
from billiard_shot.game.state import State
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke

# Places of the cue ball: shares of the length from the head string, and of the width; and the
# points that are aimed at, sideways of the apex ball, in ball radii.
BEHIND, BESIDE = (0.02, 0.12), (0.0, 0.2, 0.4)
AIMS = 0.0, 0.5
FIRST, MORE, BEST = 8, 32, 4  # breaks of each; more of the best ones


def best_break(scene: Scene, game: str) -> tuple[Place, Stroke]:
    """
    Return the place of the cue ball (x, y) [m] and the stroke of the break that is best.

    The best break keeps the turn most often, and among those that do not, is legal.
    """
    return _search(replace(scene, balls={}), game)


@lru_cache(maxsize=16)
def _search(scene: Scene, game: str) -> tuple[Place, Stroke]:
    tried = [(behind, beside, aim) for behind in BEHIND for beside in BESIDE for aim in AIMS]
    scores = {way: [_score(scene, game, way, seed) for seed in range(FIRST)] for way in tried}
    best = sorted(tried, key=lambda way: -np.mean(scores[way]))[:BEST]
    for way in best:
        scores[way] += [_score(scene, game, way, seed) for seed in range(FIRST, FIRST + MORE)]
    state, stroke = _break(scene, game, max(best, key=lambda way: np.mean(scores[way])), 0)
    return state.balls['cue'], stroke


def _break(
    scene: Scene, game: str, way: tuple[float, float, float], seed: int
) -> tuple[State, Stroke]:
    """Return the state with the cue ball placed, and the stroke."""
    behind, beside, aim = way
    state = start(game, scene, seed)
    x = -0.25 * state.length - behind * state.length
    y = min(beside * state.width, 0.5 * state.width - 2.0 * state.radius)
    state = state.with_cue_ball(x, y)
    apex = min((place for ball, place in state.balls.items() if ball != 'cue'), key=lambda p: p[0])
    azimuth = math.atan2(apex[1] + aim * state.radius - y, apex[0] - x)
    offsets = np.array([[0.0, 0.0, 0.0, azimuth, scene.robot.speed_max]])
    lifted, _ = raised(scene_of(scene, state), offsets)
    return state, Stroke.from_offsets(*lifted[0].tolist())


def _score(scene: Scene, game: str, way: tuple[float, float, float], seed: int) -> float:
    state, stroke = _break(scene, game, way, seed)
    outcome = simulated(scene_of(scene, state), stroke, np.random.default_rng(seed))
    ruling = judge(state, Call(), outcome)
    if ruling.state.over:
        return 1.5
    if not ruling.legal or 'rebreak' in ruling.state.choices:
        return -0.5 if ruling.fouls else 0.0
    return 1.0 if ruling.state.player == state.player else 0.2
