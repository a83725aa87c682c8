"""
A cue that meets a ball, alone or among others: with the geometry of each moment.

Tip, balls, noses and cloth are the bodies of one impact (impact/moving_bodies.py), which ends when
nothing is pressed. Its pressed contacts take their normals anew every eighth of the tip's contact
time; a nose keeps the normal with which it closes, as in rebound.py. Under other laws than
`bistiffness` bodies stay in place, and all contacts take part that touch at first.

A nose softens: its restitution is that of the speed with which a ball would press it as far.
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.beginning import Collisions, ContactProperties
from billiard_shot.impact.collide import Phase, read_log
from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult
from billiard_shot.impact.solve import solve_given
from billiard_shot.impact.state import BALL, BodyState, EDGE, PLANE
from billiard_shot.impact.state import TIP as TIP_BODY
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import cross_rows
from billiard_shot.records import as_rows, ROWS
from billiard_shot.shot.contact_geometry import edges_near, gaps_of, sizes, ways_apart
from billiard_shot.shot.model import (
    StrikeModel,
    TABLE,
    TIP,
    TIP_DURATION,
    tip_reach,
    tip_stiffness,
)
from billiard_shot.shot.neighbours import bodies_move, FIXED, Neighbour, UP
from billiard_shot.status import BUDGET_EXCEEDED
from billiard_shot.table.cluster import UNLIMITED

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]

NORMALS = 16  # that a contact has in TIP_DURATION
MAX_HITS = 8  # of the tip: then the cue is taken away
TOLERANCE = 1e-9  # of the impact, relative to its largest approach speed
TOUCHING = 1e-9  # m: bodies that are no farther apart touch
MAX_SWEEPS = 100  # to set balls apart
FAR = 1.0  # m, to the cloth where it takes no part
STILL = 1e-12  # of the fastest ball's speed: what rounding leaves of a ball at rest
OTHERS = np.s_[:, TABLE + 1 :]  # contacts beside TIP and TABLE


class Meeting(NamedTuple):
    """Balls and cues that meet: n cues, each with k balls, of which it meets the first."""

    position: Array  # (n, k, 3) m, of the balls' centres; frame `table`
    velocity: Array  # (n, k, 3) m/s
    spin: Array  # (n, k, 3) rad/s
    tip: Array  # (n, 3) m, centre of the tip's sphere
    speed: Array  # (n,) m/s, of the cues along their axes


class Outcome(NamedTuple):
    """What n meetings leave, until none of N contacts is pressed any more."""

    after: Meeting
    duration: Array  # (n,) s
    closings: Rows  # (n, N) how often each contact closed
    impulses: Array  # (n, N, 3) N s, on the body into which the normal points; TIP: on the cue
    losses: Array  # (n, N, 2) J: restitution, friction
    slips: Array  # (n, N) m/s, of contacts when they last ended
    first_slip: Array  # (n,) m/s, of the tip when it left the ball for the first time
    lengths: Array  # (n, N) m, minus the distances
    steps: Rows  # (n,)
    status: Rows  # (n,) Status
    phases: Rows  # (n,)
    log: tuple[Phase, ...]  # of the last meeting

    @property
    def hits(self) -> Rows:
        """How often the tip met the ball (n,)."""
        return self.closings[:, TIP]


def meet(
    model: StrikeModel,
    axes: Array,
    before: Meeting,
    tolerance: Array,
    neighbours: Sequence[Neighbour] = (),
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
        Of the impact, relative to its largest approach speed.
    neighbours : sequence of Neighbour
        Contacts beside TIP and TABLE.
    phases : int
        If above 0, those of the last meeting are logged.

    """
    n, moves = len(axes), bodies_move(model)
    bodies = _bodies(model, axes, before, neighbours)
    contacts = _contacts(model, axes, before, neighbours, bodies)
    storage = solve_collisions.current().storage
    after = storage.from_rows(BodyState, bodies.ravel())
    given = Collisions(
        properties=storage.from_rows(ContactProperties, contacts.ravel()),
        law=model.law,
        exponent=model.exponent,
        bodies=storage.from_rows(BodyState, bodies.ravel().copy()),
        moves=moves,
        interval=TIP_DURATION / NORMALS if moves else inf,
        delassus=storage.zeros(1, 1, 1),
        velocity=storage.zeros(1, 1),
        distances=moves,
        lengths=storage.zeros(1, 1),
        tolerance=storage.array(tolerance),
    )
    results, outcomes, log = solve_given(storage, given, after, phases)
    found = as_rows(ContactResult, results).reshape(n, -1)
    ends = as_rows(CollisionOutcome, outcomes)
    left = as_rows(BodyState, after).reshape(bodies.shape)
    balls = left[:, 1 : 1 + before.position.shape[1]]
    state = Meeting(
        balls['position'].copy(),
        balls['velocity'].copy(),
        balls['spin'] / model.surface.radius,
        left['position'][:, 0].copy(),
        (left['velocity'][:, 0] * axes).sum(axis=1),
    )
    lengths = found['length']
    status = ends['status'].copy()
    status[~_settle(model, neighbours, state, before, lengths)] = BUDGET_EXCEEDED
    return Outcome(
        after=state,
        duration=ends['duration'] if moves else np.zeros(n),
        closings=found['closings'],
        impulses=np.stack([found['impulse'], found['impulse_1'], found['impulse_2']], axis=-1),
        losses=np.stack([found['restitution_loss'], found['friction_loss']], axis=-1),
        slips=found['final_slip'],
        first_slip=found['first_slip'][:, TIP],
        lengths=lengths,
        steps=ends['steps'],
        status=status,
        phases=ends['phases'],
        log=read_log(log, np.tile(np.eye(3), (log.shape[1], 1, 1))),
    )


