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
from billiard_shot.impact.solve import solve_in_contact_space, Solved
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


class Motion(NamedTuple):
    """Balls and cues while they meet, n of each; arrays that are changed."""

    position: Array  # (n, 3) m, of the balls' centres
    velocity: Array  # (n, 3) m/s
    spin: Array  # (n, 3) rad/s
    axis_tip: Array  # (n, 3) m, where the tip's sphere is while the cue's end is not bent
    speed: Array  # (n,) m/s, of the cues along their axes
    bend: Array  # (n, 3) m, by which the cue's end is aside
    bending: Array  # (n, 3) m/s
    clear: NDArray[np.bool_]  # (n,) whether the tip may touch the ball: see the module
    lengths: Array  # (n, 2) m, of the contacts: compressed, or minus the distance


def meet(model: StrikeModel, axes: Array, before: Meeting, tolerance: Array) -> Outcome:
    """
    Let balls and cues meet, until nothing is pressed any more.

    Parameters
    ----------
    model : StrikeModel
    axes : (n, 3) float array
        Unit vectors along the cues.
    before : Meeting
    tolerance : (n,) float array
        Of the impact in each piece, relative to its velocities.

    """
    n, in_pieces = len(axes), model.law == BISTIFFNESS
    s, done = _start(model, before), _nothing(before)
    response, absolute_model = _response(model, axes), absolute(model)
    piece = DURATION / PIECES if in_pieces else np.inf
    left = np.arange(n)
    for _ in range(MAX_PIECES if in_pieces else 1):
        if not len(left):
            break
        at, c = left, axes[left]
        given, normals = _lengths(model, s, at, c, piece, done.hits[at])
        frames, jacobian = _geometry(model.surface.radius, normals, c)
        mobile = response[at] @ jacobian.transpose(0, 2, 1)
        cue = s.speed[at, np.newaxis] * c + s.bending[at]
        moving = np.concatenate([cue, s.velocity[at], s.spin[at]], axis=1)
        solved = solve_in_contact_space(
            contact_properties(absolute_model),
            without_rounding(jacobian @ mobile),
            _times(jacobian, moving),
            tolerance[at],
            lengths=given if in_pieces else None,
            until=piece,
        )
        after = moving + _times(mobile, solved.impulses.reshape(len(at), 6))
        _book(done, at, solved, frames, given, in_pieces)
        _log_last(done, at, solved, given, absolute_model)
        _advance(s, at, c, moving, after, solved.durations if in_pieces else np.zeros(len(at)))
        _part(model, s, at, c, solved)
        left = at[(solved.lengths > 0.0).any(axis=1)]
    if in_pieces:
        done.status[left] = BUDGET_EXCEEDED
    if model.table:  # the cloth gave way; the ball lies on it, or is above it by its distance
        radius = model.surface.radius
        lift = np.maximum(radius - s.lengths[:, TABLE], radius) - s.position[:, 2]
        s.position[:, 2] += lift
        s.axis_tip[:, 2] += lift
    return done._replace(after=Meeting(s.position, s.velocity, s.spin, s.axis_tip, s.speed))


def _start(model: StrikeModel, before: Meeting) -> Motion:
    """Begin the motion of balls and cues; whatever touches at first may be pressed."""
    n = len(before.speed)
    position, velocity, spin, tip, speed = (values.copy() for values in before)
    lengths = np.zeros((n, 2))
    lengths[:, TABLE] = (
        np.minimum(model.surface.radius - position[:, 2], 0.0) if model.table else FAR
    )
    bend, bending = np.zeros((2, n, 3))
    return Motion(
        position, velocity, spin, tip, speed, bend, bending, np.ones(n, np.bool_), lengths
    )


def _nothing(before: Meeting) -> Outcome:
    """Make the outcome of meetings in which nothing has happened yet."""
    n = len(before.speed)
    hits, steps, phases = np.zeros((3, n), np.int64)
    return Outcome(
        before,
        np.zeros(n),
        hits,
        np.zeros((n, 2, 3)),
        np.zeros((n, 2, 2)),
        np.zeros(n),
        steps,
        np.full(n, OK),
        phases,
        [],
    )


