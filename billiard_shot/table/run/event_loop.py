"""
A table that is simulated to its end: event by event, in the order of their times.

If times are equal the order is: ends of segments, then what balls meet of the table, then what
balls meet, each in the order of the balls; and last the cue. Three or more bodies in touch are one
event (cluster.py). That order, and nothing else, decides; so runs are the same to the bit.
"""

import math
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.records import Floats
from billiard_shot.status import BUDGET_EXCEEDED, NEVER_RESTS, OFF_TABLE, OK
from billiard_shot.table.contacts import balls, cushion
from billiard_shot.table.contacts.cluster import conclude, solve
from billiard_shot.table.contacts.gather import gather, ImpactWorkspace, Meeting
from billiard_shot.table.model.cue import chatters, CueRecord, THE_CUE
from billiard_shot.table.model.geometry import (
    BallClothParams,
    GATE_AUTO,
    GATE_OFF,
    reach_of_impact,
    TableModel,
)
from billiard_shot.table.model.motion import (
    advance_ball,
    BALL,
    BallRecord,
    BallRule,
    CLUSTER,
    CUE,
    CUSHION,
    energy_of,
    FLIGHT,
    FROZEN,
    IMPACT,
    kinetic_energy,
    LEFT_TABLE,
    log_event,
    log_segment,
    note_meeting,
    NOTHING,
    OWN,
    POCKET,
    POCKETED,
    position_at,
    RELEASE,
    REST,
    ROLL,
    ROLL_ON,
    Simulation,
    START,
    stop_ball,
    touches_another,
    WENT_OFF,
)
from billiard_shot.table.motion import cloth
from billiard_shot.table.motion.ball_impact import collide_fixed, MIN_APPROACH_SPEED
from billiard_shot.table.motion.boundaries import ARCS, FACINGS, HOLES, lands_off_table, OUTSIDE
from billiard_shot.table.motion.flight import bounce_on_cloth, lumped_bounce_error, take_off


@inner
def start_segment(params: BallClothParams, ball: BallRecord, tolerance: float) -> float:
    """
    Find what a ball does from now on: motion, accelerations, end. Return the error made [m].

    `tolerance` [m] is for leaving out small bounces.
    """
    for i in range(3):
        ball.acceleration[i] = 0.0
        ball.spin_acceleration[i] = 0.0
    ball.spin_ends = False
    ball.landing_speed = 0.0
    flies, error = take_off(params, ball, tolerance)
    if not flies:
        cloth.start_cloth_motion(params, ball)
    return error


@inner
def end_segment(params: BallClothParams, ball: BallRecord) -> None:
    """Follow a ball's segment to its end, and make the change that ends it."""
    advance_ball(ball, ball.end)
    if ball.motion == FLIGHT:
        bounce_on_cloth(params, ball)
        ball.cause = OWN
    else:
        ball.cause = ROLL_ON if cloth.snap_to_segment_end(params, ball) else OWN


# Bounces are lumped, if a cushion is reached meanwhile, at this share of the tolerance: a hop's
# height changes a rebound by up to 45 / (speed times duration), and the place 2 m on by 2e4 times.
HOP_AT_CUSHION = 5e-5
SLOW_SEPARATION = 1e-6  # m, between bodies that met slowly: so far they are set apart
NO_CLUSTER = -math.inf  # m, in place of the reach of an impact of several bodies


@inner
def apply_cloth_response(params: BallClothParams, ball: BallRecord, tolerance: float) -> float:
    """
    Let the cloth answer to an impact that pushed a ball into it or off it.

    Hops below the tolerance [m] are skipped, together with their small cloth impulse. Return the
    vertical speed [m/s] that is left out so.
    """
    ball.bounces = 0
    ball.landing_speed = 0.0
    up = ball.velocity[2]
    if ball.position[2] > params.radius or up == 0.0:
        return 0.0
    small = (
        params.flight_gate == GATE_AUTO and lumped_bounce_error(params, ball, abs(up)) <= tolerance
    )
    if small or params.flight_gate == GATE_OFF:
        ball.velocity[2] = 0.0
        return up if small else 0.0
    if up < 0.0:
        bounce_on_cloth(params, ball)
        ball.bounces = 0
    return 0.0


