"""
A ball against the nose of a cushion: a contact that takes time, on a cloth that takes none.

The nose is a linear spring whose restoring phase is 1/e^2 times as fast (the law `bistiffness`:
Liu, Zhao and Brogliato 2008). The cloth is rigid: the nose presses a ball that lies on it to it,
and a ball that lands meanwhile bounces. Friction acts at both contacts (Coulomb). For a ball that
lies this is the cushion of Mathavan, Jackson and Parkin (2010); for a ball in the air it is the
same ball without a cloth, until it lands. A contact of a cushion is at least ten times as long as
one of the cloth, so the cloth acts within it in no time (docs/model.md).

A nose may also have a linear spring along its surface (Stronge, Impact Mechanics, 2nd ed., 2018,
chapter 5). The spring holds while its force is below the limit of friction. Otherwise the nose
slips on the ball: the force has the size of the limit, and the direction of the slip.

Units here: the ball's mass and radius are 1, so spins are velocities; the largest velocity before
is 1, and the spring's frequency is 1. x along the cushion, y into it, z up. The normal keeps the
direction that it has when the contact begins. Gravity is left out: in 5 ms it gives 0.05 m/s.
"""

from math import inf, sqrt

from billiard_shot.compiled import inner, innermost
from billiard_shot.impact.friction import minimize_over_disc
from billiard_shot.records import Vector
from billiard_shot.table.model.motion import Rebound

Y, Z, ALONG, VX, VY, VZ, WX, WY, WZ, SHEAR, LIFT = range(11)  # of a state: see `Rebound`
SIZE = 11
SLIP_ENDS = 0.8  # of a slip that ends may go in a step
FIRST = 3.5  # step, times the fifth root of the tolerance; a contact lasts about 3
LONGEST_STEP, SHORTEST_STEP = 0.7, 1e-12  # steps
MAX_REBOUND_STEPS = 40_000  # a slip that begins slowly takes thousands, at fine tolerances
SWEEPS = 200  # until the frictions at cushion and cloth agree
LOCATING = 60  # steps until an event is found
TINY = 1e-300  # no division by less
EVENT_SHARE = 1e-2  # share of the tolerance within which events are found
STILL_TOLERANCES = 20.0  # times the tolerance: a slower slip or bounce is the error's, and ends

