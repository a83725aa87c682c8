"""Two balls: when they meet, and what that does to them; what each ball meets next."""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import Vector
from billiard_shot.table.model.geometry import (
    BallClothParams,
    GATE_OFF,
    GATE_ON,
    TableModel,
    TableNumbers,
)
from billiard_shot.table.model.motion import (
    BallRecord,
    FLIGHT,
    IMPACT,
    is_translating,
    NOTHING,
    RELEASE,
    Simulation,
)
from billiard_shot.table.motion.ball_impact import (
    apply_impulse,
    friction_impulse_per_slip,
    slip_at,
)
from billiard_shot.table.motion.boundaries import (
    contact_time,
    next_flight_boundary,
    next_rolling_boundary,
)

OVERLAP = 1e-10  # m
CLEAR = 1e-6  # m: two balls that stay farther apart than this along an axis do not meet;
SOON = 100.0  # s: but rounding could say otherwise in a polynomial over a longer time


@innermost
def stays_beyond(x: float, v: float, h: float, time: float, distance: float) -> bool:
    """Whether x + v t + h t^2 certainly stays beyond a distance from 0 for t from 0 to a time."""
    if x > distance:
        return x + ((v if v < 0.0 else 0.0) + (h if h < 0.0 else 0.0) * time) * time > distance
    if x < -distance:
        return x + ((v if v > 0.0 else 0.0) + (h if h > 0.0 else 0.0) * time) * time < -distance
    return False


@inner
def collision_time(a: BallRecord, b: BallRecord, now: float, end: float, diameter: float) -> float:
    """Time at which two balls meet, if they go on as they do until `end`; else inf."""
    s, t, lasting = now - a.time, now - b.time, end - now
    p, q, u, w = a.position, b.position, a.velocity, b.velocity
    f, g = a.acceleration[0], b.acceleration[0]
    x = p[0] - q[0] + (u[0] + 0.5 * f * s) * s - (w[0] + 0.5 * g * t) * t
    vx = u[0] + f * s - w[0] - g * t
    hx = 0.5 * (f - g)
    if lasting < SOON and stays_beyond(x, vx, hx, lasting, diameter + CLEAR):
        return math.inf
    f, g = a.acceleration[1], b.acceleration[1]
    y = p[1] - q[1] + (u[1] + 0.5 * f * s) * s - (w[1] + 0.5 * g * t) * t
    vy = u[1] + f * s - w[1] - g * t
    hy = 0.5 * (f - g)
    if lasting < SOON and stays_beyond(y, vy, hy, lasting, diameter + CLEAR):
        return math.inf
    c0 = -diameter * diameter + x * x + y * y
    c1 = 2.0 * x * vx + 2.0 * y * vy
    c2 = vx * vx + 2.0 * x * hx + (vy * vy + 2.0 * y * hy)
    c3 = 2.0 * vx * hx + 2.0 * vy * hy
    c4 = hx * hx + hy * hy
    if a.motion == FLIGHT or b.motion == FLIGHT:  # two that lie are as high as each other
        f, g = a.acceleration[2], b.acceleration[2]
        z = p[2] - q[2] + (u[2] + 0.5 * f * s) * s - (w[2] + 0.5 * g * t) * t
        vz = u[2] + f * s - w[2] - g * t
        hz = 0.5 * (f - g)
        c0 += z * z
        c1 += 2.0 * z * vz
        c2 += vz * vz + 2.0 * z * hz
        c3 += 2.0 * vz * hz
        c4 += hz * hz
    return now + contact_time(c0, c1, c2, c3, c4, lasting, scale=2.0 * diameter)


@inner
def line_of_centres(a: BallRecord, b: BallRecord) -> tuple[float, float, float, float]:
    """Find the unit vector from ball b to ball a, and the distance of their centres [m]."""
    x = a.position[0] - b.position[0]
    y = a.position[1] - b.position[1]
    z = a.position[2] - b.position[2]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return x / distance, y / distance, z / distance, distance


@innermost
def relative_component(a: Vector, b: Vector, x: float, y: float, z: float) -> float:
    """Component along (x, y, z) of a vector relative to another one."""
    return x * (a[0] - b[0]) + y * (a[1] - b[1]) + z * (a[2] - b[2])


@inner
def friction_of_balls(n: TableNumbers, slip: float) -> float:
    """Coefficient of friction between balls at a slip [m/s] (Alciatore, TP A.14)."""
    return n.friction_fast + n.friction_slow * math.exp(-n.friction_decay * slip)