@inner
def begin_motion(table: TableModel, s: Simulation, ball: BallRecord, tolerance: float) -> float:
    """Begin a ball's next segment, and find when it meets the table. Return the error made [m]."""
    params = table.params
    error = start_segment(params, ball, tolerance)
    balls.predict_boundary_event(table, s, ball)
    if cloth.resistance_rises(params) and ball.motion == ROLL and ball.time >= ball.roll_until:
        cloth.plan_roll(params, ball, table.roll_tolerance)
        start_segment(params, ball, tolerance)
        balls.predict_boundary_event(table, s, ball)
    return error


@inner
def go_on(table: TableModel, s: Simulation, ball: BallRecord, cause: int) -> None:
    """
    Begin a ball's next segment on the cloth or in the air, and find when it meets the table.

    A hop that is left out changes nothing on the way, but a cushion takes a ball in the air
    otherwise than one that lies: so if it is reached meanwhile, the hop is simulated.
    """
    params, n, up = table.params, table.numbers, 0.0
    if cause not in (OWN, ROLL_ON) and (cause != START or ball.velocity[2] < 0.0):
        up = apply_cloth_response(params, ball, n.hop_tolerance)
    if cloth.resistance_rises(params) and (cause not in (OWN, ROLL_ON) or ball.motion != ROLL):
        ball.roll_until = cloth.NO_PLAN
    error = begin_motion(table, s, ball, table.tolerance)
    share = 1.0 - params.cloth_restitution
    if up == 0.0:
        up = ball.landing_speed * share  # of bounces in one
    lasting = 2.0 * abs(up) / (params.gravity * share) if up != 0.0 else 0.0
    if up != 0.0 and ball.boundary_feature < HOLES and ball.boundary_time <= ball.time + lasting:
        ball.velocity[2] = up
        if up < 0.0:
            bounce_on_cloth(params, ball)
            ball.bounces = 0
        error = begin_motion(table, s, ball, HOP_AT_CUSHION * table.tolerance)
    if ball.first_contact == NOTHING:
        ball.left_out += error


@inner
def meet_cushion(table: TableModel, s: Simulation, ball: BallRecord, feature: int) -> None:
    """Let a ball meet a cushion; if that is not solved, note the status."""
    if not cushion.collide_cushion(table, s.rebound, ball, feature):
        s.progress.unsolved = BUDGET_EXCEEDED


@inner
def start_next_segment(table: TableModel, s: Simulation, ball: BallRecord, cause: int) -> float:
    """
    Begin the segment that follows an event, and find what its ball meets of the table.

    Return the kinetic energy [J] that the event leaves the ball, if it presses a nose or other
    balls: at the end of this.
    """
    ball.cause = cause
    if ball.nose == IMPACT:
        balls.predict_boundary_event(table, s, ball)
    else:
        ball.impact = NOTHING  # the ball moves otherwise than its last impact knew
        if ball.nose != NOTHING:
            meet_cushion(table, s, ball, ball.nose)
            cushion.press(table, s.rebound, ball)
            ball.boundary_time, ball.boundary_feature = cushion.next_nose(table.numbers, ball)
        elif ball.motion <= FLIGHT:
            go_on(table, s, ball, cause)
        else:
            ball.boundary_time = math.inf
    if ball.ball == 0:
        balls.predict_cue(table, s, ball)
    log_segment(s, ball)
    if ball.nose != NOTHING:
        return kinetic_energy(table.params, ball.exit_velocity, ball.exit_spin)
    return energy_of(table.params, ball)


