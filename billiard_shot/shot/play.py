"""
Strokes from the cue to rest, one or many: strike, table, and how each of them ended.

This is the one place that decides the status of a stroke: alone, in a batch, or at a ball to which
others are near. A stroke whose ball meets rounded jaws of pockets is played again, finer: each jaw
magnifies an error a few hundred times.
"""

from dataclasses import fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import CollisionResult
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.accuracy import HOPS
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.discontinuity import discontinuities_of_law
from billiard_shot.shot.double_hit import following_cues
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.on_table import (
    has_table,
    names_of,
    starts_after,
    strike_among,
    Struck,
    with_first_events,
)
from billiard_shot.shot.strike import no_phases, Strike
from billiard_shot.shot.strike_batch import strike_batch
from billiard_shot.status import Status
from billiard_shot.table.effects import table_on
from billiard_shot.table.motion import NOTHING, Segment
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import TableRun
from billiard_shot.table.simulate import in_threads, run_many, run_one, TableBatch, TableTask

# Statuses of a strike on endless cloth that the table may overrule,
_OPEN = (Status.OK, Status.NEVER_RESTS)
# and those that a discontinuity of the law overrules.
_SOLVED = (Status.OK, Status.MISCUE, Status.INFINITE_SEQUENCE)
PHASES, SEGMENTS = 16, 24  # of a strike and of its ball: room at first, most have fewer
HOPS_BEFORE_CUSHIONS = 0.1 * HOPS  # which magnify an error ten times
# Share of the tolerance for a stroke that is played again, and the error that is left, at most: a
# share of what this changed.
FINER, LEFT = 1e-3, 0.05


class Strokes(NamedTuple):
    """Strokes at a ball in one place."""

    scene: Scene
    model: StrikeModel
    normals: NDArray[np.float64]  # (n, 3) as of `Stroke`
    velocities: NDArray[np.float64]  # (n, 3) m/s
    centre: NDArray[np.float64]  # (3,) m, of the ball

    def some(self, which: slice | NDArray[np.integer]) -> 'Strokes':
        """Return some of the strokes."""
        return self._replace(normals=self.normals[which], velocities=self.velocities[which])


class Played(NamedTuple):
    """Strokes that were played to the end."""

    strikes: NDArray[np.void]  # (n,) Strike, with the status of the whole
    log: NDArray[np.void]  # (phases, 2) PhaseLog of the last impact
    segments: NDArray[np.void]  # (segments,) Segment of the last cue ball, on endless cloth
    group: CollisionResult | None  # impact of the last ball, if it reached a neighbour
    discontinuity: NDArray[np.float64]  # (n,) m


def play_one(strokes: Strokes, tolerance: float) -> tuple[Played, TableRun | None]:
    """Play a stroke, with all that happens."""
    played, run = _play_one(strokes, tolerance)
    if run is None or run.jaws_met == 0:
        return played, run
    finer, again = _play_one(strokes, FINER * tolerance)
    met_none = np.array([again is not None and CUE_BALL not in again.first_met])
    _estimate_error(finer.strikes, played.strikes, met_none, tolerance)
    return finer, again


def _play_one(strokes: Strokes, tolerance: float) -> tuple[Played, TableRun | None]:
    scene, model, _, velocities, centre = strokes
    table = table_on(scene) if has_table(scene) else None
    played, struck = _strike(strokes, table, tolerance, PHASES, SEGMENTS)
    if played.strikes['status'][0] >= Status.MISS or not (
        table is not None or np.isfinite(played.strikes['again'][0])
    ):
        decide(played.strikes, played.discontinuity, None)
        return played, None
    starts = starts_after(scene, centre, played.strikes) if struck is None else struck.starts
    task = TableTask(
        model.surface,
        table if table is not None else table_on(scene),
        starts,
        _hop_tolerance(scene, tolerance),
        cues=following_cues(model, played.strikes, velocities, starts['position'][:, 0]),
    )
    run = run_one(task, names_of(scene))
    if struck is not None and struck.met:
        run = with_first_events(run, struck, model.surface)
    played.strikes['final_position'][0] = run.balls[CUE_BALL].final_position
    played.strikes['duration'] = run.duration
    _add_hops(scene, played.strikes, tolerance)
    decide(played.strikes, played.discontinuity, np.array([run.status]))
    return played, run


def play_many(strokes: Strokes, tolerance: float) -> tuple[Played, TableBatch | None]:
    """Play strokes on all cores."""
    played, batch = _play_many(strokes, tolerance)
    if batch is None or not batch.jaws_met.any():
        return played, batch
    rows = np.flatnonzero(batch.jaws_met)
    finer, again = _play_many(strokes.some(rows), FINER * tolerance)
    assert again is not None
    met_none = again.first_met[:, 0] == NOTHING
    _estimate_error(finer.strikes, played.strikes[rows], met_none, tolerance)
    played.strikes[rows], played.discontinuity[rows] = finer.strikes, finer.discontinuity
    for each in fields(again):
        if each.name != 'names':
            getattr(batch, each.name)[rows] = getattr(again, each.name)
    return played, batch


