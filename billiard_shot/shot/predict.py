"""predict() and predict_batch() simulate a shot, or many."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot import machine_code
from billiard_shot.notebook import Shown
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.values import as_floats, check_type, LARGEST, positive
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.on_table import check_place, names_of, strokes_in
from billiard_shot.shot.play import play_many, play_one
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import (
    playable_offsets,
    playable_rows,
    Stroke,
    unit_rows,
    vectors_of,
)
from billiard_shot.status import Status
from billiard_shot.table.data_frame import data_frame
from billiard_shot.table.simulate import batch_of, INTERPRETED_AT_MOST, run_of, TableBatch
from billiard_shot.table.words import count_in_words

DEFAULT_SHOT_TOLERANCE = 1e-4  # m


def predict(
    scene: SceneLike,
    stroke: Stroke,
    tolerance: float = DEFAULT_SHOT_TOLERANCE,
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
    normals = np.array([stroke.touching(model_of(scene).tip_curvature).normal])
    velocities = np.array([stroke.velocity])
    played = play_one(strokes_in(scene, normals, velocities, centre), tolerance)
    run, wall_time = played.run, perf_counter() - begin
    run.cues.flags.writeable = False
    return Shot(
        scene,
        stroke,
        centre,
        tolerance,
        wall_time,
        Status(int(played.status[0])),
        error_estimate=float(played.error[0]),
        discontinuity=float(played.discontinuity[0]),
        run=run_of(run, names_of(scene), wall_time),
        _cue=run.cues[0],
        _log=run.log,
        _losses=run.losses,
    )


@dataclass(frozen=True, slots=True, eq=False)
class BatchResult(Shown):
    """Predictions of n strokes; row by row what `predict` gives."""

    scene: Scene
    velocity: NDArray[np.float64]  # (n, 3) m/s, at the end of the strike
    spin: NDArray[np.float64]  # (n, 3) rad/s
    cue_speed: NDArray[np.float64]  # (n,) m/s along the stroke
    final_position: NDArray[np.float64]  # (n, 3) m
    duration: NDArray[np.float64]  # (n,) s until rest
    status: NDArray[np.uint16]  # (n,) Status
    dissipated: NDArray[np.float64]  # (n, 2, 2) J: contact; restitution, friction
    evaluations: NDArray[np.int64]  # (n,) steps of the impact
    error_estimate: NDArray[np.float64]  # (n,) m
    double_hit: NDArray[np.bool_]  # (n,) the cue hit the ball again
    run: TableBatch  # all balls

    def __repr__(self) -> str:
        return f'BatchResult({count_in_words(self.status, "stroke", self.miscue)})'

    @property
    def miscue(self) -> NDArray[np.bool_]:
        """Whether the tip still slid when it left the ball (n,)."""
        return self.run.miscue

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each stroke.

        Status, velocity, spin, place of rest; and what rules ask: the columns of
        `TableBatch.to_frame`.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        columns: dict[str, Any] = {'status': [Status(each).name for each in self.status.tolist()]}
        for name in ('velocity', 'spin', 'final_position'):
            columns |= {f'{name}_{x}': getattr(self, name)[:, i] for i, x in enumerate('xyz')}
        for name in ('cue_speed', 'duration', 'error_estimate'):
            columns[name] = getattr(self, name)
        columns['double_hit'] = self.double_hit
        return data_frame(columns | self.run.columns())


def predict_batch(
    scene: SceneLike,
    normals: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    tolerance: float = DEFAULT_SHOT_TOLERANCE,
    position: Sequence[float] | NDArray[np.float64] | None = None,
    *,
    offsets: ArrayLike | None = None,
) -> BatchResult:
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
    BatchResult
        A stroke that cannot be played has the status that `predict` gives it.

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
        n, v = vectors_of(playable_offsets(_rows('offsets', offsets, 5)))
    else:
        n = unit_rows(_rows('normals', normals, 3))
        v = playable_rows(_rows('velocities', velocities, 3))
    if len(n) != len(v):
        raise ValueError(f'velocities must have as many rows as normals, {len(n)}, got {len(v)}')
    if len(n) > INTERPRETED_AT_MOST:
        machine_code.require()
    played = play_many(strokes_in(scene, n, v, centre), tolerance)
    run, cues = played.run, played.run.cues
    return BatchResult(
        scene=scene,
        velocity=cues['velocity'],
        spin=cues['spin'],
        cue_speed=cues['speed'],
        final_position=run.balls['position'][:, 0],
        duration=run.tables['duration'],
        status=played.status.astype(np.uint16),
        dissipated=cues['losses'].reshape(-1, 2, 2),
        evaluations=cues['steps'],
        error_estimate=played.error,
        double_hit=(cues['hits'] > 1) | (run.tables['cue_hits'] > 0),
        run=batch_of(run, names_of(scene)),
    )


def _centre(
    scene: Scene, position: Sequence[float] | NDArray[np.float64] | None
) -> NDArray[np.float64]:
    radius = scene.ball.radius
    if position is None:
        centre = np.array(scene.cue_ball)
        check_place(scene, centre)
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
    check_place(scene, place)
    return np.array([place[0], place[1], radius])


def _rows(name: str, values: ArrayLike | None, columns: int) -> NDArray[np.float64]:
    rows = as_floats(values)
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise ValueError(f'{name} must be numbers of shape (n, {columns}), got shape {rows.shape}')
    return rows
