"""
A cue that meets a ball which moves, on the cloth or in the air: with the geometry of each moment.

A strike of a ball at rest takes all directions as they are at the first touch. If the tip meets
the ball again, the ball has moved out of the cue's line meanwhile, and the answer depends on by
how much. So here the impact is cut into short pieces. In each piece the normal is that of its
middle. Compressions are carried over. Only law `bistiffness` knows how a compressed spring goes
on. Under the other laws an impact is one piece.

The end of the cue gives way sideways while the tip touches the ball. When they part it swings
back to the cue's axis, and is at rest there relative to the cue. The tip can meet the ball again
as soon as the ball is clear of that place: before, the ball only holds the end aside.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.contact_space import without_rounding
from billiard_shot.impact.events import RESTITUTION_END
from billiard_shot.impact.laws import BISTIFFNESS
from billiard_shot.impact.solve import solve_in_contact_space
from billiard_shot.impact.state import PhaseLog
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import cross_rows
from billiard_shot.records import ROWS
from billiard_shot.shot.model import contact_properties, StrikeModel, TABLE, TIP, tip_reach
from billiard_shot.status import BUDGET_EXCEEDED, OK
from billiard_shot.table.contact_duration import duration_constant, DURATION_SPEED

Array = NDArray[np.float64]

# Of tip and ball, at DURATION_SPEED [s]: high-speed films, Alciatore (billiards.colostate.edu).
DURATION = 1.3e-3
PIECES = 8  # of DURATION, into which an impact is cut
MAX_PIECES = 400  # of an impact
MAX_HITS = 8  # of the tip: then the cue is taken away
TOLERANCE = 1e-9  # of the impact in each piece, relative to its velocities
TOUCHING = 1e-9  # m: bodies that are no farther apart touch
FAR = -1.0  # m: length of a contact that nothing closes
UP = np.array([0.0, 0.0, 1.0])


class Meeting(NamedTuple):
    """Balls and cues, n of each, that meet; frame `table`."""

    position: Array  # (n, 3) m, of the balls' centres
    velocity: Array  # (n, 3) m/s
    spin: Array  # (n, 3) rad/s
    tip: Array  # (n, 3) m, centre of the tip's sphere
    speed: Array  # (n,) m/s, of the cues along their axes


class PhaseEnd(NamedTuple):
    """How a meeting stood when one of its contacts had ended."""

    active: NDArray[np.bool_]  # (2,) during the phase
    contact: int  # that has ended
    impulses: Array  # (2, 3) N s since the start
    energies: Array  # (2,) J


class Outcome(NamedTuple):
    """What n meetings leave, until nothing is pressed any more."""

    after: Meeting
    duration: Array  # (n,) s
    hits: NDArray[np.int64]  # (n,) how often the tip met the ball
    impulses: Array  # (n, 2, 3) N s, on the cue and, from the table, on the ball
    losses: Array  # (n, 2, 2) J, of tip and table: restitution, friction
    slip: Array  # (n,) m/s, of the tip when it last left the ball
    steps: NDArray[np.int64]  # (n,)
    status: NDArray[np.int64]  # (n,) Status
    phases: NDArray[np.int64]  # (n,)
    log: list[PhaseEnd]  # the phases of the last meeting


def meet(model: StrikeModel, axes: Array, before: Meeting) -> Outcome:
    """
    Let balls and cues meet, until nothing is pressed any more.

    Parameters
    ----------
    model : StrikeModel
    axes : (n, 3) float array
        Unit vectors along the cues.
    before : Meeting

    """
    n, ball = len(axes), model.surface
    x, v, w, axis_tip, speed = (values.copy() for values in before)
    reach = tip_reach(model)
    response = _response(model, axes)
    bend, bending = np.zeros((n, 3)), np.zeros((n, 3))  # of the cue's end: place, velocity
    clear = np.ones(n, np.bool_)  # of the tip's place on the axis, or in touch from the first
    lengths = np.zeros((n, 2))
    lengths[:, TABLE] = np.minimum(ball.radius - x[:, 2], 0.0) if model.table else FAR
    done = Outcome(
        before,
        np.zeros(n),
        np.zeros(n, np.int64),
        np.zeros((n, 2, 3)),
        np.zeros((n, 2, 2)),
        np.zeros(n),
        np.zeros(n, np.int64),
        np.full(n, OK),
        np.zeros(n, np.int64),
        [],
    )
    cut = model.law == BISTIFFNESS
    piece = DURATION / PIECES if cut else np.inf
    absolute_model = absolute(model)
    properties = contact_properties(absolute_model)
    left = np.arange(n)
    for _ in range(MAX_PIECES):
        if not len(left):
            break
        c, at = axes[left], left
        cue = speed[at, np.newaxis] * c + bending[at]
        away = axis_tip[at] + bend[at] - x[at]
        distance = np.linalg.norm(away, axis=1)
        normals = away + (0.5 * piece * (cue - v[at]) if cut else 0.0)
        normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
        pressed = lengths[at, TIP] > 0.0
        gap = np.maximum(distance - reach, 0.0)
        gap[gap <= TOUCHING] = 0.0
        given = lengths[at]
        given[:, TIP] = np.where(pressed, given[:, TIP], -gap)
        clear[at] |= gap > 0.0
        given[(~clear[at] | (done.hits[at] >= MAX_HITS)) & ~pressed, TIP] = FAR
        frames, jacobian = _geometry(ball.radius, normals, c)
        mobile = response[at] @ jacobian.transpose(0, 2, 1)
        delassus = without_rounding(jacobian @ mobile)
        moving = np.concatenate([cue, v[at], w[at]], axis=1)
        solved = solve_in_contact_space(
            properties,
            delassus,
            _times(jacobian, moving),
            np.full(len(at), TOLERANCE),
            lengths=given if cut else None,
            until=piece,
        )
        change = _times(mobile, solved.impulses.reshape(len(at), 6))
        after = moving + change
        time = solved.durations if cut else np.zeros(len(at))
        mean = 0.5 * time[:, np.newaxis] * (moving + after)
        along = (mean[:, :3] * c).sum(axis=1)[:, np.newaxis] * c
        axis_tip[at] += along
        bend[at] += mean[:, :3] - along
        x[at] += mean[:, 3:6]
        speed[at] = (after[:, :3] * c).sum(axis=1)
        bending[at] = after[:, :3] - speed[at, np.newaxis] * c
        v[at], w[at] = after[:, 3:6], after[:, 6:]
        lengths[at] = solved.lengths
        touched = solved.closings[:, TIP] > 0
        parted = touched & (solved.lengths[:, TIP] <= 0.0)
        bend[at[parted]], bending[at[parted]], clear[at[parted]] = 0.0, 0.0, False
        axis_tip[at[parted]] = _set_back(
            axis_tip[at[parted]], c[parted], x[at[parted]], reach - solved.lengths[parted, TIP]
        )
        done.slip[at[parted]] = solved.final_slips[parted, TIP]
        done.hits[at] += solved.closings[:, TIP] - pressed
        done.duration[at] += time
        done.impulses[at] += (solved.impulses[:, :, np.newaxis] @ frames)[:, :, 0]
        done.losses[at] += solved.losses
        done.steps[at] += solved.steps
        done.status[at] = np.maximum(done.status[at], solved.status)
        active: NDArray[np.bool_] = (given > 0.0) | (solved.closings > 0)
        pressed_on = solved.lengths > 0.0
        ended: NDArray[np.bool_] = np.any(active & ~pressed_on, axis=1)
        done.phases[at] += ended
        if ended[-1] and at[-1] == n - 1:
            contact = int(np.flatnonzero(active[-1] & ~pressed_on[-1])[0])
            energies = _energies(absolute_model, solved.lengths[-1])
            done.log.append(PhaseEnd(active[-1], contact, done.impulses[-1].copy(), energies))
        left = at[pressed_on.any(axis=1)] if cut else at[:0]
    done.status[left] = BUDGET_EXCEEDED
    lift = np.maximum(ball.radius - lengths[:, TABLE], ball.radius) - x[:, 2]
    if model.table:  # the cloth gave way; the ball lies on it, or is above it by its distance
        x[:, 2] += lift
        axis_tip[:, 2] += lift
    return done._replace(after=Meeting(x, v, w, axis_tip, speed))


def _energies(model: StrikeModel, lengths: Array) -> Array:
    """Elastic energies (2,) [J] of springs with compressions (2,) [m]."""
    power = model.exponent + 1.0
    energies: Array = np.array(model.stiffness) * np.maximum(lengths, 0.0) ** power / power
    return energies


def log_of(phases: list[PhaseEnd], frames: Array) -> NDArray[np.void]:
    """Write phases as a log (phases, 2); `frames`: (2, 3, 3), normal and tangents as rows."""
    log = ROWS.records(PhaseLog, 2 * len(phases)).reshape(-1, 2)
    for row, phase in zip(log, phases, strict=True):
        row['ending'], row['contact'] = RESTITUTION_END, phase.contact
        row['active'], row['energy'] = phase.active, phase.energies
        along = np.einsum('kij,kj->ki', frames, phase.impulses)
        row['impulse'], row['impulse_1'], row['impulse_2'] = along.T
    return log


def absolute(model: StrikeModel) -> StrikeModel:
    """Return a model with stiffnesses in N/m^exponent, such that a tip's contact has DURATION."""
    effective = 1.0 / (1.0 / model.cue_mass + 1.0 / model.surface.mass)
    power = model.exponent + 1.0
    depth = DURATION_SPEED * DURATION / duration_constant(model.exponent)
    tip = 0.5 * power * effective * DURATION_SPEED**2 / depth**power
    return model._replace(stiffness=(tip, tip * model.stiffness[TABLE] / model.stiffness[TIP]))


