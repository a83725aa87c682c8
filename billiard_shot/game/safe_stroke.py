"""Strokes that pot nothing on purpose: safeties, push-outs, escapes, and the plain break."""

import math

import numpy as np

from billiard_shot.game.call import Call, Decision
from billiard_shot.game.playable import raised
from billiard_shot.game.state import State
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.ghost_ball import grazing
from billiard_shot.shot.predict import predict_batch
from billiard_shot.shot.stroke import Stroke

FULLNESS = 0.0, 0.3, -0.3, 0.6, -0.6, 0.85, -0.85, 0.97, -0.97  # of the line past the ball
SOFT = 0.5, 1.0, 1.7, 2.8  # m/s of the cue
KICK_SPEEDS = 1.5, 2.5  # m/s of the cue
KICKS = 120  # directions of strokes by cushions


def towards(scene: Scene, balls: tuple[str, ...]) -> Array:
    """List strokes (n, 5) straight at balls, full to thin, at several speeds."""
    x, y = scene.balls[CUE_BALL]
    rows = []
    for ball in balls:
        along, across = scene.balls[ball][0] - x, scene.balls[ball][1] - y
        half = grazing(math.hypot(along, across), 2.0 * scene.ball.radius)
        for full in FULLNESS:
            azimuth = math.atan2(across, along) + full * half
            rows += [(0.0, b, 0.0, azimuth, speed) for speed in SOFT for b in (0.0, -0.25)]
    offsets, playable = raised(scene, np.array(rows).reshape(-1, 5))
    return offsets[playable]


def all_round(scene: Scene) -> Array:
    """List strokes (n, 5) in all directions: most balls can be met by cushions."""
    azimuths = np.linspace(-math.pi, math.pi, KICKS, endpoint=False)
    rows = [(0.0, 0.0, 0.0, azimuth, speed) for azimuth in azimuths for speed in KICK_SPEEDS]
    offsets, playable = raised(scene, np.array(rows))
    return offsets[playable]


def hit_something(scene: Scene, state: State) -> Decision:
    """Decide on any stroke that meets a legal ball first; none if there is no such stroke."""
    targets = state.game.targets(state)
    for offsets in (towards(scene, targets), all_round(scene)):
        run = predict_batch(scene, offsets=offsets)
        wanted = [run.names.index(ball) for ball in targets]
        legal = np.flatnonzero(np.isin(run.first_met[:, run.names.index(CUE_BALL)], wanted))
        if len(legal):
            stroke = Stroke.from_offsets(*offsets[legal[-1]].tolist())
            return Decision(stroke, Call(safety=True), reason='no direct shot')
    return Decision(reason='no stroke meets a legal ball')


def break_stroke(scene: Scene) -> Stroke:
    """Return the stroke at the ball nearest to the head of the table, as hard as the robot can."""
    x, y = scene.balls[CUE_BALL]
    apex = min(scene.object_balls.values(), key=lambda place: place[0])
    azimuth = math.atan2(apex[1] - y, apex[0] - x)
    offsets = np.array([[0.0, 0.0, 0.0, azimuth, scene.robot.speed_max]])
    return Stroke.from_offsets(*raised(scene, offsets)[0][0].tolist())