def _estimate_error(
    finer: NDArray[np.void],
    coarse: NDArray[np.void],
    met_none: NDArray[np.bool_],
    tolerance: float,
) -> None:
    """Write errors [m], and what follows for the statuses, of strokes that were played again."""
    shift = finer['final_position'] - coarse['final_position']
    change = np.sqrt(shift[:, 0] ** 2 + shift[:, 1] ** 2 + shift[:, 2] ** 2)
    finer['error'] = np.maximum(coarse['error'], np.where(met_none, LEFT * change, 0.0))
    finer_than_possible = finer['status'] == Status.TOLERANCE_NOT_REACHED
    finer['status'][finer_than_possible] = coarse['status'][finer_than_possible]
    too_large = (finer['status'] == Status.OK) & (finer['error'] > tolerance)
    finer['status'][too_large] = Status.TOLERANCE_NOT_REACHED


def _play_many(strokes: Strokes, tolerance: float) -> tuple[Played, TableBatch | None]:
    scene, centre = strokes.scene, strokes.centre
    table = table_on(scene) if has_table(scene) else None

    def strike_part(part: slice) -> tuple[Played, Struck | None]:
        return _strike(strokes.some(part), table, tolerance, 0, 0)

    parts = in_threads(strike_part, len(strokes.normals))
    nothing = ROWS.records(Strike, 0)
    played = Played(
        np.concatenate([nothing, *(each.strikes for each, _ in parts)]),
        no_phases(),
        ROWS.records(Segment, 0),
        None,
        np.concatenate([np.zeros(0), *(each.discontinuity for each, _ in parts)]),
    )
    if table is None:
        _follow_on_endless_cloth(strokes, played, tolerance)
        return played, None
    struck = [each for _, each in parts if each is not None]
    starts = np.concatenate(
        [starts_after(scene, centre, nothing), *(each.starts for each in struck)]
    )
    batch = _follow(strokes, table, played.strikes, tolerance, starts)
    _add_hops(scene, played.strikes, tolerance)
    decide(played.strikes, played.discontinuity, batch.status)
    return played, batch


def _follow_on_endless_cloth(strokes: Strokes, played: Played, tolerance: float) -> None:
    """Decide strokes on endless cloth; play on those whose cue hits the ball again."""
    strikes = played.strikes
    again = np.isfinite(strikes['again'])
    decide(strikes, played.discontinuity, None)
    if again.any():
        some, table = strikes[again], table_on(strokes.scene)
        starts = starts_after(strokes.scene, strokes.centre, some)
        batch = _follow(strokes.some(np.flatnonzero(again)), table, some, tolerance, starts)
        decide(some, np.zeros(len(some)), batch.status)
        strikes[again] = some


def _follow(
    strokes: Strokes,
    table: TableParams,
    strikes: NDArray[np.void],
    tolerance: float,
    starts: NDArray[np.void],
) -> TableBatch:
    """Follow all balls until rest, and write place and duration into the strikes."""
    scene, model, _, velocities, _ = strokes
    task = TableTask(
        model.surface,
        table,
        starts,
        _hop_tolerance(scene, tolerance),
        cues=following_cues(model, strikes, velocities, starts['position'][:, 0]),
    )
    batch = run_many(task, names_of(scene))
    strikes['final_position'], strikes['duration'] = batch.final_position[:, 0], batch.duration
    return batch


def _hop_tolerance(scene: Scene, tolerance: float) -> float:
    """Largest error of a hop that is left out [m], so that the shot keeps to the tolerance [m]."""
    return (HOPS if scene.table is None else HOPS_BEFORE_CUSHIONS) * tolerance


def _add_hops(scene: Scene, strikes: NDArray[np.void], tolerance: float) -> None:
    """Add the hops that are left out before cushions to the errors of strokes that were played."""
    if scene.table is not None:
        strikes['error'][strikes['status'] < Status.MISS] += HOPS * tolerance


def _strike(
    strokes: Strokes, table: TableParams | None, tolerance: float, phases: int, segments: int
) -> tuple[Played, Struck | None]:
    """Strike the ball; if there is a table, find what that leaves on it."""
    scene, model, normals, velocities, centre = strokes
    around = surroundings_of(scene)
    done = strike_batch(model, normals, velocities, centre, tolerance, around, phases, segments)
    strikes = done.strikes
    struck = None
    if table is not None:
        struck = strike_among(scene, model, table, centre, velocities, strikes, phases)
    gap = discontinuities_of_law(model, normals, velocities, centre, tolerance, strikes)
    if struck is None:
        return Played(strikes, done.log, done.segments, None, gap), None
    gap[struck.together] = 0.0
    return Played(strikes, done.log, done.segments, struck.group, gap), struck


def decide(
    strikes: NDArray[np.void],
    discontinuity: NDArray[np.float64],
    table: NDArray[np.uint16] | None,
) -> None:
    """Write the statuses of whole strokes, and add discontinuities to the errors."""
    status = strikes['status']
    if table is not None:
        open_ = _is_one_of(status, _OPEN)
        status[open_] = table[open_]
    if discontinuity.any():
        jumps = _is_one_of(status, _SOLVED) & (discontinuity > 0.0)
        status[jumps] = Status.TOLERANCE_NOT_REACHED
        strikes['error'] += discontinuity


def _is_one_of(status: NDArray[np.int64], wanted: tuple[Status, ...]) -> NDArray[np.bool_]:
    """Whether each status is one of some; for one status ten times as fast as `np.isin`."""
    found = status == wanted[0]
    for other in wanted[1:]:
        found |= status == other
    return found
