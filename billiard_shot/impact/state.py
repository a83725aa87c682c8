"""What a collision is given, and what it carries from step to step: two tuples of arrays."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled

COLUMNS = 26  # room for the coefficients of a step's polynomials

INACTIVE, COMPRESSING, RESTORING = 0, 1, 2  # phase of a contact
FRICTIONLESS, SLIDING, STICKING = 0, 1, 2  # grip of an active contact


class Model(NamedTuple):
    """
    The collision's data for N contacts, in units of its largest speed, response and stiffness.

    Contact j has components 3 j (normal), 3 j + 1 and 3 j + 2 (tangential).
    """

    response: NDArray[np.float64]  # (3 N, 3 N) W: contact velocities per impulse
    friction: NDArray[np.float64]  # (N,)
    restitution: NDArray[np.float64]  # (N,)
    stiffness: NDArray[np.float64]  # (N,)
    law: int
    exponent: float  # of the springs: N = stiffness * y**exponent
    tolerance: float
    straight: bool  # no slip can ever turn: nothing happens in the second tangential components


class State(NamedTuple):
    """
    The collision's state, and the polynomials of the current step in x = time / scale.

    Column 0 of `u` and `y` is the state itself, the other columns are the step's coefficients.
    """

    u: NDArray[np.float64]  # (3 N, COLUMNS) contact velocities
    y: NDArray[np.float64]  # (N, COLUMNS) compressions of the springs
    force: NDArray[np.float64]  # (3 N, COLUMNS) contact forces on bodies a
    impulse: NDArray[np.float64]  # (3 N,) their integrals since the start
    account: NDArray[np.float64]  # (N, 3) energy lost to restitution, to friction; last slip
    phase: NDArray[np.int64]  # (N,) INACTIVE, COMPRESSING, RESTORING
    grip: NDArray[np.int64]  # (N,) FRICTIONLESS, SLIDING, STICKING
    young: NDArray[np.bool_]  # (N,) sliding so slowly that the forces set the direction
    still: NDArray[np.bool_]  # (N,) the normal velocity is exactly zero: an event happened there
    onset: NDArray[np.bool_]  # (N,) the slip is exactly zero and about to grow along `direction`
    pinned: NDArray[np.bool_]  # (N,) sticking beyond its own cone: others help to hold it
    light: NDArray[np.bool_]  # (N,) the force is negligible (exponent > 1: not analytic at 0)
    direction: NDArray[np.float64]  # (N, 2) of sliding
    rate: NDArray[np.float64]  # (N,) y' = -rate u_n
    goal: NDArray[np.float64]  # (N,) compression (law poisson: impulse) that ends restitution
    peak: NDArray[np.float64]  # (N,) compression at which restitution began
    begun: NDArray[np.float64]  # (N,) normal impulse at which the contact became active
    effective: NDArray[np.float64]  # (3 N, 3 N) response with the sticking contacts' friction
    gain: NDArray[np.float64]  # (3 N, 3 N) friction of the sticking contacts per other force
    work: NDArray[np.float64]  # (3 N + 3, COLUMNS) scratch


@compiled
def initial_state(count: int, impulse: NDArray[np.float64], account: NDArray[np.float64]) -> State:
    """State of N contacts that have not met yet, on the caller's impulse and account."""
    return State(
        np.zeros((3 * count, COLUMNS)),
        np.zeros((count, COLUMNS)),
        np.zeros((3 * count, COLUMNS)),
        impulse,
        account,
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros((count, 2)),
        np.ones(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros((3 * count, 3 * count)),
        np.zeros((3 * count, 3 * count)),
        np.zeros((3 * count + 3, COLUMNS)),
    )


@compiled
def slip_speed(s: State, contact: int) -> float:
    """Slip at a contact now."""
    x, y = s.u[3 * contact + 1, 0], s.u[3 * contact + 2, 0]
    return float(np.sqrt(x * x + y * y))


@compiled
def stop_slip(s: State, contact: int) -> None:
    """Set a contact's slip to exactly zero."""
    s.u[3 * contact + 1, 0] = 0.0
    s.u[3 * contact + 2, 0] = 0.0
