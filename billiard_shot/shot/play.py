"""Strokes from the cue to rest, one or many: a scene made ready once, one verb, one result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.options import ENERGETIC
from billiard_shot.notebook import Shown
from billiard_shot.records import Array, column, OBJECTS, Triple
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.shot.effects import cue_params, model_of, StrikeModel
from billiard_shot.status import INFINITE_SEQUENCE, MISS, OK, Status, TOLERANCE_NOT_REACHED
from billiard_shot.table.model.cue import CueParams
from billiard_shot.table.model.geometry import TableParams
from billiard_shot.table.model.motion import TableBall
from billiard_shot.table.run.effects import table_on
from billiard_shot.table.run.layout import ENDLESS, layout_of
from billiard_shot.table.run.results import count_in_words
from billiard_shot.table.run.simulate import TableBatch
from billiard_shot.table.run.states import ball_starts, TableStates
from billiard_shot.table.run.task import BatchRecording, in_threads, joined, run_tables, TableTask
from billiard_shot.table.strike import placement

DEFAULT_SHOT_TOLERANCE = 1e-4  # m


class Accuracy(NamedTuple):
    """How accurately strokes are played."""

    tolerance: float  # m, of trajectories
    # Whether errors are estimated, and a stroke that does not keep the tolerance is told.
    checked: bool = True
    fast_rebounds: bool = False  # see `TableTask`


USUAL_ACCURACY = Accuracy(DEFAULT_SHOT_TOLERANCE)


class PreparedScene(NamedTuple):
    """
    All that strokes depend on, beside themselves.

    Attributes
    ----------
    model : StrikeModel
        Ball, cue and cloth.
    table : TableParams
    obstacles : Surroundings
        What a cue may have no room for: such a stroke is refused.
    cue : CueParams
        What impacts with the cue depend on.
    names : tuple of str
        The balls; the cue ball first, others in the scene's order.
    starts : (1, balls) array of TableBall
        The balls at rest. Not to be changed.
    reaching : float
        See `reaching_speed`.

    """

    model: StrikeModel
    table: TableParams
    obstacles: placement.Surroundings
    cue: CueParams
    names: tuple[str, ...]
    starts: NDArray[np.void]
    reaching: float


@lru_cache(maxsize=64)
def prepared_scene(scene: Scene) -> PreparedScene:
    """Collect what a scene means to compiled code, with the effects that it forces on or off."""
    names = (CUE_BALL, *scene.object_balls)
    radius = scene.ball.radius
    places = [scene.cue_ball, *((*scene.balls[name], radius) for name in names[1:])]
    return _prepared(
        model_of(scene), table_on(scene), placement.surroundings_of(scene), names, places
    )


@lru_cache(maxsize=64)
def alone(model: StrikeModel) -> PreparedScene:
    """Prepare a scene with the cue ball alone on endless cloth, at the origin."""
    places = [(0.0, 0.0, model.surface.radius)]
    obstacles = placement.nothing_around(model.ferrule_radius, model.surface.radius)
    return _prepared(model, ENDLESS, obstacles, (CUE_BALL,), places)


def _prepared(
    model: StrikeModel,
    table: TableParams,
    obstacles: placement.Surroundings,
    names: tuple[str, ...],
    places: Sequence[Triple],
) -> PreparedScene:
    starts = ball_starts(1, len(names))
    starts['position'] = places
    cue = cue_params(model, table)
    laid_out = layout_of(model.surface, table, cue)
    balls = OBJECTS.from_rows(TableBall, starts[0])
    reaching = placement.reaching_speed(laid_out, balls, 0, len(balls))
    return PreparedScene(model, table, obstacles, cue, names, starts, reaching)


def check_place(scene: Scene, centre: Array) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or a cushion."""
    x, y = float(centre[0]), float(centre[1])
    if why := no_place(scene.table, x, y, scene.ball.radius, scene.object_balls):
        raise ValueError(f'position must be {why}, got ({x:g}, {y:g}) (m)')


