"""
The collision as a state transition diagram, in time: which contacts are active, step by step.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = stiffness y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y. Each step is a polynomial (series.py,
or collocation.py where slip has just begun); events are its roots (events.py). Everything inside
is in units of the largest approach speed, response and stiffness: answers cannot depend on them.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, entry, inlined
from billiard_shot.impact.collocation import implicit_step, STAGES
from billiard_shot.impact.events import (
    CONE,
    EMPTY,
    END,
    first_event,
    heavy,
    JOIN,
    NOTHING,
    SLIP_STOP,
    TURN,
)
from billiard_shot.impact.friction import holds, let_go, NO_SLIP, settle
from billiard_shot.impact.laws import (
    BISTIFFNESS,
    elastic_energy,
    end_of_restitution,
    opening_rate,
    POISSON,
)
from billiard_shot.impact.polynomial import evaluate
from billiard_shot.impact.series import expand, step_size
from billiard_shot.impact.standstill import MOVES, stand, STOPPED
from billiard_shot.impact.state import (
    COLUMNS,
    COMPRESSING,
    FRICTIONLESS,
    INACTIVE,
    initial_state,
    Model,
    RESTORING,
    SLIDING,
    slip_speed,
    State,
    STICKING,
    stop_slip,
)
from billiard_shot.status import Status

LOOSEST = 1e-6  # tolerance: a looser one would save a sixth of the steps, and lose its meaning
MAX_STEPS = 20_000
MAX_PHASES = 5_000
FLOOR = 10  # why a phase ended, beside the events END, JOIN and EMPTY: the energy floor
ROUNDING = 1e-14  # of velocities, in units of the largest
PINNED_STEP = 0.01  # longest step while contacts hold beyond their own cones
CAUTION = 0.02  # part of the tolerance that a step may use up
CREEP = 0.01  # explicit steps shorter than this, CREEP_STEPS in a row, mean that slip creeps
CREEP_STEPS = 8

OK = int(Status.OK)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
NEGATIVE_ENERGY = int(Status.NEGATIVE_ENERGY)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@compiled
def work_of(
    force: NDArray[np.float64], velocity: NDArray[np.float64], order: int, x: float
) -> float:
    """Integral of force times velocity from 0 to x, exact for the polynomials at hand."""
    total = 0.0
    power = x
    for n in range(2 * order):
        product = 0.0
        for i in range(max(0, n - order), min(n, order - 1) + 1):
            product += force[i] * velocity[n - i]
        total += product * power / (n + 1)
        power *= x
    return total


@compiled
def advance(s: State, scale: float, order: int, x: float) -> None:
    """Move the state to x, and book the impulses and the work of friction."""
    for j in range(s.phase.shape[0]):
        n = 3 * j
        if s.phase[j] == INACTIVE:
            continue
        for row in range(n, n + 3 if s.grip[j] != FRICTIONLESS else n + 1):
            total = 0.0
            for k in range(order - 1, -1, -1):
                total = total * x + s.force[row, k] / (k + 1)
            s.impulse[row] += scale * x * total
        if s.grip[j] == SLIDING:
            s.account[j, 1] -= scale * work_of(s.force[n + 1], s.u[n + 1], order, x)
            s.account[j, 1] -= scale * work_of(s.force[n + 2], s.u[n + 2], order, x)
    for row in range(s.u.shape[0]):
        s.u[row, 0] = evaluate(s.u[row], order, x)
    for j in range(s.phase.shape[0]):
        s.still[j] = False
        s.onset[j] = False
        if s.phase[j] != INACTIVE:
            s.y[j, 0] = max(evaluate(s.y[j], order, x), 0.0)
        elif abs(s.u[3 * j, 0]) <= ROUNDING:
            s.u[3 * j, 0] = 0.0
            s.still[j] = True


@compiled
def excitation(m: Model, s: State) -> float:
    """Largest normal velocity that a contact has, or that its spring could still give."""
    largest = 0.0
    for j in range(m.stiffness.shape[0]):
        if s.phase[j] == INACTIVE:
            largest = max(largest, -s.u[3 * j, 0])
        else:
            energy = elastic_energy(m.stiffness[j], s.y[j, 0], m.exponent)
            spring = np.sqrt(2.0 * energy * m.response[3 * j, 3 * j])
            largest = max(largest, abs(s.u[3 * j, 0]), spring)
    return largest


@compiled
def opening_loss(m: Model, s: State, j: int) -> float:
    """Energy lost while a spring opened from its peak: law bistiffness gives back e^2 of it."""
    if m.law != BISTIFFNESS:
        return 0.0
    e = m.restitution[j]
    peak = elastic_energy(m.stiffness[j], s.peak[j], m.exponent)
    return (1.0 - e * e) * (peak - elastic_energy(m.stiffness[j], s.y[j, 0], m.exponent))


@compiled
def turn(m: Model, s: State, j: int) -> None:
    """End a contact's compression, or begin it anew."""
    s.u[3 * j, 0] = 0.0
    s.still[j] = True
    if s.phase[j] == COMPRESSING:
        s.phase[j] = RESTORING
        s.peak[j] = s.y[j, 0]
        s.rate[j] = opening_rate(m.law, m.restitution[j])
        s.goal[j] = end_of_restitution(m.law, m.restitution[j], m.exponent, s.y[j, 0])
        if m.law == POISSON:
            s.goal[j] = s.impulse[3 * j] + m.restitution[j] * (s.impulse[3 * j] - s.begun[j])
    else:
        s.phase[j] = COMPRESSING
        s.rate[j] = 1.0
        s.account[j, 0] += opening_loss(m, s, j)


