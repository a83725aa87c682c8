"""
Who takes part in an impact of several bodies, and how these touch.

The balls take part that are connected to those that meet by gaps within reach of the impact. If
the cue hits ball 0, so do its tip, the cloth under ball 0, and the cushions within reach. In an
impact of balls alone a cushion takes no part: its contact is so long that balls meet within it one
after the other.

Bodies are the balls, then tip and cloth, then edges of cushions and, beside these, the cloth under
other balls. The contacts of the cue come first (table/model/cue.py).
"""

from math import sqrt
from typing import Any, NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.kernel import Results, Scratch
from billiard_shot.impact.state import BALL_BODY, BodyState, ContactProperties, EDGE, PLANE
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Floats
from billiard_shot.table.contacts.balls import friction_of_balls
from billiard_shot.table.contacts.cushion import advance_free
from billiard_shot.table.model import motion
from billiard_shot.table.model.cue import (
    CLOTH_CONTACT,
    CueRecord,
    set_cloth,
    set_tip_and_cloth,
    shafts_of,
    THE_CUE,
    TIP_CONTACT,
    write_contact,
    write_fixed,
    write_shaft,
    write_tip,
)
from billiard_shot.table.model.geometry import BallClothParams, GATE_OFF, TableModel
from billiard_shot.table.motion.boundaries import edge_at, FACINGS, HOLES, projects_onto_edge

# Of impacts of balls, and of impacts with the cue, relative to their largest approach speeds.
BALL_IMPACT_TOLERANCE, CUE_IMPACT_TOLERANCE = 1e-7, 1e-9


class ImpactWorkspace(NamedTuple):
    """Room for an impact of N contacts at most."""

    members: Any  # (balls,) ints: the balls that take part
    scratch: Scratch
    bodies: list[BodyState]  # and N contacts: parts of `Collisions`
    properties: list[ContactProperties]
    edges: Any  # (N,) ints: the feature of the table that each contact is with, or NOTHING
    results: Results
    losses: Floats  # (N, 2) J: restitution and friction, in the strike with which the run begins
    participants: Any  # (room, 2) ints: number of an event, and a ball that took part in it
    tolerance: Floats  # (1,) part of `Collisions`
    unused: Floats  # (1, 1, 1) parts of `Collisions` that an impact of bodies does not need


class Meeting(NamedTuple):
    """Bodies that meet, as the beginning of an impact of several."""

    time: float  # s
    ball: int
    other: int  # the ball that it meets, or THE_CUE
    reach: float  # m: balls at so small distances take part


class ClusterImpact(NamedTuple):
    """An impact of several bodies, whose bodies and contacts are in an `ImpactWorkspace`."""

    time: float  # s; this and the next two as of its meeting
    ball: int
    other: int
    with_cue: bool
    begin: float  # s, before its time if ball 0 presses a nose
    members: int  # balls that take part
    bodies: int  # with tip, cloth and edges
    contacts: int
    shafts: int  # contacts beside these, which come last: the shaft of the cue, or none


@inner
def gather(
    table: TableModel,
    s: motion.Simulation,
    cues: list[CueRecord],
    number: int,
    meeting: Meeting,
    room: ImpactWorkspace,
) -> ClusterImpact:
    """
    Write the bodies and contacts of the impact that begins as bodies meet.

    If ball 0 presses a nose when the cue hits it, the impact begins when that began: nose and tip
    then act at once.
    """
    time, first, other, reach = meeting
    begin, with_cue, ball = time, other == THE_CUE, s.balls[first]
    if with_cue:
        if ball.nose == motion.NOTHING or ball.nose == motion.IMPACT:
            advance_free(table, ball, time)
        else:
            begin = ball.time
    members = find_members(table, s, meeting, begin, room.members)
    for k in range(members):
        write_ball(table.params, s.balls[room.members[k]], begin, room.bodies[k])
    bodies, contacts = members, 0
    if with_cue:
        for k in range(3):  # also if it presses a nose
            room.bodies[0].velocity[k] = ball.velocity[k]
            room.bodies[0].spin[k] = table.params.radius * ball.spin[k]
        add_cue(table, s, cues[number], begin, members, room)
        bodies, contacts = members + 2, 2
    contacts = add_pairs(table, room, members, contacts, reach, with_cue)
    if with_cue and not table.numbers.endless:
        for k in range(members):
            bodies, contacts = add_edges(table, room, k, members, bodies, contacts, reach=reach)
    shafts = add_shaft(table, cues[number], members, contacts, room) if with_cue else 0
    return ClusterImpact(time, first, other, with_cue, begin, members, bodies, contacts, shafts)


