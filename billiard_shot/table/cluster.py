"""
Impacts of three balls or more, all at once, by billiard_shot.impact.

The balls take part that are connected to those that meet by gaps within reach of the impact
(contact_duration.py). A cushion does not: its contact is so long that balls meet within it one
after the other.

A simulation stops for such an impact: `gather` writes its balls and contacts, `solve` solves it,
and `conclude` lets its balls go on. In the record each of them moves evenly, while the impact
lasts, to where it is at the end.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import Collisions, ContactProperties
from billiard_shot.impact.kernel import Scratch, solve_collisions
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult, Results
from billiard_shot.impact.solve import scratch
from billiard_shot.impact.state import BALL, BodyState, PhaseLog
from billiard_shot.records import Storage
from billiard_shot.status import BUDGET_EXCEEDED, NEGATIVE_ENERGY, TOLERANCE_NOT_REACHED
from billiard_shot.table.ball_collision import friction_of_balls
from billiard_shot.table.cushion import advance_free
from billiard_shot.table.geometry import Table
from billiard_shot.table.motion import Ball, CLUSTER, FLIGHT, IMPACT, NOTHING, SLIDE
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.simulation_state import (
    energy_of,
    kinetic_energy,
    log_event,
    note_meeting,
    position_at,
    Progress,
    Simulation,
)

TOLERANCE = 1e-7  # of the impact, relative to the approach
MOST_CONTACTS = 6  # per ball: twelve balls around each one
MAX_SWEEPS = 100
CLEARANCE = 1e-7  # m, to which balls are set apart
UNLIMITED = 1_000_000  # closings of a contact
LONGEST = 10e-3  # s: then the cloth would have slowed sliding balls by 0.02 m/s


class ClusterRoom(NamedTuple):
    """Room for an impact of N contacts at most among B balls at most."""

    members: Any  # (B,) ints: the balls that take part
    scratch: Scratch
    bodies: list[BodyState]  # B, and N contacts: parts of `Collisions`
    properties: list[ContactProperties]
    unused: Any  # (1, 1, 1) in place of W
    results: Results
    participants: Any  # (room, 2) ints: number of an event, and a ball that took part in it


def room_for(storage: Storage, balls: int, participants: int) -> ClusterRoom:
    """Make room for the impacts on a table of so many balls, and for a record of participants."""
    count = max(min(balls * (balls - 1) // 2, MOST_CONTACTS * balls), 1)
    return ClusterRoom(
        storage.array(np.zeros(balls, np.int64)),
        scratch(storage, count),
        storage.records(BodyState, balls),
        storage.records(ContactProperties, count),
        storage.zeros(1, 1, 1),
        Results(
            storage.records(ContactResult, count),
            storage.records(BodyState, balls),
            storage.records(PhaseLog, 0),
            storage.records(CollisionOutcome, 1),
        ),
        storage.array(np.zeros((participants, 2), np.int64)),
    )


def solve(storage: Storage, table: Table, p: Progress, room: ClusterRoom) -> None:
    """Solve an impact after `gather`."""
    params, moving = table.params, bool(table.numbers.ball_duration > 0.0)
    collision = Collisions(
        properties=room.properties,
        law=int(params.law),
        exponent=float(params.exponent),
        bodies=room.bodies[: int(p.members)],
        moves=moving,
        interval=inf,
        delassus=room.unused,
        velocity=room.unused[0],
        distances=moving,
        lengths=room.unused[0],
        tolerance=storage.array([TOLERANCE]),
    )
    contacts = room.scratch.contacts[: int(p.contacts)]
    solve_collisions.on(storage)(collision, room.scratch._replace(contacts=contacts), room.results)


@inner
def find_members(s: Simulation, members: Any, reach: float) -> int:
    """Write the balls that take part in an order that is theirs; return their number."""
    p, count = s.progress, len(s.balls)
    for i in range(count):
        members[i] = 1 if i in (p.ball, p.other) else 0
    grows = True
    while grows:
        grows = False
        for i in range(count):
            if members[i] == 1 or s.balls[i].motion > FLIGHT:
                continue
            x, y, z = position_at(s.balls[i], p.time)
            for k in range(count):
                if members[k] == 1:
                    u, v, w = position_at(s.balls[k], p.time)
                    u, v, w = x - u, y - v, z - w
                    if u * u + v * v + w * w <= reach * reach:
                        members[i], grows = 1, True
                        break
    number = 0
    for i in range(count):
        if members[i] == 1:
            members[number] = i
            number += 1
    return number


@inner
def write_ball(params: BallClothParams, ball: Ball, time: float, body: BodyState) -> None:
    """Write a ball of a time as a body, free of any cushion."""
    dt = time - ball.time
    body.kind, body.turning = BALL, params.radius * params.radius / params.inertia
    body.response = body.across = 1.0 / params.mass
    body.position[0], body.position[1], body.position[2] = position_at(ball, time)
    for k in range(3):
        if ball.nose != NOTHING:
            velocity, spin = ball.exit_velocity[k], ball.exit_spin[k]
        else:
            velocity = ball.velocity[k] + ball.acceleration[k] * dt
            spin = ball.spin[k] + ball.spin_acceleration[k] * dt
        body.velocity[k], body.spin[k] = velocity, params.radius * spin


@inner
def gather(table: Table, s: Simulation, room: ClusterRoom) -> None:
    """Write the balls and contacts of an impact that is pending; their numbers to `progress`."""
    p, n, radius = s.progress, table.numbers, table.params.radius
    bodies = room.bodies
    farthest = 2.0 * radius + p.reach
    p.members = find_members(s, room.members, farthest)
    for k in range(p.members):
        write_ball(table.params, s.balls[room.members[k]], p.time, bodies[k])
    stiffness = n.impact_stiffness if n.ball_duration > 0.0 else n.ball_stiffness
    number = 0
    for a in range(p.members):
        for b in range(a + 1, p.members):
            square, one, other = 0.0, bodies[a].position, bodies[b].position
            for k in range(3):
                apart = one[k] - other[k]
                square += apart * apart
            if square > farthest * farthest or number == len(room.properties):
                continue  # there is always room, see MOST_CONTACTS
            gap = sqrt(square) - 2.0 * radius
            if gap <= n.contact_gap or n.ball_duration == 0.0:
                gap = 0.0
            properties = room.properties[number]
            properties.body_a, properties.body_b, properties.gap = a, b, gap
            # Tangents parallel and normal to the cloth: balls that lie on it stay in a plane.
            tangent = properties.tangent
            tangent[0], tangent[1], tangent[2] = other[1] - one[1], one[0] - other[0], 0.0
            properties.max_closings = UNLIMITED
            properties.friction = friction_of_balls(n, 0.0)
            properties.fading, properties.decay = n.friction_slow, n.friction_decay
            properties.restitution, properties.stiffness = n.ball_restitution, stiffness
            number += 1
    p.contacts = number


@inner
def set_apart(bodies: list[BodyState], count: int, diameter: float) -> bool:
    """
    Move balls apart that are still dented, each by half of what they overlap.

    Return whether none overlap in the end.
    """
    for _ in range(MAX_SWEEPS):
        apart = True
        for a in range(count):
            for b in range(a + 1, count):
                one, other = bodies[a].position, bodies[b].position
                square = 0.0
                for k in range(3):
                    away = one[k] - other[k]
                    square += away * away
                if square < diameter * diameter:
                    size = sqrt(square)
                    share = 0.5 * (diameter + CLEARANCE - size) / size
                    apart = False
                    for k in range(3):
                        shift = share * (one[k] - other[k])
                        one[k] += shift
                        other[k] -= shift
        if apart:
            return True
    return False


@inner
def takes_part(p: Progress, room: ClusterRoom, member: int) -> bool:
    """Whether a contact of a member closed."""
    for j in range(p.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and member in (c.body_a, c.body_b):
            return True
    return False


@inner
def first_partner(p: Progress, room: ClusterRoom, member: int) -> int:
    """Ball that a member met first: one that began the impact, or the first by index."""
    found = NOTHING
    for j in range(p.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and member in (c.body_a, c.body_b):
            other = room.members[c.body_a + c.body_b - member]
            if other in (p.ball, p.other):
                return other
            if found == NOTHING or other < found:
                found = other
    return found


@inner
def leave_impact(
    params: BallClothParams, ball: Ball, x: float, y: float, z: float, lasting: float
) -> None:
    """
    Let a ball go on with the exit velocity and spin that an impact gives it.

    If the impact lasts, this begins the segment in which the ball moves evenly to (x, y, z), where
    the impact will end. `resume` begins what follows, or finds what the ball meets meanwhile.
    """
    ball.modified = True
    if lasting == 0.0:
        for k in range(3):
            ball.velocity[k], ball.spin[k] = ball.exit_velocity[k], ball.exit_spin[k]
        return
    lies = ball.position[2] == params.radius and z <= params.radius + CLEARANCE
    ball.motion = SLIDE if lies else FLIGHT
    ball.acceleration[0], ball.acceleration[1] = 0.0, 0.0
    ball.acceleration[2] = 0.0 if lies else -params.gravity
    ball.velocity[0] = (x - ball.position[0]) / lasting
    ball.velocity[1] = (y - ball.position[1]) / lasting
    up = 0.0 if lies else (z - ball.position[2]) / lasting
    ball.velocity[2] = up - 0.5 * ball.acceleration[2] * lasting
    for k in range(3):
        ball.spin_acceleration[k] = (ball.exit_spin[k] - ball.spin[k]) / lasting
    ball.nose, ball.end = IMPACT, ball.time + lasting
    ball.spin_ends, ball.landing_speed = False, 0.0


@inner
def conclude(table: Table, s: Simulation, room: ClusterRoom) -> None:
    """Let the balls of an impact that is solved go on; `resume` begins their segments."""
    p, params, outcome = s.progress, table.params, room.results.outcomes[0]
    bodies = room.results.bodies
    lasting = outcome.duration if table.numbers.ball_duration > 0.0 else 0.0
    for k in range(p.members):
        _, _, z = position_at(s.balls[room.members[k]], p.time)
        if z == params.radius:  # the ball lies, and stays there in `leave_impact`
            bodies[k].position[2] = params.radius
    if lasting > LONGEST or not set_apart(bodies, p.members, 2.0 * params.radius):
        lasting = 0.0
    if outcome.status == BUDGET_EXCEEDED or outcome.status == TOLERANCE_NOT_REACHED:
        p.unsolved = outcome.status
    elif outcome.status == NEGATIVE_ENERGY:
        p.flaw = outcome.status
    before, after, first = 0.0, 0.0, s.balls[p.ball]
    was = first.motion
    for k in range(p.members):
        ball = s.balls[room.members[k]]
        ball.impact = p.events  # of which `predict_collisions` needs to know
        if not takes_part(p, room, k):
            continue
        advance_free(table, ball, p.time)
        before += energy_of(params, ball)
        for i in range(3):
            ball.exit_velocity[i] = bodies[k].velocity[i]
            ball.exit_spin[i] = bodies[k].spin[i] / params.radius
        after += kinetic_energy(params, ball.exit_velocity, ball.exit_spin)
        place = bodies[k].position
        leave_impact(params, ball, place[0], place[1], place[2], lasting)
        if ball.first_contact == NOTHING:
            ball.first_contact = first_partner(p, room, k)
        if p.participants < len(room.participants):
            room.participants[p.participants][0] = p.events
            room.participants[p.participants][1] = room.members[k]
        p.participants += 1
    for j in range(p.contacts):
        if room.results.contacts[j].closings > 0:
            c = room.properties[j]
            note_meeting(s, room.members[c.body_a], room.members[c.body_b], p.time)
    log_event(s, p.time, CLUSTER, first, p.other, before, after, was)
