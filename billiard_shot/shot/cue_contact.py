"""
A cue that meets a ball, alone or among others: with the geometry of each moment.

The impact is cut into short pieces. In each piece the normals are those of its middle.
Compressions are carried over. Only law `bistiffness` knows how a compressed spring goes on. Under
the other laws an impact is one piece, in which all contacts take part that touch at first.

The end of the cue gives way sideways while the tip touches the ball. When they part it swings
back to the cue's axis, and is at rest there relative to the cue. The tip can meet the ball again
as soon as the ball is clear of that place, or has met something else: before, the ball only holds
the end aside.

A nose keeps the normal with which it closes, as in rebound.py. Its restitution is that of the
speed with which a ball would press it as far.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import read_log
from billiard_shot.impact.solve import Properties, solve_in_contact_space, Solved
from billiard_shot.numerics import rounding
from billiard_shot.shot.contact_geometry import (
    delassus_of,
    frames_of,
    gaps_of,
    jacobian_of,
    mobility_of,
    shares,
    sizes,
    times,
    tip_response,
    ways_apart,
)
from billiard_shot.shot.meeting import add_piece, log_last, Meeting, nothing_yet, Outcome
from billiard_shot.shot.model import (
    StrikeModel,
    TABLE,
    TIP,
    TIP_DURATION,
    tip_reach,
    tip_stiffness,
)
from billiard_shot.shot.neighbours import FIXED, is_in_pieces, Neighbour, UP
from billiard_shot.status import BUDGET_EXCEEDED
from billiard_shot.table.cushion import LEAST

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]

PIECES = 8  # of TIP_DURATION, into which an impact is cut
MAX_PIECES = 400  # of an impact
MAX_HITS = 8  # of the tip: then the cue is taken away
TOLERANCE = 1e-9  # of the impact in each piece, relative to its velocities
TOUCHING = 1e-9  # m: bodies that are no farther apart touch
MAX_SWEEPS = 100  # to set balls apart
FAR = -1.0  # m: length of a contact that nothing closes
STILL = 1e-12  # of the fastest ball's speed: what rounding leaves of a ball at rest
OTHERS = np.s_[:, TABLE + 1 :]  # contacts beside TIP and TABLE


class Motion(NamedTuple):
    """Balls and cues while they meet; arrays that are changed."""

    position: Array  # as in `Meeting`, and the next two
    velocity: Array
    spin: Array
    axis_tip: Array  # (n, 3) m, where the tip's sphere is while the cue's end is not bent
    speed: Array  # (n,) m/s, of the cues along their axes
    bend: Array  # (n, 3) m, by which the cue's end is aside
    bending: Array  # (n, 3) m/s
    clear: Flags  # (n,) whether the tip may touch the ball: see the module
    lengths: Array  # (n, N) m, of the contacts: compressed, or minus the distance
    normals: Array  # (n, N, 3) of the last piece
    rush: Array  # (n, N) m/s, with which a ball would press a nose as far as this one has


class Contacts(NamedTuple):
    """What is the same in all pieces of n meetings."""

    model: StrikeModel
    neighbours: Sequence[Neighbour]
    axes: Array  # (n, 3)
    steady: Flags  # (n,) the tip keeps its normal in its first hit
    share: Array  # see `shares`
    tip: Array  # (n, 3, 3) see `tip_response`
    springs: Properties
    is_nose: Flags  # (neighbours,)
    piece: float  # s; inf if there is only one
    most_hits: int  # of the tip


def meet(
    model: StrikeModel,
    axes: Array,
    before: Meeting,
    tolerance: Array,
    neighbours: Sequence[Neighbour] = (),
    steady: Flags | None = None,
    phases: int = 0,
) -> Outcome:
    """
    Let cues and balls meet, until nothing is pressed any more.

    Parameters
    ----------
    model : StrikeModel
    axes : (n, 3) float array
        Unit vectors along the cues.
    before : Meeting
    tolerance : (n,) float array
        Of the impact in each piece, relative to its velocities.
    neighbours : sequence of Neighbour
        Contacts beside TIP and TABLE.
    steady : (n,) bool array, optional
        Whether the tip keeps its normal in its first hit. Default: nowhere.
    phases : int
        If above 0, those of the last meeting are logged.

    """
    n, in_pieces = len(axes), is_in_pieces(model)
    steady = np.zeros(n, np.bool_) if steady is None else steady
    g = _contacts(model, axes, before, neighbours, steady)
    s = _start(g, before)
    done = nothing_yet(before, len(g.share))
    left: Rows = np.arange(n)
    for _ in range(MAX_PIECES if in_pieces else 1):
        if not len(left):
            break
        left = _go_on(g, s, done, left, tolerance, phases)
    if in_pieces:
        done.status[left] = BUDGET_EXCEEDED
    done.status[~_settle(g, s, before)] = BUDGET_EXCEEDED
    after = Meeting(s.position, s.velocity, s.spin, s.axis_tip, s.speed)
    return done._replace(after=after, lengths=s.lengths)


def _go_on(g: Contacts, s: Motion, done: Outcome, at: Rows, tolerance: Array, phases: int) -> Rows:
    """Let some of the meetings go on by a piece; return those that have not ended then."""
    axes, in_pieces = g.axes[at], g.piece < np.inf
    given = _lengths(g, s, at, done.hits[at])
    frames = frames_of(s.normals[at], axes)
    jacobian = jacobian_of(frames, g.share, g.model.surface.radius)
    mobility = mobility_of(jacobian, g.tip[at], g.model.surface)
    moving = _velocities(s, at, axes)
    approach = times(jacobian, moving)
    solved = solve_in_contact_space(
        _springs(g, s, at, given, approach),
        delassus_of(jacobian, mobility),
        approach,
        tolerance[at],
        0 if in_pieces else phases,
        given if in_pieces else None,
        g.piece,
    )
    after = moving + times(mobility, solved.impulses.reshape(len(at), -1))
    add_piece(done, at, solved, frames, given, in_pieces)
    if phases and in_pieces:
        log_last(g.springs, done, at, solved, given)
    elif phases:
        done.log[:] = read_log(solved.log, frames[-1])
    _advance(s, at, axes, moving, after, solved.durations if in_pieces else np.zeros(len(at)))
    _keep_lengths(g, s, at, solved)
    _part(g, s, at, solved)
    goes_on = (solved.lengths > 0.0).any(axis=1)
    if in_pieces:
        goes_on |= _hits_soon(g, s, at, done.hits[at])
    return at[goes_on]


def _contacts(
    model: StrikeModel,
    axes: Array,
    before: Meeting,
    neighbours: Sequence[Neighbour],
    steady: Flags,
) -> Contacts:
    """Collect what stays the same."""
    in_pieces = is_in_pieces(model)
    scale = tip_stiffness(model) / model.stiffness[TIP] if in_pieces else 1.0
    springs = Properties(
        np.array([*model.friction, *(each.friction for each in neighbours)]),
        np.array([*model.restitution, *(each.restitution for each in neighbours)]),
        np.array([scale * k for k in model.stiffness] + [each.stiffness for each in neighbours]),
        model.law,
        model.exponent,
        np.array([0.0, 0.0, *(each.fading for each in neighbours)]),
        np.array([0.0, 0.0, *(each.decay for each in neighbours)]),
    )
    return Contacts(
        model,
        neighbours,
        axes,
        steady,
        shares(neighbours, before.position.shape[1]),
        tip_response(model, axes),
        springs,
        np.array([each.nose is not None for each in neighbours], np.bool_),
        TIP_DURATION / PIECES if in_pieces else np.inf,
        MAX_HITS if model.follows else 1,
    )


def _start(g: Contacts, before: Meeting) -> Motion:
    """Begin the motion of balls and cues; whatever touches at first may be pressed."""
    n, count, radius = len(g.axes), len(g.share), g.model.surface.radius
    position, velocity, spin, tip, speed = (values.copy() for values in before)
    lengths, rush = np.zeros((2, n, count))
    lengths[:, TABLE] = np.minimum(radius - position[:, 0, 2], 0.0) if g.model.table else FAR
    normals = np.zeros((n, count, 3))
    normals[:, TABLE] = UP
    away = tip - position[:, 0]
    normals[:, TIP] = away / sizes(away)[:, np.newaxis]
    bend, bending = np.zeros((2, n, 3))
    clear = np.ones(n, np.bool_)
    return Motion(
        position, velocity, spin, tip, speed, bend, bending, clear, lengths, normals, rush
    )


def _lengths(g: Contacts, s: Motion, at: Rows, hits: Rows) -> Array:
    """Find the lengths (n, N) of contacts as a piece begins, and the normals of its middle."""
    half = 0.5 * g.piece if g.piece < np.inf else 0.0
    given = s.lengths[at]
    pressed = given > 0.0
    if g.neighbours:
        radius, place = g.model.surface.radius, s.position[at]
        gap = gaps_of(g.neighbours, place, radius)
        gap[gap <= TOUCHING] = 0.0
        given[OTHERS] = np.where(pressed[OTHERS], given[OTHERS], -gap)
        ways = ways_apart(g.neighbours, place + half * s.velocity[at])
        normals = ways / sizes(ways)[..., np.newaxis]
        kept = pressed[OTHERS] & g.is_nose
        s.normals[at, TABLE + 1 :] = np.where(
            kept[..., np.newaxis], s.normals[at, TABLE + 1 :], normals
        )
    away, approach = _tip_apart(s, at, g.axes[at])
    gap = sizes(away) - tip_reach(g.model)
    away = away + half * approach
    moves = ~(g.steady[at] & (hits <= 1) & ((hits == 0) | pressed[:, TIP]))
    s.normals[at[moves], TIP] = away[moves] / sizes(away[moves])[:, np.newaxis]
    s.clear[at] |= gap > TOUCHING
    gone = (hits >= g.most_hits) | ~s.clear[at]
    gap[gap <= TOUCHING] = 0.0
    given[:, TIP] = np.where(pressed[:, TIP], given[:, TIP], np.where(gone, FAR, -gap))
    return given


def _tip_apart(s: Motion, at: Rows, axes: Array) -> tuple[Array, Array]:
    """From the ball's centre to that of the tip's sphere (n, 3) [m], and how fast it changes."""
    away = s.axis_tip[at] + s.bend[at] - s.position[at, 0]
    return away, s.speed[at, np.newaxis] * axes + s.bending[at] - s.velocity[at, 0]


def _velocities(s: Motion, at: Rows, axes: Array) -> Array:
    """Velocities of the bodies (n, 3 + 6 k), see contact_geometry.py."""
    tip = s.speed[at, np.newaxis] * axes + s.bending[at]
    rows = len(at)
    balls = s.velocity[at].reshape(rows, -1), s.spin[at].reshape(rows, -1)
    return np.concatenate([tip, *balls], axis=1)


def _springs(g: Contacts, s: Motion, at: Rows, given: Array, approach: Array) -> Properties:
    """Return the contacts' properties; noses are softer for a ball that presses them faster."""
    if not g.is_nose.any():
        return g.springs
    noses = TABLE + 1 + np.flatnonzero(g.is_nose)
    closing = np.maximum(-approach[:, 3 * noses], 0.0)
    power = g.model.exponent + 1.0
    stiffness = np.asarray(g.springs.stiffness)[noses]
    energy = stiffness * np.maximum(given[:, noses], 0.0) ** power / power
    rush = np.sqrt(closing**2 + 2.0 * energy / g.model.surface.mass)
    before = np.where(given[:, noses] > 0.0, s.rush[np.ix_(at, noses)], 0.0)
    rush = s.rush[np.ix_(at, noses)] = np.maximum(rush, before)
    softening = np.array([each.softening for each in g.neighbours])[g.is_nose]
    restitution = np.tile(g.springs.restitution, (len(at), 1))
    softened = restitution[:, noses] / (1.0 + (softening * rush) ** 2)
    restitution[:, noses] = np.maximum(softened, LEAST)
    return replace(g.springs, restitution=restitution)


