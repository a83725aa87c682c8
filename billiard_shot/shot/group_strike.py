"""
Strikes on a ball that touches, or nearly touches, other balls or a cushion.

The tip presses the ball for about a millisecond. During this time the ball may reach another ball
or a cushion. Tip, balls, cushion and cloth therefore collide at once, with the distances between
them. A contact of two balls has the normal with which it closes, if balls go straight: the struck
one in the direction that the strike alone would give it.

All strokes of a call have the same balls in the same places, and so the same contacts: first TIP
and TABLE, as in every strike, then those of balls with each other and with cushions.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import CollisionResult, read_log
from billiard_shot.impact.contact_space import without_rounding
from billiard_shot.impact.solve import Properties, solve_in_contact_space, Solved
from billiard_shot.numerics.vectors import cross_rows
from billiard_shot.shot.cue_contact import absolute, DURATION, FAR, UP
from billiard_shot.shot.model import StrikeModel, TABLE, TIP, tip_reach
from billiard_shot.shot.neighbours import FIXED, Neighbour
from billiard_shot.shot.strike import final_status, MISCUE_SLIP
from billiard_shot.status import Status
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.params import TableParams

Array = NDArray[np.float64]

TOLERANCE = 1e-9  # of the impact, relative to the cue's speed
FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


class GroupStrike(NamedTuple):
    """What n strikes on a ball among others do."""

    reached: NDArray[np.bool_]  # (n,) whether a contact beside TIP and TABLE closed
    velocities: Array  # (n, balls, 3) m/s, afterwards
    spins: Array  # (n, balls, 3) rad/s
    first_met: NDArray[np.int64]  # (n, balls) index of the ball that each one met, or NOTHING
    # Of the last strike, if its phases were asked for: in detail, and the balls that met.
    result: CollisionResult | None
    met: list[tuple[int, int]]


def may_reach(neighbours: list[Neighbour], speeds: Array) -> NDArray[np.bool_]:
    """Whether a ball can reach its nearest neighbour while the tip of a cue [m/s] touches it."""
    nearest = min((each.gap for each in neighbours if each.a == 0), default=np.inf)
    return nearest <= FARTHEST * DURATION * speeds


def strike_group(
    model: StrikeModel,
    table: TableParams,
    members: list[int],
    neighbours: list[Neighbour],
    velocities: Array,
    strikes: NDArray[np.void],
    places: Array,
    phases: int,
) -> GroupStrike:
    """
    Strike the first ball together with its neighbours.

    Parameters
    ----------
    model, table : StrikeModel, TableParams
    members, neighbours
        See `neighbours_of`.
    velocities : (n, 3) float array
        Of the cue [m/s].
    strikes : (n,) Strike, changed
        The strikes of the ball alone; afterwards these.
    places : (balls, 3) float array
        Centres [m].
    phases : int
        Of the last strike that are logged; 0: there is no `result`.

    """
    ball, count = model.surface, len(neighbours) + 2
    n, speeds = len(strikes), np.linalg.norm(velocities, axis=1)
    c = velocities / speeds[:, np.newaxis]
    share = np.zeros((count, len(members)))  # 1 for ball a of a contact, -1 for ball b
    share[TIP, 0], share[TABLE, 0] = -1.0, 1.0
    axes = np.zeros((n, count, 3, 3))
    axes[:, : TABLE + 1] = strikes['axes'].reshape(n, 2, 3, 3)
    gaps = np.zeros((n, count))
    gaps[:, TABLE] = 0.0 if model.table else -FAR
    for j, each in enumerate(neighbours, TABLE + 1):
        share[j, each.a] = 1.0
        if each.b != FIXED:
            share[j, each.b] = -1.0
    others = np.s_[:, TABLE + 1 :]
    normals, gaps[others] = _geometry(neighbours, places[members], strikes, ball.radius)
    axes[others] = _frames(normals)
    turning = -ball.radius * cross_rows(axes[:, :, :1], axes)
    w = _response(model, c, axes, turning, share)
    approach = np.zeros((n, 3 * count))
    approach[:, :3] = _dots(axes[:, TIP], velocities[:, np.newaxis])
    solved = _solve(model, table, neighbours, w, approach, gaps, phases)
    impulses = _sum_of_three(solved.impulses[..., np.newaxis] * axes, 2)
    moments = -ball.radius * cross_rows(axes[:, :, 0], impulses)
    velocity, spin = np.zeros((2, n, len(places), 3))
    velocity[:, members] = _sums(share, impulses) / ball.mass
    spin[:, members] = _sums(np.abs(share), moments) / ball.inertia
    cue = speeds + _dots(c, impulses[:, TIP]) / model.cue_mass
    _write(model, strikes, solved, velocity[:, 0], spin[:, 0], cue, speeds)
    pushes = solved.impulses[:, TABLE + 1 :, 0]
    met = _first_met(members, neighbours, pushes, len(places))
    result, pairs = None, []
    if phases:
        result = _result(solved, impulses, axes[-1], velocity[-1, members], spin[-1, members])
        pairs = [
            (members[each.a], members[each.b])
            for push, each in zip(pushes[-1].tolist(), neighbours, strict=True)
            if push > 0.0 and each.b != FIXED
        ]
    reached: NDArray[np.bool_] = np.any(pushes > 0.0, axis=1)
    return GroupStrike(reached, velocity, spin, met, result, pairs)


def _geometry(
    neighbours: list[Neighbour], members: Array, strikes: NDArray[np.void], radius: float
) -> tuple[Array, Array]:
    """
    Find normals and gaps with which the neighbours' contacts close, as the balls move.

    Parameters
    ----------
    neighbours : list of N Neighbour
    members : (balls, 3) float array
        Centres [m] of the balls that take part.
    strikes : (n,) Strike
        Of the first ball alone.
    radius : float
        [m]

    Returns
    -------
    normals, gaps : (n, N, 3), (n, N) float arrays
        Gaps along the normals [m].

    """
    n, seen = len(strikes), {0}
    moving = np.zeros((n, len(members), 3))  # m/s, that a ball gets from the first that meets it
    moving[:, 0] = strikes['velocity']
    normals = np.tile([each.normal for each in neighbours], (n, 1, 1))
    gaps = np.tile([each.gap for each in neighbours], (n, 1))
    for j, each in enumerate(neighbours):
        a, b = each.a, each.b
        if b == FIXED:
            continue
        if each.gap > 0.0:
            normals[:, j], gaps[:, j] = _as_it_closes(
                moving[:, a] - moving[:, b], members[b] - members[a], each, radius
            )
        if b not in seen:
            seen.add(b)
            push = np.minimum(_dots(moving[:, a], normals[:, j]), 0.0)[:, np.newaxis]
            moving[:, b] = 0.5 * (1.0 + each.restitution) * push * normals[:, j]
    return normals, gaps


def _as_it_closes(
    velocity: Array, between: Array, contact: Neighbour, radius: float
) -> tuple[Array, Array]:
    """
    Find how a ball meets another one, if it goes straight. If it passes, they do not meet.

    If it goes away from the other one, their contact is as it is now.

    Parameters
    ----------
    velocity : (n, 3) float array
        Of the ball, relative to the other one [m/s].
    between : (3,) float array
        From the centre of the ball to that of the other one [m].
    contact : Neighbour
    radius : float
        [m]

    Returns
    -------
    normals, gaps : (n, 3), (n,) float arrays
        Normals as they meet; distances along them [m].

    """
    speed = _sizes(velocity)
    way = velocity / np.where(speed > 0.0, speed, 1.0)[:, np.newaxis]
    ahead = _dots(way, between)
    beside = ahead * ahead - (float(between @ between) - 4.0 * radius * radius)
    meets = (ahead > 0.0) & (beside > 0.0)
    path = np.where(meets, ahead - np.sqrt(np.where(meets, beside, 0.0)), 0.0)
    normals = (path[:, np.newaxis] * way - between) / (2.0 * radius)
    normals = np.where(meets[:, np.newaxis], normals, contact.normal)
    gaps = np.where(meets, -path * _dots(normals, way), np.where(ahead > 0.0, -FAR, contact.gap))
    return normals, gaps


def _frames(normals: Array) -> Array:
    """Add two tangents to normals (..., 3), the first one upright; or along x."""
    up = UP - normals[..., 2:] * normals
    size = _sizes(up)[..., np.newaxis]
    first = np.where(size > 0.0, up / np.where(size > 0.0, size, 1.0), np.array([1.0, 0.0, 0.0]))
    return np.stack([normals, first, cross_rows(normals, first)], axis=-2)


def _response(model: StrikeModel, c: Array, axes: Array, turning: Array, share: Array) -> Array:
    """W (n, 3 contacts, 3 contacts) [1/kg]."""
    ball, (n, count) = model.surface, axes.shape[:2]
    pulls = (share @ share.T)[:, np.newaxis, :, np.newaxis] / ball.mass
    turns = (np.abs(share) @ np.abs(share).T)[:, np.newaxis, :, np.newaxis] / ball.inertia
    one, other = np.s_[:, :, :, np.newaxis, np.newaxis], np.s_[:, np.newaxis, np.newaxis]
    w = pulls * _dots(axes[one], axes[other]) + turns * _dots(turning[one], turning[other])
    tip = axes[:, TIP]
    along = _dots(tip, c[:, np.newaxis])
    across = _dots(tip[:, :, np.newaxis], tip[:, np.newaxis])
    stiff = along[:, :, np.newaxis] * along[:, np.newaxis]
    w[:, TIP, :, TIP] += stiff / model.cue_mass + model.inverse_end_mass * (across - stiff)
    return without_rounding(w.reshape(n, 3 * count, 3 * count))


def _solve(
    model: StrikeModel,
    table: TableParams,
    neighbours: list[Neighbour],
    w: Array,
    approach: Array,
    gaps: Array,
    phases: int,
) -> Solved:
    """Solve the strikes. If balls take time to collide, so does the tip: distances count then."""
    takes_time = table.ball_duration > 0.0
    stiffness = np.array([*model.stiffness, *(each.stiffness for each in neighbours)])
    if takes_time:
        stiffness *= absolute(model).stiffness[TIP] / model.stiffness[TIP]
    properties = Properties(
        [*model.friction, *(each.friction for each in neighbours)],
        [*model.restitution, *(each.restitution for each in neighbours)],
        stiffness,
        model.law,
        model.exponent,
        [0.0, 0.0, *(each.fading for each in neighbours)],
        [0.0, 0.0, *(each.decay for each in neighbours)],
    )
    tolerance = np.full(len(w), TOLERANCE)
    lengths = -gaps if takes_time else None
    return solve_in_contact_space(properties, w, approach, tolerance, phases, lengths)


def _write(
    model: StrikeModel,
    strikes: NDArray[np.void],
    solved: Solved,
    velocity: Array,
    spin: Array,
    cue_speed: Array,
    speeds: Array,
) -> None:
    """Write what the strikes did to cue, struck ball, tip and table."""
    strikes['velocity'], strikes['spin'], strikes['cue_speed'] = velocity, spin, cue_speed
    strikes['losses'] = solved.losses[:, : TABLE + 1].reshape(-1, 4)
    strikes['impulses'] = solved.impulses[:, : TABLE + 1].reshape(-1, 6)
    away = tip_reach(model) - np.minimum(solved.lengths[:, TIP], 0.0)
    strikes['tip'] = away[:, np.newaxis] * strikes['axes'][:, :3]
    strikes['hits'] = 1
    strikes['phases'], strikes['steps'] = solved.phases, solved.steps
    miscue = solved.final_slips[:, TIP] > MISCUE_SLIP * speeds
    strikes['status'] = [
        final_status(status, slips, int(Status.OK), exact=True)
        for status, slips in zip(solved.status.tolist(), miscue.tolist(), strict=True)
    ]


def _first_met(
    members: list[int], neighbours: list[Neighbour], pushes: Array, balls: int
) -> NDArray[np.int64]:
    """Ball (n, balls) that each one met, the one that it pushed most; or NOTHING."""
    met = np.full((len(pushes), balls), NOTHING)
    most = np.zeros((len(pushes), balls))
    for push, each in zip(pushes.T, neighbours, strict=True):
        if each.b != FIXED:
            a, b = members[each.a], members[each.b]
            for one, other in ((a, b), (b, a)):
                met[:, one] = np.where(push > most[:, one], other, met[:, one])
                most[:, one] = np.maximum(push, most[:, one])
    return met


def _result(
    solved: Solved, impulses: Array, axes: Array, velocities: Array, spins: Array
) -> CollisionResult:
    """Collect the last strike in detail."""
    return CollisionResult(
        Status(int(solved.status[-1])),
        velocities,
        spins,
        impulses[-1],
        solved.losses[-1],
        solved.final_slips[-1],
        solved.lengths[-1],
        float(solved.durations[-1]),
        read_log(solved.log, axes),
        int(solved.steps[-1]),
    )


def _dots(one: Array, other: Array) -> Array:
    """Scalar products of vectors on the last axis; the sum has the same order for any shape."""
    return _sum_of_three(one * other, -1)


def _sizes(vectors: Array) -> Array:
    """Lengths of vectors on the last axis."""
    return np.sqrt(_dots(vectors, vectors))


def _sum_of_three(values: Array, axis: int) -> Array:
    """Sum along an axis of length three, in order."""
    first, second, third = np.moveaxis(values, axis, 0)
    total: Array = first + second + third
    return total


def _sums(share: Array, vectors: Array) -> Array:
    """Add vectors (n, contacts, 3) up to those of balls (n, balls, 3), contact by contact."""
    total = np.zeros((len(vectors), share.shape[1], 3))
    for j, row in enumerate(share):
        total += row[:, np.newaxis] * vectors[:, j, np.newaxis]
    return total
