"""
A ball meets a cushion: the contact by its model (cushion_models.py), and the time that it takes.

A ball that meets a straight cushion presses it for some milliseconds. Meanwhile it moves along the
cushion, and other balls may meet it. In the record this is one segment, whose acceleration brings
the ball to where it then touches the nose; the ball leaves it as the contact says. A jaw is passed
in no time, because the way along it would be longer than the jaw.
"""

import math

from billiard_shot.compiled import inner
from billiard_shot.table.contacts.cushion_models import (
    collide_lying,
    interpolate_rebound,
    MATHAVAN,
    restitution_at,
    STRONGE,
)
from billiard_shot.table.contacts.rebound import ALONG, follow, VX, VY, VZ, WX, WY, WZ, Y, Z
from billiard_shot.table.model.geometry import TableModel, TableNumbers
from billiard_shot.table.model.motion import (
    advance_ball,
    BallRecord,
    FLIGHT,
    NOTHING,
    Rebound,
    SLIDE,
)
from billiard_shot.table.motion import boundaries
from billiard_shot.table.motion.flight import LYING

UNREACHED_HEIGHT = 1e300  # height that a contact without duration does not change
GRIP = 1e3  # coefficient of a friction that lets nothing slip
# The error of a step relative to the ball's speed, at most and at least; and per tolerance [m].
COARSEST_STEP, FINEST_STEP, STEP_SHARE = 5e-5, 1e-11, 0.02
IN_THE_AIR = 0.01  # of it for a ball that flies, whose later rebounds enlarge what errs


@inner
def direction_from(
    table: TableModel, ball: BallRecord, feature: int
) -> tuple[float, float, float]:
    """
    Find the horizontal direction to a ball from the edge it touches, and its distance [m].

    A ball that comes down on a cushion behind the edge touches it from behind.
    """
    x, y, away = boundaries.edge_at(table, feature, ball.position[0], ball.position[1])
    if away < 0.0:
        return -x, -y, -away
    return x, y, away


@inner
def normal_at(table: TableModel, ball: BallRecord, feature: int) -> tuple[float, float, float]:
    """Find the unit vector to a ball from where it touches a nose, facing or arc."""
    x, y, _ = direction_from(table, ball, feature)
    up = (ball.position[2] - table.numbers.nose_height) / table.params.radius
    up = min(max(up, -1.0), 1.0)
    flat = math.sqrt(1.0 - up * up)
    return flat * x, flat * y, up


@inner
def direction_to(table: TableModel, ball: BallRecord, feature: int) -> tuple[float, float, float]:
    """Find the unit vector to a ball from an edge that it touches, or that it is pressed into."""
    x, y, away = direction_from(table, ball, feature)
    up = ball.position[2] - table.numbers.nose_height
    size = math.sqrt(away * away + up * up)
    return away * x / size, away * y / size, up / size


@inner
def shift_to_touch(
    table: TableModel, ball: BallRecord, feature: int, z: float
) -> tuple[float, float, float]:
    """Find the way (x, y) to where a ball at height z touches an edge, and its length [m]."""
    x, y, away = direction_from(table, ball, feature)
    radius, up = table.params.radius, z - table.numbers.nose_height
    shift = math.sqrt(max(radius * radius - up * up, 0.0)) - away
    return shift * x, shift * y, shift


@inner
def collide_cushion(table: TableModel, r: Rebound, ball: BallRecord, feature: int) -> bool:
    """
    Find how a ball leaves a cushion that it meets.

    The velocities are written to the ball's `exit_velocity` and `exit_spin`; time [s], height and
    way along the cushion [m] to `r`. Return whether that is solved.
    """
    x, y, z = normal_at(table, ball, feature)
    lies = ball.position[2] == table.params.radius
    model = table.numbers.cushion_model
    if lies and model != MATHAVAN and model != STRONGE:
        r.state[ALONG] = collide_lying(table, ball, x, y, z)
        r.time, r.held = table.numbers.cushion_duration, True
        return True
    return collide_compliant(table, r, ball, x, y, z)