def _advance(s: Motion, at: Rows, c: Array, before: Array, after: Array, time: Array) -> None:
    """Move cues and balls by a piece, with the mean of their velocities at both ends."""
    n, balls = len(at), s.position.shape[1]
    mean = 0.5 * time[:, np.newaxis] * (before + after)
    along = (mean[:, :3] * c).sum(axis=1)[:, np.newaxis] * c
    s.axis_tip[at] += along
    s.bend[at] += mean[:, :3] - along
    middle = 3 + 3 * balls
    s.position[at] += mean[:, 3:middle].reshape(n, balls, 3)
    s.speed[at] = (after[:, :3] * c).sum(axis=1)
    s.bending[at] = after[:, :3] - s.speed[at, np.newaxis] * c
    s.velocity[at] = after[:, 3:middle].reshape(n, balls, 3)
    s.spin[at] = after[:, middle:].reshape(n, balls, 3)


def _keep_lengths(g: Contacts, s: Motion, at: Rows, solved: Solved) -> None:
    """Move balls that pressed each other or a nose to where the lengths of their contacts say."""
    for j in range(TABLE + 1, len(g.share)):
        active = solved.closings[:, j] > 0
        if active.any():
            rows = at[active]
            _move_apart(g, s, j, rows, -solved.lengths[active, j], s.normals[rows, j])