@inner
def come_to_rest(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """Let a ball rest that has used up its motion: it stays there, so nothing is looked for."""
    ball.cause, ball.impact = OWN, NOTHING
    stop_ball(ball, REST)
    ball.boundary_time, ball.boundary_feature = math.inf, NOTHING
    if ball.ball == 0:
        balls.predict_cue(table, s, ball)
    log_segment(s, ball)


@inner
def handle_segment_end(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """Let a ball's segment end by itself."""
    motion, cause = ball.motion, OWN
    advance_ball(ball, ball.end)
    if ball.nose != NOTHING:
        cushion.release(table, ball)
        before = energy_of(table.params, ball)
        after = start_next_segment(table, s, ball, RELEASE)
        if ball.motion != motion:
            log_event(s, ball.time, RELEASE, ball, NOTHING, before, after=after, motion=motion)
        return
    before = energy_of(table.params, ball)
    if motion == FLIGHT and not table.numbers.endless and lands_off_table(table, ball):
        stop_ball(ball, LEFT_TABLE)
        cause = WENT_OFF
    else:
        end_segment(table.params, ball)
        cause = ball.cause
    after = energy_of(table.params, ball)
    if after == 0.0 and cause == OWN:
        come_to_rest(table, s, ball)
    else:
        start_next_segment(table, s, ball, cause)
    if cause != ROLL_ON:
        log_event(s, ball.time, cause, ball, NOTHING, before, after=after, motion=motion)


@inner
def separate(
    table: TableModel, s: Simulation, ball: BallRecord, space: float, x: float, y: float, z: float
) -> None:
    """Shift a ball by half of a space along (x, y, z), if nothing is in its way."""
    n, radius, shift = table.numbers, table.params.radius, 0.5 * space
    px, py = ball.position[0] + shift * x, ball.position[1] + shift * y
    pz = ball.position[2]
    if pz > radius:
        pz += shift * z
    if abs(px) > max(n.centre_half_length, abs(ball.position[0])):
        return
    if abs(py) > max(n.centre_half_width, abs(ball.position[1])):
        return
    for i in range(len(s.balls)):
        if i == ball.ball or s.balls[i].motion > FLIGHT:
            continue
        u, v, t = position_at(s.balls[i], ball.time)
        u, v, t = px - u, py - v, pz - t
        inside = u * u + v * v + t * t <= 4.0 * radius * radius
        if inside and u * x + v * y + t * z < 0.0:
            return
    ball.position[0], ball.position[1], ball.position[2] = px, py, pz


@inner
def meet_edge(
    table: TableModel, s: Simulation, ball: BallRecord, feature: int, x: float, y: float
) -> None:
    """
    Let a ball that touches a nose, facing or arc collide with it, or begin to press it.

    Its segment began at (x, y): the ball is not driven to a nose that it touched there.
    """
    n, lies = table.numbers, ball.position[2] == table.params.radius
    moved = abs(ball.position[0] - x if feature < 2 else ball.position[1] - y)
    if feature >= FACINGS or moved > FROZEN:
        ball.last_edge = ball.time
    if feature < FACINGS:
        ball.cushions += 1
    elif feature >= ARCS and ball.first_contact == NOTHING:
        ball.jaws += 1
    p, q, shift = cushion.shift_to_touch(table, ball, feature, ball.position[2])
    x, y, z = cushion.normal_at(table, ball, feature)
    approach = -(ball.velocity[0] * x + ball.velocity[1] * y + ball.velocity[2] * z)
    slow = approach <= MIN_APPROACH_SPEED
    # In the edge by rounding, or pressed in by its motion, or another ball ended its contact.
    if lies and (slow or abs(shift) <= SLOW_SEPARATION):
        ball.position[0] += p
        ball.position[1] += q
    if slow:
        x, y, z = cushion.direction_to(
            table, ball, feature
        )  # also if it flies, and is in the edge
        approach = -(ball.velocity[0] * x + ball.velocity[1] * y + ball.velocity[2] * z)
        if approach > 0.0:  # else an impact, which ends here, lets the ball leave the edge
            collide_fixed(table.params, ball, x, y, z, 0.0, friction=n.cushion_friction)
            if lies:
                ball.velocity[2] = 0.0  # the cloth holds it
        separate(table, s, ball, 2.0 * SLOW_SEPARATION, x, y, z=0.0)
    elif feature < FACINGS and n.cushion_duration > 0.0:
        ball.nose = feature
    else:
        meet_cushion(table, s, ball, feature)
        for i in range(3):
            ball.velocity[i], ball.spin[i] = ball.exit_velocity[i], ball.exit_spin[i]


@inner
def is_cluster(
    table: TableModel, s: Simulation, i: int, j: int, time: float, reach: float
) -> bool:
    """Whether either of two balls that meet is within reach of another one."""
    distance = 2.0 * table.params.radius + reach
    return touches_another(s, i, j, time, distance) or touches_another(s, j, i, time, distance)


@inner
def impact_reach(
    table: TableModel, a: BallRecord, b: BallRecord, x: float, y: float, z: float, approach: float
) -> float:
    """Distance [m] up to which balls take part in an impact of balls that meet along (x, y, z)."""
    n, along = table.numbers, 0.0
    for ball in (a, b):
        v = ball.velocity
        normal = x * v[0] + y * v[1] + z * v[2]
        square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - normal * normal
        along = max(along, math.sqrt(max(square, 0.0)))
    return reach_of_impact(n.contact_gap, n.ball_duration, table.params.exponent, approach, along)


@inner
def handle_boundary(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """Let a ball meet something of the table."""
    params, feature, cause = table.params, ball.boundary_feature, CUSHION
    x, y = ball.position[0], ball.position[1]
    cushion.advance_free(table, ball, ball.boundary_time)
    before, motion = energy_of(params, ball), ball.motion
    if feature == OUTSIDE:
        cause, feature = WENT_OFF, NOTHING
        stop_ball(ball, LEFT_TABLE)
    elif feature >= HOLES:
        cause, feature = POCKET, feature - HOLES
        ball.pocket = feature
        stop_ball(ball, POCKETED)
    else:
        meet_edge(table, s, ball, feature, x=x, y=y)
    after = start_next_segment(table, s, ball, cause)
    log_event(s, ball.time, cause, ball, feature, before, after=after, motion=motion)


@inner
def handle_collision(table: TableModel, s: Simulation, i: int, j: int, time: float) -> float:
    """
    Let two balls meet.

    Return NO_CLUSTER; or, if others take part, the distance up to which they do [m], and leave the
    impact to cluster.py.
    """
    params, a, b = table.params, s.balls[i], s.balls[j]
    cushion.advance_free(table, a, time)
    cushion.advance_free(table, b, time)
    before, motion = energy_of(params, a) + energy_of(params, b), a.motion
    x, y, z, distance = balls.line_of_centres(a, b)
    approach = -balls.relative_component(a.velocity, b.velocity, x, y, z)
    slow = approach <= MIN_APPROACH_SPEED
    if not slow:
        reach = impact_reach(table, a, b, x, y, z, approach=approach)
        if is_cluster(table, s, i, j, time, reach):
            return reach
    if approach > 0.0:  # else they part: one has just left another impact
        balls.collide_balls(
            params, table.numbers, a, b, 0.0 if slow else table.numbers.ball_restitution
        )
    if slow:
        space = SLOW_SEPARATION - distance + 2.0 * params.radius
        separate(table, s, a, space, x, y, z=z)
        separate(table, s, b, space, -x, -y, z=-z)
    if a.first_contact == NOTHING:
        a.first_contact = j
    if b.first_contact == NOTHING:
        b.first_contact = i
    note_meeting(s, i, j, time)
    after = start_next_segment(table, s, a, BALL) + start_next_segment(table, s, b, BALL)
    log_event(s, time, BALL, a, j, before, after=after, motion=motion)
    return NO_CLUSTER


@inner
def next_event(s: Simulation) -> tuple[float, int, int]:
    """
    When something happens next, and to which ball.

    And with what: with another ball, something of the table (then the ball itself), THE_CUE, or
    NOTHING.
    """
    time, ball, other = math.inf, NOTHING, NOTHING
    count = len(s.balls)
    for i in range(count):
        end = s.balls[i].end
        if end < time:
            time, ball = end, i
    for i in range(count):
        end = s.balls[i].boundary_time
        if end < time:
            time, ball, other = end, i, i
    for i in range(count):
        end = s.balls[i].meeting_time
        if end < time:
            time, ball, other = end, i, s.balls[i].meets
    if s.cue.meeting_time < time:
        time, ball, other = s.cue.meeting_time, 0, THE_CUE
    return time, ball, other


PLACED = -math.inf  # s, in place of the end of a run: cues are placed, and nothing is simulated


class RunLimits(NamedTuple):
    """What ends the runs of tables, and the times at which they return the places of the balls."""

    until: float  # s; inf: until all balls rest; 0: only strikes are simulated; or PLACED
    max_events: int  # of a table
    rules: list[BallRule]  # of each ball, or none: the run goes on until all rest
    times: Floats  # (n,) s, ascending
    places: Floats  # (tables, balls, n, 3) m, written; zero of tables that cannot be simulated


@inner
def resume(table: TableModel, s: Simulation, cause: int, now: float) -> None:
    """Let the balls go on that were put somewhere, or that took part in an impact."""
    for i in range(len(s.balls)):
        if s.balls[i].modified:
            met = cause == CUE or (cause == START and s.balls[i].first_contact != NOTHING)
            start_next_segment(table, s, s.balls[i], CLUSTER if met and i > 0 else cause)
    for i in range(len(s.balls)):
        if s.balls[i].modified:
            balls.predict_collisions(table, s, i, now)
        s.balls[i].modified = False


@inner
def is_decided(s: Simulation, cue: CueRecord) -> bool:
    """Whether the stroke failed, a ball broke its rule, or all wanted balls have missed."""
    if cue.miscue or s.progress.double_hit:
        return True
    met = s.balls[0].first_contact
    if met != NOTHING and s.rules[met].barred:
        return True
    missed, pending = False, False
    for i in range(len(s.balls)):
        ball, rule = s.balls[i], s.rules[i]
        if ball.motion == LEFT_TABLE or (ball.motion == POCKETED and rule.must_stay):
            return True
        if rule.sought > 0 and ball.first_contact != NOTHING:
            over = ball.motion == REST or ball.cushions > rule.sought
            missed, pending = missed or over, pending or not over
    return missed and not pending


@inner
def ending(params: BallClothParams, ball: BallRecord) -> int:
    """Status of a ball in its last segment: OK, OFF_TABLE, NEVER_RESTS or BUDGET_EXCEEDED."""
    if ball.motion == LEFT_TABLE:
        return OFF_TABLE
    if ball.motion == FLIGHT and params.cloth_restitution < 1.0:
        return BUDGET_EXCEEDED
    return OK if ball.motion == REST or ball.motion > FLIGHT else NEVER_RESTS


@inner
def note_places(s: Simulation, window: RunLimits, number: int, noted: int, time: float) -> int:
    """
    Note where the balls of a table are at the times of a window before the given one.

    The first `noted` are noted already; return how many are then.
    """
    while noted < len(window.times) and window.times[noted] < time:
        for i in range(len(s.balls)):
            place = window.places[number][i][noted]
            place[0], place[1], place[2] = position_at(s.balls[i], window.times[noted])
        noted += 1
    return noted


@inner
def stop_all(s: Simulation, time: float) -> int:
    """Bring all balls to a time, as their last segments; return the status of the table."""
    status = OK
    for i in range(len(s.balls)):
        ball = s.balls[i]
        if ball.motion == LEFT_TABLE:
            status = OFF_TABLE
        elif ball.motion != REST and ball.motion <= FLIGHT:
            advance_ball(ball, time)
            ball.cause = RELEASE  # which is no event if the motion goes on
            log_segment(s, ball)
    return status


@inner
def note_hit(params: BallClothParams, s: Simulation, cue: CueRecord, time: float) -> None:
    """Note that the cue meets the ball again, after the strike."""
    ball, (_, _, z) = s.balls[0], position_at(s.balls[0], time)
    alone = ball.first_contact == NOTHING and ball.cushions == 0
    if alone and chatters(cue.tip_time + time, z - params.radius):
        cue.chatter = True
    else:
        s.progress.double_hit = True
        cue.double_hit = min(cue.double_hit, time)


@inner
def run_events(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    window: RunLimits,
    room: ImpactWorkspace,
) -> tuple[float, int]:
    """
    Simulate until nothing moves, or only endlessly, or all is decided, or the window ends.

    With rules, a stroke that failed already in the strike ends there.

    Return when that is [s], and the status of the table.
    """
    p, now, noted = s.progress, 0.0, 0
    if len(s.rules) > 0 and is_decided(s, cues[number]):
        return now, OK
    resume(table, s, START, now)
    while True:
        time, i, j = next_event(s)
        noted = note_places(s, window, number, noted, min(time, window.until))
        if time > window.until:
            note_places(s, window, number, noted, math.inf)
            return window.until, stop_all(s, window.until)
        if time == math.inf:
            break
        if p.events >= window.max_events:
            return now, BUDGET_EXCEEDED
        now, reach = time, NO_CLUSTER
        if j == NOTHING:
            handle_segment_end(table, s, s.balls[i])
        elif j == THE_CUE:
            note_hit(table.params, s, cues[number], now)
            if not p.double_hit or len(s.rules) == 0:
                reach = table.cue.neighbour_reach
            # else a foul decides the run: nobody needs to know where the ball goes
        elif j == i:
            handle_boundary(table, s, s.balls[i])
        else:
            reach = handle_collision(table, s, i, j, now)
        if reach != NO_CLUSTER:
            impact = gather(table, s, cues, number, Meeting(now, i, j, reach), room)
            solve(table, impact, room)
            conclude(table, s, cues, number, impact, room)
        if p.unsolved != OK:
            return now, p.unsolved
        if reach != NO_CLUSTER:
            resume(table, s, CUE if j == THE_CUE else CLUSTER, now)
        if len(s.rules) > 0 and is_decided(s, cues[number]):
            return now, OK
        if reach == NO_CLUSTER:
            balls.predict_collisions(table, s, i, now)
            if j >= 0 and j != i:
                balls.predict_collisions(table, s, j, now)
    status = OK
    for i in range(len(s.balls)):
        status = max(status, ending(table.params, s.balls[i]))
    return now, p.flaw if status == OK else status
