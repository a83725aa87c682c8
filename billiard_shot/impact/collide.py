"""Simultaneous frictional impacts between any rigid bodies: the public function `collide`."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.bodies import (
    Body,
    check_indices,
    checked_number,
    Contact,
    contact_space,
    system_of,
    velocity_changes,
)
from billiard_shot.impact.events import ImpactEventKind
from billiard_shot.impact.integrator import ENERGY_FLOOR
from billiard_shot.impact.kernel import Properties, solve_in_contact_space
from billiard_shot.impact.options import LAWS
from billiard_shot.records import Array
from billiard_shot.status import Status

USUAL_PHASES = 64  # that the log has room for; a collision with more is solved twice
REACTIVATIONS = 'instant', 'distance'


class Ending(IntEnum):
    """Why a phase ended."""

    RESTITUTION = ImpactEventKind.RESTITUTION_END  # the contact has finished restitution
    ACTIVATION = ImpactEventKind.ACTIVATION  # another contact became active
    SPRING_EXHAUSTED = ImpactEventKind.SPRING_EXHAUSTED  # law poisson: its spring was empty
    ENERGY_FLOOR = ENERGY_FLOOR  # the motion died down: an infinite sequence ends


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """
    One state of the collision's state transition diagram.

    Attributes
    ----------
    active : tuple of int
        The contacts that were active.
    ending : Ending
        Why the phase ended.
    contact : int
        Contact at which it ended; -1 if the whole collision ended.
    impulses : (N, 3) float array
        Impulses on bodies a since the start of the collision [N s], common frame.
    energies : (N,) float array
        Elastic energies as the phase ended [J].

    """

    active: tuple[int, ...]
    ending: Ending
    contact: int
    impulses: Array
    energies: Array


@dataclass(frozen=True, slots=True, eq=False)
class CollisionResult:
    """
    Result of a collision.

    Attributes
    ----------
    status : Status
        OK, INFINITE_SEQUENCE, NEGATIVE_ENERGY (law poisson), TOLERANCE_NOT_REACHED (the energies
        do not add up) or BUDGET_EXCEEDED.
    velocities, spins : (bodies, 3) float arrays
        After the collision [m/s], [rad/s], common frame.
    impulses : (N, 3) float array
        Impulses on bodies a [N s], common frame.
    dissipated : (N, 2) float array
        Kinetic energy lost at each contact to restitution and to friction [J].
    slips : (N,) float array
        Slip of each contact when it last ended [m/s].
    lengths : (N,) float array
        Minus the distance of each contact at the end of the collision [m]; zero without distances.
    duration : float
        Time until no contact is active [s], if stiffnesses are in N/m^exponent.
    phases : tuple of Phase
        The states that the collision passed through.
    evaluations : int
        Number of steps. An implicit step with n stiff contacts counts as 1 + 4 n^2 steps.

    """

    status: Status
    velocities: Array
    spins: Array
    impulses: Array
    dissipated: Array
    slips: Array
    lengths: Array
    duration: float
    phases: tuple[Phase, ...]
    evaluations: int

    def __repr__(self) -> str:
        counts = (
            (len(self.velocities), 'bodies'),
            (len(self.impulses), 'contacts'),
            (len(self.phases), 'phases'),
        )
        counted = ', '.join(f'{count} {things}' for count, things in counts)
        return (
            f'CollisionResult({self.status.name}, {counted}, lost {self.dissipated.sum():.4g} J)'
        )


def read_log(log: NDArray[np.void], axes: Array | None = None) -> tuple[Phase, ...]:
    """
    Read phases (phases, N) of `PhaseLog`.

    `axes` (N, 3, 3): rows n, t1, t2 of each contact; by default the log is in the common frame.
    """
    if axes is None:
        axes = np.broadcast_to(np.eye(3), (log.shape[-1], 3, 3))
    impulses = np.stack([log['impulse'], log['impulse_1'], log['impulse_2']], axis=-1)
    return tuple(
        Phase(
            tuple(np.flatnonzero(row['active']).tolist()),
            Ending(int(row['ending'][0])),
            int(row['contact'][0]),
            np.einsum('ik,ikl->il', impulse, axes),
            row['energy'].copy(),
        )
        for row, impulse in zip(log, impulses, strict=True)
    )


def properties_of(contacts: Sequence[Contact], law: int, exponent: float) -> Properties:
    """Collect what the solver takes of contacts; the exponent is of those without their own."""
    return Properties(
        np.array([c.friction for c in contacts], float),
        np.array([c.restitution for c in contacts], float),
        np.array([c.stiffness for c in contacts], float),
        law,
        np.array([exponent if c.exponent is None else c.exponent for c in contacts], float),
    )


def collide(
    bodies: Sequence[Body],
    contacts: Sequence[Contact],
    law: str = 'bistiffness',
    exponent: float = 1.0,
    tolerance: float = 1e-10,
    reactivation: str = 'instant',
    phases: bool = True,
) -> CollisionResult:
    """
    Let rigid bodies that touch collide at all their contacts at once.

    Parameters
    ----------
    bodies : sequence of Body
        All bodies that take part. A body that cannot move is `Body.fixed()`.
    contacts : sequence of Contact
        All points at which the bodies touch. Contacts that approach start the collision. The
        others become active only if the motion closes them.
    law : {'bistiffness', 'energetic', 'poisson'}
        Law of restitution; see `laws.py`.
    exponent : float
        Exponent of the virtual springs, force = stiffness * compression ** exponent; at least 1. 1
        is linear, 1.5 is Hertz's. A contact may have its own.
    tolerance : float
        Error of the velocities relative to the largest approach speed, 1e-13 to 1e-2.
    reactivation : {'instant', 'distance'}
        When an inactive contact becomes active. `instant`: as soon as its bodies approach, as in
        the paper. `distance`: when the bodies are as close as when the contact last ended or, the
        first time, when its `gap` is closed. The collision ends as soon as no contact is active,
        even if bodies at a distance still approach.
    phases : bool
        Whether to return the phases; without them a collision of many contacts takes less time.

    Returns
    -------
    CollisionResult

    Raises
    ------
    ValueError
        If the law, exponent, tolerance, reactivation or a body index is not allowed, naming it and
        its range. If a contact has a gap and reactivation is `instant`.

    References
    ----------
    Jia, Mason, Erdmann, "A State Transition Diagram for Simultaneous Collisions with Application
    in Billiard Shooting", WAFR 2008.

    """
    if law not in LAWS:
        raise ValueError(f'law must be one of {", ".join(LAWS)}, got {law!r}')
    exponent = checked_number('exponent', exponent, 1.0)
    tolerance = checked_number('tolerance', tolerance, 1e-13, 1e-2)
    if reactivation not in REACTIVATIONS:
        raise ValueError(
            f'reactivation must be one of {", ".join(REACTIVATIONS)}, got {reactivation!r}'
        )
    gap = np.array([c.gap for c in contacts], float)
    if reactivation == 'instant' and gap.any():
        raise ValueError(f'gap must be 0 with reactivation instant, got {gap.max():g}')
    check_indices(bodies, contacts)
    system = system_of(bodies, contacts)
    space = contact_space(system)
    solved = solve_in_contact_space(
        properties_of(contacts, LAWS[law], exponent),
        space.delassus[np.newaxis],
        space.approach[np.newaxis],
        [tolerance],
        USUAL_PHASES if phases else 0,
        None if reactivation == 'instant' else -gap[np.newaxis],
    )
    impulses = np.einsum('ik,ikl->il', solved.impulses[0], space.axes)
    changes = velocity_changes(system, impulses)
    return CollisionResult(
        Status(solved.status[0]), system.velocities + changes[:, :3],
        system.spins + changes[:, 3:], impulses, solved.losses[0], solved.final_slips[0],
        lengths=solved.lengths[0], duration=float(solved.durations[0]),
        phases=read_log(solved.log, space.axes), evaluations=int(solved.steps[0]),
    )  # fmt: skip
