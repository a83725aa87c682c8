"""Error and cost of tolerances: a guide to the choice of one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.plan import plan
from billiard_shot.scene import Scene
from billiard_shot.shot.accuracy import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.predict import predict, predict_batch
from billiard_shot.shot.stroke import Stroke
from billiard_shot.study.sample_strokes import sample_strokes
from billiard_shot.table.motion import Motion

SHOT_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)  # m
REFERENCE_TOLERANCE = 1e-11  # m, tolerance of the shots that errors are measured against
OPENING = Stroke.from_offsets(a=0.0, b=0.1, elevation=0.08, azimuth=-0.106, speed=8.0)
PLANNED, POTTED_BALL = 'frozen_combination', '8'  # scene of the plan, and the ball that it pots


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Error and cost of one tolerance.

    Times are processor times. Each is the smallest of several runs, in which the tolerances take
    turns, so that other work of the computer changes their ratios little; those of a strike and of
    a shot are medians of all strokes.

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
    tolerances: Sequence[float] = SHOT_TOLERANCES,
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
        Runs of each shot.

    """
    cloth, table, rack = Scene.load('pool'), Scene.load('pool_table'), Scene.load('eight_ball')
    strokes = sample_strokes(table, shots)
    exact = _places(table, strokes, REFERENCE_TOLERANCE)
    scene = Scene.load(PLANNED)
    best = plan(scene, {'pot': POTTED_BALL}, budget=2000).best
    assert best is not None
    rng = np.random.default_rng(1)
    noisy = [scene.noise.perturb(best.stroke, rng, scene.ball.radius) for _ in range(judged)]
    normals = np.array([stroke.normal for stroke in noisy])
    velocities = np.array([stroke.velocity for stroke in noisy])
    strikes = np.median(_times(cloth, strokes, tolerances, repeats), axis=1)
    on_table = np.median(_times(table, strokes, tolerances, repeats), axis=1)
    openings = _times(rack, [OPENING], tolerances, repeats)[:, 0]
    for i, tolerance in enumerate(tolerances):
        errors = np.linalg.norm(_places(table, strokes, tolerance) - exact, axis=1)
        judging = np.inf
        for _ in range(repeats):
            started = process_time()
            batch = predict_batch(scene, normals, velocities, tolerance)
            judging = min(judging, process_time() - started)
        motion = batch.motion
        reached = (motion[:, batch.names.index(POTTED_BALL)] == Motion.POCKETED) & (
            motion[:, 0] == Motion.REST
        )
        yield Tolerance(
            tolerance,
            float(np.median(errors)),
            float(errors.max()),
            float(strikes[i]),
            float(on_table[i]),
            float(openings[i]),
            plan=judging,
            success=float(reached.mean()),
        )


def cost_of_accuracy(studied: Sequence[Tolerance]) -> str:
    """Say how much longer a shot within the last tolerance takes than one within the default."""
    usual = min(studied, key=lambda each: abs(np.log(each.tolerance / DEFAULT_SHOT_TOLERANCE)))
    finest = studied[-1]
    return (
        f'a shot within {1e9 * finest.tolerance:g} nm takes {finest.shot / usual.shot:.1f} times '
        f'the processor time of one within {1e3 * usual.tolerance:g} mm'
    )


def _times(
    scene: Scene, strokes: Sequence[Stroke], tolerances: Sequence[float], repeats: int
) -> NDArray[np.float64]:
    """Measure processor times (tolerances, strokes) [s]; the tolerances take turns."""
    smallest = np.full((len(tolerances), len(strokes)), np.inf)
    for _ in range(repeats):
        for j, stroke in enumerate(strokes):
            for i, tolerance in enumerate(tolerances):
                started = process_time()
                predict(scene, stroke, tolerance)
                smallest[i, j] = min(smallest[i, j], process_time() - started)
    return smallest


def _places(scene: Scene, strokes: Sequence[Stroke], tolerance: float) -> NDArray[np.float64]:
    return np.array([predict(scene, s, tolerance).final_position['cue'] for s in strokes])
