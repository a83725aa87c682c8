"""What a collision is given, what it carries from step to step, and room to work in."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, frugal

COLUMNS = 26  # room for the coefficients of a step's polynomials
STAGES = 8  # nodes of an implicit step

INACTIVE, COMPRESSING, RESTORING = 0, 1, 2  # phase of a contact
FRICTIONLESS, SLIDING, STICKING = 0, 1, 2  # grip of an active contact

# What is known of one contact: its parameters, its condition, its account.
_FIELDS = np.dtype(
    [
        ('friction', np.float64),
        ('restitution', np.float64),
        ('stiffness', np.float64),
        ('phase', np.int64),  # INACTIVE, COMPRESSING, RESTORING
        ('grip', np.int64),  # FRICTIONLESS, SLIDING, STICKING
        ('young', np.int64),  # 1, or 2: sliding so slowly that the forces set the direction
        ('still', np.int64),  # 1: the normal velocity is exactly zero, an event happened there
        ('onset', np.int64),  # 1: the slip is exactly zero and about to grow
        ('pinned', np.int64),  # 1: sticking beyond its own cone, others help to hold it
        ('light', np.int64),  # 1: the force is negligible (exponent > 1: not analytic at 0)
        ('faint', np.float64),  # compression up to which it is
        ('idle', np.int64),  # 1: without friction until it presses enough to say how it slides
        ('armed', np.int64),  # 1: a swing has begun that no event will end
        ('toward_x', np.float64),  # direction of sliding
        ('toward_y', np.float64),
        ('rate', np.float64),  # y' = -rate u_n
        ('goal', np.float64),  # compression (law poisson: impulse) that ends restitution
        ('peak', np.float64),  # compression at which restitution began
        ('begun', np.float64),  # normal impulse at which the contact became active
        ('kept', np.float64),  # energy lost to restitution
        ('rubbed', np.float64),  # energy lost to friction
        ('last_slip', np.float64),  # slip when the contact last ended
        ('tie', np.float64),  # least distance to a jump of the law, in parts of the peak
    ],
    align=True,
)
CONTACT = np.dtype((np.record, _FIELDS))


class Model(NamedTuple):
    """
    The collision's data for N contacts, in units of its largest speed, response and stiffness.

    Contact j has components 3 j (normal), 3 j + 1 and 3 j + 2 (tangential).
    """

    response: NDArray[np.float64]  # (3 N, 3 N) W: contact velocities per impulse
    law: int
    exponent: float  # of the springs: N = stiffness * y**exponent
    tolerance: float
    straight: bool  # no slip can ever turn: nothing happens in the second tangential components


class State(NamedTuple):
    """
    The collision's state, and the polynomials of the current step in x = time / scale.

    Column 0 of `u` and `y` is the state itself, the other columns are the step's coefficients.
    """

    contact: NDArray[np.void]  # (N,) CONTACT
    u: NDArray[np.float64]  # (3 N, COLUMNS) contact velocities
    y: NDArray[np.float64]  # (N, COLUMNS) compressions of the springs
    force: NDArray[np.float64]  # (3 N, COLUMNS) contact forces on bodies a
    impulse: NDArray[np.float64]  # (3 N,) their integrals since the start
    effective: NDArray[np.float64]  # (3 N, 3 N) response with the sticking contacts' friction
    gain: NDArray[np.float64]  # (3 N, 3 N) friction of the sticking contacts per other force
    work: NDArray[np.float64]  # (3 N + 3, COLUMNS) scratch


class Room(NamedTuple):
    """Scratch arrays of the steps that need more of them."""

    chosen: NDArray[np.int64]  # (2 N,) numbers of components or contacts
    push: NDArray[np.float64]  # (2, 3 N)
    square: NDArray[np.float64]  # (3, 2 N, 2 N)
    newton: NDArray[np.float64]  # (STAGES N + 1, STAGES N)
    nodes: NDArray[np.float64]  # (10 N + 1, STAGES)


@compiled
def initial_state(count: int, impulse: NDArray[np.float64]) -> State:
    """State of N contacts that have not met yet, on the caller's impulse."""
    return State(
        np.zeros(count, CONTACT),
        np.zeros((3 * count, COLUMNS)),
        np.zeros((count, COLUMNS)),
        np.zeros((3 * count, COLUMNS)),
        impulse,
        np.zeros((3 * count, 3 * count)),
        np.zeros((3 * count, 3 * count)),
        np.zeros((3 * count + 3, COLUMNS)),
    )


@compiled
def room_for(count: int) -> Room:
    """Scratch arrays for N contacts."""
    return Room(
        np.empty(2 * count, np.int64),
        np.empty((2, 3 * count)),
        np.empty((3, 2 * count, 2 * count)),
        np.empty((STAGES * count + 1, STAGES * count)),
        np.empty((10 * count + 1, STAGES)),
    )


@frugal
def slip_speed(s: State, contact: int) -> float:
    """Slip at a contact now."""
    x, y = s.u[3 * contact + 1, 0], s.u[3 * contact + 2, 0]
    return float(np.sqrt(x * x + y * y))


@frugal
def stop_slip(s: State, contact: int) -> None:
    """Set a contact's slip to exactly zero."""
    s.u[3 * contact + 1, 0] = 0.0
    s.u[3 * contact + 2, 0] = 0.0