@inner
def find_members(
    table: TableModel, s: motion.Simulation, meeting: Meeting, begin: float, members: Any
) -> int:
    """Write the balls that take part in an order that is theirs; return their number."""
    count, reach = len(s.balls), 2.0 * table.params.radius + meeting.reach
    for i in range(count):
        members[i] = 1 if i in (meeting.ball, meeting.other) else 0
    grows = table.numbers.pair_gate != GATE_OFF
    while grows:
        grows = False
        for i in range(count):
            if members[i] == 1 or s.balls[i].motion > motion.FLIGHT:
                continue
            x, y, z = motion.position_at(s.balls[i], begin)
            for k in range(count):
                if members[k] == 1:
                    u, v, w = motion.position_at(s.balls[k], begin)
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
def write_ball(
    params: BallClothParams, ball: motion.BallRecord, time: float, body: BodyState
) -> None:
    """Write a ball of a time as a body, free of any cushion."""
    dt = time - ball.time
    body.kind, body.turning = BALL_BODY, params.radius * params.radius / params.inertia
    body.response = body.across = 1.0 / params.mass
    body.position[0], body.position[1], body.position[2] = motion.position_at(ball, time)
    for k in range(3):
        if ball.nose != motion.NOTHING:
            velocity, spin = ball.exit_velocity[k], ball.exit_spin[k]
        else:
            velocity = ball.velocity[k] + ball.acceleration[k] * dt
            spin = ball.spin[k] + ball.spin_acceleration[k] * dt
        body.velocity[k], body.spin[k] = velocity, params.radius * spin


@inner
def connect(
    table: TableModel, room: ImpactWorkspace, contact: int, a: int, b: int, gap: float
) -> None:
    """Write a contact of two bodies at a distance `gap` [m], with the vertical as its tangent."""
    touch = gap <= max(table.numbers.contact_gap, 0.0)
    write_contact(room.properties[contact], a, b, 0.0 if touch else gap)
    room.edges[contact] = motion.NOTHING


@inner
def add_cue(
    table: TableModel,
    s: motion.Simulation,
    cue: CueRecord,
    begin: float,
    members: int,
    room: ImpactWorkspace,
) -> None:
    """Add tip and cloth after the balls, and their contacts with ball 0."""
    q, radius = table.cue, table.params.radius
    ball, tip, cloth = room.bodies[0], room.bodies[members], room.bodies[members + 1]
    write_tip(q, cue.axis, dot(cue.axis, s.cue.velocity), tip)
    write_fixed(cloth, PLANE, 0.0, 0.0, 1.0)
    axes, n = room.scratch.workspace.polynomials, room.scratch.workspace.vector[0]
    for k in range(3):
        tip.position[k] = s.cue.position[k] + (begin - s.cue.time) * s.cue.velocity[k]
        n[k] = tip.position[k] - ball.position[k]
    distance = unit(n, n)
    connect(table, room, TIP_CONTACT, members, 0, distance - q.reach)
    connect(table, room, CLOTH_CONTACT, 0, members + 1, ball.position[2] - radius)
    set_tip_and_cloth(
        q, cue.axis, n, room.properties[TIP_CONTACT], room.properties[CLOTH_CONTACT], axes
    )