@compiled
def join(s: State, j: int, known: bool) -> None:
    """Make a contact active; `known`: its normal velocity is just now passing zero."""
    s.phase[j] = COMPRESSING
    s.grip[j] = FRICTIONLESS
    s.y[j, 0] = 0.0
    s.rate[j] = 1.0
    s.begun[j] = s.impulse[3 * j]
    if known:
        s.u[3 * j, 0] = 0.0
        s.still[j] = True


@compiled
def part(m: Model, s: State, j: int) -> None:
    """End a contact: book the energy that its spring keeps, and note the slip it ends with."""
    s.account[j, 0] += opening_loss(m, s, j) if s.phase[j] == RESTORING else 0.0
    s.account[j, 0] += elastic_energy(m.stiffness[j], s.y[j, 0], m.exponent)
    s.account[j, 2] = 0.0 if s.grip[j] == STICKING else slip_speed(s, j)
    s.phase[j] = INACTIVE
    s.grip[j] = FRICTIONLESS
    s.y[j, 0] = 0.0


@compiled
def complete_impulse(m: Model, s: State, j: int) -> None:
    """
    Law poisson: give a contact with an empty spring the rest of its impulse, all others untouched.

    Friction acts as before the moment (it holds, or slides until it stops); the energy that
    the spring does not have is booked as a negative loss.
    """
    n = 3 * j
    size = s.u.shape[0]
    remaining = s.goal[j] - s.impulse[n]
    push, change = np.zeros(size), np.zeros(size)
    while remaining > 0.0:
        dx, dy = s.direction[j, 0], s.direction[j, 1]
        for row in range(size):
            push[row] = s.gain[row, n]
        push[n] = 1.0
        if s.grip[j] == SLIDING:
            push[n + 1], push[n + 2] = -m.friction[j] * dx, -m.friction[j] * dy
        for row in range(size):
            change[row] = s.effective[row, n]
            if s.grip[j] == SLIDING:
                change[row] += s.effective[row, n + 1] * push[n + 1]
                change[row] += s.effective[row, n + 2] * push[n + 2]
        amount = remaining
        slip = s.u[n + 1, 0] * dx + s.u[n + 2, 0] * dy
        rate = change[n + 1] * dx + change[n + 2] * dy
        if s.grip[j] == SLIDING and slip + rate * amount < 0.0:
            amount = -slip / rate
        for row in range(n, n + 3):
            work = amount * push[row] * (s.u[row, 0] + 0.5 * amount * change[row])
            s.account[j, 0 if row == n else 1] -= work
        for row in range(size):
            s.u[row, 0] += amount * change[row]
            s.impulse[row] += amount * push[row]
        remaining -= amount
        if remaining > 0.0:
            s.grip[j] = FRICTIONLESS  # it stopped; the springs of the others set no direction


