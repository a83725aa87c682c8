"""
The strike with which the run of a table begins: the impact of cue, ball 0, cloth, and others.

The tip presses the ball for about a millisecond. Meanwhile the ball may reach other balls or a
cushion, or meet the tip or the cloth more than once: a strike is an impact of moving bodies
(gather.py), with the distances and normals of each moment.

Under other laws than `bistiffness` bodies stay in place, as in the paper: only this law defines
how contacts close again. All contacts then take part that touch at first, and the tip meets the
ball once.

In the record a strike takes no time: the run begins at its end.
"""

from math import inf

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import NO_LIMITS, TipLimits
from billiard_shot.numerics.vectors import dot
from billiard_shot.status import BUDGET_EXCEEDED, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.contacts import cluster
from billiard_shot.table.contacts.gather import (
    ClusterImpact,
    CUE_IMPACT_TOLERANCE,
    gather,
    ImpactWorkspace,
    Meeting,
)
from billiard_shot.table.model.cue import (
    CHATTER_HEIGHT,
    CHATTER_TIME,
    chatters,
    CLOTH_CONTACT,
    CueParams,
    CueRecord,
    follow_through_time,
    LONGEST_SWING,
    shafts_of,
    THE_CUE,
    TIP_CONTACT,
)
from billiard_shot.table.model.geometry import BallClothParams, TableModel
from billiard_shot.table.model.motion import BALL, energy_of, log_event, REST, Simulation
from billiard_shot.table.motion.ball_impact import collide_fixed

# Slip that makes a miscue until the tip presses the ball most, and in all, relative to the way of
# a cue in a central hit. At 2 m/s and 1.3 ms these are 0.2 and 1 mm. Grip fades with the pressure:
# the tip slips as it leaves a ball that the cloth still pushes, and nobody calls that a miscue.
MISCUE_TO_PEAK, MISCUE_IN_ALL = 0.077, 0.38


@inner
def strike(
    table: TableModel, s: Simulation, cues: list[CueRecord], number: int, room: ImpactWorkspace
) -> None:
    """Let the cue of a table strike ball 0; others that it does not reach take no part."""
    cue = cues[number]
    impact = solve_strike(table, s, cues, number, room)
    if cue.others and not reaches_others(impact, room):
        cue.others = False
        impact = solve_strike(table, s, cues, number, room)
    end_strike(table, s, cue, impact, room)
    cue.strikes = False


@inner
def solve_strike(
    table: TableModel, s: Simulation, cues: list[CueRecord], number: int, room: ImpactWorkspace
) -> ClusterImpact:
    """Solve a strike as an impact of cue, ball 0, cloth, and the others that may take part."""
    q, cue = table.cue, cues[number]
    reach = q.neighbour_reach if cue.others else -table.params.radius  # nothing is so near
    impact = gather(table, s, cues, number, Meeting(0.0, 0, THE_CUE, reach), room)
    room.tolerance[0] = CUE_IMPACT_TOLERANCE if cue.others else cue.tolerance
    limits = tip_limits(q, cue) if len(s.rules) > 0 else NO_LIMITS
    swing = swing_time(q)
    cluster.solve_bodies(table.params, impact, room, q.moves, q.interval, swing, limits, logs=True)
    return impact


@inner
def tip_limits(q: CueParams, cue: CueRecord) -> TipLimits:
    """
    Return the limits beyond which the strike of a trial has failed.

    Near others, only the end tells whether a second hit is chatter.
    """
    way = cue.speed * q.tip_duration
    again, lifted = (inf, inf) if cue.others else (CHATTER_TIME, CHATTER_HEIGHT)
    return TipLimits(MISCUE_TO_PEAK * way, MISCUE_IN_ALL * way, again, lifted)


@inner
def swing_time(q: CueParams) -> float:
    """How long the end of a cue with a shaft, that may hit again, swings at most [s]."""
    swings = q.moves and q.follow_through > 0.0 and shafts_of(q) > 0
    return LONGEST_SWING if swings else 0.0


@inner
def miscues(q: CueParams, cue: CueRecord, room: ImpactWorkspace) -> bool:
    """Whether the tip slid too far in its first hit; the cue has the speed of the stroke."""
    tip, way = room.results.contacts[TIP_CONTACT], cue.speed * q.tip_duration
    return tip.slid_to_peak > MISCUE_TO_PEAK * way or tip.slid > MISCUE_IN_ALL * way


@inner
def reaches_others(impact: ClusterImpact, room: ImpactWorkspace) -> bool:
    """Whether a contact closed beside those of tip and cloth with ball 0."""
    closings = 0
    for j in range(CLOTH_CONTACT + 1, impact.contacts):
        closings += room.results.contacts[j].closings
    return closings > 0


