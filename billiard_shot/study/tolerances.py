"""Error and cost of tolerances: a guide to the choice of one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.plan import plan
from billiard_shot.scene import Scene
from billiard_shot.shot.predict import predict, predict_batch
from billiard_shot.shot.stroke import Stroke
from billiard_shot.study.sample_strokes import sample_strokes
from billiard_shot.table.motion import Motion

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)  # m
FINEST = 1e-11  # m, tolerance of the shots that errors are measured against
OPENING = Stroke.from_offsets(a=0.0, b=0.1, elevation=0.08, azimuth=-0.106, speed=8.0)
PLANNED, BALL = 'frozen_combination', '8'  # scene of the plan, and the ball that it pots


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Error and cost of one tolerance; times of single shots are medians.

    Attributes
    ----------
    tolerance : float
        [m].
    typical_error, largest_error : float
        Of the place of rest of the cue ball on a table without other balls [m].
    strike, shot, opening : float
        Time of a strike on endless cloth, of a shot on a table without other balls, and of a break
        at eight-ball [s].
    plan : float
        Time of all strokes that judge a plan [s].
    success : float
        Fraction of them that reach the target.

    """

    tolerance: float
    typical_error: float
    largest_error: float
    strike: float
    shot: float
    opening: float
    plan: float
    success: float


def study_tolerances(
    tolerances: Sequence[float] = TOLERANCES,
    shots: int = 100,
    judged: int = 1000,
    repeats: int = 5,
) -> Iterator[Tolerance]:
    """
    Measure error and time of each tolerance.

    Parameters
    ----------
    tolerances : sequence of float
        [m].
    shots : int
        Random strokes, 0.5 to 5 m/s, for errors and for the times of a strike and of a shot.
    judged : int
        Strokes with execution noise that judge a plan.
    repeats : int
        Of the break.

    """
    cloth, table, rack = Scene.load('pool'), Scene.load('pool_table'), Scene.load('eight_ball')
    strokes = sample_strokes(table, shots)
    exact = _places(table, strokes, FINEST)
    scene = Scene.load(PLANNED)
    best = plan(scene, {'pot': BALL}, budget=2000).best
    assert best is not None
    rng = np.random.default_rng(1)
    noisy = [scene.noise.perturb(best.stroke, rng, scene.ball.radius) for _ in range(judged)]
    normals = np.array([stroke.normal for stroke in noisy])
    velocities = np.array([stroke.velocity for stroke in noisy])
    for tolerance in tolerances:
        errors = np.linalg.norm(_places(table, strokes, tolerance) - exact, axis=1)
        started = perf_counter()
        batch = predict_batch(scene, normals, velocities, tolerance)
        judging = perf_counter() - started
        assert batch.table is not None
        motion = batch.table.motion
        reached = (motion[:, batch.table.names.index(BALL)] == Motion.POCKETED) & (
            motion[:, 0] == Motion.REST
        )
        yield Tolerance(
            tolerance,
            float(np.median(errors)),
            float(errors.max()),
            median(predict(cloth, stroke, tolerance).wall_time for stroke in strokes),
            median(predict(table, stroke, tolerance).wall_time for stroke in strokes),
            median(predict(rack, OPENING, tolerance).wall_time for _ in range(repeats)),
            judging,
            float(reached.mean()),
        )


def _places(scene: Scene, strokes: Sequence[Stroke], tolerance: float) -> NDArray[np.float64]:
    return np.array([predict(scene, s, tolerance).final_position['cue'] for s in strokes])
