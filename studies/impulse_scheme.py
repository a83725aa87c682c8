"""
The paper's own method: fixed steps of impulse instead of time, for two contacts.

Jia, Mason and Erdmann, A State Transition Diagram for Simultaneous Collisions with Application in
Billiard Shooting (WAFR 2008); equation numbers are theirs. First order in the step, kept for
comparison: `collide` solves the same model with located events and a controlled error.
Corrected here: a restoring contact ends at (1 - e^2) E_max (section 2.2 says e^2 E_max was lost);
E_max is renewed when a restoring contact is compressed again; and the motion decides whether the
table takes part in a stroke, not the height of the contact point (section 3).
"""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.impact import friction
from billiard_shot.impact.options import LAWS, POISSON
from billiard_shot.status import BUDGET_EXCEEDED, NEGATIVE_ENERGY, OK, Status

IS_COMPILED = find_spec('numba') is not None
"""Whether the scheme is compiled when it is first called; if not, it takes 200 times as long."""


def compiled(function: Any) -> Any:
    """Let numba compile a function when it is first called, if numba is installed."""
    if not IS_COMPILED:
        return function
    from numba import njit

    return njit(cache=True, error_model='numpy')(function)


least_over_disc = compiled(friction.minimize_over_disc)
MAX_IMPULSE_STEPS = 20_000_000
MAX_STATES = 10_000
CURVE_ROWS = 2_000
STEEPEST = 10.0  # largest growth of a secondary impulse at once, in steps
NOT_ACTIVE_YET, COMPRESSING, RESTORING = 0, 1, 2
ACTIVE_STATE_NAMES = (
    '',
    'S3',
    'S2',
    'S1',
)  # by the active contacts: 1 for the first plus 2 for the second


@dataclass(frozen=True, slots=True)
class ImpulseRun:
    """
    Result of the impulse scheme.

    Attributes
    ----------
    status : Status
        OK, NEGATIVE_ENERGY (law `poisson`) or BUDGET_EXCEEDED.
    states : tuple of str
        S1: both contacts active; S2: only the second (table); S3: only the first.
    impulses, energies : (states, 2) float arrays
        Normal impulses [N s] and elastic energies [J] of the two contacts as each state ends.
    velocities, spins : (bodies, 3) float arrays
        [m/s] and [rad/s], at the end. Bodies: upper and lower ball; or cue and ball.
    lost : float
        Kinetic energy lost in the whole collision [J].
    curve : (rows, 4) float array
        The impulse curve I1, I2 [N s] and the elastic energies E1, E2 [J] along it, thinned.
    steps : int
        Steps taken.

    """

    status: Status
    states: tuple[str, ...]
    impulses: NDArray[np.float64]
    energies: NDArray[np.float64]
    velocities: NDArray[np.float64]
    spins: NDArray[np.float64]
    lost: float
    curve: NDArray[np.float64]
    steps: int


def two_balls(
    masses: tuple[float, float],
    restitution: tuple[float, float],
    ratio: float,
    speed: float,
    step: float,
    law: str = 'energetic',
) -> ImpulseRun:
    """
    Let a ball fall onto another that rests on a table, centres in a vertical line (section 2).

    Parameters
    ----------
    masses : (float, float)
        Of the upper and the lower ball [kg].
    restitution : (float, float)
        Of ball against ball and ball against table, 0 to 1.
    ratio : float
        Stiffness ratio k2 / k1, table contact over ball contact.
    speed : float
        Of the upper ball, downwards [m/s].
    step : float
        Increment of the primary impulse [N s].
    law : str
        'energetic' (section 2.2) or 'poisson' (section 2.1).

    Returns
    -------
    ImpulseRun
        Velocities along z, up.

    """
    _check(step=step, speed=speed, ratio=ratio, upper_mass=masses[0], lower_mass=masses[1])
    upper, lower = 1.0 / masses[0], 1.0 / masses[1]
    response = np.zeros((6, 6))
    response[0, 0], response[0, 3] = upper + lower, -lower  # equations (5), (6): u1 = v1 - v2
    response[3, 0], response[3, 3] = -lower, lower  # u2 = v2
    velocity = np.zeros(6)
    velocity[0] = -speed
    run = _run(
        response, velocity, np.zeros(2), restitution, np.array([1.0, ratio]), law, step=step
    )
    status, impulse, states, steps, curve = run
    velocities = np.zeros((2, 3))
    velocities[0, 2] = -speed + upper * impulse[0]  # (13)
    velocities[1, 2] = lower * (impulse[3] - impulse[0])
    before = 0.5 * masses[0] * speed**2
    after = 0.5 * float(np.asarray(masses) @ velocities[:, 2] ** 2)
    return _result(
        status, states, velocities, np.zeros((2, 3)), before - after, curve, steps=steps
    )


