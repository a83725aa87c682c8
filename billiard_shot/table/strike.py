"""
The strike with which the run of a table begins: the impact of cue, ball 0, cloth, and others.

The tip presses the ball for about a millisecond. Meanwhile the ball may reach other balls or a
cushion, or meet the tip or the cloth more than once. Then it is an impact of moving bodies
(gather.py), with the distances and normals of each moment. So is every steep strike. Else the
normals are those of the first touch, as in the paper.

Under other laws than `bistiffness` bodies stay in place: only this law defines how contacts close
again. All contacts then take part that touch at first, and the tip meets the ball once.

In the record a strike takes no time: the run begins at its end.
"""

from math import inf

from billiard_shot.compiled import inner
from billiard_shot.impact.state import BALL_BODY, PLANE
from billiard_shot.numerics.vectors import dot
from billiard_shot.status import BUDGET_EXCEEDED
from billiard_shot.table.ball_impact import collide_fixed
from billiard_shot.table.cluster import (
    first_partner,
    note_meetings,
    set_apart,
    settle,
    solve_bodies,
    takes_part,
)
from billiard_shot.table.cue import (
    chatters,
    CueParams,
    CueRecord,
    follow_through_time,
    LONGEST_SWING,
    THE_CUE,
)
from billiard_shot.table.cue_impact import (
    CLOTH_CONTACT,
    set_tip_and_cloth,
    shafts_of,
    TIP_CONTACT,
    write_contact,
    write_fixed,
    write_shaft,
    write_tip,
)
from billiard_shot.table.gather import (
    ClusterImpact,
    CUE_IMPACT_TOLERANCE,
    gather,
    ImpactRoom,
    Meeting,
)
from billiard_shot.table.geometry import TableModel
from billiard_shot.table.motion import BALL, REST
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.simulation_state import energy_of, log_event, Simulation

# Slip that makes a miscue until the tip presses the ball most, and in all, relative to the way of
# a cue in a central hit. At 2 m/s and 1.3 ms these are 0.2 and 1 mm. Grip fades with the pressure:
# the tip slips as it leaves a ball that the cloth still pushes, and nobody calls that a miscue.
MISCUE_TO_PEAK, MISCUE_IN_ALL = 0.077, 0.38


@inner
def strike(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    room: ImpactRoom,
) -> None:
    """
    Let the cue of a table strike ball 0.

    If others are near or the stroke is steep, bodies move at first. If it is not steep, and the
    ball reaches no others, normals stay. If tip or cloth then meet the ball again, bodies move
    after all; so they do in a miscue with a shaft, whose tip often meets the ball again.
    """
    q, cue = table.cue, cues[number]
    near = cue.others
    # The tip of a faster cue goes through a good part of the ball, where it has no normal.
    slow = cue.speed * q.tip_duration < table.params.radius
    tolerance = CUE_IMPACT_TOLERANCE if near else min(cue.tolerance, CUE_IMPACT_TOLERANCE)
    steep = slow and -cue.axis[2] >= q.normals_move_from
    impact, moving = steady_impact(q), near or steep
    if moving:
        impact = solve_near(table, s, cues, number, room, tolerance)
    if not steep and not (moving and reaches_others(impact, room)):
        impact = steady_impact(q)
        solve_steady(table, cue, impact, room)
        again = repeats(room) or (impact.shafts > 0 and miscues(q, cue, room))
        moving = q.follow_through > 0.0 and q.moves and again
        if moving:
            impact = solve_near(table, s, cues, number, room, tolerance)
    cue.others = reaches_others(impact, room)
    end_strike(table, s, cue, impact, room, moving)
    cue.strikes = False


@inner
def solve_near(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    room: ImpactRoom,
    tolerance: float,
) -> ClusterImpact:
    """Solve a strike as an impact of all bodies that are near."""
    q, params = table.cue, table.params
    meeting = Meeting(0.0, 0, THE_CUE, q.neighbour_reach)
    impact = gather(table, s, cues, number, meeting, room)
    room.tolerance[0] = tolerance
    solve_bodies(params, impact, room, q.moves, q.interval, swing_time(q), logs=True)
    return impact


@inner
def steady_impact(q: CueParams) -> ClusterImpact:
    """Return the impact of tip, cloth and ball 0 alone, whose contacts keep their normals."""
    return ClusterImpact(
        0.0, 0, THE_CUE, True, 0.0, members=1, bodies=3, contacts=2, shafts=shafts_of(q)
    )


@inner
def swing_time(q: CueParams) -> float:
    """How long the end of a cue with a shaft, that may hit again, swings at most [s]."""
    swings = q.moves and q.follow_through > 0.0 and shafts_of(q) > 0
    return LONGEST_SWING if swings else 0.0


@inner
def solve_steady(
    table: TableModel, cue: CueRecord, impact: ClusterImpact, room: ImpactRoom
) -> None:
    """Solve the impact of `steady_impact`."""
    q, params, n = table.cue, table.params, cue.normal
    ball, tip, cloth = room.bodies[0], room.bodies[1], room.bodies[2]
    upper, lower = room.properties[TIP_CONTACT], room.properties[CLOTH_CONTACT]
    write_contact(upper, 1, 0, 0.0)
    write_contact(lower, 0, 2, 0.0)
    set_tip_and_cloth(q, cue.axis, n, upper, lower, room.scratch.workspace.polynomials)
    if impact.shafts > 0:
        shaft, axes = room.properties[impact.contacts], room.scratch.workspace.polynomials
        write_shaft(q, cue.axis, n, 1, 2, shaft, axes=axes)
    write_tip(q, cue.axis, cue.speed, tip)
    write_fixed(cloth, PLANE, 0.0, 0.0, 1.0)
    cloth.position[2] = -params.radius
    write_fixed(ball, BALL_BODY, 0.0, 0.0, 0.0)
    ball.response = ball.across = 1.0 / params.mass
    ball.turning = params.radius * params.radius / params.inertia
    for k in range(3):
        tip.position[k] = q.reach * n[k]
    room.members[0], room.tolerance[0] = 0, cue.tolerance
    solve_bodies(params, impact, room, False, inf, swing_time(q), logs=True)


