"""
Impacts of three bodies or more, and of the cue, all at once, by billiard_shot.impact.

`gather` (gather.py) writes the bodies and contacts of such an impact, `solve` solves it, and
`conclude` lets balls and cue go on. The record shows uniform motion during the impact. For the
strike with which a run begins see strike.py.
"""

from math import inf, sqrt

import numpy as np

from billiard_shot.compiled import inner
from billiard_shot.impact import kernel
from billiard_shot.impact.beginning import Collisions, NO_LIMITS, TipLimits
from billiard_shot.impact.state import BodyState, ContactProperties, PhaseLog
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import dot
from billiard_shot.records import Storage
from billiard_shot.status import BUDGET_EXCEEDED, NEGATIVE_ENERGY, TOLERANCE_NOT_REACHED
from billiard_shot.table.contacts.cushion import advance_free
from billiard_shot.table.contacts.gather import (
    BALL_IMPACT_TOLERANCE,
    ClusterImpact,
    CUE_IMPACT_TOLERANCE,
    ImpactWorkspace,
)
from billiard_shot.table.model.cue import CLOTH_CONTACT, CueRecord, MAX_HITS, TIP_CONTACT
from billiard_shot.table.model.geometry import BallClothParams, TableModel
from billiard_shot.table.model.motion import (
    BallRecord,
    CLUSTER,
    CUE,
    energy_of,
    FLIGHT,
    IMPACT,
    kinetic_energy,
    log_event,
    note_meeting,
    NOTHING,
    position_at,
    Simulation,
    SLIDE,
)
from billiard_shot.table.motion.boundaries import edge_at

MOST_CONTACTS = 6  # per ball: twelve balls around each one
MOST_EDGES = 7  # of a ball in the mouth of a pocket, with the cloth; of at most three balls
MAX_SWEEPS = 100
SEPARATION_GAP = 1e-7  # m, to which balls are set apart
LONGEST_IMPACT = 10e-3  # s: then the cloth would have slowed sliding balls by 0.02 m/s
STILL_SPEED = 1e-12  # of the fastest ball's speed: what rounding leaves of a ball at rest