def _response(model: StrikeModel, axes: Array) -> Array:
    """Velocities per impulse (n, 9, 9): of the cue's end, the ball, and its spin."""
    along = axes[:, :, np.newaxis] * axes[:, np.newaxis]
    response = np.zeros((len(axes), 9, 9))
    response[:, :3, :3] = along / model.cue_mass + model.inverse_end_mass * (np.eye(3) - along)
    response[:, 3:6, 3:6] = np.eye(3) / model.surface.mass
    response[:, 6:, 6:] = np.eye(3) / model.surface.inertia
    return response


def _geometry(radius: float, normals: Array, axes: Array) -> tuple[Array, Array]:
    """
    Axes (n, 2, 3, 3) of tip and table, normal and two tangents, and contact velocities (n, 6, 9).

    Where the cue, the normal and the vertical are in one plane, the second tangents are normal to
    it.
    """
    side = cross_rows(UP, axes)
    width = np.linalg.norm(side, axis=1)
    side[width < rounding.COUPLING] = np.array([0.0, 1.0, 0.0])
    side /= np.where(width < rounding.COUPLING, 1.0, width)[:, np.newaxis]
    first = cross_rows(side, normals)
    first /= np.linalg.norm(first, axis=1)[:, np.newaxis]
    up = np.broadcast_to(UP, normals.shape)
    frames = np.stack(
        [
            np.stack([normals, first, cross_rows(normals, first)], axis=1),
            np.stack([up, cross_rows(side, up), side], axis=1),
        ],
        axis=1,
    )
    turning = radius * cross_rows(np.stack([normals, up], axis=1)[:, :, np.newaxis], frames)
    jacobian = np.zeros((len(axes), 2, 3, 9))
    jacobian[:, TIP, :, :3] = frames[:, TIP]
    jacobian[:, TIP, :, 3:6] = -frames[:, TIP]
    jacobian[:, TABLE, :, 3:6] = frames[:, TABLE]
    jacobian[..., 6:] = -turning
    return frames, jacobian.reshape(-1, 6, 9)


def _times(matrices: Array, vectors: Array) -> Array:
    """Multiply matrices (n, i, j) with vectors (n, j), each as it would be alone."""
    product: Array = (matrices @ vectors[:, :, np.newaxis])[:, :, 0]
    return product


def _set_back(tips: Array, axes: Array, centres: Array, distances: Array) -> Array:
    """Move tips back along their axes until they are at least so far from the balls' centres."""
    apart = tips - centres
    along = (apart * axes).sum(axis=1)
    inside = (apart**2).sum(axis=1) - distances**2
    back = along + np.sqrt(np.maximum(along**2 - inside, 0.0))
    return tips - np.where(inside < 0.0, back, 0.0)[:, np.newaxis] * axes