@compiled
def slide_against(s: State, j: int, order: int, x: float) -> None:
    """Begin to slide at x: against the force that held until then."""
    fx, fy = evaluate(s.force[3 * j + 1], order - 1, x), evaluate(s.force[3 * j + 2], order - 1, x)
    for k in range(order):
        if x == 0.0 and fx == 0.0 and fy == 0.0:
            fx, fy = s.force[3 * j + 1, k], s.force[3 * j + 2, k]
    size = np.sqrt(fx * fx + fy * fy)
    s.direction[j, 0] = -fx / size
    s.direction[j, 1] = -fy / size


@compiled
def aim(s: State) -> None:
    """Note the direction of each contact's slip as a step begins, unless it has yet to grow."""
    for j in range(s.grip.shape[0]):
        if s.grip[j] == SLIDING and not s.onset[j]:
            size = slip_speed(s, j)
            s.direction[j, 0] = s.u[3 * j + 1, 0] / size
            s.direction[j, 1] = s.u[3 * j + 2, 0] / size


@compiled
def explicit_step(
    m: Model, s: State, scale: float, order: int, tolerance: float
) -> tuple[float, float]:
    """Expand the state; return the scale that did not overflow, and the length in its units."""
    length = 0.0
    while length == 0.0 and scale > 1e-100:
        expand(m, s, scale, order)
        length = step_size(m, s, order, tolerance)
        if length == 0.0:
            scale *= 1e-3
    return scale, length


@compiled
def mature(m: Model, s: State, length: float) -> None:
    """Release from implicit steps the contacts that an explicit step of like length follows."""
    for j in range(s.young.shape[0]):
        if s.young[j]:
            n = 3 * j
            turning = max(s.effective[n + 1, n + 1], s.effective[n + 2, n + 2])
            turning *= m.friction[j] * m.stiffness[j] * s.y[j, 0] ** m.exponent
            s.young[j] = slip_speed(s, j) < 0.5 * length * turning


@compiled
def record(
    m: Model, s: State, log: NDArray[np.float64], row: int, reason: int, contact: int
) -> None:
    """Write a phase that ends now, while the log has room."""
    if row >= log.shape[0]:
        return
    count = m.stiffness.shape[0]
    log[row, 0] = reason
    log[row, 1] = contact
    for j in range(count):
        log[row, 2 + j] = 1.0 if s.phase[j] != INACTIVE else 0.0
        log[row, 2 + 4 * count + j] = elastic_energy(m.stiffness[j], s.y[j, 0], m.exponent)
    for i in range(3 * count):
        log[row, 2 + count + i] = s.impulse[i]


@compiled
def transition(m: Model, s: State, event: int, j: int, known: bool) -> bool:
    """Carry out an event at contact j; True where forces jumped, so that friction must settle."""
    if event == TURN:
        turn(m, s, j)
        return False
    if event == CONE:
        let_go(m, s, j)
        return False
    if event == SLIP_STOP:
        stop_slip(s, j)
        s.onset[j] = False
    elif event == JOIN:
        join(s, j, known)
    else:
        if event == EMPTY:
            complete_impulse(m, s, j)
        part(m, s, j)
    return True


