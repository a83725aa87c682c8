"""predict() and predict_batch() simulate a shot, or many; analyses of a shot simulate it again."""

from collections.abc import Sequence
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.fields import as_floats, check_type, LARGEST, positive
from billiard_shot.shot import play
from billiard_shot.shot.effects import GATES, model_of, ShotContext
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import (
    playable_offsets,
    playable_rows,
    read_rows,
    Stroke,
    stroke_at,
    unit_rows,
    vectors_of,
)
from billiard_shot.status import Status
from billiard_shot.table.run.effects import Effect, report
from billiard_shot.table.run.simulate import run_of
from billiard_shot.table.run.states import TableStates
from billiard_shot.table.run.task import run_with_events


def predict(
    scene: SceneLike,
    stroke: Stroke,
    tolerance: float = play.DEFAULT_SHOT_TOLERANCE,
    position: Sequence[float] | NDArray[np.float64] | None = None,
) -> Shot:
    """
    Simulate a shot: the strike, and all balls until they rest.

    Parameters
    ----------
    scene : Scene, str or Path
        Ball, cue and cloth, with what lies and stands on it. A name or path is read as by
        `Scene.load`, each time.
    stroke : Stroke
        Where the cue hits the ball, and how it moves.
    tolerance : float
        Largest error of the trajectory [m], above 0; from the end of the strike up to the first
        impact with another ball, or to a later hit of the cue.
    position : (2,) or (3,) array_like, optional
        Where the cue ball lies on the cloth (x, y) [m]; by default where the scene has it. A third
        number, its height, must be 0 or the radius.

    Raises
    ------
    ValueError
        If `tolerance` or `position` make no sense. An unplayable stroke is not an error; see
        `Shot.status` and `Shot.message`.

    """
    scene = Scene.load(scene)
    check_type('stroke', stroke, Stroke)
    begin = perf_counter()
    tolerance = positive('tolerance', tolerance, 'm')
    centre = _centre(scene, position)
    prepared = play.prepared_scene(scene)
    normals = np.array([stroke.touching(prepared.model.tip_curvature).normal])
    velocities, accuracy = np.array([stroke.velocity]), play.Accuracy(tolerance)
    tables = None if position is None else _with_cue_ball(scene, centre)
    task = play.task_of(prepared, normals, velocities, tables, accuracy)
    run = play.play_by(run_with_events, prepared.model, task)
    wall_time = perf_counter() - begin
    run.cues.flags.writeable = False
    return Shot(
        scene,
        stroke,
        centre,
        tolerance,
        wall_time,
        Status(int(run.tables['status'][0])),
        error_estimate=float(run.tables['error'][0]),
        discontinuity=float(run.tables['discontinuity'][0]),
        run=run_of(run, prepared.names, wall_time),
        _cue=run.cues[0],
        _log=run.log,
        _losses=run.losses,
    )


def predict_batch(
    scene: SceneLike,
    normals: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    tolerance: float = play.DEFAULT_SHOT_TOLERANCE,
    position: Sequence[float] | NDArray[np.float64] | None = None,
    *,
    offsets: ArrayLike | None = None,
) -> play.StrokeBatch:
    """
    Predict many strokes at once, on all cores.

    Parameters
    ----------
    scene, tolerance, position
        As for `predict`.
    normals, velocities : (n, 3) array_like
        As of `Stroke`; the tip touches the ball at the normal, whatever its shape. A row that no
        `Stroke` can have gets the status INVALID_STROKE; `Stroke` says why.
    offsets : (n, 5) array_like
        In place of `normals` and `velocities`: the arguments a, b, elevation, azimuth, speed of
        `Stroke.from_offsets`.

    Returns
    -------
    StrokeBatch
        Row by row what `predict` gives; so a stroke that cannot be played has its status.

    Raises
    ------
    ValueError
        If an array has another shape, or `tolerance` or `position` make no sense.

    """
    scene = Scene.load(scene)
    tolerance = positive('tolerance', tolerance, 'm')
    centre = _centre(scene, position)
    if (offsets is None) == (normals is None) or (normals is None) != (velocities is None):
        raise ValueError('offsets must be given, or normals and velocities, and not all three')
    if offsets is not None:
        n, v = vectors_of(playable_offsets(read_rows('offsets', offsets, 5)))
    else:
        n = unit_rows(read_rows('normals', normals, 3))
        v = playable_rows(read_rows('velocities', velocities, 3))
    if len(n) != len(v):
        raise ValueError(f'velocities must have as many rows as normals, {len(n)}, got {len(v)}')
    tables = None if position is None else _with_cue_ball(scene, centre)
    return play.play_strokes(scene, n, v, tables, play.Accuracy(tolerance))


