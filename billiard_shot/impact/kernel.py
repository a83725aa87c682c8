"""
The collision as a state transition diagram, in time: which contacts are active, step by step.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = k y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y. Each step is a polynomial (series.py, or
collocation.py where slip has just begun); events are its roots (polynomial.py). Everything inside is
in units of the largest approach speed, the largest response and the largest stiffness, so that
answers cannot depend on any of them.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.collocation import STAGES, collocate
from billiard_shot.impact.events import (
    CONE,
    EMPTY,
    END,
    JOIN,
    NOTHING,
    SLIP_STOP,
    TURN,
    first_event,
    step_size,
)
from billiard_shot.impact.friction import (
    FRICTIONLESS,
    SLIDING,
    STICKING,
    hold,
    release,
)
from billiard_shot.impact.laws import (
    BISTIFFNESS,
    POISSON,
    elastic_energy,
    end_of_restitution,
    opening_rate,
)
from billiard_shot.impact.polynomial import evaluate
from billiard_shot.impact.series import COLUMNS, expand
from billiard_shot.status import Status

MAX_STEPS = 20_000
MAX_PHASES = 5_000
INACTIVE, COMPRESSING, RESTORING = 0, 1, 2
OVER, FLOOR, BUDGET = 10, 11, 12  # why a phase ended, beside the events END and JOIN

OK = int(Status.OK)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
NEGATIVE_ENERGY = int(Status.NEGATIVE_ENERGY)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@compiled
def settle(
    response: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    nothing: float,
    straight: bool,
    phase: NDArray[np.int64],
    grip: NDArray[np.int64],
    young: NDArray[np.bool_],
    direction: NDArray[np.float64],
    fired: NDArray[np.bool_],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """
    Give every active contact its mode of friction; slip below `nothing` is none.

    Contacts that slide keep sliding. The others hold or start to slide as the forces of this moment
    ask, or, where all springs are still empty, the forces of the next moment.
    """
    count = friction.shape[0]
    active = phase != INACTIVE
    onset = np.zeros(count, np.bool_)
    normal = np.zeros(count)
    loaded = False
    for j in range(count):
        young[j] = young[j] and active[j]
        if not active[j]:
            continue
        if y[j] > 0.0:
            loaded = True
        if friction[j] == 0.0:
            grip[j] = FRICTIONLESS
            continue
        x, z = u[3 * j + 1, 0], u[3 * j + 2, 0]
        slip = np.sqrt(x * x + z * z)
        if slip > nothing:
            grip[j] = SLIDING
            direction[2 * j] = x / slip
            direction[2 * j + 1] = z / slip
            fired[j, 1] = False
        elif not (grip[j] == SLIDING and fired[j, 1]):
            u[3 * j + 1, 0] = 0.0
            u[3 * j + 2, 0] = 0.0
            grip[j] = STICKING
            young[j] = False
    for j in range(count):
        if active[j]:
            pressed = y[j] if loaded else max(-u[3 * j, 0], 0.0)
            normal[j] = stiffness[j] * pressed**exponent
    release(response, friction, grip, active, normal, direction, onset)
    for j in range(count):
        if onset[j]:
            fired[j, 1] = True
            young[j] = not straight


@compiled
def excitation(
    response: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    phase: NDArray[np.int64],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
) -> float:
    """Largest normal velocity that an active contact has, or that its spring could still give."""
    largest = 0.0
    for j in range(stiffness.shape[0]):
        if phase[j] != INACTIVE:
            energy = elastic_energy(stiffness[j], y[j], exponent)
            largest = max(largest, abs(u[3 * j, 0]), np.sqrt(2.0 * energy * response[3 * j, 3 * j]))
    return largest


@compiled
def advance(
    x: float,
    scale: float,
    order: int,
    phase: NDArray[np.int64],
    grip: NDArray[np.int64],
    force: NDArray[np.float64],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    impulse: NDArray[np.float64],
    loss: NDArray[np.float64],
) -> None:
    """Move the state (column 0 of u and y) to x, and book impulses and the friction's work."""
    for j in range(phase.shape[0]):
        n = 3 * j
        if phase[j] != INACTIVE:
            for row in range(n, n + 3):
                total = 0.0
                for k in range(order - 1, -1, -1):
                    total = total * x + force[row, k] / (k + 1)
                impulse[row] += scale * x * total
            if grip[j] == SLIDING:
                loss[j, 1] -= scale * work_of(force[n + 1], u[n + 1], order, x)
                loss[j, 1] -= scale * work_of(force[n + 2], u[n + 2], order, x)
    for row in range(u.shape[0]):
        u[row, 0] = evaluate(u[row], order, x)
    for j in range(phase.shape[0]):
        if phase[j] != INACTIVE:
            y[j, 0] = max(evaluate(y[j], order, x), 0.0)


