"""One shot, compiled from end to end: may it be played, what does the impact do, what follows."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.kernel import solve
from billiard_shot.shot import row as at
from billiard_shot.shot.accuracy import error_of, inner_tolerance
from billiard_shot.shot.contacts import dot, levers, response_of, weighted, yielding
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
def strike(
    model: Model, n: NDArray[np.float64], c: NDArray[np.float64], speed: float, accuracy: float,
    row: NDArray[np.float64], log: NDArray[np.float64],
) -> int:
    """Solve the impact of cue, ball and table; fill in what it gives, and return its status."""
    ball = model.surface
    lever = levers(ball.radius, n, c)
    approach = np.zeros(6)
    approach[0] = speed * dot(n, c)
    approach[1] = speed * dot(lever[0, 1], c)
    impulse = row[at.IMPULSE]
    account = np.zeros((2, 3))
    status, phases, steps = solve(
        response_of(model, c, lever), approach, model.friction, model.restitution,
        model.stiffness, model.law, model.exponent, accuracy, impulse, account, log,
    )
    row[at.VELOCITY] = weighted(impulse, lever[1]) / ball.mass
    row[at.SPIN] = weighted(impulse, lever[2]) / ball.inertia
    row[at.CUE_SPEED] = speed + dot(c, yielding(model, c, weighted(impulse, lever[0])))
    row[at.LOSS] = account[:, :2].copy().reshape(4)
    row[at.PHASES] = phases
    row[at.EVALUATIONS] = steps
    if account[TIP, 2] > MISCUE_SLIP * speed and status in (OK, INFINITE_SEQUENCE):
        return MISCUE
    return status


@compiled
def shoot(
    model: Model,
    normal: NDArray[np.float64],
    velocity: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    row: NDArray[np.float64],
    log: NDArray[np.float64],
    segments: NDArray[np.float64],
) -> None:
    """
    Play one stroke.

    Parameters
    ----------
    model : Model
    normal, velocity : (3,) float arrays
        As of `Stroke`, but checked here.
    position : (3,) float array
        Centre of the cue ball [m].
    tolerance : float
        Of the trajectory [m].
    row : (COLUMNS,) float array, written
        All results, see row.py. A refused stroke leaves the ball where it is.
    log : (rows, 12) float array, written
        Phases of the impact, see `solve`; as many as there is room for.
    segments : (rows, motion.COLUMNS) float array, written
        The trajectory; as many segments as there is room for.

    """
    row[:] = 0.0
    row[at.REST] = position
    speed = length_of(velocity)
    n = normal / length_of(normal)
    c = velocity / speed
    status = refusal(model, n, c)
    state = motion.start(position, np.zeros(3), np.zeros(3))
    if status != OK:
        row[at.STATUS] = status
        row[at.SEGMENTS] = motion.follow(state, motion.REST, np.inf, segments, 0)
        return
    accuracy = inner_tolerance(model, speed, tolerance)
    status = strike(model, n, c, speed, accuracy, row, log)
    state[motion.VELOCITY:motion.ACCELERATION] = row[at.VELOCITY]
    state[motion.ANGULAR:motion.ANGULAR_ACCELERATION] = row[at.SPIN]
    end, count, hops, left_out = roll_out(
        model.surface, state, 0.25 * tolerance, accuracy, segments
    )
    row[at.REST] = state[motion.POSITION:motion.VELOCITY]
    row[at.DURATION] = state[motion.TIME]
    row[at.SEGMENTS] = count
    row[at.HOPS] = hops
    row[at.ERROR] = left_out + error_of(model, accuracy, speed, state[motion.TIME])
    if status in (OK, INFINITE_SEQUENCE) and end != OK:
        status = end
    if status == OK and row[at.ERROR] > tolerance:
        status = TOLERANCE_NOT_REACHED
    row[at.STATUS] = status


@compiled
def shoot_each(
    model: Model,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    rows: NDArray[np.float64],
) -> None:
    """Play (n, 3) normals and velocities one after the other, into (n, COLUMNS) rows."""
    log, segments = np.zeros((0, 12)), np.zeros((0, motion.COLUMNS))
    for i in range(len(rows)):
        shoot(model, normals[i], velocities[i], position, tolerance, rows[i], log, segments)