def task_of(
    prepared: PreparedScene,
    normals: Array,
    velocities: Array,
    tables: TableStates | None,
    accuracy: Accuracy,
    mapped: placement.StrikePolynomials = placement.ALL_SOLVED,
    rules: NDArray[np.void] | None = None,
) -> TableTask:
    """
    State the tables on which n strokes are played; a refused stroke leaves the ball where it is.

    Parameters
    ----------
    prepared : PreparedScene
    normals, velocities : (n, 3) float arrays
        As of `Stroke`, but not checked yet.
    tables : TableStates, optional
        n tables, or one for all strokes, the cue ball first; by default as the scene has them.
    accuracy : Accuracy
    mapped : StrikePolynomials
        Which strikes come from maps; by default all are solved.
    rules : (balls,) array of BallRule, optional
        As of `TableTask`.

    """
    return TableTask(
        prepared.model.surface,
        prepared.table,
        prepared.starts if tables is None else tables.starts(),
        accuracy.tolerance,
        cue=prepared.cue,
        strokes=placement.Strokes(
            normals, velocities, prepared.obstacles, mapped, accuracy.checked
        ),
        rules=rules,
        fast_rebounds=accuracy.fast_rebounds,
    )


def solve_strikes(
    model: StrikeModel, normals: Array, velocities: Array, tolerance: float
) -> NDArray[np.void]:
    """Solve only strikes, at a cue ball alone on endless cloth; return (n,) CueRecord."""
    task = task_of(alone(model), normals, velocities, None, Accuracy(tolerance, checked=False))
    return run_tables(task._replace(until=0.0)).cues


# Tolerances of the strike, relative to the stiffness: near enough to be on a jump.
NEAR_A_JUMP = 10.0
COARSEST_STRIKE = 1e-6  # tolerance of a strike
SUSPECT = 1e4  # changes of the stiffness: margins of decisions that they may turn are smaller


def note_discontinuities(
    played: BatchRecording, model: StrikeModel, strokes: placement.Strokes, tolerance: float
) -> None:
    """
    Find how far the resting places of strokes jump, on endless cloth, and note it in their ends.

    A strike that comes close to a decision is solved again with the tip a little stiffer and a
    little softer, by as much as its accuracy is. The changes of a continuous outcome cancel. If
    more than the tolerance is left, the outcome jumps in between.

    Parameters
    ----------
    played : BatchRecording
        Of n strokes. Those in which the ball reached others do not jump.
    model : StrikeModel
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].

    """
    if model.law != ENERGETIC:  # the others have next to none
        return
    cues, ends = played.cues, played.tables
    found = ends['discontinuity']
    changes = NEAR_A_JUMP * np.minimum(cues['tolerance'], COARSEST_STRIKE)
    near = cues['discontinuity_margin'] <= SUSPECT * changes
    near &= (cues['status'] < MISS) & (cues['phases'] > 1) & ~cues['others']
    for i in np.flatnonzero(near):
        finest = tolerance * (placement.FINER if ends['jaws_met'][i] > 0 else 1.0)
        (tip, cloth), places = model.stiffness, []
        for change in (-changes[i], 0.0, changes[i]):
            changed = model._replace(
                stiffness=(float(tip * (1.0 + change)), cloth), follow_through=0.0
            )
            vectors = strokes.normals[i : i + 1], strokes.velocities[i : i + 1]
            places.append(_end(changed, *vectors, finest))
        bend = float(np.linalg.norm(places[0] - 2.0 * places[1] + places[2]))
        found[i] = bend if bend > 2.0 * finest else 0.0
    ends['error'] += found
    well = np.isin(ends['status'], (OK, INFINITE_SEQUENCE)) & (ends['run_status'] == OK)
    ends['status'][well & (found > 0.0)] = TOLERANCE_NOT_REACHED


def _end(model: StrikeModel, normal: Array, velocity: Array, tolerance: float) -> Array:
    """Find where the ball of one stroke rests on endless cloth (3,) [m]."""
    task = task_of(alone(model), normal, velocity, None, Accuracy(tolerance, checked=False))
    place: Array = run_tables(task).balls['position'][0, 0]
    return place