@inner
def end_strike(
    table: TableModel, s: Simulation, cue: CueRecord, impact: ClusterImpact, room: ImpactWorkspace
) -> None:
    """
    Let balls and cue begin as a strike leaves them.

    A ball that reached no others begins where it was struck.
    """
    q, params = table.cue, table.params
    ball, bodies = s.balls[0], room.results.bodies
    cluster.settle(table, s, impact, room)
    apart = cluster.set_apart(table, impact, room)
    if not apart:
        room.results.outcomes[0].status = BUDGET_EXCEEDED
    for k in range(impact.members):
        if not cluster.takes_part(impact, room, k):
            continue
        one, body = s.balls[room.members[k]], bodies[k]
        one.first_contact = cluster.first_partner(impact, room, k)
        for i in range(3):
            one.velocity[i], one.spin[i] = body.velocity[i], body.spin[i] / params.radius
            if cue.others and apart:
                one.position[i] = body.position[i]
    log_meetings(params, s, impact, room)
    if q.moves and q.on_cloth and not cue.others and ball.velocity[2] < 0.0:
        # it came back to the cloth meanwhile, and leaves it again
        bounce, friction = params.cloth_restitution, params.cloth_friction
        collide_fixed(params, ball, 0.0, 0.0, 1.0, bounce, friction=friction)
    note_strike(params, q, cue, impact, room)
    for k in range(3):
        cue.velocity[k], cue.spin[k] = ball.velocity[k], ball.spin[k]
        cue.tip[k] = ball.position[k] + bodies[impact.members].position[k] - bodies[0].position[k]
        s.cue.position[k], s.cue.velocity[k] = cue.tip[k], cue.speed * cue.axis[k]
    s.cue.end = cue.end
    if not q.on_cloth:  # a ball that would go down is put onto the cloth
        ball.velocity[2] = max(ball.velocity[2], 0.0)


@inner
def log_meetings(
    params: BallClothParams, s: Simulation, impact: ClusterImpact, room: ImpactWorkspace
) -> None:
    """Log the meetings of balls in a strike as events that take and lose no energy."""
    cluster.note_meetings(s, impact, room)
    for j in range(impact.contacts):
        c = room.properties[j]
        if room.results.contacts[j].closings > 0 and max(c.body_a, c.body_b) < impact.members:
            one, other = s.balls[room.members[c.body_a]], s.balls[room.members[c.body_b]]
            energy = energy_of(params, one) + energy_of(params, other)
            log_event(s, impact.time, BALL, one, other.ball, energy, after=energy, motion=REST)


@inner
def note_strike(
    params: BallClothParams,
    q: CueParams,
    cue: CueRecord,
    impact: ClusterImpact,
    room: ImpactWorkspace,
) -> None:
    """
    Write the outcome of a strike into the record of its cue, whose speed is that of the stroke.

    The slip that makes a miscue is that of the first hit.
    """
    outcome, contacts = room.results.outcomes[0], room.results.contacts
    tip, cloth = contacts[TIP_CONTACT], contacts[CLOTH_CONTACT]
    cue.status, cue.miscue = outcome.status, miscues(q, cue, room)
    if q.moves and cue.speed * q.tip_duration > params.radius and cue.status == OK:
        # the tip goes through a good part of the ball, which no spring describes
        cue.status, cue.drift = TOLERANCE_NOT_REACHED, cue.speed
    cue.tip_time, cue.cloth_time = tip.touched, cloth.touched
    cue.phases, cue.steps, cue.contacts = outcome.phases, outcome.steps, impact.contacts
    cue.hits = max(tip.closings, 1) if q.moves else 1
    cue.chatter = cue.hits > 1 and not cue.others and chatters(tip.began, tip.lifted)
    cue.double_hit = 0.0 if cue.hits > 1 and not cue.chatter else inf
    cue.discontinuity_margin = min(tip.discontinuity_margin, cloth.discontinuity_margin)
    for k in range(3):
        cue.impulses[k], cue.impulses[3 + k] = tip.impulse[k], cloth.impulse[k]
    for j in range(impact.contacts):
        losses = room.losses[j]
        losses[0], losses[1] = contacts[j].restitution_loss, contacts[j].friction_loss
        if j <= CLOTH_CONTACT:
            cue.losses[2 * j], cue.losses[2 * j + 1] = losses[0], losses[1]
    cue.speed = dot(cue.axis, room.results.bodies[impact.members].velocity)
    cue.end = follow_through_time(q.follow_through, cue.speed)