@inner
def collide_balls(
    params: BallClothParams, n: TableNumbers, a: BallRecord, b: BallRecord, restitution: float
) -> None:
    """Change the velocities and spins of two equal balls that meet: restitution and friction."""
    x, y, z, distance = line_of_centres(a, b)
    overlap = 2.0 * params.radius - distance
    if overlap > OVERLAP:  # pressed together by their motion on the cloth
        shift = 0.5 * overlap
        a.position[0] += shift * x
        a.position[1] += shift * y
        a.position[2] += shift * z
        b.position[0] -= shift * x
        b.position[1] -= shift * y
        b.position[2] -= shift * z
    p, q, s = slip_at(a, -params.radius, x, y, z)
    u, v, w = slip_at(b, params.radius, x, y, z)
    u, v, w = p - u, q - v, s - w
    slip = math.sqrt(u * u + v * v + w * w)
    push = (
        -0.5
        * params.mass
        * (1.0 + restitution)
        * relative_component(a.velocity, b.velocity, x, y, z)
    )
    friction = friction_of_balls(n, slip)
    drag = friction_impulse_per_slip(params, push, slip, friction, 2.0)
    u, v, w = push * x - drag * u, push * y - drag * v, push * z - drag * w
    apply_impulse(params, a, -params.radius, x, y, z, u=u, v=v, w=w)
    apply_impulse(params, b, params.radius, x, y, z, u=-u, v=-v, w=-w)


@inner
def predict_boundary_event(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """Find when a ball, in its present segment, meets something of the table."""
    if table.numbers.endless or not is_translating(ball):
        ball.boundary_time, ball.boundary_feature = math.inf, NOTHING
    elif ball.motion == FLIGHT and ball.acceleration[2] != 0.0:
        ball.boundary_time, ball.boundary_feature = next_flight_boundary(table, ball)
    else:
        ball.boundary_time, ball.boundary_feature, searched = next_rolling_boundary(table, ball)
        s.progress.searches += searched


@inner
def meeting_time(ball: BallRecord, cue: BallRecord, reach: float) -> float:
    """
    When a cue meets a ball in the ball's present segment [s], or inf.

    If they meet at once, the ball has not been clear of the cue yet: it holds the cue's end aside,
    and that is no hit. But it is one if the ball comes back from a cushion that it pressed.

    Parameters
    ----------
    ball : BallRecord
    cue : BallRecord
        The sphere of the tip, until its `end`.
    reach : float
        Distance of the centres of tip and ball as they meet [m].

    """
    end = min(ball.end, cue.end)
    if ball.time >= end:
        return math.inf
    time = collision_time(cue, ball, ball.time, end, reach)
    comes_back = ball.cause == RELEASE and ball.time > cue.time  # and not from a hit
    return time if time > ball.time or comes_back else math.inf


@inner
def predict_cue(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """
    Find when the cue that follows its stroke meets the ball that it struck, in its segment.

    During a hit nothing is to be found: the time of the cue is the end of the hit.
    """
    cue, meets = s.cue, ball.motion <= FLIGHT and s.cue.time <= ball.time
    cue.meeting_time = meeting_time(ball, cue, table.cue.reach) if meets else math.inf


@inner
def predict_collisions(table: TableModel, s: Simulation, index: int, now: float) -> None:
    """
    Find when a ball meets each other one, before either does something else anyway.

    GATE_ON as `pair_gate` looks at every pair, and to the end of its segments; GATE_OFF at none.
    """
    gate, diameter = table.numbers.pair_gate, 2.0 * table.params.radius
    if gate == GATE_OFF:
        return
    ball = s.balls[index]
    until = ball.end
    if gate != GATE_ON:
        until = min(until, ball.boundary_time)
    on_table = ball.motion <= FLIGHT
    any_other = gate == GATE_ON or is_translating(ball)
    for i in range(len(s.balls)):
        if i == index:
            continue
        other = s.balls[i]
        time = math.inf
        may_meet = on_table and other.motion <= FLIGHT and not share_impact(ball, other)
        if may_meet and (any_other or is_translating(other)):
            end = other.end if other.end < until else until
            if gate != GATE_ON and other.boundary_time < end:
                end = other.boundary_time
            s.progress.searches += 1
            time = collision_time(ball, other, now, end, diameter)
        if index < i:
            s.collisions[index][i] = time
        else:
            note_collision(s, i, index, time)
    find_next_meeting(s, index)


@inner
def share_impact(a: BallRecord, b: BallRecord) -> bool:
    """Whether an impact that lasts knows how both balls move: they take part in it, or rest."""
    one, other = a.nose == IMPACT, b.nose == IMPACT
    if not (one or other) or a.impact != b.impact:
        return False
    return (one or not is_translating(a)) and (other or not is_translating(b))


@inner
def find_next_meeting(s: Simulation, index: int) -> None:
    """Find which of the balls after it a ball meets next; of equal times, the first ball."""
    ball, row = s.balls[index], s.collisions[index]
    ball.meeting_time, ball.meets = math.inf, NOTHING
    for i in range(index + 1, len(s.balls)):
        if row[i] < ball.meeting_time:
            ball.meeting_time, ball.meets = row[i], i


@inner
def note_collision(s: Simulation, i: int, j: int, time: float) -> None:
    """Note when balls i < j meet, and what this changes of the next meeting of ball i."""
    ball = s.balls[i]
    s.collisions[i][j] = time
    if time < ball.meeting_time or (time == ball.meeting_time and j < ball.meets):
        ball.meeting_time, ball.meets = time, j
    elif j == ball.meets:
        find_next_meeting(s, i)