@inner
def repeats(room: ImpactRoom) -> bool:
    """Whether tip or cloth meet the ball again."""
    results = room.results.contacts
    return max(results[TIP_CONTACT].closings, results[CLOTH_CONTACT].closings) > 1


@inner
def miscues(q: CueParams, cue: CueRecord, room: ImpactRoom) -> bool:
    """Whether the tip slid too far in its first hit; the cue has the speed of the stroke."""
    tip, way = room.results.contacts[TIP_CONTACT], cue.speed * q.tip_duration
    return tip.slid_to_peak > MISCUE_TO_PEAK * way or tip.slid > MISCUE_IN_ALL * way


@inner
def reaches_others(impact: ClusterImpact, room: ImpactRoom) -> bool:
    """Whether a contact closed beside those of tip and cloth with ball 0."""
    closings = 0
    for j in range(CLOTH_CONTACT + 1, impact.contacts):
        closings += room.results.contacts[j].closings
    return closings > 0


@inner
def end_strike(
    table: TableModel,
    s: Simulation,
    cue: CueRecord,
    impact: ClusterImpact,
    room: ImpactRoom,
    moving: bool,
) -> None:
    """
    Let balls and cue begin as a strike leaves them.

    A ball that reached no others begins where it was struck.
    """
    q, params = table.cue, table.params
    ball, bodies, moved = s.balls[0], room.results.bodies, False
    if moving:
        settle(table, s, impact, room)
        moved = set_apart(table, impact, room)
        if not moved:
            room.results.outcomes[0].status = BUDGET_EXCEEDED
    moved = moved and cue.others
    for k in range(impact.members):
        if not takes_part(impact, room, k):
            continue
        one, body = s.balls[room.members[k]], bodies[k]
        one.first_contact = first_partner(impact, room, k)
        for i in range(3):
            one.velocity[i], one.spin[i] = body.velocity[i], body.spin[i] / params.radius
            if moved:
                one.position[i] = body.position[i]
    log_meetings(params, s, impact, room)
    if moving and q.on_cloth and not cue.others and ball.velocity[2] < 0.0:
        # it came back to the cloth meanwhile, and leaves it again
        bounce, friction = params.cloth_restitution, params.cloth_friction
        collide_fixed(params, ball, 0.0, 0.0, 1.0, bounce, friction=friction)
    note_strike(q, cue, impact, room, moving)
    for k in range(3):
        cue.velocity[k], cue.spin[k] = ball.velocity[k], ball.spin[k]
        cue.tip[k] = ball.position[k] + bodies[impact.members].position[k] - bodies[0].position[k]
        s.cue.position[k], s.cue.velocity[k] = cue.tip[k], cue.speed * cue.axis[k]
    s.cue.end = cue.end
    if not q.on_cloth:  # a ball that would go down is put onto the cloth
        ball.velocity[2] = max(ball.velocity[2], 0.0)


@inner
def log_meetings(
    params: BallClothParams, s: Simulation, impact: ClusterImpact, room: ImpactRoom
) -> None:
    """Log the meetings of balls in a strike as events that take and lose no energy."""
    note_meetings(s, impact, room)
    for j in range(impact.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and max(c.body_a, c.body_b) < impact.members:
            one, other = s.balls[room.members[c.body_a]], s.balls[room.members[c.body_b]]
            energy = energy_of(params, one) + energy_of(params, other)
            log_event(s, impact.time, BALL, one, other.ball, energy, after=energy, motion=REST)


@inner
def note_strike(
    q: CueParams, cue: CueRecord, impact: ClusterImpact, room: ImpactRoom, moving: bool
) -> None:
    """
    Write the outcome of a strike into the record of its cue, whose speed is that of the stroke.

    The slip that makes a miscue is that of the first hit.
    """
    outcome, contacts = room.results.outcomes[0], room.results.contacts
    tip, cloth = contacts[TIP_CONTACT], contacts[CLOTH_CONTACT]
    cue.status, cue.miscue = outcome.status, miscues(q, cue, room)
    cue.tip_time, cue.cloth_time = tip.touched, cloth.touched
    cue.phases, cue.steps, cue.contacts = outcome.phases, outcome.steps, impact.contacts
    cue.hits = max(tip.closings, 1) if moving else 1
    cue.chatter = cue.hits > 1 and not cue.others and chatters(tip.began, -cloth.length)
    cue.double_hit = 0.0 if cue.hits > 1 and not cue.chatter else inf
    cue.discontinuity_margin = min(tip.discontinuity_margin, cloth.discontinuity_margin)
    cue.impulses[0], cue.impulses[1], cue.impulses[2] = tip.impulse, tip.impulse_1, tip.impulse_2
    cue.impulses[3], cue.impulses[4] = cloth.impulse, cloth.impulse_1
    cue.impulses[5] = cloth.impulse_2
    for j in range(impact.contacts):
        losses = room.losses[j]
        losses[0], losses[1] = contacts[j].restitution_loss, contacts[j].friction_loss
        if j <= CLOTH_CONTACT:
            cue.losses[2 * j], cue.losses[2 * j + 1] = losses[0], losses[1]
    cue.speed = dot(cue.axis, room.results.bodies[impact.members].velocity)
    cue.end = follow_through_time(q.follow_through, cue.speed)