@compiled
def is_over(s: State) -> bool:
    """Whether no contact is active and none approaches."""
    for j in range(s.phase.shape[0]):
        if s.phase[j] != INACTIVE or s.u[3 * j, 0] < -ROUNDING:
            return False
    return True


@inlined
def run(m: Model, s: State, log: NDArray[np.float64]) -> tuple[int, int, int]:
    """Walk through the states of a collision; return its status, numbers of phases and steps."""
    count = m.friction.shape[0]
    order = min(max(int(4.5 - np.log10(m.tolerance)), 6), COLUMNS - 4)
    floor = max(1e-2 * m.tolerance, 1e-14)
    status = OK
    phases = 0
    creeping = 0
    scale = 1.0
    stirred = 1.0
    moved = False  # since the last change of state
    unsettled = True
    for step in range(MAX_STEPS):
        if phases >= MAX_PHASES:
            return BUDGET_EXCEEDED, phases, step
        if unsettled:
            settle(m, s)
            unsettled = False
            stirred = excitation(m, s)
            if stirred < floor:
                record(m, s, log, phases, FLOOR, -1)
                for j in range(count):
                    if s.phase[j] != INACTIVE:
                        part(m, s, j)
                return INFINITE_SEQUENCE, phases + 1, step
        fresh = False
        pinned = False
        for j in range(count):
            pinned = pinned or s.pinned[j]
            fresh = fresh or s.young[j]
            s.light[j] = m.exponent != 1.0 and s.y[j, 0] < heavy(m, j)
        if not m.straight:
            aim(s)
        tolerance = CAUTION * m.tolerance * min(1.0, stirred)
        degree, noise, end = order, max(ROUNDING, tolerance), 1.0
        error = tolerance
        if fresh:
            degree = STAGES
            scale, error = implicit_step(m, s, scale, tolerance)
            noise = error
        else:
            scale, end = explicit_step(m, s, scale, order, tolerance)
            if end < 1.0 and not m.straight:
                fate = stand(m, s, scale, tolerance)
                if fate != MOVES:
                    moved = True
                    unsettled = fate == STOPPED
                    scale = 1.0
                    continue
        if scale == 0.0:  # the slip does not begin after all
            for j in range(count):
                if s.young[j]:
                    stop_slip(s, j)
                    s.onset[j] = False
            unsettled = True
            scale = 1.0
            continue
        if pinned:
            end = min(end, PINNED_STEP / scale)
        x, event, j = first_event(m, s, scale, degree, noise, end)
        known = x > 0.0 or (j >= 0 and s.still[j])
        if event == CONE:
            slide_against(s, j, degree, x)
        if x > 0.0:
            moved = True
            unsettled = pinned and not holds(m, s, degree, x)
            advance(s, scale, degree, x)
            for i in range(count):
                if s.grip[i] == SLIDING and not m.straight:
                    unsettled = unsettled or slip_speed(s, i) <= NO_SLIP * m.tolerance
            if fresh:
                mature(m, s, scale)
        if event in (JOIN, END, EMPTY):
            if moved:
                record(m, s, log, phases, event, j)
                phases += 1
            moved = False
        if event == EMPTY:
            status = NEGATIVE_ENERGY
        if event != NOTHING:
            unsettled = transition(m, s, event, j, known) or unsettled
        if is_over(s):
            return status, phases, step + 1
        if fresh:
            scale *= min(max(0.8 * (tolerance / max(error, 1e-300)) ** (1.0 / STAGES), 0.2), 4.0)
        else:
            scale *= min(max(end, 1e-3), 1e3)
            creeping = creeping + 1 if event == NOTHING and x == end and scale < CREEP else 0
            if creeping >= CREEP_STEPS and not m.straight:
                creeping = 0
                for i in range(count):
                    s.young[i] = s.grip[i] == SLIDING
    return BUDGET_EXCEEDED, phases, MAX_STEPS