@compiled
def work_of(force: NDArray[np.float64], velocity: NDArray[np.float64], order: int, x: float) -> float:
    """Integral of force times velocity from 0 to x, exact for the polynomials at hand."""
    total = 0.0
    outer = x
    for i in range(order):
        if force[i] != 0.0:
            power = outer
            for k in range(order + 1):
                total += force[i] * velocity[k] * power / (i + k + 1)
                power *= x
        outer *= x
    return total


@compiled
def complete_impulse(
    remaining: float,
    contact: int,
    effective: NDArray[np.float64],
    gain: NDArray[np.float64],
    friction: float,
    grip: NDArray[np.int64],
    direction: NDArray[np.float64],
    u: NDArray[np.float64],
    impulse: NDArray[np.float64],
    loss: NDArray[np.float64],
) -> None:
    """
    Law poisson: give a contact with an empty spring the rest of its impulse, all others untouched.

    Friction acts as before the moment (it holds, or slides until it stops); the energy that
    the spring does not have is booked as a negative loss.
    """
    size = u.shape[0]
    n = 3 * contact
    push = np.zeros(size)
    change = np.zeros(size)
    while remaining > 0.0:
        push[:] = 0.0
        push[n] = 1.0
        if grip[contact] == SLIDING:
            push[n + 1] = -friction * direction[2 * contact]
            push[n + 2] = -friction * direction[2 * contact + 1]
        for row in range(size):
            if gain[row, n] != 0.0:
                push[row] += gain[row, n]
        for row in range(size):
            change[row] = 0.0
            for column in range(size):
                change[row] += effective[row, column] * push[column]
        amount = remaining
        if grip[contact] == SLIDING:
            slip = u[n + 1, 0] * direction[2 * contact] + u[n + 2, 0] * direction[2 * contact + 1]
            rate = change[n + 1] * direction[2 * contact] + change[n + 2] * direction[2 * contact + 1]
            if rate < 0.0 and slip + rate * amount < 0.0:
                amount = -slip / rate
        for row in range(n, n + 3):
            work = amount * push[row] * (u[row, 0] + 0.5 * amount * change[row])
            loss[contact, 0 if row == n else 1] -= work
        for row in range(size):
            u[row, 0] += amount * change[row]
            impulse[row] += amount * push[row]
        remaining -= amount
        if remaining > 0.0:
            grip[contact] = FRICTIONLESS  # it stopped; the springs of the others set no direction


@compiled
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
        W [1/kg]: contact velocities per impulse. Contact j has components 3 j (normal), 3 j + 1 and
        3 j + 2 (tangential). Where all motion stays in one plane per contact, component 3 j + 1
        should lie in it and the couplings to 3 j + 2 be exactly zero: that case is cheaper.
    velocity : (3 N,) float array
        Contact velocities before the collision [m/s]; approaching where the normal one is negative.
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
        A row a phase: why it ended (END, JOIN, OVER ...), at which contact, active flags (N),
        impulses (3 N) [N s] and elastic energies (N) [J] at its end. Phases beyond its rows are counted.
    """
    count = friction.shape[0]
    impulse[:] = 0.0
    account[:] = 0.0
    speed = 0.0
    mobility = 0.0
    firmness = 0.0
    for j in range(count):
        speed = max(speed, -velocity[3 * j])
        mobility = max(mobility, response[3 * j, 3 * j])
        firmness = max(firmness, stiffness[j])
    if speed <= 0.0 or mobility <= 0.0:
        return OK, 0, 0
    u = np.zeros((3 * count, COLUMNS))
    for row in range(3 * count):
        u[row, 0] = velocity[row] / speed
        if abs(u[row, 0]) < 1e-15:
            u[row, 0] = 0.0
    status, phases, steps = run(
        response / mobility, friction, restitution, stiffness / firmness, law, exponent, tolerance,
        u, impulse, account, log,
    )
    for row in range(3 * count):
        impulse[row] *= speed / mobility
    for j in range(count):
        account[j, 0] *= speed * speed / mobility
        account[j, 1] *= speed * speed / mobility
        account[j, 2] *= speed
    for i in range(min(phases, log.shape[0])):
        for column in range(2 + count, 2 + 4 * count):
            log[i, column] *= speed / mobility
        for column in range(2 + 4 * count, 2 + 5 * count):
            log[i, column] *= speed * speed / mobility
    return status, phases, steps


@compiled
def is_straight(
    response: NDArray[np.float64], friction: NDArray[np.float64], u: NDArray[np.float64]
) -> bool:
    """Whether no slip can ever turn: nothing happens in any contact's second tangential direction."""
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