def _bodies(
    model: StrikeModel, axes: Array, before: Meeting, neighbours: Sequence[Neighbour]
) -> NDArray[np.void]:
    """Make the bodies (n, B): tip, balls, the cloth, and what is fixed of each neighbour."""
    n, balls = before.position.shape[:2]
    fixed = sum(each.b == FIXED for each in neighbours)
    ball, rows = model.surface, ROWS.records(BodyState, n * (2 + balls + fixed)).reshape(n, -1)
    tip, ball_rows, cloth = rows[:, 0], rows[:, 1 : 1 + balls], rows[:, 1 + balls]
    tip['kind'], tip['axis'], tip['position'] = TIP_BODY, axes, before.tip
    tip['response'], tip['across'] = 1.0 / model.cue_mass, model.inverse_end_mass
    tip['velocity'] = before.speed[:, np.newaxis] * axes
    ball_rows['kind'], ball_rows['turning'] = BALL, ball.radius**2 / ball.inertia
    ball_rows['response'] = ball_rows['across'] = 1.0 / ball.mass
    ball_rows['position'], ball_rows['velocity'] = before.position, before.velocity
    ball_rows['spin'] = ball.radius * before.spin
    cloth['kind'], cloth['axis'] = PLANE, UP
    cloth['position'] = np.array([0.0, 0.0, 0.0 if model.table else -FAR])
    number = 2 + balls
    for each in neighbours:
        if each.b == FIXED:
            row = rows[:, number]
            row['kind'], row['axis'] = PLANE, UP
            if each.nose is not None:
                row['kind'] = EDGE
                place = before.position[:, each.a]
                row['position'], row['axis'] = edges_near(each.nose, place)
            number += 1
    return rows