@compiled
def is_straight(
    response: NDArray[np.float64], friction: NDArray[np.float64], u: NDArray[np.float64]
) -> bool:
    """Whether no slip can ever turn: nothing happens in any second tangential direction."""
    count = friction.shape[0]
    for i in range(count):
        if friction[i] > 0.0:
            if u[3 * i + 2, 0] != 0.0:
                return False
            for j in range(count):
                if response[3 * i + 2, 3 * j] != 0.0:
                    return False
                if friction[j] > 0.0 and response[3 * i + 2, 3 * j + 1] != 0.0:
                    return False
    return True


@entry
def solve(
    response: NDArray[np.float64],
    velocity: NDArray[np.float64],
    friction: NDArray[np.float64],
    restitution: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    law: int,
    exponent: float,
    tolerance: float,
    impulse: NDArray[np.float64],
    account: NDArray[np.float64],
    log: NDArray[np.float64],
) -> tuple[int, int, int]:
    """
    Solve a collision in contact space; return its status, its number of phases, and of steps.

    Parameters
    ----------
    response : (3 N, 3 N) float array
        W [1/kg]: contact velocities per impulse. Contact j has components 3 j (normal), 3 j + 1
        and 3 j + 2 (tangential). Where all motion stays in one plane per contact, component
        3 j + 1 should lie in it and couplings to 3 j + 2 be exactly zero: that is cheaper.
    velocity : (3 N,) float array
        Contact velocities before the collision [m/s]; approaching where the normal one is below 0.
    friction, restitution, stiffness : (N,) float arrays
        Coulomb coefficients, coefficients of restitution, stiffnesses (their ratios matter).
    law, exponent : int, float
        See laws.py.
    tolerance : float
        Error of the result relative to the largest approach speed.
    impulse : (3 N,) float array, written
        Impulses on bodies a [N s].
    account : (N, 3) float array, written
        Energy lost to restitution and to friction [J]; slip [m/s] when the contact last ended.
    log : (rows, 2 + 5 N) float array, written
        A row a phase: why it ended (JOIN, END, EMPTY, FLOOR), at which contact, active flags (N),
        impulses (3 N) [N s] and elastic energies (N) [J] at its end. Phases beyond its rows are
        counted only.
    """
    count = friction.shape[0]
    speed = 0.0
    mobility = 0.0
    firmness = 0.0
    for j in range(count):
        speed = max(speed, -velocity[3 * j])
        mobility = max(mobility, response[3 * j, 3 * j])
        firmness = max(firmness, stiffness[j])
    for row in range(3 * count):
        impulse[row] = 0.0
        account[row // 3, row % 3] = 0.0
    if speed <= 0.0 or mobility <= 0.0:
        return OK, 0, 0
    s = initial_state(count, impulse, account)
    scaled_response, scaled_stiffness = np.empty((3 * count, 3 * count)), np.empty(count)
    for row in range(3 * count):
        u = velocity[row] / speed
        s.u[row, 0] = u if abs(u) >= ROUNDING else 0.0
        for column in range(3 * count):
            scaled_response[row, column] = response[row, column] / mobility
    for j in range(count):
        scaled_stiffness[j] = stiffness[j] / firmness
        s.still[j] = s.u[3 * j, 0] == 0.0
        s.phase[j] = COMPRESSING if s.u[3 * j, 0] < 0.0 else INACTIVE
    m = Model(
        scaled_response,
        friction,
        restitution,
        scaled_stiffness,
        law,
        exponent,
        min(tolerance, LOOSEST),
        is_straight(scaled_response, friction, s.u),
    )
    status, phases, steps = run(m, s, log)
    unit = speed / mobility
    for row in range(3 * count):
        impulse[row] *= unit
    for j in range(count):
        account[j, 0] *= unit * speed
        account[j, 1] *= unit * speed
        account[j, 2] *= speed
    for i in range(min(phases, log.shape[0])):
        for column in range(2 + count, 2 + 5 * count):
            log[i, column] *= unit if column < 2 + 4 * count else unit * speed
    return status, phases, steps
