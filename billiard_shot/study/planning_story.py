"""A search stage by stage: the planner's own steps, recorded for inspection."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.cross_entropy import Population, population_of, refine
from billiard_shot.planning.limits import limits_of
from billiard_shot.planning.problem import Problem, problem_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.search import (
    best_of,
    choose_candidates,
    NORMAL_BUDGET,
    REFINED,
    run_race,
)
from billiard_shot.planning.stages import KINDS, next_stage, Stage
from billiard_shot.planning.targets import target_of
from billiard_shot.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class StoryStage:
    """
    A stage of a search.

    Attributes
    ----------
    name : str
    strokes : (n, 5) float array
        Candidates: a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
    reached : (n,) bool array
        Whether a candidate reaches the target without errors.
    refined : tuple of Population
        The best candidates after each iteration of their refinement.

    """

    name: str
    strokes: NDArray[np.float64]
    reached: NDArray[np.bool_]
    refined: tuple[Population, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Story:
    """The first round of a search, and the finalists of its race."""

    scene: Scene
    stages: tuple[StoryStage, ...]
    finalists: tuple[RankedStroke, ...]


def tell(scene: Scene, ball: str, seed: int = 1) -> Story:
    """Search for a stroke that pots a ball, as `plan` does, in one round."""
    limits = limits_of(scene, None, scene.noise)
    problem = problem_of(scene, target_of(scene, {'pot': ball}), limits, scene.noise)
    draws = np.random.default_rng(seed)
    with ThreadPoolExecutor() as threads:
        runner = Runner(problem, NORMAL_BUDGET, threads)
        stages = tuple(_stages(problem, runner, draws))
        ended = best_of([stage.refined[-1] for stage in stages if stage.refined])
        finalists = run_race(problem, runner, ended, draws, effort=1.0)
    return Story(scene, stages, tuple(finalists))


def _stages(problem: Problem, runner: Runner, draws: np.random.Generator) -> Iterator[StoryStage]:
    made: list[Stage] = []
    best = 0.0
    while len(made) < len(KINDS) and (stage := next_stage(problem, runner, made, best)):
        population = population_of(stage, choose_candidates(stage, REFINED, draws))
        refined = tuple(refine(problem, runner, population, draws, effort=1.0))
        best = max([best, *(float(last.value[0]) for last in refined[-1:])])
        yield StoryStage(stage.name, stage.candidates.strokes, stage.outcomes.success, refined)