@inner
def collide_compliant(
    table: TableModel, r: Rebound, ball: BallRecord, x: float, y: float, z: float
) -> bool:
    """
    Let a ball collide with a cushion whose normal is (x, y, z), as rebound.py says.

    With the model of Stronge a ball that lies meets the nose as if there were no cloth, which then
    takes what the ball has of a vertical velocity.
    """
    params, n = table.params, table.numbers
    v, w, state, radius = ball.velocity, ball.spin, r.state, params.radius
    flat = math.sqrt(x * x + y * y)
    speed = 0.0
    for i in range(3):
        speed = max(speed, abs(v[i]), radius * abs(w[i]))
    # x of the contact is (-q, p) along the cushion, y is (-p, -q) into it
    p, q = (x / flat, y / flat) if flat > 0.0 else (1.0, 0.0)
    turning, period = radius / speed, n.cushion_duration / math.pi
    length, height = speed * period, ball.position[2] - radius
    lies = height <= 0.0 and v[2] <= 0.0
    r.held = lies and n.cushion_model != STRONGE
    state[Y] = 0.0
    state[Z] = max(height, 0.0) / length if length > 0.0 else UNREACHED_HEIGHT
    if lies:
        state[Z] = 0.0 if r.held else UNREACHED_HEIGHT
    state[ALONG] = 0.0
    state[VX], state[VY] = (p * v[1] - q * v[0]) / speed, -(p * v[0] + q * v[1]) / speed
    state[VZ] = 0.0 if lies else v[2] / speed
    state[WX], state[WY] = turning * (p * w[1] - q * w[0]), -turning * (p * w[0] + q * w[1])
    state[WZ] = turning * w[2]
    r.time, r.sine, r.cosine = 0.0, -z, flat
    r.turn = params.mass * radius * radius / params.inertia
    r.restitution, r.nose_friction = restitution_at(n, ball, x, y, z), n.cushion_friction
    r.tangential_stiffness = n.cushion_frequency_ratio**2 / (1.0 + r.turn)
    r.cloth_friction = min(params.sliding_friction, GRIP)
    r.bounce_restitution, r.bounce_friction = params.cloth_restitution, params.cloth_friction
    error = min(COARSEST_STEP, STEP_SHARE * table.tolerance)
    if not lies:
        error *= IN_THE_AIR
    solved = r.held and len(table.rebounds) > 0 and interpolate_rebound(table.rebounds, r)
    solved = solved or follow(r, max(error, FINEST_STEP))
    if lies and n.cushion_model == STRONGE:
        r.held, state[Z], state[VZ] = True, 0.0, 0.0
    ball.exit_velocity[0] = -speed * (q * state[VX] + p * state[VY])
    ball.exit_velocity[1] = speed * (p * state[VX] - q * state[VY])
    ball.exit_velocity[2] = speed * state[VZ]
    ball.exit_spin[0] = -(q * state[WX] + p * state[WY]) / turning
    ball.exit_spin[1] = (p * state[WX] - q * state[WY]) / turning
    ball.exit_spin[2] = state[WZ] / turning
    r.time *= period
    state[Z] *= length
    state[ALONG] *= length
    return solved


@inner
def press(table: TableModel, r: Rebound, ball: BallRecord) -> None:
    """Begin the segment in which a ball presses a nose, after `collide_cushion`."""
    params, along, lasting = table.params, r.state[ALONG], r.time
    height = 0.0 if r.held else max(r.state[Z], 0.0)
    x, y, _ = direction_from(table, ball, ball.nose)
    p, q, _ = shift_to_touch(table, ball, ball.nose, params.radius + height)
    change = p - along * y, q + along * x, params.radius + height - ball.position[2]
    ball.motion = SLIDE
    if height > 0.0 or ball.position[2] > params.radius:
        ball.motion = FLIGHT
    if ball.position[2] <= params.radius and ball.velocity[2] < 0.0:
        ball.velocity[2] = 0.0  # the cloth holds it
    for i in range(3):
        ball.acceleration[i] = 2.0 * (change[i] / lasting - ball.velocity[i]) / lasting
        ball.spin_acceleration[i] = (ball.exit_spin[i] - ball.spin[i]) / lasting
    ball.end = ball.time + lasting
    ball.spin_ends, ball.landing_speed = False, 0.0


@inner
def release(table: TableModel, ball: BallRecord) -> None:
    """Let a ball that presses a nose leave it: from now on it moves as after the contact."""
    if ball.position[2] <= table.params.radius * (1.0 + LYING):
        ball.position[2] = table.params.radius
    for i in range(3):
        ball.velocity[i], ball.spin[i] = ball.exit_velocity[i], ball.exit_spin[i]
    ball.nose = NOTHING


@inner
def advance_free(table: TableModel, ball: BallRecord, time: float) -> None:
    """
    Move a ball on to a time; if it presses a nose, that contact is over.

    What the ball meets then lasts much shorter. If it is driven into the nose again, that is a new
    contact.
    """
    advance_ball(ball, time)
    if ball.nose != NOTHING:
        release(table, ball)


@inner
def next_nose(n: TableNumbers, ball: BallRecord) -> tuple[float, int]:
    """When a ball that presses a nose meets another one, in a corner without a pocket; or inf."""
    end, feature = ball.end - ball.time, NOTHING
    px, py, vx, vy = ball.position[0], ball.position[1], ball.velocity[0], ball.velocity[1]
    ax, ay = ball.acceleration[0], ball.acceleration[1]
    for nose in range(4):
        if nose // 2 == ball.nose // 2:
            continue
        t = boundaries.crossing_time(*boundaries.approach_to_nose(n, nose, ball))
        if t < end and boundaries.beside_nose(
            n, nose, px + (vx + 0.5 * ax * t) * t, py + (vy + 0.5 * ay * t) * t
        ):
            end, feature = t, nose
    return (ball.time + end if feature != NOTHING else math.inf), feature