# Dormand and Prince (1980): the weights of each stage; those of the last are the solution's.
RUNGE_KUTTA_STAGES = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0),
    (44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# The solution minus that of fourth order.
ERRORS = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
# Within a step (Shampine, Math. Comp. 46, 1986): the weights of each stage are polynomials in the
# part of the step, without a constant.
DENSE_WEIGHTS = (
    (1.0, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432),
    (0.0, 0.0, 0.0, 0.0),
    (0.0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799),
    (0.0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072),
    (0.0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632),
    (0.0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844),
    (0.0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423),
)


@innermost
def closing_speed(r: Rebound, state: Vector) -> float:
    """Speed at which the ball approaches the nose."""
    return r.cosine * state[VY] + r.sine * state[VZ]


@innermost
def compression_rate(r: Rebound, state: Vector) -> float:
    """Rate of the nose's compression, which is its force: faster in restoring."""
    closing = closing_speed(r, state)
    return closing if r.compressing else closing / (r.restitution * r.restitution)


@innermost
def nose_slip(r: Rebound, state: Vector) -> tuple[float, float]:
    """Slip at the nose: along the cushion, and along the other tangent (0, -sine, cosine)."""
    return (
        state[VX] + r.sine * state[WY] - r.cosine * state[WZ],
        state[WX] - r.sine * state[VY] + r.cosine * state[VZ],
    )


@innermost
def cloth_slip(state: Vector) -> tuple[float, float]:
    """Slip of the ball's lowest point."""
    return state[VX] - state[WY], state[VY] + state[WX]


@innermost
def press_of(r: Rebound, g: float) -> float:
    """Force on the cloth per force of the nose, for a friction g there; negative: it lifts."""
    return r.sine - r.cosine * g


@innermost
def size_of(x: float, y: float) -> float:
    """Length of a vector of the plane."""
    return sqrt(x * x + y * y)


@inner
def friction_of_cloth(r: Rebound, state: Vector, f: float, g: float) -> tuple[float, float]:
    """Friction at the cloth per force of the nose, for a friction (f, g) there."""
    most = r.cloth_friction * press_of(r, g)
    if r.cloth_slips:
        x, y = cloth_slip(state)
        share = most / max(size_of(x, y), TINY)
        return -share * x, -share * y
    h = -f * (1.0 - r.turn * r.sine) / (1.0 + r.turn)
    k = (r.cosine - g * (r.turn - r.sine)) / (1.0 + r.turn)
    share = min(most / max(size_of(h, k), TINY), 1.0)
    return share * h, share * k


@inner
def friction_at_onset(r: Rebound, x: float, y: float) -> tuple[float, float, float, float]:
    """
    Friction per force of the nose if the nose does not slip, and the ball slips on the cloth.

    (x, y) has the direction of that slip, and the size of its coefficient of friction. The nose's
    friction (f, g) lies on the rim of its disc if no friction inside keeps it from slipping; then
    the slip begins along `against` (f, g), against it, with the same equations otherwise. The size
    of (f, g) falls as `against` grows.
    """
    s, c, turn, most = r.sine, r.cosine, r.turn, r.nose_friction
    if most == 0.0:
        return 0.0, 0.0, -s * x, -s * y
    one, two, both = s * s + turn, 1.0 + turn, y * (turn - s)
    against, low, high = 0.0, 0.0, inf
    f, g, press = 0.0, 0.0, s
    for _ in range(SWEEPS):
        g = s * (both - c) / (one + against + c * both)
        press = press_of(r, g)
        f = press * x * (1.0 - turn * s) / (two + against)
        size = size_of(f, g)
        if size <= most and against == 0.0:
            break
        if size > most:
            low = against
        else:
            high = against
        # Newton's rule for most / size - 1, which is nearly linear
        across = f * f / (two + against) + g * g / (one + against + c * both)
        change = (size / most - 1.0) * size * size / across
        if abs(change) <= 1e-14 * (two + against):
            break
        against += change
        if not low <= against <= high:
            against = 0.5 * (low + high) if high < inf else 2.0 * low + 1.0
    return f, g, -press * x, -press * y


@inner
def friction_without_slip(r: Rebound, state: Vector) -> tuple[float, float, float, float]:
    """Friction per force of the nose if the nose does not slip, and the ball lies: as below."""
    s, c, turn = r.sine, r.cosine, r.turn
    one, two, both = s * s + turn, 1.0 + turn, turn - s
    if r.cloth_slips:
        x, y = cloth_slip(state)
        share = r.cloth_friction / max(size_of(x, y), TINY)
        return friction_at_onset(r, share * x, share * y)
    determinant = one * two - both * both
    g, k = -c * (s * two + both) / determinant, c * (one + s * both) / determinant
    if abs(k) <= r.cloth_friction * press_of(r, g) and abs(g) <= r.nose_friction:
        return 0.0, g, 0.0, k
    f, g, h, k = 0.0, 0.0, 0.0, 0.0
    for _ in range(SWEEPS):
        last_g, last_h, last_k = g, h, k
        f, g = minimize_over_disc(
            two, 0.0, one, h * (1.0 - turn * s), s * c + k * both, r.nose_friction
        )
        h, k = friction_of_cloth(r, state, f, g)
        if abs(g - last_g) + abs(h - last_h) + abs(k - last_k) < 1e-14:
            break
    return f, g, h, k


@innermost
def slip_beneath_spring(r: Rebound, state: Vector) -> tuple[float, float, float]:
    """
    Speed at which a nose with a tangential spring slips on the ball, and its direction.

    The direction is that of the deflection, which is zero only when the contact begins. If the
    nose slips, the deflection grows with the limit of friction, and the rest of the motion is the
    slip. If the speed is negative, the spring holds.
    """
    a, b = nose_slip(r, state)
    x, y = state[SHEAR], state[LIFT]
    size = size_of(x, y)
    if size == 0.0:
        x, y, size = a, b, max(size_of(a, b), TINY)
    x, y = x / size, y / size
    growth = r.nose_friction / r.tangential_stiffness * compression_rate(r, state)
    return a * x + b * y - growth, x, y


@inner
def spring_rates(r: Rebound, state: Vector) -> tuple[float, float]:
    """
    Rates of the tangential spring's variables.

    A spring that holds is deflected as fast as the ball moves. In a slip the motion across its
    direction turns the deflection. Where that takes less than `lag`, as at the beginning and the
    end of a contact, it is slowed down to that: so small a deflection matters less than the error.
    """
    a, b = nose_slip(r, state)
    if not r.spring_slips:
        return a, b
    _, x, y = slip_beneath_spring(r, state)
    along = a * x + b * y
    most = r.nose_friction * state[Y] / r.tangential_stiffness
    size = max(most, r.lag * size_of(a, b), TINY)
    return (a - along * x) / size, (b - along * y) / size


@innermost
def spring_margin(r: Rebound, state: Vector) -> float:
    """Return how far the tangential spring is from slipping or, if it slips, from holding."""
    if r.spring_slips:
        return slip_beneath_spring(r, state)[0]
    most = r.nose_friction * state[Y] / r.tangential_stiffness
    return most - size_of(state[SHEAR], state[LIFT])


@inner
def friction_of_spring(r: Rebound, state: Vector) -> tuple[float, float]:
    """Friction per force of a nose with a tangential spring."""
    if r.spring_slips:
        _, x, y = slip_beneath_spring(r, state)
        return -r.nose_friction * x, -r.nose_friction * y
    x, y, force = state[SHEAR], state[LIFT], state[Y]
    if force == 0.0:  # the contact begins: both grow from zero
        x, y = nose_slip(r, state)
        force = closing_speed(r, state)
    return -r.tangential_stiffness * x / force, -r.tangential_stiffness * y / force


@inner
def frictions(r: Rebound, state: Vector) -> tuple[float, float, float, float]:
    """
    Friction per force of the nose: at the nose (f, g) and at the cloth (h, k).

    A contact that slips has the direction of its slip. Any other one has the friction that keeps
    it from slipping or, if that is too much, the one that takes most energy: its slip begins
    against that.
    """
    h, k = 0.0, 0.0
    if r.tangential_stiffness > 0.0:
        f, g = friction_of_spring(r, state)
    elif r.nose_slips:
        x, y = nose_slip(r, state)
        share = r.nose_friction / max(size_of(x, y), TINY)
        f, g = -share * x, -share * y
    elif r.held:
        return friction_without_slip(r, state)
    else:
        return 0.0, 0.0, 0.0, 0.0
    if r.held:
        h, k = friction_of_cloth(r, state, f, g)
    return f, g, h, k


@inner
def write_rates(r: Rebound, state: Vector, stage: int) -> None:
    """Write how a state changes in time into the rates of a stage."""
    f, g, h, k = frictions(r, state)
    r.press = press_of(r, g) if r.held else 0.0
    force, out, first = state[Y], r.rates, SIZE * stage
    out[first + Y] = compression_rate(r, state)
    out[first + Z] = 0.0 if r.held else state[VZ]
    out[first + ALONG] = state[VX]
    out[first + VX] = force * (f + h)
    out[first + VY] = force * (k - r.cosine - r.sine * g)
    out[first + VZ] = 0.0 if r.held else force * (r.cosine * g - r.sine)
    out[first + WX] = force * r.turn * (g + k)
    out[first + WY] = force * r.turn * (r.sine * f - h)
    out[first + WZ] = -force * r.turn * r.cosine * f
    if r.tangential_stiffness > 0.0:
        out[first + SHEAR], out[first + LIFT] = spring_rates(r, state)
    else:
        out[first + SHEAR] = out[first + LIFT] = 0.0


@innermost
def weighted(r: Rebound, i: int, stages: int, weights: tuple[float, ...]) -> float:
    """
    Sum the rates of a number of the state in the first stages, times weights.

    Stages and weights are constants in machine code, which is a fifth faster than a loop.
    """
    k = r.rates
    total = weights[0] * k[i]
    if stages > 1:
        total += weights[1] * k[SIZE + i]
    if stages > 2:
        total += weights[2] * k[2 * SIZE + i]
    if stages > 3:
        total += weights[3] * k[3 * SIZE + i]
    if stages > 4:
        total += weights[4] * k[4 * SIZE + i]
    if stages > 5:
        total += weights[5] * k[5 * SIZE + i]
    return total


@innermost
def take_stage(r: Rebound, step: float, stage: int) -> None:
    """Write the state of a stage, and its rates."""
    for i in range(SIZE):
        r.trial[i] = r.state[i] + step * weighted(r, i, stage, RUNGE_KUTTA_STAGES[stage])
    write_rates(r, r.trial, stage)


@inner
def take_trial(r: Rebound, step: float) -> float:
    """Make a step from `state` to `trial`, whose first rates are there; return its error."""
    take_stage(r, step, 1)
    take_stage(r, step, 2)
    take_stage(r, step, 3)
    take_stage(r, step, 4)
    take_stage(r, step, 5)
    take_stage(r, step, 6)
    error = 0.0
    for i in range(SIZE):
        rate = weighted(r, i, 6, ERRORS) + ERRORS[6] * r.rates[6 * SIZE + i]
        error = max(error, abs(step * rate))
    return error


@inner
def margin(r: Rebound, state: Vector) -> float:
    """
    Return how far a state is from the next event: negative if it is past it.

    Events are the end of the contact and of compression or restoring, a landing and a take-off,
    and with a tangential spring the beginning and end of slip. The rates of the state are those
    that were written last.
    """
    closing = closing_speed(r, state)
    left = closing if r.compressing else min(-closing, state[Y])
    if r.tangential_stiffness > 0.0:
        left = min(left, spring_margin(r, state))
    if r.held:
        return min(left, r.press)
    return min(left, -state[Z] / state[VZ]) if state[VZ] < 0.0 else left  # the time until it lands


@inner
def slip_limit(r: Rebound) -> float:
    """Longest step that leaves the slips their directions."""
    state, rates, longest = r.state, r.rates, inf
    if r.nose_slips:
        a, b = nose_slip(r, state)
        u = rates[VX] + r.sine * rates[WY] - r.cosine * rates[WZ]
        v = rates[WX] - r.sine * rates[VY] + r.cosine * rates[VZ]
        shrinking = -(a * u + b * v)
        if shrinking > 0.0:
            longest = SLIP_ENDS * (a * a + b * b) / shrinking
    if r.held and r.cloth_slips:
        p, q = cloth_slip(state)
        shrinking = -(p * (rates[VX] - rates[WY]) + q * (rates[VY] + rates[WX]))
        if shrinking > 0.0:
            longest = min(longest, SLIP_ENDS * (p * p + q * q) / shrinking)
    return longest


@inner
def turns_around(r: Rebound) -> bool:
    """Whether a slip has turned by more than a right angle in the trial."""
    if r.nose_slips:
        a, b = nose_slip(r, r.state)
        u, v = nose_slip(r, r.trial)
        if a * u + b * v <= 0.0:
            return True
    if r.held and r.cloth_slips:
        p, q = cloth_slip(r.state)
        u, v = cloth_slip(r.trial)
        if p * u + q * v <= 0.0:
            return True
    return False


@inner
def may_skip_landing(r: Rebound, step: float) -> bool:
    """Whether friction may have lifted the ball in the trial after it met the cloth."""
    if r.held:
        return False
    state, trial = r.state, r.trial
    down, up = -state[VZ], trial[VZ]
    # the tangents of its path at both ends meet below the cloth
    return down > 0.0 and up > 0.0 and state[Z] * up + trial[Z] * down < down * up * step


@innermost
def rub_on_cloth(r: Rebound, x: float, y: float) -> None:
    """Let an impulse (-x, -y) of the cloth's friction act on the ball."""
    state = r.state
    state[VX] -= x
    state[VY] -= y
    state[WX] -= r.turn * y
    state[WY] += r.turn * x


@inner
def land(r: Rebound, still: float) -> None:
    """Let the ball bounce on the cloth; if it hardly leaves it, the nose holds it there."""
    state = r.state
    push = -(1.0 + r.bounce_restitution) * state[VZ]
    p, q = cloth_slip(state)
    slip = size_of(p, q)
    drag = min(r.bounce_friction * push / slip, 1.0 / (1.0 + r.turn)) if slip > 0.0 else 0.0
    rub_on_cloth(r, drag * p, drag * q)
    state[VZ] *= -r.bounce_restitution
    state[Z] = 0.0
    if state[VZ] <= still:
        state[VZ] = 0.0
        r.held = True


@inner
def note_slip_beneath_spring(r: Rebound, close: float) -> None:
    """Note whether a nose with a tangential spring slips on the ball."""
    state = r.state
    speed, x, y = slip_beneath_spring(r, state)
    if not r.spring_slips:
        r.spring_slips = speed > close and spring_margin(r, state) <= close
        if r.spring_slips:
            state[SHEAR], state[LIFT] = x, y
    elif speed <= close:
        r.spring_slips = False
        most = r.nose_friction * state[Y] / r.tangential_stiffness
        size = max(most - 2.0 * close, 0.0)  # so that it does not begin to slip at once
        state[SHEAR], state[LIFT] = size * x, size * y


@inner
def stop_at_nose(r: Rebound, a: float, b: float) -> None:
    """Stop a slip (a, b) at the nose by an impulse of friction; the cloth holds a lying ball."""
    state, up = r.state, 0.0 if r.held else r.cosine * r.cosine
    f, g = -a / (1.0 + r.turn), -b / (r.turn + r.sine * r.sine + up)
    state[VX] += f
    state[VY] -= r.sine * g
    if not r.held:
        state[VZ] += r.cosine * g
    state[WX] += r.turn * g
    state[WY] += r.turn * r.sine * f
    state[WZ] -= r.turn * r.cosine * f


@inner
def note_slips(r: Rebound, tolerance: float, begins: float) -> None:
    """
    Note which contacts slip.

    If a slip is next to none, it ends: an impulse of friction stops the rest of it. That is the
    impulse by which slipping exceeds sticking until the slip is zero, if it keeps its direction.
    A slip that begins is slow, and follows its friction, until it is large enough for a direction
    of its own: `begins`.
    """
    least = STILL_TOLERANCES * tolerance
    p, q = cloth_slip(r.state)
    if r.tangential_stiffness > 0.0:
        r.nose_slips = False
        note_slip_beneath_spring(r, 2.0 * EVENT_SHARE * tolerance)
    else:
        a, b = nose_slip(r, r.state)
        slips = size_of(a, b) > (least if r.nose_slips else begins)
        if r.nose_slips and not slips:
            stop_at_nose(r, a, b)
        r.nose_slips = slips
    slips = size_of(p, q) > (least if r.cloth_slips else begins)
    if r.held and r.cloth_slips and not slips:
        rub_on_cloth(r, p / (1.0 + r.turn), q / (1.0 + r.turn))
    r.cloth_slips = slips


@inner
def is_wedged(r: Rebound, still: float) -> bool:
    """Whether the ball stands still between nose and cloth, whose friction holds it."""
    if r.nose_slips or r.cloth_slips or not r.held:
        return False
    push = abs(r.rates[VY]) + abs(r.rates[WX])
    # At the first touch nothing is pressed yet, and nothing pushes.
    return abs(closing_speed(r, r.state)) <= still and push < 1e-9 * r.state[Y]


@inner
def follow(r: Rebound, tolerance: float) -> bool:
    """
    Follow a ball that approaches the nose until the nose does not press it any more.

    Parameters
    ----------
    r : Rebound, changed
    tolerance : float
        Error of a step.

    Returns
    -------
    solved : bool
        False if it takes too many steps, or if the ball is wedged between nose and cloth.

    """
    state, still = r.state, STILL_TOLERANCES * tolerance
    close = EVENT_SHARE * tolerance * min(closing_speed(r, state), 1.0)
    step, accepted, ahead = FIRST * tolerance**0.2, True, 0.0
    r.compressing = True
    r.nose_slips = r.cloth_slips = True
    r.spring_slips, r.lag = False, tolerance ** (1.0 / 3.0)
    state[SHEAR] = state[LIFT] = 0.0
    begins = tolerance ** (2.0 / 3.0)
    note_slips(r, tolerance, begins)
    for _ in range(MAX_REBOUND_STEPS):
        if accepted:
            write_rates(r, state, 0)
            if r.held and r.press < -close:  # friction at the nose lifts the ball
                r.held = False
                continue
            if is_wedged(r, still):
                return False
            ahead = margin(r, state)
            step = min(step, LONGEST_STEP, slip_limit(r))
            if not r.held and state[Z] <= 0.0 and state[VZ] > 0.0 and r.rates[VZ] < 0.0:
                step = min(step, -state[VZ] / r.rates[VZ])  # so that it does not land in this one
        error = take_trial(r, step)
        factor = 0.9 * (tolerance / max(error, TINY)) ** 0.2
        accepted = step <= SHORTEST_STEP or (
            error <= tolerance and not turns_around(r) and not may_skip_landing(r, step)
        )
        if not accepted:
            step *= min(max(factor, 0.1), 0.5)
            continue
        following = step * min(factor, 4.0)
        left = margin(r, r.trial)
        if left < 0.0:
            step = locate(r, step, ahead, left, close)
        for i in range(SIZE):
            state[i] = r.trial[i]
        r.time += step
        step = following
        if left < 0.0 and carry_out(r, close, still):
            return True
        note_slips(r, tolerance, begins)
    return False


@inner
def interpolate(r: Rebound, step: float, part: float) -> None:
    """Write the state after part of a step, whose rates are there, to `trial`."""
    for i in range(SIZE):
        r.trial[i] = r.state[i]
    for stage in range(7):
        p, q, s, t = DENSE_WEIGHTS[stage]
        weight = step * part * (p + part * (q + part * (s + part * t)))
        for i in range(SIZE):
            r.trial[i] += weight * r.rates[SIZE * stage + i]


@inner
def locate(r: Rebound, step: float, left: float, right: float, close: float) -> float:
    """
    Find the step that ends at the next event: by bisection and the secant's rule in turns.

    `left` and `right` are the margins without the step and after all of it.
    """
    low, high, part = 0.0, 1.0, 1.0
    for i in range(LOCATING):
        part = 0.5 * (low + high)
        if i % 3 != 2 and left > 0.0:
            part = low + (high - low) * left / (left - right)
        interpolate(r, step, part)
        if r.held:
            _, g, _, _ = frictions(r, r.trial)
            r.press = press_of(r, g)
        found = margin(r, r.trial)
        if abs(found) <= close or (high - low) * step <= SHORTEST_STEP:
            break
        if found > 0.0:
            low, left = part, found
        else:
            high, right = part, found
    return part * step


@inner
def carry_out(r: Rebound, close: float, still: float) -> bool:
    """Make the change that an event asks for; return whether the contact ends."""
    state = r.state
    if not r.compressing and state[Y] <= 2.0 * close:
        return True
    if r.held:
        r.held = r.press > 2.0 * close
    elif state[VZ] < 0.0 and state[Z] <= -2.0 * close * state[VZ]:
        land(r, still)
    closing = closing_speed(r, state)
    if abs(closing) <= 2.0 * close:
        r.compressing = not r.compressing
    else:
        r.compressing = closing > 0.0
    return False
