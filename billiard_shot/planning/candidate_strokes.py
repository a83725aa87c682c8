"""candidates(): the strokes that a plan begins with, before any of them is refined or raced."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import os
from typing import Any

import numpy as np

from billiard_shot.planning.limits import limits_of
from billiard_shot.planning.noises import noise_of
from billiard_shot.planning.plan import checked_problem
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.stages import next_stage, Stage
from billiard_shot.planning.targets import Target, target_of
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Robot, Scene, SceneLike
from billiard_shot.scene.values import whole

CANDIDATE_BUDGET = 6_000  # simulated strokes


@dataclass(frozen=True, slots=True, eq=False)
class CandidateStrokes:
    """
    Strokes that may reach a target, the nearest first.

    Attributes
    ----------
    offsets : (n, 5) float array
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.
    penalty : (n,) float array
        0 if the stroke reaches the target without errors. Otherwise how far it is from that: one
        for every step that is missing, and below one for the distance that is left.

    """

    offsets: Array
    penalty: Array

    def __len__(self) -> int:
        """Return the number of strokes."""
        return len(self.penalty)

    def __repr__(self) -> str:
        return f'CandidateStrokes({len(self)}, of which {(self.penalty == 0.0).sum()} reach it)'


def candidates(
    scene: SceneLike,
    target: Target | Mapping[str, Any],
    noise: str | Noise | Mapping[str, Any] | None = None,
    budget: int = CANDIDATE_BUDGET,
    constraints: Mapping[str, Any] | Robot | None = None,
) -> CandidateStrokes:
    """
    List strokes that may reach a target, simulated once, without errors.

    They differ in path, speed and spin. Straight paths come first; combinations, cushions and
    curves follow only if no stroke so far has reached the target.

    Parameters
    ----------
    scene, target, noise, constraints
        As of `plan`.
    budget : int
        Largest number of simulated strokes, at least 1.

    Raises
    ------
    ValueError
        As of `plan`.

    """
    scene = Scene.load(scene)
    spread = noise_of(scene, noise)
    wanted = target_of(scene, target)
    budget = whole('budget', budget, 1)
    problem = checked_problem(scene, wanted, limits_of(scene, constraints, spread), spread)
    stages: list[Stage] = []
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        runner = Runner(problem, budget, threads)
        runner.reserved = 0
        best = 0.0
        while stage := next_stage(problem, runner, stages, best, share=1.0):
            best = float(stage.outcomes.success.any())
    strokes = np.concatenate([stage.candidates.strokes for stage in stages])
    penalty = np.concatenate([stage.outcomes.penalty for stage in stages])
    order = np.argsort(penalty, kind='stable')
    return CandidateStrokes(strokes[order], penalty[order])