@compiled
def record(
    log: NDArray[np.float64],
    row: int,
    reason: int,
    contact: int,
    stiffness: NDArray[np.float64],
    exponent: float,
    phase: NDArray[np.int64],
    y: NDArray[np.float64],
    impulse: NDArray[np.float64],
) -> None:
    """Write a phase that ends now, while the log has room."""
    if row >= log.shape[0]:
        return
    count = stiffness.shape[0]
    log[row, 0] = reason
    log[row, 1] = contact
    for j in range(count):
        log[row, 2 + j] = 1.0 if phase[j] != INACTIVE else 0.0
        log[row, 2 + 4 * count + j] = elastic_energy(stiffness[j], y[j, 0], exponent)
    for i in range(3 * count):
        log[row, 2 + count + i] = impulse[i]


@compiled
def opening_loss(
    law: int, restitution: float, stiffness: float, exponent: float, peak: float, y: float
) -> float:
    """Energy lost while a spring opened from `peak` to y: law bistiffness gives back e^2 of it."""
    if law != BISTIFFNESS:
        return 0.0
    released = elastic_energy(stiffness, peak, exponent) - elastic_energy(stiffness, y, exponent)
    return (1.0 - restitution * restitution) * released


@compiled
def part(
    contact: int,
    friction: float,
    phase: NDArray[np.int64],
    grip: NDArray[np.int64],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    account: NDArray[np.float64],
) -> None:
    """End a contact, and note the slip it ends with."""
    phase[contact] = INACTIVE
    y[contact, 0] = 0.0
    x, z = u[3 * contact + 1, 0], u[3 * contact + 2, 0]
    account[contact, 2] = 0.0 if grip[contact] == STICKING else np.sqrt(x * x + z * z)
    grip[contact] = FRICTIONLESS


@compiled
def finish(
    phases: int,
    steps: int,
    stiffness: NDArray[np.float64],
    exponent: float,
    phase: NDArray[np.int64],
    grip: NDArray[np.int64],
    friction: NDArray[np.float64],
    y: NDArray[np.float64],
    u: NDArray[np.float64],
    impulse: NDArray[np.float64],
    account: NDArray[np.float64],
    log: NDArray[np.float64],
) -> tuple[int, int, int]:
    """End an infinite sequence that has died down to nothing (paper, theorem 3)."""
    record(log, phases, FLOOR, -1, stiffness, exponent, phase, y, impulse)
    for j in range(phase.shape[0]):
        if phase[j] != INACTIVE:
            account[j, 0] += elastic_energy(stiffness[j], y[j, 0], exponent)
            part(j, friction[j], phase, grip, u, y, account)
    return INFINITE_SEQUENCE, phases + 1, steps


@compiled
def turn_directions(
    straight: bool, grip: NDArray[np.int64], direction: NDArray[np.float64], u: NDArray[np.float64]
) -> None:
    """Note the direction in which each contact slides as a step begins."""
    if straight:
        return
    for j in range(grip.shape[0]):
        if grip[j] == SLIDING:
            x, y = u[3 * j + 1, 0], u[3 * j + 2, 0]
            slip = np.sqrt(x * x + y * y)
            direction[2 * j] = x / slip
            direction[2 * j + 1] = y / slip


@compiled
def slide_against(
    force: NDArray[np.float64], order: int, x: float, direction: NDArray[np.float64]
) -> None:
    """Direction in which a sticking contact begins to slide: against the force that held it."""
    fx, fy = evaluate(force[1], order - 1, x), evaluate(force[2], order - 1, x)
    k = 0
    while x == 0.0 and fx == 0.0 and fy == 0.0 and k < order - 1:
        k += 1
        fx, fy = force[1, k], force[2, k]
    size = np.sqrt(fx * fx + fy * fy)
    direction[0] = -fx / size
    direction[1] = -fy / size