def _move_apart(g: Contacts, s: Motion, j: int, rows: Rows, distance: Array, push: Array) -> None:
    """
    Move a ball, or the two balls of a contact, along `push` so that it has a distance [m].

    The tip goes with the cue ball: else such a move would press the one into the other.
    """
    each = g.neighbours[j - TABLE - 1]
    gap = gaps_of([each], s.position[rows], g.model.surface.radius)[:, 0]
    change = (distance - gap)[:, np.newaxis] * push
    if each.b != FIXED:
        change *= 0.5
        s.position[rows, each.b] -= change
    s.position[rows, each.a] += change
    if each.a == 0:
        s.axis_tip[rows] += change


def _part(g: Contacts, s: Motion, at: Rows, solved: Solved) -> None:
    """Note the lengths after a piece; the cue's end swings back if the tip has parted."""
    s.lengths[at] = solved.lengths
    s.clear[at] |= (solved.closings[OTHERS] > 0).any(axis=1)
    parted = (solved.closings[:, TIP] > 0) & (solved.lengths[:, TIP] <= 0.0)
    gone = at[parted]
    s.bend[gone], s.bending[gone], s.clear[gone] = 0.0, 0.0, False
    distance = tip_reach(g.model) - solved.lengths[parted, TIP]
    tips, centres = s.axis_tip[gone], s.position[gone, 0]
    s.axis_tip[gone] = _set_back(tips, g.axes[gone], centres, distance)


