"""
The collision as a state transition diagram, in time: one call from approach to parting.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = stiffness y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y (walk.py). Everything inside
is in units of the largest approach speed, response and stiffness: answers cannot depend on them.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, frugal
from billiard_shot.impact.advance import ROUNDING
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.state import (
    COMPRESSING,
    INACTIVE,
    initial_state,
    Model,
    room_for,
    State,
)
from billiard_shot.impact.swings import no_swings
from billiard_shot.impact.walk import run
from billiard_shot.status import Status

LOOSEST = 1e-6  # tolerance: a looser one would save a sixth of the steps, and lose its meaning
UNACCOUNTED = 1e4  # energy, in tolerances, above which it says that the tolerance was not kept,
LEAST_UNACCOUNTED = 1e-8  # and at least
OK = int(Status.OK)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
TOLERANCE_NOT_REACHED = int(Status.TOLERANCE_NOT_REACHED)


@frugal
def is_straight(
    response: NDArray[np.float64], friction: NDArray[np.float64], velocity: NDArray[np.float64]
) -> bool:
    """Whether no slip can ever turn: nothing happens in any second tangential direction."""
    count = friction.shape[0]
    for i in range(count):
        if friction[i] > 0.0:
            if velocity[3 * i + 2] != 0.0:
                return False
            for j in range(count):
                if response[3 * i + 2, 3 * j] != 0.0:
                    return False
                if friction[j] > 0.0 and response[3 * i + 2, 3 * j + 1] != 0.0:
                    return False
    return True


@frugal
def unaccounted(s: State, velocity: NDArray[np.float64], speed: float) -> float:
    """
    Energy that came or went without an account, in parts of all that changed hands.

    Impulses times the mean of the velocities before and after are the work done on the bodies.
    """
    gap, turnover = 0.0, 0.0
    for row in range(s.u.shape[0]):
        before, after = velocity[row] / speed, s.u[row, 0]
        gap += 0.5 * s.impulse[row] * (before + after)
        turnover += 0.5 * abs(s.impulse[row]) * (abs(before) + abs(after))
    for j in range(len(s.contact)):
        gap += s.contact[j].kept + s.contact[j].rubbed
    return abs(gap) / turnover if turnover > 0.0 else 0.0


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
    account : (N, 4) float array, written
        Energy lost to restitution and to friction [J]; slip [m/s] when the contact last ended; how
        near it came to ending instead of being compressed anew, or the other way round, where the
        answer may jump (in parts of its largest compression; infinite: it never did).
    log : (rows, 2 + 5 N) float array, written
        A row a phase: why it ended (JOIN, END, EMPTY, FLOOR), at which contact, active flags (N),
        impulses (3 N) [N s] and elastic energies (N) [J] at its end. Phases beyond its rows are
        counted only; those of swings that were leapt over (leaps.py) are not even counted.

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
        account[row // 3, 3] = np.inf
    if speed <= 0.0 or mobility <= 0.0:
        return OK, 0, 0
    s = initial_state(count, impulse)
    scaled = np.empty((3 * count, 3 * count))
    for row in range(3 * count):
        u = velocity[row] / speed
        s.u[row, 0] = u if abs(u) >= ROUNDING else 0.0
        for column in range(3 * count):
            scaled[row, column] = response[row, column] / mobility
    for j in range(count):
        c = s.contact[j]
        c.friction, c.restitution = friction[j], restitution[j]
        c.stiffness, c.rate, c.tie = stiffness[j] / firmness, 1.0, np.inf
        c.still = s.u[3 * j, 0] == 0.0
        c.phase = COMPRESSING if s.u[3 * j, 0] < 0.0 else INACTIVE
    straight = is_straight(response, friction, velocity)
    m = Model(scaled, law, exponent, min(tolerance, LOOSEST), straight)
    status, phases, steps = run(m, s, room_for(count), no_swings(count), log)
    allowed = max(UNACCOUNTED * m.tolerance, LEAST_UNACCOUNTED)
    ends = status in (OK, INFINITE_SEQUENCE) and law != POISSON
    if ends and unaccounted(s, velocity, speed) > allowed:
        status = TOLERANCE_NOT_REACHED
    unit = speed / mobility
    for row in range(3 * count):
        impulse[row] *= unit
    for j in range(count):
        c = s.contact[j]
        account[j, 0] = c.kept * unit * speed
        account[j, 1] = c.rubbed * unit * speed
        account[j, 2] = c.last_slip * speed
    for i in range(min(phases, log.shape[0])):
        for column in range(2 + count, 2 + 5 * count):
            log[i, column] *= unit if column < 2 + 4 * count else unit * speed
    return status, phases, steps
