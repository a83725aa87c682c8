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
from billiard_shot.impact.moving_balls import (
    PLACE,
    place_contact,
    push_balls,
    SPIN,
    VELOCITY,
    write_contact_motion,
)
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult, Results
from billiard_shot.impact.solve import scratch
from billiard_shot.impact.state import Balls, NO_BALLS, PhaseLog
from billiard_shot.records import Floats, Storage
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
LONGEST = 10e-3  # s: then the cloth would have slowed sliding balls by 0.02 m/s


class ClusterRoom(NamedTuple):
    """Room for an impact of N contacts at most among B balls at most."""

    members: Any  # (B,) ints: the balls that take part
    scratch: Scratch  # whose workspace has a matrix of `motion` for each member
    properties: list[ContactProperties]  # N, and further parts of `Collisions`
    delassus: Any  # (1, 3 N, 3 N)
    velocity: Any  # (1, 3 N)
    lengths: Any  # (1, N)
    results: Results
    participants: Any  # (room, 2) ints: number of an event, and a ball that took part in it


def room_for(storage: Storage, balls: int, participants: int) -> ClusterRoom:
    """Make room for the impacts on a table of so many balls, and for a record of participants."""
    count = max(min(balls * (balls - 1) // 2, MOST_CONTACTS * balls), 1)
    zeros = storage.zeros
    return ClusterRoom(
        storage.array(np.zeros(balls, np.int64)),
        scratch(storage, count),
        storage.records(ContactProperties, count),
        zeros(1, 3 * count, 3 * count),
        zeros(1, 3 * count),
        zeros(1, count),
        Results(
            storage.records(ContactResult, count),
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
        delassus=room.delassus,
        velocity=room.velocity,
        distances=moving,
        lengths=room.lengths,
        until=inf,
        balls=balls_of(params, int(p.members)) if moving else NO_BALLS,
        tolerance=storage.array([TOLERANCE]),
    )
    contacts = room.scratch.contacts[: int(p.contacts)]
    solve_collisions.on(storage)(collision, room.scratch._replace(contacts=contacts), room.results)


@inner
def balls_of(params: BallClothParams, count: int) -> Balls:
    """Describe equal balls to the solver."""
    return Balls(count, 1.0 / params.mass, params.radius * params.radius / params.inertia)


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
def write_motion(ball: Ball, time: float, radius: float, motion: Floats) -> None:
    """Write where a ball is at a time, velocity and spin times radius; free of any cushion."""
    dt = time - ball.time
    motion[PLACE][0], motion[PLACE + 1][0], motion[PLACE + 2][0] = position_at(ball, time)
    for k in range(3):
        if ball.nose != NOTHING:
            velocity, spin = ball.exit_velocity[k], ball.exit_spin[k]
        else:
            velocity = ball.velocity[k] + ball.acceleration[k] * dt
            spin = ball.spin[k] + ball.spin_acceleration[k] * dt
        motion[VELOCITY + k][0], motion[SPIN + k][0] = velocity, radius * spin


@inner
def gather(table: Table, s: Simulation, room: ClusterRoom) -> None:
    """Write the balls and contacts of an impact that is pending; their numbers to `progress`."""
    p, n, radius = s.progress, table.numbers, table.params.radius
    contacts, ws = room.scratch.contacts, room.scratch.workspace
    motion = ws.motion
    farthest = 2.0 * radius + p.reach
    p.members = find_members(s, room.members, farthest)
    for k in range(p.members):
        write_motion(s.balls[room.members[k]], p.time, radius, motion[k])
    balls = balls_of(table.params, p.members)
    stiffness = n.impact_stiffness if n.ball_duration > 0.0 else n.ball_stiffness
    number = 0
    for a in range(p.members):
        for b in range(a + 1, p.members):
            square = 0.0
            for k in range(3):
                apart = motion[a][PLACE + k][0] - motion[b][PLACE + k][0]
                square += apart * apart
            if square > farthest * farthest or number == len(contacts):
                continue  # there is always room, see MOST_CONTACTS
            gap = sqrt(square) - 2.0 * radius
            if gap <= n.contact_gap or n.ball_duration == 0.0:
                gap = 0.0
            c, properties = contacts[number], room.properties[number]
            c.ball_a, c.ball_b = a, b
            c.impulse, c.impulse_1, c.impulse_2 = 0.0, 0.0, 0.0
            place_contact(contacts, motion, ws.polynomials, number, gap)
            properties.friction = friction_of_balls(n, 0.0)
            properties.fading, properties.decay = n.friction_slow, n.friction_decay
            properties.restitution, properties.stiffness = n.ball_restitution, stiffness
            room.lengths[0][number] = -gap
            number += 1
    p.contacts = number
    write_contact_motion(balls, contacts[:number], motion, room.velocity[0], room.delassus[0])


@inner
def set_apart(motion: Floats, count: int, diameter: float) -> bool:
    """
    Move balls apart that are still dented, each by half of what they overlap.

    Return whether none overlap in the end.
    """
    for _ in range(MAX_SWEEPS):
        apart = True
        for a in range(count):
            for b in range(a + 1, count):
                one, other = motion[a], motion[b]
                square = 0.0
                for k in range(3):
                    away = one[PLACE + k][0] - other[PLACE + k][0]
                    square += away * away
                if square < diameter * diameter:
                    size = sqrt(square)
                    share = 0.5 * (diameter + CLEARANCE - size) / size
                    apart = False
                    for k in range(3):
                        shift = share * (one[PLACE + k][0] - other[PLACE + k][0])
                        one[PLACE + k][0] += shift
                        other[PLACE + k][0] -= shift
        if apart:
            return True
    return False


@inner
def push_in_place(table: Table, p: Progress, room: ClusterRoom) -> None:
    """Add the impulses of an impact that takes no time to the velocities of its balls."""
    contacts, ws = room.scratch.contacts, room.scratch.workspace
    balls, impulses = balls_of(table.params, p.members), ws.vector[0]
    for j in range(p.contacts):
        result = room.results.contacts[j]
        impulses[0], impulses[1] = result.impulse, result.impulse_1
        impulses[2] = result.impulse_2
        push_balls(balls, contacts[j], ws.motion, impulses, 0)


@inner
def takes_part(p: Progress, room: ClusterRoom, member: int) -> bool:
    """Whether a contact of a member closed."""
    for j in range(p.contacts):
        c = room.scratch.contacts[j]
        if room.results.contacts[j].impulse != 0.0 and member in (c.ball_a, c.ball_b):
            return True
    return False


@inner
def first_partner(p: Progress, room: ClusterRoom, member: int) -> int:
    """Ball that a member met first: one that began the impact, or the first by index."""
    found = NOTHING
    for j in range(p.contacts):
        c = room.scratch.contacts[j]
        if room.results.contacts[j].impulse != 0.0 and member in (c.ball_a, c.ball_b):
            other = room.members[c.ball_a + c.ball_b - member]
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
    motion = room.scratch.workspace.motion
    lasting = outcome.duration if table.numbers.ball_duration > 0.0 else 0.0
    if table.numbers.ball_duration == 0.0:
        push_in_place(table, p, room)
    for k in range(p.members):
        _, _, z = position_at(s.balls[room.members[k]], p.time)
        if z == params.radius:  # the ball lies, and stays there in `leave_impact`
            motion[k][PLACE + 2][0] = params.radius
    if lasting > LONGEST or not set_apart(motion, p.members, 2.0 * params.radius):
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
            ball.exit_velocity[i] = motion[k][VELOCITY + i][0]
            ball.exit_spin[i] = motion[k][SPIN + i][0] / params.radius
        after += kinetic_energy(params, ball.exit_velocity, ball.exit_spin)
        place = motion[k]
        x, y, z = place[PLACE][0], place[PLACE + 1][0], place[PLACE + 2][0]
        leave_impact(params, ball, x, y, z, lasting)
        if ball.first_contact == NOTHING:
            ball.first_contact = first_partner(p, room, k)
        if p.participants < len(room.participants):
            room.participants[p.participants][0] = p.events
            room.participants[p.participants][1] = room.members[k]
        p.participants += 1
    for j in range(p.contacts):
        if room.results.contacts[j].impulse != 0.0:
            c = room.scratch.contacts[j]
            note_meeting(s, room.members[c.ball_a], room.members[c.ball_b], p.time)
    log_event(s, p.time, CLUSTER, first, p.other, before, after, was)