def _hits_soon(g: Contacts, s: Motion, at: Rows, hits: Rows) -> Flags:
    """Whether the tip hits the ball within the next piece, as they move."""
    away, approach = _tip_apart(s, at, g.axes[at])
    distance = sizes(away)
    closing = -(away * approach).sum(axis=1) / distance
    gap = distance - tip_reach(g.model)
    may = (hits < g.most_hits) & (s.clear[at] | (gap > TOUCHING))
    return may & (closing > 0.0) & (gap < closing * g.piece)


def _settle(g: Contacts, s: Motion, before: Meeting) -> Flags:
    """
    Put balls and cues where they are when nothing is pressed; return (n,) whether they can be.

    If they cannot, the balls are where they were before.
    """
    speed = sizes(s.velocity).max(axis=1, initial=0.0)[:, np.newaxis, np.newaxis]
    s.velocity[np.abs(s.velocity) <= STILL * speed] = 0.0
    s.spin[np.abs(s.spin) * g.model.surface.radius <= STILL * speed] = 0.0
    radius = g.model.surface.radius
    if g.model.table:  # the cloth gave way; the ball lies on it, or is above it by its distance
        lift = np.maximum(radius - s.lengths[:, TABLE], radius) - s.position[:, 0, 2]
        s.position[:, 0, 2] += lift
        s.axis_tip[:, 2] += lift
    s.position[:, 1:, 2] = before.position[:, 1:, 2]  # the cloth holds them, or throws them up
    apart = _set_apart(g, s)
    s.position[~apart] = before.position[~apart]
    return apart


def _set_apart(g: Contacts, s: Motion) -> Flags:
    """Move balls sideways out of noses and of each other; return (n,) whether none overlap."""
    radius = g.model.surface.radius
    solid = [
        (j, each)
        for j, each in enumerate(g.neighbours, TABLE + 1)
        if each.nose is not None or each.b != FIXED
    ]
    left: Rows = np.arange(len(s.position) if solid else 0)
    for _ in range(MAX_SWEEPS):
        if not len(left):
            break
        apart = np.ones(len(left), np.bool_)
        for j, each in solid:
            gap = gaps_of([each], s.position[left], radius)[:, 0]
            apart &= gap >= -0.5 * rounding.PLACE
            rows = left[gap < 0.0]
            way = ways_apart([each], s.position[rows])[:, 0]
            level = way * np.array([1.0, 1.0, 0.0])
            push = level * (sizes(way) / (level**2).sum(axis=1))[:, np.newaxis]
            _move_apart(g, s, j, rows, np.zeros(len(rows)), push)
        left = left[~apart]
    done = np.ones(len(s.position), np.bool_)
    done[left] = False
    return done


def _set_back(tips: Array, axes: Array, centres: Array, distances: Array) -> Array:
    """Move tips back along their axes until they are at least so far from the balls' centres."""
    apart = tips - centres
    along = (apart * axes).sum(axis=1)
    inside = (apart**2).sum(axis=1) - distances**2
    back = along + np.sqrt(np.maximum(along**2 - inside, 0.0))
    return tips - np.where(inside < 0.0, back, 0.0)[:, np.newaxis] * axes