def solve_strike(
    normal: ArrayLike,
    velocity: ArrayLike,
    cue_mass: float,
    ball_mass: float,
    radius: float,
    friction: tuple[float, float],
    restitution: tuple[float, float],
    ratio: float,
    step: float,
    law: str = 'energetic',
) -> ImpulseRun:
    """
    Strike a resting ball with a cue that is guided along its velocity (section 3).

    Parameters
    ----------
    normal : (3,) array_like
        Outward normal n of the ball at the tip, any length; table frame, z up.
    velocity : (3,) array_like
        Of the cue [m/s]. It must point into the ball.
    cue_mass, ball_mass, radius : float
        M [kg], m [kg], r [m].
    friction, restitution : (float, float)
        Of cue against ball and ball against table.
    ratio : float
        Stiffness ratio k_cb / k_bt, cue contact over table contact.
    step : float
        Increment of the primary normal impulse [N s].
    law : str
        'energetic' (the paper's) or 'poisson'.

    Returns
    -------
    ImpulseRun
        Bodies: the cue, the ball.

    """
    n, v_c = np.array(normal, float), np.array(velocity, float)
    if n.shape != (3,) or not 0.0 < np.linalg.norm(n) < np.inf:
        raise ValueError(f'normal must be three finite numbers, not all zero, got {normal!r}')
    if v_c.shape != (3,) or not 0.0 < np.linalg.norm(v_c) < np.inf:
        raise ValueError(f'velocity must be three finite numbers, not all zero, got {velocity!r}')
    n /= np.linalg.norm(n)
    if n @ v_c >= 0.0:
        raise ValueError(f'velocity must point into the ball, got {velocity!r} at {normal!r}')
    _check(step=step, ratio=ratio, cue_mass=cue_mass, ball_mass=ball_mass, radius=radius)
    speed = float(np.linalg.norm(v_c))
    c, z = v_c / speed, np.array([0.0, 0.0, 1.0])
    to_contacts = np.zeros((6, 7))  # u = to_contacts @ (cue speed, v, omega); equation (18)
    to_contacts[:3, 0] = _frame(n) @ c
    to_contacts[:3, 1:4] = -_frame(n)
    to_contacts[3:, 1:4] = _frame(z)
    to_contacts[:3, 4:] = np.cross(_frame(n), radius * n)
    to_contacts[3:, 4:] = np.cross(_frame(z), radius * z)
    turn = 2.5 / (ball_mass * radius**2)
    mobility = np.array([1.0 / cue_mass, *[1.0 / ball_mass] * 3, turn, turn, turn])  # (16), (17)
    response = to_contacts @ (mobility[:, None] * to_contacts.T)
    contact_velocity = to_contacts[:, 0] * speed
    mu = np.asarray(friction, float)
    if mu.shape != (2,) or not (np.isfinite(mu) & (mu >= 0.0)).all():
        raise ValueError(f'friction must be two finite numbers >= 0, got {friction!r}')
    run = _run(response, contact_velocity, mu, restitution, np.array([ratio, 1.0]), law, step=step)
    status, impulse, states, steps, curve = run
    motion = mobility * (impulse @ to_contacts)
    motion[0] += speed
    before = 0.5 * cue_mass * speed**2
    velocities, spins = np.array([motion[0] * c, motion[1:4]]), np.array([np.zeros(3), motion[4:]])
    lost = before - 0.5 * float((motion**2 / mobility).sum())
    return _result(status, states, velocities, spins, lost, curve, steps=steps)