def _lengths(
    model: StrikeModel,
    s: Motion,
    at: NDArray[np.int64],
    c: Array,
    piece: float,
    hits: NDArray[np.int64],
) -> tuple[Array, Array]:
    """Find the lengths of contacts (n, 2) and the tips' normals (n, 3) for the next piece [s]."""
    away = s.axis_tip[at] + s.bend[at] - s.position[at]
    gap = np.maximum(np.linalg.norm(away, axis=1) - tip_reach(model), 0.0)
    gap[gap <= TOUCHING] = 0.0
    if piece < np.inf:  # the normal is that of its middle
        cue = s.speed[at, np.newaxis] * c + s.bending[at]
        away = away + 0.5 * piece * (cue - s.velocity[at])
    normals = away / np.linalg.norm(away, axis=1)[:, np.newaxis]
    s.clear[at] |= gap > 0.0
    given = s.lengths[at]
    pressed = given[:, TIP] > 0.0
    given[~pressed, TIP] = -gap[~pressed]
    given[(~s.clear[at] | (hits >= MAX_HITS)) & ~pressed, TIP] = FAR
    return given, normals


def _advance(
    s: Motion, at: NDArray[np.int64], c: Array, before: Array, after: Array, time: Array
) -> None:
    """Move cues and balls by a piece, with the mean of their velocities (n, 9) at both ends."""
    mean = 0.5 * time[:, np.newaxis] * (before + after)
    along = (mean[:, :3] * c).sum(axis=1)[:, np.newaxis] * c
    s.axis_tip[at] += along
    s.bend[at] += mean[:, :3] - along
    s.position[at] += mean[:, 3:6]
    s.speed[at] = (after[:, :3] * c).sum(axis=1)
    s.bending[at] = after[:, :3] - s.speed[at, np.newaxis] * c
    s.velocity[at], s.spin[at] = after[:, 3:6], after[:, 6:]


def _part(model: StrikeModel, s: Motion, at: NDArray[np.int64], c: Array, solved: Solved) -> None:
    """Note the lengths after a piece, and let the cue's end swing back if the tip has parted."""
    s.lengths[at] = solved.lengths
    parted = (solved.closings[:, TIP] > 0) & (solved.lengths[:, TIP] <= 0.0)
    gone = at[parted]
    s.bend[gone], s.bending[gone], s.clear[gone] = 0.0, 0.0, False
    s.axis_tip[gone] = _set_back(
        s.axis_tip[gone],
        c[parted],
        s.position[gone],
        tip_reach(model) - solved.lengths[parted, TIP],
    )


def _book(
    done: Outcome,
    at: NDArray[np.int64],
    solved: Solved,
    frames: Array,
    given: Array,
    in_pieces: bool,
) -> None:
    """Add what a piece did to the outcome."""
    parted = (solved.closings[:, TIP] > 0) & (solved.lengths[:, TIP] <= 0.0)
    done.slip[at[parted]] = solved.final_slips[parted, TIP]
    done.hits[at] += solved.closings[:, TIP] - (given[:, TIP] > 0.0)
    done.duration[at] += solved.durations if in_pieces else 0.0
    done.impulses[at] += (solved.impulses[:, :, np.newaxis] @ frames)[:, :, 0]
    done.losses[at] += solved.losses
    done.steps[at] += solved.steps
    done.status[at] = np.maximum(done.status[at], solved.status)
    done.phases[at] += _ended(solved, given).any(axis=1)


def _ended(solved: Solved, given: Array) -> NDArray[np.bool_]:
    """Whether each contact (n, 2) was active in a piece, and is not any more."""
    ended: NDArray[np.bool_] = ((given > 0.0) | (solved.closings > 0)) & (solved.lengths <= 0.0)
    return ended


def _log_last(
    done: Outcome, at: NDArray[np.int64], solved: Solved, given: Array, model: StrikeModel
) -> None:
    """Log the phase of the last meeting that has ended in a piece."""
    ended = _ended(solved, given)[-1]
    if at[-1] == len(done.hits) - 1 and ended.any():
        active: NDArray[np.bool_] = (given[-1] > 0.0) | (solved.closings[-1] > 0)
        energies = _energies(model, solved.lengths[-1])
        contact = int(np.flatnonzero(ended)[0])
        done.log.append(PhaseEnd(active, contact, done.impulses[-1].copy(), energies))


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