@compiled
def implicit_step(
    effective: NDArray[np.float64],
    gain: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    rate: NDArray[np.float64],
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    young: NDArray[np.bool_],
    direction: NDArray[np.float64],
    scale: float,
    tolerance: float,
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    force: NDArray[np.float64],
) -> tuple[float, float]:
    """Collocate, with shorter and shorter steps until one is good; return its length and error."""
    turn_young(young, direction, u)
    while scale > 1e-14:
        error = collocate(
            effective, gain, friction, stiffness, exponent, rate, active, grip, young, direction,
            scale, tolerance, u, y, force,
        )
        if error <= tolerance:
            return scale, error
        scale *= max(0.7 * (tolerance / error) ** (1.0 / STAGES), 0.1) if error < 1e300 else 0.25
    return 0.0, 0.0


@compiled
def turn_young(
    young: NDArray[np.bool_], direction: NDArray[np.float64], u: NDArray[np.float64]
) -> None:
    """Directions of young contacts: of the slip, or, where it is still zero, as decided at its onset."""
    for j in range(young.shape[0]):
        if young[j]:
            x, y = u[3 * j + 1, 0], u[3 * j + 2, 0]
            slip = np.sqrt(x * x + y * y)
            if slip > 0.0:
                direction[2 * j] = x / slip
                direction[2 * j + 1] = y / slip