@inner
def add_shaft(
    table: TableModel, cue: CueRecord, members: int, contacts: int, room: ImpactWorkspace
) -> int:
    """Add the shaft of the cue after all contacts; return the number of shafts."""
    q, work = table.cue, room.scratch.workspace
    shafts = shafts_of(q)
    if shafts > 0:
        n, ball, tip = work.vector[0], room.bodies[0].position, room.bodies[members].position
        for k in range(3):
            n[k] = tip[k] - ball[k]
        shaft = room.properties[contacts]
        write_shaft(q, cue.axis, n, members, members + 1, shaft, axes=work.polynomials)
    return shafts


@inner
def add_pairs(
    table: TableModel,
    room: ImpactWorkspace,
    members: int,
    contacts: int,
    reach: float,
    with_cue: bool,
) -> int:
    """Add the contacts of balls with each other; return the number of contacts."""
    n, diameter = table.numbers, 2.0 * table.params.radius
    stiffness = n.impact_stiffness if n.ball_duration > 0.0 else n.ball_stiffness
    for a in range(members):
        for b in range(a + 1, members):
            square, one, other = 0.0, room.bodies[a].position, room.bodies[b].position
            for k in range(3):
                apart = one[k] - other[k]
                square += apart * apart
            gap = sqrt(square) - diameter
            if gap > reach or contacts == len(room.properties):
                continue  # there is always room, see MOST_CONTACTS
            moves = with_cue or n.ball_duration > 0.0
            connect(table, room, contacts, a, b, gap if moves else 0.0)
            c = room.properties[contacts]
            contacts += 1
            if not with_cue:
                # Tangents parallel and normal to the cloth: balls that lie on it stay in a plane.
                c.tangent[0], c.tangent[1] = other[1] - one[1], one[0] - other[0]
                c.tangent[2] = 0.0
            c.friction = friction_of_balls(n, 0.0)
            c.fading, c.decay = n.friction_slow, n.friction_decay
            c.restitution, c.exponent = n.ball_restitution, table.params.exponent
            c.stiffness = table.cue.ball_stiffness if with_cue else stiffness
    return contacts


@inner
def add_edges(
    table: TableModel,
    room: ImpactWorkspace,
    member: int,
    members: int,
    bodies: int,
    contacts: int,
    reach: float,
) -> tuple[int, int]:
    """
    Add the edges of cushions that a ball may reach, and the cloth under a ball beside them.

    Return the numbers of bodies and contacts.
    """
    n, radius = table.numbers, table.params.radius
    place = room.bodies[member].position
    x, y, up = place[0], place[1], place[2] - n.nose_height
    if max(abs(x) - n.nose_half_length, abs(y) - n.nose_half_width) + radius + reach < 0.0:
        return bodies, contacts
    found = False
    for feature in range(HOLES if len(table.jaws) > 0 else FACINGS):
        u, v, away = edge_at(table, feature, x, y)
        gap = sqrt(away * away + up * up) - radius
        if away <= 0.0 or gap > reach or not projects_onto_edge(table, feature, x, y):
            continue
        if contacts == len(room.properties):
            continue  # there is always room, see MOST_EDGES
        edge = room.bodies[bodies]
        write_fixed(edge, EDGE, -v, u, 0.0)
        edge.position[0], edge.position[1] = x - u * away, y - v * away
        edge.position[2] = n.nose_height
        connect(table, room, contacts, member, bodies, gap)
        room.edges[contacts] = feature
        c = room.properties[contacts]
        bodies, contacts, found = bodies + 1, contacts + 1, True
        c.friction, c.restitution = n.cushion_friction, n.cushion_restitution
        c.early_softening = n.cushion_early_fading * sqrt(2.0 / table.params.mass)
        c.softening = 2.0 * n.cushion_fading * n.cushion_fading / table.params.mass
        c.stiffness, c.exponent = table.cue.nose_stiffness, table.params.exponent
        c.keeps_normal = True
    if found and member > 0 and contacts < len(room.properties):
        connect(table, room, contacts, member, members + 1, place[2] - radius)
        set_cloth(table.cue, room.properties[contacts])
        contacts += 1
    return bodies, contacts