@dataclass(frozen=True, eq=False, repr=False)
class StrokeBatch(TableBatch, Shown):
    """
    n strokes that were played, and what came of them on n tables; ball 0 is the cue ball.

    Attributes
    ----------
    scene : Scene
    velocity : (n, 3) float array
        Of the cue ball at the end of the strike [m/s].
    spin : (n, 3) float array
        The same [rad/s].
    cue_speed : (n,) float array
        Along the stroke [m/s].
    evaluations : (n,) int array
        Steps of the impact; 0: it is not solved, but mapped.
    error_estimate : (n,) float array
        [m]; 0 if it is not estimated.
    chatter : (n,) bool array
        The tip touched the ball again, see `Shot.chatter`.

    """

    scene: Scene
    velocity = column('played.cues', 'velocity')
    spin = column('played.cues', 'spin')
    cue_speed = column('played.cues', 'speed')
    evaluations = column('played.cues', 'steps')
    error_estimate = column('played.tables', 'error')
    chatter = column('played.cues', 'chatter')

    @property
    def dissipated(self) -> NDArray[np.float64]:
        """Energy lost (n, 2, 2) [J], by contact: to restitution, to friction."""
        losses: NDArray[np.float64] = self.played.cues['losses'].reshape(-1, 2, 2)
        return losses

    @property
    def refused(self) -> NDArray[np.bool_]:
        """Whether a stroke could not be played (n,)."""
        refused: NDArray[np.bool_] = self.status >= MISS
        return refused

    @property
    def mapped(self) -> NDArray[np.bool_]:
        """Whether the strike comes from a map (n,), see `predict_within_noise`."""
        mapped: NDArray[np.bool_] = ~self.refused & (self.evaluations == 0)
        return mapped

    def __repr__(self) -> str:
        return f'StrokeBatch({count_in_words(self.status, "stroke", self.miscue)})'

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame`: status, velocity, spin, and those of `TableBatch`."""
        status = [Status(each).name for each in self.status.tolist()]
        vectors = {
            f'{name}_{x}': getattr(self, name)[:, i]
            for name in ('velocity', 'spin')
            for i, x in enumerate('xyz')
        }
        names = 'cue_speed', 'duration', 'error_estimate', 'chatter'
        own = {'status': status} | vectors | {name: getattr(self, name) for name in names}
        return own | super().columns()


def play_strokes(
    scene: Scene,
    normals: Array,
    velocities: Array,
    tables: TableStates | None = None,
    accuracy: Accuracy = USUAL_ACCURACY,
    mapped: placement.StrikePolynomials = placement.ALL_SOLVED,
    workers: int | None = None,
) -> StrokeBatch:
    """
    Play n strokes, at one table or at n tables, on all cores.

    Parameters
    ----------
    scene : Scene
    normals, velocities : (n, 3) float arrays
        As of `Stroke`; NaN where there is no stroke.
    tables : TableStates, optional
        n tables, or one for all strokes, the cue ball first; by default the balls of the scene.
    accuracy : Accuracy
    mapped : StrikePolynomials
        Which strikes come from maps; by default all are solved.
    workers : int, optional
        Threads; by default as many as there are cores.

    Raises
    ------
    ValueError
        If the first ball of the tables is not the cue ball.

    """
    if tables is not None and tables.names[0] != CUE_BALL:
        raise ValueError(f'tables must have {CUE_BALL!r} first, got {", ".join(tables.names)}')
    count, prepared = len(normals), prepared_scene(scene)

    def play_part(rows: slice) -> BatchRecording:
        some, maps = tables, mapped.part(rows)
        if tables is not None and len(tables) > 1:
            some = tables.take(rows)
        task = task_of(prepared, normals[rows], velocities[rows], some, accuracy, maps)
        return play_by(run_tables, prepared.model, task)

    parts = in_threads(play_part, count, workers)
    names = prepared.names if tables is None else tables.names
    return StrokeBatch(names, joined(parts), scene)


def play_by(
    run: Callable[[TableTask], BatchRecording], model: StrikeModel, task: TableTask
) -> BatchRecording:
    """
    Play strokes in this thread.

    Parameters
    ----------
    run : callable
        How much is recorded: `run_tables`, `run_recorded` or, of the last stroke,
        `run_with_events`.
    model : StrikeModel
    task : TableTask
        With strokes, see `task_of`.

    """
    played = run(task)
    if task.strokes is not None and task.strokes.checked:
        note_discontinuities(played, model, task.strokes, task.tolerance)
    return played