@compiled
def mature(
    effective: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    length: float,
    young: NDArray[np.bool_],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """Release from implicit steps the contacts whose slip an explicit step of like length follows."""
    for j in range(young.shape[0]):
        if young[j]:
            n = 3 * j
            slip = np.sqrt(u[n + 1, 0] ** 2 + u[n + 2, 0] ** 2)
            turning = max(effective[n + 1, n + 1], effective[n + 2, n + 2])
            turning *= friction[j] * stiffness[j] * y[j, 0] ** exponent
            young[j] = slip < 0.5 * length * turning


@compiled
def run(
    response: NDArray[np.float64],
    friction: NDArray[np.float64],
    restitution: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    law: int,
    exponent: float,
    tolerance: float,
    u: NDArray[np.float64],
    impulse: NDArray[np.float64],
    account: NDArray[np.float64],
    log: NDArray[np.float64],
) -> tuple[int, int, int]:
    """Walk through the states of a collision in scaled units; see `solve`."""
    count = friction.shape[0]
    y = np.zeros((count, COLUMNS))
    force = np.zeros((3 * count, COLUMNS))
    work = np.empty((4 * count, COLUMNS))
    roots = np.empty((3, COLUMNS))
    effective, gain = np.empty_like(response), np.empty_like(response)
    phase, grip = np.zeros(count, np.int64), np.zeros(count, np.int64)
    young, light = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    fired = np.zeros((count, 2), np.bool_)
    direction, rate = np.zeros(2 * count), np.ones(count)
    goal, peak, begun = np.zeros(count), np.zeros(count), np.zeros(count)
    heavy = (1e-3 * tolerance / stiffness) ** (1.0 / exponent)
    straight = is_straight(response, friction, u)
    order = min(max(int(4.5 - np.log10(tolerance)), 6), COLUMNS - 4)
    floor = max(1e-2 * tolerance, 1e-14)
    status = OK
    phases = 0
    creeping = 0
    idle = True  # nothing has happened yet in this phase
    scale = 1.0
    for j in range(count):
        fired[j, 0] = u[3 * j, 0] == 0.0
        phase[j] = COMPRESSING if u[3 * j, 0] < 0.0 else INACTIVE
    unsettled = True
    stirred = 1.0
    for step in range(MAX_STEPS):
        if phases >= MAX_PHASES:
            return BUDGET_EXCEEDED, phases, step
        if unsettled:
            settle(
                response, friction, stiffness, exponent, 1e-3 * tolerance, straight,
                phase, grip, young, direction, fired, u, y[:, 0],
            )
            hold(response, grip, phase != INACTIVE, effective, gain)
            unsettled = False
            stirred = excitation(response, stiffness, exponent, phase, u, y[:, 0])
            if stirred < floor and phases > 0:
                return finish(
                    phases, step, stiffness, exponent, phase, grip, friction, y, u, impulse, account, log
                )
        fresh = False
        for j in range(count):
            fresh = fresh or young[j]
            light[j] = exponent != 1.0 and phase[j] != INACTIVE and y[j, 0] < heavy[j]
        local = 0.1 * tolerance * min(1.0, max(stirred, floor))
        active = phase != INACTIVE
        if fresh:
            degree = STAGES
            end = 1.0
            scale, error = implicit_step(
                effective, gain, friction, stiffness, exponent, rate, active, grip, young,
                direction, scale, local, u, y, force,
            )
            if scale == 0.0:  # the slip does not begin after all
                for j in range(count):
                    if young[j]:
                        young[j] = False
                        grip[j] = STICKING
                        u[3 * j + 1, 0] = 0.0
                        u[3 * j + 2, 0] = 0.0
                hold(response, grip, active, effective, gain)
                scale = 1e-3
                continue
        else:
            degree = order
            turn_directions(straight, grip, direction, u)
            expand(
                effective, gain, friction, stiffness, exponent, rate, active, grip, light, straight,
                direction, scale, order, u, y, force, work,
            )
            end = step_size(friction, grip, active, order, local, u)
            if end == 0.0:
                scale *= 1e-3
                continue
            error = local
        reach = end
        x, event, j = first_event(
            law, friction, phase, grip, young, straight, direction, fired, light, heavy, goal,
            impulse, scale, degree, end, u, y, force, roots,
        )
        if event == CONE:
            slide_against(force[3 * j : 3 * j + 3], degree, x, direction[2 * j : 2 * j + 2])
        if x > 0.0:
            advance(x, scale, degree, phase, grip, force, u, y, impulse, account)
            fired[:] = False
            idle = False
            for i in range(count):
                if phase[i] != INACTIVE and grip[i] == SLIDING and not straight:
                    slip = np.sqrt(u[3 * i + 1, 0] ** 2 + u[3 * i + 2, 0] ** 2)
                    if slip <= 1e-3 * tolerance and not (event == SLIP_STOP and i == j):
                        unsettled = True
        if fresh:
            mature(effective, friction, stiffness, exponent, scale, young, u, y)
            scale *= min(max(0.8 * (local / max(error, 1e-300)) ** (1.0 / STAGES), 0.2), 4.0)
        else:
            creeping = creeping + 1 if reach * scale < 0.01 and event == NOTHING and x == reach else 0
            scale *= min(max(reach, 1e-3), 1e3)
            if creeping >= 8 and not straight:
                creeping = 0
                for i in range(count):
                    young[i] = phase[i] != INACTIVE and grip[i] == SLIDING
        if event == NOTHING:
            continue
        if event == TURN:
            u[3 * j, 0] = 0.0
            fired[j, 0] = True
            if phase[j] == COMPRESSING:
                phase[j] = RESTORING
                peak[j] = y[j, 0]
                rate[j] = opening_rate(law, restitution[j])
                goal[j] = end_of_restitution(law, restitution[j], exponent, y[j, 0])
                if law == POISSON:
                    goal[j] = begun[j] + (1.0 + restitution[j]) * (impulse[3 * j] - begun[j])
            else:
                phase[j] = COMPRESSING
                rate[j] = 1.0
                account[j, 0] += opening_loss(
                    law, restitution[j], stiffness[j], exponent, peak[j], y[j, 0]
                )
        elif event == SLIP_STOP:
            u[3 * j + 1, 0] = 0.0
            u[3 * j + 2, 0] = 0.0
            grip[j] = STICKING
            unsettled = True
        elif event == CONE:
            grip[j] = SLIDING
            fired[j, 1] = True
            young[j] = not straight
            u[3 * j + 1, 0] = 0.0
            u[3 * j + 2, 0] = 0.0
            hold(response, grip, active, effective, gain)
        else:
            if not idle:
                record(log, phases, event, j, stiffness, exponent, phase, y, impulse)
                phases += 1
                idle = True
            unsettled = True
            if event == JOIN:
                phase[j] = COMPRESSING
                y[j, 0] = 0.0
                rate[j] = 1.0
                begun[j] = impulse[3 * j]
                grip[j] = FRICTIONLESS
                young[j] = False
                fired[j, 1] = False
                if x > 0.0 or fired[j, 0]:
                    u[3 * j, 0] = 0.0
                    fired[j, 0] = True
            else:
                if event == EMPTY:
                    complete_impulse(
                        goal[j] - impulse[3 * j], j, effective, gain, friction[j], grip, direction,
                        u, impulse, account,
                    )
                    status = NEGATIVE_ENERGY
                else:
                    left = opening_loss(law, restitution[j], stiffness[j], exponent, peak[j], y[j, 0])
                    if law != BISTIFFNESS or restitution[j] == 0.0:
                        left = elastic_energy(stiffness[j], y[j, 0], exponent)
                    account[j, 0] += left
                part(j, friction[j], phase, grip, u, y, account)
                over = True
                for i in range(count):
                    over = over and phase[i] == INACTIVE and not u[3 * i, 0] < 0.0
                if over:
                    return status, phases, step + 1
    return BUDGET_EXCEEDED, phases, MAX_STEPS