def room_for(storage: Storage, balls: int, with_cue: bool) -> ImpactWorkspace:
    """Make room for the impacts on a table of so many balls; none for a record of participants."""
    count = min(balls * (balls - 1) // 2, MOST_CONTACTS * balls)
    count += 3 + MOST_EDGES * min(balls, 3) if with_cue else 0
    count = max(count, 1)
    return impact_room(storage, balls, balls + (count if with_cue else 0), count)


def impact_room(storage: Storage, balls: int, bodies: int, count: int) -> ImpactWorkspace:
    """Make room for impacts of so many balls, bodies and contacts."""
    return ImpactWorkspace(
        storage.array(np.zeros(balls, np.int64)),
        kernel.scratch(storage, count),
        storage.records(BodyState, bodies),
        storage.records(ContactProperties, count),
        storage.array(np.zeros(count, np.int64)),
        kernel.Results(
            storage.records(kernel.ContactResult, count),
            storage.records(BodyState, bodies),
            storage.records(PhaseLog, 0),
            storage.records(kernel.CollisionOutcome, 1),
        ),
        losses=storage.zeros(count, 2),
        participants=storage.array(np.zeros((0, 2), np.int64)),
        tolerance=storage.zeros(1),
        unused=storage.zeros(1, 1, 1),
    )


@inner
def solve(table: TableModel, impact: ClusterImpact, room: ImpactWorkspace) -> None:
    """Solve an impact after `gather`."""
    params, with_cue = table.params, impact.with_cue
    room.tolerance[0] = CUE_IMPACT_TOLERANCE if with_cue else BALL_IMPACT_TOLERANCE
    moves = table.cue.moves if with_cue else table.numbers.ball_duration > 0.0
    interval = table.cue.interval if with_cue else inf
    solve_bodies(params, impact, room, moves, interval, 0.0, NO_LIMITS, logs=False)


@inner
def solve_bodies(
    params: BallClothParams,
    impact: ClusterImpact,
    room: ImpactWorkspace,
    moves: bool,
    interval: float,
    swing: float,
    limits: TipLimits,
    logs: bool,
) -> None:
    """Solve the impact of the bodies and contacts of a room, see `Collisions`."""
    work, unused, results = room.scratch, room.unused, room.results
    count = impact.contacts + impact.shafts
    kernel.solve_collisions(
        Collisions(
            room.properties[:count],
            params.law,
            room.bodies[: impact.bodies],
            delassus=unused,
            velocity=unused[0],
            distances=moves,
            lengths=unused[0],
            tolerance=room.tolerance,
            moves=moves,
            interval=interval,
            swing=swing,
            limits=limits,
        ),
        kernel.Scratch(work.contacts[:count], work.workspace, work.progress),
        kernel.Results(
            results.contacts,
            results.bodies,
            results.log[: len(results.log) if logs else 0],
            results.outcomes,
        ),
    )


@inner
def settle(table: TableModel, s: Simulation, impact: ClusterImpact, room: ImpactWorkspace) -> None:
    """
    Stop what only rounding moves, and put balls onto the cloth.

    The cloth gives way to the ball that the cue hits. Afterwards this ball lies on it, or is above
    it by its distance, and the tip moves with it.
    """
    radius, bodies = table.params.radius, room.results.bodies
    fastest = 0.0
    for k in range(impact.members):
        fastest = max(fastest, dot(bodies[k].velocity, bodies[k].velocity))
    still = STILL_SPEED * sqrt(fastest)
    for k in range(impact.members):
        body = bodies[k]
        for i in range(3):
            if abs(body.velocity[i]) <= still:
                body.velocity[i] = 0.0
            if abs(body.spin[i]) <= still:
                body.spin[i] = 0.0
        if k > 0 or not impact.with_cue:
            _, _, z = position_at(s.balls[room.members[k]], impact.begin)
            if z == radius:  # the ball lies, and stays there in `leave_impact`
                body.position[2] = radius
    if impact.with_cue:
        height = max(bodies[0].position[2], radius)
        if table.cue.on_cloth:
            height = max(radius - room.results.contacts[CLOTH_CONTACT].length, radius)
        shift_ball(impact, room, 0, 0.0, 0.0, height - bodies[0].position[2])


@inner
def shift_ball(
    impact: ClusterImpact, room: ImpactWorkspace, member: int, x: float, y: float, z: float
) -> None:
    """Shift a ball, and the tip of the cue with the ball that it hits."""
    place = room.results.bodies[member].position
    place[0] += x
    place[1] += y
    place[2] += z
    if member == 0 and impact.with_cue:
        tip = room.results.bodies[impact.members].position
        tip[0] += x
        tip[1] += y
        tip[2] += z


@inner
def set_apart(table: TableModel, impact: ClusterImpact, room: ImpactWorkspace) -> bool:
    """
    Move balls apart that are still dented, and out of cushions; return whether none overlap then.

    Two balls move by half of what they overlap each, but none into the cloth.
    """
    bodies, radius = room.results.bodies, table.params.radius
    for _ in range(MAX_SWEEPS):
        apart = True
        for a in range(impact.members):
            for b in range(a + 1, impact.members):
                one, other = bodies[a].position, bodies[b].position
                x, y, z = one[0] - other[0], one[1] - other[1], one[2] - other[2]
                square = x * x + y * y + z * z
                if square < 4.0 * radius * radius:
                    size = sqrt(square)
                    share, apart = 0.5 * (2.0 * radius + SEPARATION_GAP - size) / size, False
                    x, y, z = share * x, share * y, share * z
                    shift_ball(impact, room, a, x, y, max(z, radius - one[2]))
                    shift_ball(impact, room, b, -x, -y, max(-z, radius - other[2]))
        for j in range(impact.contacts):
            if room.edges[j] != NOTHING and leave_edge(table, impact, room, j):
                apart = False
        if apart:
            return True
    return False


@inner
def leave_edge(
    table: TableModel, impact: ClusterImpact, room: ImpactWorkspace, contact: int
) -> bool:
    """Move a ball sideways out of the edge of a contact; return whether it was in it."""
    radius, member = table.params.radius, room.properties[contact].body_a
    place = room.results.bodies[member].position
    x, y, away = edge_at(table, room.edges[contact], place[0], place[1])
    up = place[2] - table.numbers.nose_height
    inside = sqrt(max(radius * radius - up * up, 0.0)) - away
    if inside <= 0.5 * rounding.PLACE:
        return False
    inside += SEPARATION_GAP
    shift_ball(impact, room, member, inside * x, inside * y, 0.0)
    return True


@inner
def takes_part(impact: ClusterImpact, room: ImpactWorkspace, member: int) -> bool:
    """Whether a contact of a member closed. The cue hits ball 0 in any case."""
    if member == 0 and impact.with_cue:
        return True
    for j in range(impact.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and member in (c.body_a, c.body_b):
            return True
    return False


@inner
def first_partner(impact: ClusterImpact, room: ImpactWorkspace, member: int) -> int:
    """Ball that a member met: one that began the impact, or the one that it pushed most."""
    found, most = NOTHING, -1.0
    for j in range(impact.contacts):
        c, result = room.properties[j], room.results.contacts[j]
        other = c.body_a + c.body_b - member
        if result.closings == 0 or member not in (c.body_a, c.body_b) or other >= impact.members:
            continue
        ball = room.members[other]
        if ball in (impact.ball, impact.other):
            return ball
        push = dot(result.impulse, result.impulse)
        if push > most:
            found, most = ball, push
    return found


@inner
def leave_impact(
    params: BallClothParams, ball: BallRecord, x: float, y: float, z: float, lasting: float
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
    lies = ball.position[2] == params.radius and z <= params.radius + SEPARATION_GAP
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
def conclude(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    impact: ClusterImpact,
    room: ImpactWorkspace,
) -> None:
    """Let balls and cue go on after an impact is solved; `resume` begins the balls' segments."""
    p, outcome = s.progress, room.results.outcomes[0]
    with_cue, status, lasting = impact.with_cue, outcome.status, 0.0
    settle(table, s, impact, room)
    if set_apart(table, impact, room):
        moves = table.cue.moves if with_cue else table.numbers.ball_duration > 0.0
        lasting = max(outcome.duration - (impact.time - impact.begin), 0.0) if moves else 0.0
        lasting = lasting if lasting <= LONGEST_IMPACT else 0.0
    elif with_cue:
        status = BUDGET_EXCEEDED
    unsolved = status in (BUDGET_EXCEEDED, TOLERANCE_NOT_REACHED)
    if unsolved and not with_cue:
        p.unsolved = status
    elif unsolved or status == NEGATIVE_ENERGY:
        p.flaw = status
    let_go(table, s, impact, room, lasting)
    if with_cue:
        release_cue(s, cues[number], impact, room, lasting)


@inner
def write_exit(params: BallClothParams, ball: BallRecord, body: BodyState) -> float:
    """Write velocity and spin with which a ball leaves an impact; return its kinetic energy."""
    for i in range(3):
        ball.exit_velocity[i], ball.exit_spin[i] = body.velocity[i], body.spin[i] / params.radius
    return kinetic_energy(params, ball.exit_velocity, ball.exit_spin)


@inner
def let_go(
    table: TableModel, s: Simulation, impact: ClusterImpact, room: ImpactWorkspace, lasting: float
) -> None:
    """Let the balls of an impact go on, and log it."""
    p, params, first = s.progress, table.params, s.balls[impact.ball]
    before, after, was = 0.0, 0.0, first.motion
    for k in range(impact.members):
        ball = s.balls[room.members[k]]
        ball.impact = p.events  # of which `predict_collisions` needs to know
        if not takes_part(impact, room, k):
            continue
        advance_free(table, ball, impact.time)
        before += energy_of(params, ball)
        after += write_exit(params, ball, room.results.bodies[k])
        place = room.results.bodies[k].position
        leave_impact(params, ball, place[0], place[1], place[2], lasting)
        if ball.first_contact == NOTHING:
            ball.first_contact = first_partner(impact, room, k)
        if p.participants < len(room.participants):
            room.participants[p.participants][0] = p.events
            room.participants[p.participants][1] = room.members[k]
        p.participants += 1
    note_meetings(s, impact, room)
    cause, other = (CUE, NOTHING) if impact.with_cue else (CLUSTER, impact.other)
    log_event(s, impact.time, cause, first, other, before, after=after, motion=was)


@inner
def note_meetings(s: Simulation, impact: ClusterImpact, room: ImpactWorkspace) -> None:
    """Note which balls ball 0 met in an impact."""
    for j in range(impact.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and max(c.body_a, c.body_b) < impact.members:
            note_meeting(s, room.members[c.body_a], room.members[c.body_b], impact.time)


@inner
def release_cue(
    s: Simulation, cue: CueRecord, impact: ClusterImpact, room: ImpactWorkspace, lasting: float
) -> None:
    """Let the cue go on beside the ball that it hit."""
    p, tip, ball = s.progress, room.results.bodies[impact.members], s.balls[0]
    # An impact that is over by now leaves the ball, and the tip beside it, where the ball is.
    place = room.results.bodies[0].position if lasting > 0.0 else ball.position
    for k in range(3):
        s.cue.position[k] = place[k] + tip.position[k] - room.results.bodies[0].position[k]
        s.cue.velocity[k] = dot(cue.axis, tip.velocity) * cue.axis[k]
    s.cue.time = impact.time + lasting
    p.cue_touches += max(room.results.contacts[TIP_CONTACT].closings, 1)
    if p.cue_touches >= MAX_HITS:
        s.cue.end = impact.time
