"""One shot, compiled from end to end: may it be played, what does the impact do, what follows."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, entry
from billiard_shot.impact.kernel import solve
from billiard_shot.shot import row as at
from billiard_shot.shot.accuracy import error_of, inner_tolerance
from billiard_shot.shot.contacts import approach_of, dot, levers, response_of, weighted, yielding
from billiard_shot.shot.model import Model, TIP
from billiard_shot.status import Status
from billiard_shot.table import motion
from billiard_shot.table.roll_out import roll_out

OK = int(Status.OK)
MISCUE = int(Status.MISCUE)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
TOLERANCE_NOT_REACHED = int(Status.TOLERANCE_NOT_REACHED)
MISS = int(Status.MISS)
NEGATIVE_ELEVATION = int(Status.NEGATIVE_ELEVATION)
CUE_THROUGH_CLOTH = int(Status.CUE_THROUGH_CLOTH)
INVALID_STROKE = int(Status.INVALID_STROKE)

GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
# Slip at the end, relative to the cue's speed, that makes a miscue. Grip fades with the tip's
# pressure: while the cloth still pushes the ball, every tip slips in the last instant, in scene
# `pool` by up to 0.02 of the cue's speed. Tips that slide in earnest end with more than 0.06.
MISCUE_SLIP = 0.03


@compiled
def length_of(v: NDArray[np.float64]) -> float:
    """Length of a vector, NaN if it has none that is above 0."""
    length = np.sqrt(dot(v, v))
    return length if 0.0 < length < np.inf else np.nan


@compiled
def refusal(model: Model, n: NDArray[np.float64], c: NDArray[np.float64]) -> int:
    """Why a stroke along c, at the normal n, cannot be played, or OK."""
    if not np.isfinite(dot(n, c)):
        return INVALID_STROKE
    if dot(n, c) > -GRAZING:
        return MISS
    if c[2] > LEVEL:
        return NEGATIVE_ELEVATION
    height = model.surface.radius * (1.0 + n[2])
    if height - model.tip_radius * np.sqrt(max(1.0 - c[2] * c[2], 0.0)) < -LEVEL * height:
        return CUE_THROUGH_CLOTH
    return OK


@compiled
def book(
    model: Model, lever: NDArray[np.float64], c: NDArray[np.float64], speed: float,
    account: NDArray[np.float64], row: NDArray[np.float64],
) -> bool:
    """Fill in what follows from the impulses of a strike; return whether it was a miscue."""
    ball = model.surface
    impulse, cue = row[at.IMPULSE], np.zeros(3)
    weighted(impulse, lever[0], cue)
    weighted(impulse, lever[1], row[at.VELOCITY])
    weighted(impulse, lever[2], row[at.SPIN])
    for i in range(3):
        row[at.VELOCITY.start + i] /= ball.mass
        row[at.SPIN.start + i] /= ball.inertia
    row[at.CUE_SPEED] = speed + yielding(model, c, cue, c)
    for i in range(4):
        row[at.LOSS.start + i] = account[i // 2, i % 2]
    for i in range(9):
        row[at.AXES.start + i] = lever[0, i // 3, i % 3]
        row[at.AXES.start + 9 + i] = lever[1, 3 + i // 3, i % 3]
    miscue: bool = account[TIP, 2] > MISCUE_SLIP * speed
    return miscue


@compiled
def verdict(status: int, miscue: bool, end: int, exact: bool) -> int:
    """Status of a shot: of its impact, unless that went well and something else is to be said."""
    if status not in (OK, INFINITE_SEQUENCE):
        return status
    if miscue:
        return MISCUE
    if end != OK:
        return end
    return status if exact else TOLERANCE_NOT_REACHED


@entry
def shoot(
    model: Model,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    rows: NDArray[np.float64],
    log: NDArray[np.float64],
    segments: NDArray[np.float64],
) -> None:
    """
    Play strokes, one after the other, each with the ball in the same place.

    A refused stroke leaves the ball where it is.

    Parameters
    ----------
    model : Model
    normals, velocities : (n, 3) float arrays
        As of `Stroke`, but checked here.
    position : (3,) float array
        Centre of the cue ball [m].
    tolerance : float
        Of the trajectories [m].
    rows : (n, COLUMNS) float array, written
        All results, see row.py.
    log : (phases, 12) float array, written
        Phases of the last impact, see `solve`; as many as there is room for.
    segments : (segments, motion.COLUMNS) float array, written
        The last trajectory; as many segments as there is room for.

    """
    still, n, c = np.zeros(3), np.zeros(3), np.zeros(3)
    account = np.zeros((2, 4))
    for i in range(len(rows)):
        row = rows[i]
        for k in range(at.COLUMNS):
            row[k] = 0.0
        ball = motion.start(position, still, still)
        speed = length_of(velocities[i])
        size = length_of(normals[i])
        for k in range(3):
            n[k], c[k] = normals[i, k] / size, velocities[i, k] / speed
        row[at.STATUS] = refusal(model, n, c)
        if row[at.STATUS] == OK:
            accuracy = inner_tolerance(model, speed, tolerance)
            lever = levers(model.surface.radius, n, c)
            status, phases, steps = solve(
                response_of(model, c, lever), approach_of(lever, speed, n, c), model.friction,
                model.restitution, model.stiffness, model.law, model.exponent, accuracy,
                row[at.IMPULSE], account, log,
            )
            row[at.PHASES], row[at.EVALUATIONS] = phases, steps
            miscue = book(model, lever, c, speed, account, row)
            ball = motion.start(position, row[at.VELOCITY], row[at.SPIN])
            end, left_out = roll_out(model.surface, ball, 0.25 * tolerance, segments)
            row[at.ERROR] = left_out + error_of(accuracy, speed, ball[motion.TIME])
            row[at.STATUS] = verdict(status, miscue, end, row[at.ERROR] <= tolerance)
        else:
            motion.record(ball, segments)
        for k in range(3):
            row[at.REST.start + k] = ball[motion.POSITION + k]
        row[at.DURATION] = ball[motion.TIME]
        row[at.SEGMENTS] = ball[motion.COUNT]
