"""Error and cost of tolerances in a scene: a guide to the choice of one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.accuracy import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.predict import predict
from billiard_shot.shot.stroke import Stroke
from billiard_shot.study.sample_strokes import sample_strokes

SHOT_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)  # m
REFERENCE_TOLERANCE = 1e-11  # m, tolerance of the shots that errors are measured against


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Error and cost of one tolerance.

    Times are processor times, medians of all strokes. Each is the smallest of several runs, in
    which the tolerances take turns, so that other work of the computer changes their ratios
    little.

    Attributes
    ----------
    tolerance : float
        [m].
    typical_error, largest_error : float
        Of the place of rest of the cue ball without the other balls [m].
    strike, alone, shot : float
        Time of a strike on endless cloth, of a shot without the other balls, and of a shot with
        all balls [s].

    """

    tolerance: float
    typical_error: float
    largest_error: float
    strike: float
    alone: float
    shot: float


def study_accuracy(
    scene: Scene,
    tolerances: Sequence[float] = SHOT_TOLERANCES,
    count: int = 100,
    repeats: int = 5,
) -> Iterator[Tolerance]:
    """
    Measure error and time of each tolerance with random strokes.

    Parameters
    ----------
    scene : Scene
    tolerances : sequence of float
        [m].
    count : int
        Number of strokes, 0.5 to 5 m/s, that aim at the balls of the scene. Those whose cue hits
        the ball again are left out: errors are unbounded after it.
    repeats : int
        Runs of each shot.

    Raises
    ------
    ValueError
        If none of the strokes can be played.

    """
    shots = [predict(scene, stroke) for stroke in sample_strokes(scene, count)]
    strokes = [s.stroke for s in shots if not s.status.refused and s.double_hit is None]
    if not strokes:
        raise ValueError(f'scene: none of {count} random strokes can be played')
    alone = replace(scene, balls={CUE_BALL: scene.cue_ball[:2]})
    strikes = _times(replace(alone, table=None), strokes, tolerances, repeats)
    without = _times(alone, strokes, tolerances, repeats)
    all_balls = _times(scene, strokes, tolerances, repeats)
    exact = _places(alone, strokes, REFERENCE_TOLERANCE)
    for tolerance, *times in zip(tolerances, strikes, without, all_balls, strict=True):
        errors = np.linalg.norm(_places(alone, strokes, tolerance) - exact, axis=1)
        yield Tolerance(tolerance, float(np.median(errors)), float(errors.max()), *times)


def cost_of_accuracy(studied: Sequence[Tolerance]) -> str:
    """Say how much longer a shot within the last tolerance takes than one within the default."""
    usual = min(studied, key=lambda each: abs(np.log(each.tolerance / DEFAULT_SHOT_TOLERANCE)))
    finest = studied[-1]
    ratio = finest.alone / usual.alone
    return (
        f'a shot within {1e9 * finest.tolerance:g} nm takes {ratio:.1f} times the processor time '
        f'of one within {1e3 * usual.tolerance:g} mm'
    )


def _times(
    scene: Scene, strokes: Sequence[Stroke], tolerances: Sequence[float], repeats: int
) -> list[float]:
    """Measure processor times (tolerances,) [s]; the tolerances take turns."""
    smallest = np.full((len(tolerances), len(strokes)), np.inf)
    for _ in range(repeats):
        for j, stroke in enumerate(strokes):
            for i, tolerance in enumerate(tolerances):
                started = process_time()
                predict(scene, stroke, tolerance)
                smallest[i, j] = min(smallest[i, j], process_time() - started)
    return np.median(smallest, axis=1).tolist()


def _places(scene: Scene, strokes: Sequence[Stroke], tolerance: float) -> Array:
    return np.array([predict(scene, s, tolerance).final_position[CUE_BALL] for s in strokes])