def _centre(
    scene: Scene, position: Sequence[float] | NDArray[np.float64] | None
) -> NDArray[np.float64]:
    radius = scene.ball.radius
    if position is None:
        centre = np.array(scene.cue_ball)
        play.check_place(scene, centre)
        return centre
    place = as_floats(position)
    on_cloth = place.shape == (2,) or (
        place.shape == (3,) and (place[2] == 0.0 or abs(place[2] - radius) <= 1e-6 * radius)
    )
    if not on_cloth or not (np.abs(place) <= LARGEST).all():
        raise ValueError(
            f'position must be finite (x, y) or (x, y, z), x and y {-LARGEST:g} to {LARGEST:g}, '
            f'z 0 or the radius, {radius:g}, got {position!r} (m)'
        )
    play.check_place(scene, place)
    return np.array([place[0], place[1], radius])


def _with_cue_ball(scene: Scene, centre: Array) -> TableStates:
    """Return the table of a scene with the cue ball elsewhere."""
    prepared = play.prepared_scene(scene)
    position = prepared.starts['position'].copy()
    position[0, 0] = centre
    return TableStates(prepared.names, position)


DIFFERENCE_STEP = 1e-4  # in radii, radians and parts of the speed
ANALYSIS_TOLERANCE = 1e-9  # m


def effects_of(shot: Shot) -> tuple[Effect, ...]:
    """
    Say of every effect the library knows whether a shot simulated it, and why.

    To say whether an effect was called for that the scene turns off, the stroke is predicted again
    with it, unless the shot tells. No effect was simulated if the stroke was refused.
    """
    if shot.status.refused:
        reason = 'the stroke was not played'
        return tuple(Effect(gate.name, False, reason, False) for gate in GATES)

    def again(scene: Scene) -> ShotContext:
        return predict(scene, shot.stroke, shot.tolerance, shot.position).effect_context

    context = shot.effect_context
    return tuple(report(gate, context, again) for gate in GATES)


def sensitivity_of(shot: Shot) -> NDArray[np.float64]:
    """
    Find how the place of rest (x, y) of the cue ball changes with the stroke (2, 5).

    Per radius of a and of b, radian of elevation and of azimuth, and m/s of speed: all in m.
    (a, b) is where the tip touches the ball. Central differences of eleven strokes; one-sided
    where only one of two neighbours can be played, and zero where neither can, or the stroke was
    refused.
    """
    if shot.status.refused:
        return np.zeros((2, 5))
    model = model_of(shot.scene)
    base = np.array(shot.stroke.touching(model.tip_curvature).offsets)
    steps = np.full(5, DIFFERENCE_STEP)
    steps[4] *= base[4]
    changes = np.vstack([np.zeros(5), np.diag(steps), -np.diag(steps)])
    near = [stroke_at(*(base + change)) for change in changes]
    normals, velocities = np.array([s.normal for s in near]), np.array([s.velocity for s in near])
    ends = predict_batch(shot.scene, normals, velocities, ANALYSIS_TOLERANCE, shot.position)
    played, places = ~ends.refused, ends.final_position[:, 0]
    rest = np.where(played[:, np.newaxis], places, places[0])[:, :2]
    reach = np.where(played, np.concatenate([[0.0], steps, -steps]), 0.0)
    span = reach[1:6] - reach[6:]
    return ((rest[1:6] - rest[6:]) / np.where(span > 0.0, span, 1.0)[:, np.newaxis]).T