def _frame(n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows n, t1, t2 of an orthonormal frame."""
    t = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    t /= np.linalg.norm(t)
    return np.array([n, t, np.cross(n, t)])


def _check(**numbers: float) -> None:
    for name, value in numbers.items():
        if not 0.0 < value < np.inf:
            raise ValueError(f'{name} must be finite and > 0, got {value!r}')


def _run(
    response: NDArray[np.float64],
    velocity: NDArray[np.float64],
    friction: NDArray[np.float64],
    restitution: tuple[float, float],
    stiffness: NDArray[np.float64],
    law: str,
    step: float,
) -> tuple[int, NDArray[np.float64], NDArray[np.float64], int, NDArray[np.float64]]:
    if law not in ('energetic', 'poisson'):
        raise ValueError(f"law must be 'energetic' or 'poisson' in impulse space, got {law!r}")
    e = np.asarray(restitution, float)
    if e.shape != (2,) or not ((e >= 0.0) & (e <= 1.0)).all():
        raise ValueError(f'restitution must be two numbers from 0 to 1, got {restitution!r}')
    impulse = np.zeros(6)
    log, curve = np.zeros((MAX_STATES, 5)), np.zeros((CURVE_ROWS, 4))
    status, states, steps, rows = integrate_impulse(
        response,
        velocity,
        friction,
        e,
        stiffness,
        LAWS[law],
        step=step,
        impulse=impulse,
        log=log,
        curve=curve,
    )
    return status, impulse, log[:states], steps, curve[:rows]


def _result(
    status: int,
    log: NDArray[np.float64],
    velocities: NDArray[np.float64],
    spins: NDArray[np.float64],
    lost: float,
    curve: NDArray[np.float64],
    steps: int,
) -> ImpulseRun:
    states = tuple(ACTIVE_STATE_NAMES[int(active)] for active in log[:, 0])
    impulses, energies = log[:, 1:3].copy(), log[:, 3:5].copy()
    return ImpulseRun(
        Status(status),
        states,
        impulses,
        energies,
        velocities,
        spins,
        lost=lost,
        curve=curve,
        steps=steps,
    )


@compiled
def friction_impulses(
    response: NDArray[np.float64],
    u: NDArray[np.float64],
    friction: NDArray[np.float64],
    push: NDArray[np.float64],
) -> None:
    """
    Add to the normal increments in `push` the tangential ones (section 3.1, contact modes).

    A contact sticks if the increment that ends the step without slip lies within the cone.
    Otherwise its friction opposes the slip at the end of the step. The four cases of two contacts
    are not distinguished: each contact is solved in turn until both agree.
    """
    scale = 1e-15 * (push[0] + push[3])
    for _ in range(200):
        moved = 0.0
        for n in (0, 3):
            radius = friction[n // 3] * push[n]
            if radius <= 0.0:
                continue
            x, y = push[n + 1], push[n + 2]
            push[n + 1] = 0.0
            push[n + 2] = 0.0
            bx, by = u[n + 1], u[n + 2]
            for i in range(6):
                bx += response[n + 1, i] * push[i]
                by += response[n + 2, i] * push[i]
            axx, axy, ayy = response[n + 1, n + 1], response[n + 1, n + 2], response[n + 2, n + 2]
            push[n + 1], push[n + 2] = least_over_disc(axx, axy, ayy, bx, by, radius)
            moved = max(moved, abs(push[n + 1] - x), abs(push[n + 2] - y))
        if moved <= scale:
            break


@compiled
def first_slope(
    response: NDArray[np.float64],
    u: NDArray[np.float64],
    energy: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    lead: int,
    step: float,
) -> float:
    """
    Slope rho of the secondary impulse where its energy is still zero.

    The energies (8), (9) after one step, put into (10), leave a quadratic equation in rho:
    p rho^2 + q rho = s. For two balls at rest its root is equation (11).
    """
    follow = 1 - lead
    a, b = 3 * lead, 3 * follow
    k = stiffness[follow] / stiffness[lead]
    p = -0.5 * response[a, b] * step * step
    q = energy[lead] - u[a] * step - 0.5 * response[a, a] * step * step
    q += k * 0.5 * response[b, b] * step * step
    s = k * (-u[b] * step - 0.5 * response[b, a] * step * step)
    root = q * q + 4.0 * p * s
    if s <= 0.0 or root < 0.0 or q + np.sqrt(root) <= 0.0:
        return 0.0
    return float(2.0 * s / (q + np.sqrt(root)))


@compiled
def increments(
    response: NDArray[np.float64],
    u: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    phase: NDArray[np.int64],
    energy: NDArray[np.float64],
    lead: int,
    step: float,
    push: NDArray[np.float64],
) -> None:
    """
    Impulses of one step: the primary one grows by `step`, the other by (10), (21) times it.

    If the primary energy vanishes, the slope is unbounded; then both grow by less. If a primary
    contact without energy is still in restitution (law poisson), only its impulse grows.
    """
    follow = 1 - lead
    slope = 0.0
    if phase[follow] != NOT_ACTIVE_YET and not (phase[lead] == RESTORING and energy[lead] <= 0.0):
        if energy[follow] > 0.0 and energy[lead] > 0.0:
            firmness = stiffness[follow] * energy[follow] / (stiffness[lead] * energy[lead])
            slope = np.sqrt(firmness)
        else:
            slope = first_slope(response, u, energy, stiffness, lead, step)
    part = min(1.0, STEEPEST / max(slope, 1.0))
    push[:] = 0.0
    push[3 * lead] = part * step
    push[3 * follow] = part * step * slope
    friction_impulses(response, u, friction, push)


@compiled
def joins(
    phase: NDArray[np.int64],
    u: NDArray[np.float64],
    response: NDArray[np.float64],
    push: NDArray[np.float64],
    impulse: NDArray[np.float64],
    memory: NDArray[np.float64],
) -> bool:
    """Activate contacts that approach or that `push` would close; return whether there are any."""
    joined = False
    for j in range(2):
        n = 3 * j
        if phase[j] == NOT_ACTIVE_YET and u[n] <= 0.0:
            change = 0.0
            for i in range(6):
                change += response[n, i] * push[i]
            if u[n] < 0.0 or (u[n] == 0.0 and change < 0.0):
                phase[j] = COMPRESSING
                memory[j, 0] = impulse[n]
                joined = True
    return joined


@compiled
def update_phase(
    law: int,
    restitution: float,
    contact: int,
    u: float,
    impulse: float,
    phase: NDArray[np.int64],
    energy: NDArray[np.float64],
    memory: NDArray[np.float64],
) -> bool:
    """
    Update the phase of a contact; return whether the contact has finished.

    `memory` (contacts, 2): the impulse at the start of the contact, and the energy (section 2.2)
    or impulse (section 2.1) that ends its restitution.
    """
    if phase[contact] == COMPRESSING and u >= 0.0:
        phase[contact] = RESTORING
        if law == POISSON:
            begun = memory[contact, 0]
            memory[contact, 1] = begun + (1.0 + restitution) * (impulse - begun)
        else:
            memory[contact, 1] = (1.0 - restitution * restitution) * energy[contact]
    elif phase[contact] == RESTORING and u < 0.0:
        phase[contact] = COMPRESSING
    if phase[contact] != RESTORING:
        return False
    if law == POISSON:
        return bool(impulse >= memory[contact, 1])
    return bool(energy[contact] <= memory[contact, 1])


@compiled
def log_state(
    log: NDArray[np.float64],
    states: int,
    active: int,
    impulse: NDArray[np.float64],
    energy: NDArray[np.float64],
) -> None:
    """Log a state that ends."""
    log[states, 0] = active
    log[states, 1] = impulse[0]
    log[states, 2] = impulse[3]
    log[states, 3] = energy[0]
    log[states, 4] = energy[1]


@compiled
def thin_out(curve: NDArray[np.float64]) -> int:
    """Drop every second row of a full curve, and return the number of rows left."""
    half = int(curve.shape[0] // 2)
    for row in range(half):
        curve[row] = curve[2 * row]
    return half


@compiled
def integrate_impulse(
    response: NDArray[np.float64],
    velocity: NDArray[np.float64],
    friction: NDArray[np.float64],
    restitution: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    law: int,
    step: float,
    impulse: NDArray[np.float64],
    log: NDArray[np.float64],
    curve: NDArray[np.float64],
) -> tuple[int, int, int, int]:
    """
    Walk through the states S1, S2, S3 of two contacts (Fig. 2); arguments as of the kernel.

    `log`: one row per state: active contacts (1 + 2), I1, I2, E1, E2 at its end. `curve`: rows I1,
    I2, E1, E2. Returns the status and the numbers of states, steps and rows of the curve.
    """
    u = velocity.copy()
    energy, memory, phase = np.zeros(2), np.zeros((2, 2)), np.zeros(2, np.int64)
    push, change = np.zeros(6), np.zeros(6)
    status, states, lead, idle = OK, 0, 0, True
    rows, stride = 1, 1
    joins(phase, u, response, push, impulse, memory)
    for steps in range(MAX_IMPULSE_STEPS):
        if states == log.shape[0]:
            return BUDGET_EXCEEDED, states, steps, rows
        if phase[lead] == NOT_ACTIVE_YET or (
            phase[1 - lead] == RESTORING and energy[1 - lead] <= 0.0
        ):
            lead = 1 - lead
        if phase[lead] == NOT_ACTIVE_YET:
            return status, states, steps, rows
        active = (1 if phase[0] != NOT_ACTIVE_YET else 0) + (
            2 if phase[1] != NOT_ACTIVE_YET else 0
        )
        increments(
            response, u, friction, stiffness, phase, energy, lead=lead, step=step, push=push
        )
        if joins(phase, u, response, push, impulse, memory):
            if not idle:  # no state ends where nothing has happened yet
                log_state(log, states, active, impulse, energy)
                states += 1
            idle = True
            continue
        for i in range(6):
            change[i] = 0.0
            for k in range(6):
                change[i] += response[i, k] * push[k]
        for j in range(2):
            energy[j] -= (u[3 * j] + 0.5 * change[3 * j]) * push[3 * j]  # (8), (9), (19), (20)
        for i in range(6):
            u[i] += change[i]
            impulse[i] += push[i]
        idle = False
        ended = 0
        for j in range(2):
            e = restitution[j]
            if update_phase(
                law, e, j, u[3 * j], impulse[3 * j], phase, energy=energy, memory=memory
            ):
                ended += 1 + j
        if ended != 0:
            log_state(log, states, active, impulse, energy)
            states += 1
            idle = True
        for j in range(2):
            if ended & (1 + j) != 0:
                if law == POISSON and energy[j] < 0.0:
                    status = NEGATIVE_ENERGY
                phase[j] = NOT_ACTIVE_YET
                energy[j] = 0.0
        if ended != 0:
            push[:] = 0.0
            joins(phase, u, response, push, impulse, memory)
        if steps % stride == 0 or ended != 0:
            if rows == curve.shape[0]:
                rows = thin_out(curve)
                stride *= 2
            curve[rows, 0], curve[rows, 1] = impulse[0], impulse[3]
            curve[rows, 2], curve[rows, 3] = energy[0], energy[1]
            rows += 1
    return BUDGET_EXCEEDED, states, MAX_IMPULSE_STEPS, rows