def _contacts(
    model: StrikeModel,
    axes: Array,
    before: Meeting,
    neighbours: Sequence[Neighbour],
    bodies: NDArray[np.void],
) -> NDArray[np.void]:
    """Make the contacts (n, N) of the bodies."""
    n, balls = before.position.shape[:2]
    ball, count = model.surface, TABLE + 1 + len(neighbours)
    rows = ROWS.records(ContactProperties, n * count).reshape(n, count)
    scale = tip_stiffness(model) / model.stiffness[TIP] if bodies_move(model) else 1.0
    for j in (TIP, TABLE):
        rows['friction'][:, j], rows['restitution'][:, j] = model.friction[j], model.restitution[j]
        rows['stiffness'][:, j] = scale * model.stiffness[j]
    rows['body_a'][:, TIP], rows['body_b'][:, TIP] = 0, 1
    rows['body_a'][:, TABLE], rows['body_b'][:, TABLE] = 1, 1 + balls
    side = cross_rows(UP, axes)
    side[sizes(side) < rounding.COUPLING] = np.array([0.0, 1.0, 0.0])
    away = before.tip - before.position[:, 0]
    rows['tangent'][:, TIP] = cross_rows(side, away)
    rows['tangent'][:, TABLE] = cross_rows(side, UP)
    rows['tangent'][OTHERS] = UP
    rows['gap'][:, TIP] = sizes(away) - tip_reach(model)
    height = before.position[:, 0, 2] - bodies['position'][:, 1 + balls, 2]
    rows['gap'][:, TABLE] = height - ball.radius
    rows['keeps_normal'][:, TABLE] = True
    rows['max_closings'] = UNLIMITED
    rows['max_closings'][:, TIP] = MAX_HITS if model.follows else 1
    rows['gap'][OTHERS] = gaps_of(neighbours, before.position, ball.radius)
    number = 2 + balls
    for j, each in enumerate(neighbours, TABLE + 1):
        row = rows[:, j]
        row['friction'], row['fading'], row['decay'] = each.friction, each.fading, each.decay
        row['restitution'], row['stiffness'] = each.restitution, each.stiffness
        row['softening'] = 2.0 * each.softening**2 / ball.mass
        row['keeps_normal'] = each.b == FIXED
        row['body_a'], row['body_b'] = 1 + each.a, 1 + each.b
        if each.b == FIXED:
            row['body_b'] = number
            number += 1
    rows['gap'][rows['gap'] <= TOUCHING] = 0.0
    return rows


def _settle(
    model: StrikeModel,
    neighbours: Sequence[Neighbour],
    s: Meeting,
    before: Meeting,
    lengths: Array,
) -> Flags:
    """
    Put balls and cues where they are when nothing is pressed; return (n,) whether they can be.

    If they cannot, the balls are where they were before.
    """
    radius = model.surface.radius
    speed = sizes(s.velocity).max(axis=1, initial=0.0)[:, np.newaxis, np.newaxis]
    s.velocity[np.abs(s.velocity) <= STILL * speed] = 0.0
    s.spin[np.abs(s.spin) * radius <= STILL * speed] = 0.0
    if model.table:  # the cloth gave way; the ball lies on it, or is above it by its distance
        lift = np.maximum(radius - lengths[:, TABLE], radius) - s.position[:, 0, 2]
        s.position[:, 0, 2] += lift
        s.tip[:, 2] += lift
    s.position[:, 1:, 2] = before.position[:, 1:, 2]  # the cloth holds them, or throws them up
    apart = _set_apart(model, neighbours, s)
    s.position[~apart] = before.position[~apart]
    return apart


def _set_apart(model: StrikeModel, neighbours: Sequence[Neighbour], s: Meeting) -> Flags:
    """Move balls sideways out of noses and of each other; return (n,) whether none overlap."""
    radius = model.surface.radius
    solid = [each for each in neighbours if each.nose is not None or each.b != FIXED]
    left: Rows = np.arange(len(s.position) if solid else 0)
    for _ in range(MAX_SWEEPS):
        if not len(left):
            break
        apart = np.ones(len(left), np.bool_)
        for each in solid:
            gap = gaps_of([each], s.position[left], radius)[:, 0]
            apart &= gap >= -0.5 * rounding.PLACE
            rows = left[gap < 0.0]
            way = ways_apart([each], s.position[rows])[:, 0]
            level = way * np.array([1.0, 1.0, 0.0])
            push = level * (sizes(way) / (level**2).sum(axis=1))[:, np.newaxis]
            _move_apart(each, s, rows, push, radius)
        left = left[~apart]
    done = np.ones(len(s.position), np.bool_)
    done[left] = False
    return done


def _move_apart(each: Neighbour, s: Meeting, rows: Rows, push: Array, radius: float) -> None:
    """
    Move a ball, or the two balls of a contact, along `push` so that they touch.

    The tip goes with the cue ball: else such a move would press the one into the other.
    """
    gap = gaps_of([each], s.position[rows], radius)[:, 0]
    change = -gap[:, np.newaxis] * push
    if each.b != FIXED:
        change *= 0.5
        s.position[rows, each.b] -= change
    s.position[rows, each.a] += change
    if each.a == 0:
        s.tip[rows] += change
