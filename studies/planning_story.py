"""A search stage by stage: the planner's own steps, recorded for inspection."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.canvas import BLUE, GREEN, new_figure, ORANGE, save
from billiard_shot.pictures.table import draw_balls, draw_table
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.problem import limits_of, Problem, problem_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.search import (
    best_of,
    choose_candidates,
    NORMAL_BUDGET,
    Population,
    population_of,
    refine,
    run_race,
    state_success,
)
from billiard_shot.planning.stages import KINDS, next_stage, Stage
from billiard_shot.planning.targets import target_of
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.predict import predict
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.outline import outline_of


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
        strokes, values = run_race(problem, runner, ended, draws, effort=1.0)
        finalists = state_success(problem, runner, strokes, values, draws, effort=1.0)
    return Story(scene, stages, tuple(finalists))


def _stages(problem: Problem, runner: Runner, draws: np.random.Generator) -> Iterator[StoryStage]:
    made: list[Stage] = []
    best = 0.0
    while len(made) < len(KINDS) and (stage := next_stage(problem, runner, made, best)):
        population = population_of(stage, choose_candidates(stage, 1.0, draws))
        refined = tuple(refine(problem, runner, population, draws, effort=1.0))
        best = max([best, *(float(last.value[0]) for last in refined[-1:])])
        yield StoryStage(
            stage.kind.name, stage.candidates.strokes, stage.outcomes.success, refined
        )


STORY_SCENE, TARGET_BALL = 'blocked', '8'
DRAWN_STROKES = 60  # candidates of a stage, and executions of the winner
FAILED_COLOUR = '#8d9a92'
PATH_COLOURS = (ORANGE, BLUE)
ITERATIONS = ('much wider\nthan errors', 'wider', 'a little\nwider', 'as errors\nspread', 'again')


def draw_planning_story(path: Path) -> None:
    """Draw a search that pots a blocked ball: stages, refinement, and the winner with errors."""
    figure = new_figure(9.0, 6.2)
    story = tell(Scene.load(STORY_SCENE), TARGET_BALL)
    stages = story.stages[-2:]
    panels = figure.subplots(2, 2).ravel()
    for number, (panel, stage) in enumerate(zip(panels, stages, strict=False), 1):
        _draw_stage(panel, story.scene, stage, number)
    _draw_refinement(panels[2], stages)
    _draw_winner(panels[3], story)
    figure.suptitle(
        f'Ball 1 hides ball {TARGET_BALL}: with errors, '
        'a kick pots it more often than a combination'
    )
    save(figure, path)


def _draw_stage(axes: Any, scene: Scene, stage: StoryStage, number: int) -> None:
    """Draw some candidates of a stage without errors."""
    reached = int(stage.reached.sum())
    axes.set_title(
        f'{number}. {stage.name}: {reached} of {len(stage.strokes)} pot it',
        fontsize='medium',
        loc='left',
    )
    shown = np.linspace(0, len(stage.strokes) - 1, DRAWN_STROKES).astype(int)
    shown = np.union1d(
        shown, np.flatnonzero(stage.reached)[:: max(1, reached * 3 // DRAWN_STROKES)]
    )
    strokes = [Stroke.from_offsets(*stroke) for stroke in stage.strokes[shown].tolist()]
    _draw_paths(axes, scene, strokes, stage.reached[shown].tolist())


def _draw_winner(axes: Any, story: Story) -> None:
    """Draw executions of the winner with errors."""
    winner = story.finalists[0]
    stroke, scene = winner.stroke, story.scene
    rng = np.random.default_rng(1)
    strokes = [scene.noise.perturb(stroke, rng, scene.ball.radius) for _ in range(DRAWN_STROKES)]
    fell = [TARGET_BALL in predict(scene, each).pocketed for each in strokes]
    axes.set_title(
        f'4. the winner with errors pots it in {winner.success:.0%} of {winner.trials:,} trials',
        fontsize='medium',
        loc='left',
    )
    _draw_paths(axes, scene, strokes, fell)


def _draw_paths(
    axes: Any, scene: Scene, strokes: Iterable[Stroke], reached: Iterable[bool]
) -> None:
    """Draw the paths of the cue ball to its first contact, and of the ball to be potted."""
    half = outline_of(scene).frame
    axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]), aspect='equal', xticks=[])
    axes.set_yticks([])
    draw_table(axes, scene)
    for stroke, good in zip(strokes, reached, strict=True):
        shot = predict(scene, stroke)
        trails = trails_of(shot)
        met = [e.time for e in shot.run.events if CUE_BALL in e.balls and len(e.balls) > 1]
        look = {'color': GREEN if good else FAILED_COLOUR, 'alpha': 0.7 if good else 0.25}
        look |= {'linewidth': 0.9 if good else 0.6, 'zorder': 3 if good else 2.5}
        for name, until in ((CUE_BALL, min(met, default=np.inf)), (TARGET_BALL, np.inf)):
            for piece in trails.pieces(name):
                seen = piece.times <= until
                axes.plot(*piece.points[seen, :2].T, **look)
    draw_balls(axes, scene, {CUE_BALL: scene.cue_ball, **scene.balls})


def _draw_refinement(axes: Any, stages: Iterable[StoryStage]) -> None:
    """Draw the success of the refined strokes after each iteration."""
    axes.set_title('3. refinement: success among samples', fontsize='medium', loc='left')
    for stage, colour in zip(stages, PATH_COLOURS, strict=False):
        for step, population in enumerate(stage.refined):
            axes.plot(
                np.full(len(population.success), step), 100 * population.success, '.', color=colour
            )
        best = [100 * population.success.max() for population in stage.refined]
        axes.plot(best, color=colour)
        axes.annotate(
            stage.name, (len(best) - 1, max(best[-2:])), (0, 8), textcoords='offset points',
            color=colour, ha='right', fontsize='small',
        )  # fmt: skip
    axes.set_xticks(range(len(ITERATIONS)), ITERATIONS, fontsize='small')
    axes.set_ylabel('samples that pot it (%)')
    axes.set_xlabel('spread of the samples')
    axes.margins(y=0.15)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
