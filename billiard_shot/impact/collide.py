"""
Simultaneous frictional impacts between any rigid bodies: the public function `collide`.

Bodies and their contacts become contact space: velocities at the contacts, and how impulses change
them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.impact.events import ImpactEventKind
from billiard_shot.impact.integrator import ENERGY_FLOOR
from billiard_shot.impact.kernel import Properties, solve_in_contact_space
from billiard_shot.impact.options import LAWS
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import cross_rows, PARALLEL
from billiard_shot.records import Array
from billiard_shot.status import Status


def vector(field: str, value: ArrayLike, size: int = 3) -> Array:
    """Check a vector; a ValueError names the field, its value and the allowed values."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f'{field} must be {size} finite numbers, got {value!r}') from None
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ValueError(f'{field} must be {size} finite numbers, got {value!r}')
    array.flags.writeable = False
    return array


def direction(field: str, value: ArrayLike, size: int = 3) -> Array:
    """Check a vector of any length but zero, and return it as a unit vector."""
    array = vector(field, value, size)
    length = np.linalg.norm(array)
    if not length > 0.0:
        raise ValueError(f'{field} must not be zero, got {value!r}')
    array = array / length
    array.flags.writeable = False
    return array


def checked_number(
    field: str, value: Any, low: float, high: float = np.inf, *, open_low: bool = False
) -> float:
    """Check that a number is finite and in [low, high], or in (low, high] if `open_low`."""
    allowed = f'{"(" if open_low else "["}{low:g}, {high:g}{")" if high == np.inf else "]"}'
    try:
        x = float(value)
    except (TypeError, ValueError):
        raise ValueError(f'{field} must be a number in {allowed}, got {value!r}') from None
    if not (low <= x <= high) or (open_low and x == low) or not np.isfinite(x):
        raise ValueError(f'{field} must be in {allowed}, got {value!r}')
    return x


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """
    A rigid body.

    Parameters
    ----------
    mass : float
        Mass [kg], above 0. `Body.fixed()` makes a body that nothing moves.
    inertia : None, float, (3,) or (3, 3) array-like
        Moments of inertia about the centre of mass [kg m^2], in the body's frame: None for a body
        that does not turn, one number, three principal moments, or the whole matrix.
    velocity, spin : (3,) array-like
        Velocity of the centre of mass [m/s], and angular velocity [rad/s], common frame.
    position : (3,) array-like
        Centre of mass [m], common frame.
    orientation : (4,) array-like
        Quaternion x, y, z, w that turns the body's frame into the common one; of any length but 0.
    guide : None or (3,) array-like
        Direction that the body is constrained to move along.
    end_mass : None or float
        Effective mass [kg] for motion across the guide, as of the light, flexible end of a cue.
        None if the guide is rigid.

    Raises
    ------
    ValueError
        Naming the field, its value and the allowed range.

    """

    mass: float
    inertia: ArrayLike | None = None
    velocity: ArrayLike = (0.0, 0.0, 0.0)
    spin: ArrayLike = (0.0, 0.0, 0.0)
    position: ArrayLike = (0.0, 0.0, 0.0)
    orientation: ArrayLike = (0.0, 0.0, 0.0, 1.0)
    guide: ArrayLike | None = None
    end_mass: float | None = None

    def __post_init__(self) -> None:
        """Check everything."""
        if self.mass != np.inf:  # as of Body.fixed()
            checked_number('mass', self.mass, 0.0, open_low=True)
        for field in ('velocity', 'spin', 'position'):
            object.__setattr__(self, field, vector(field, getattr(self, field)))
        object.__setattr__(self, 'orientation', direction('orientation', self.orientation, 4))
        if self.inertia is not None:
            object.__setattr__(self, 'inertia', inertia_matrix(self.inertia))
        if self.guide is not None:
            object.__setattr__(self, 'guide', direction('guide', self.guide))
        if self.end_mass is not None:
            checked_number('end_mass', self.end_mass, 0.0, open_low=True)
            if self.guide is None:
                raise ValueError('end_mass needs a guide: it is the mass that moves across it')
        elif self.guide is not None:
            velocity, guide = np.asarray(self.velocity), np.asarray(self.guide)
            across = velocity - guide * (velocity @ guide)
            if np.linalg.norm(across) > 1e-9 * np.linalg.norm(velocity):
                raise ValueError(
                    f'velocity must be along the guide {guide}, got {self.velocity!r}'
                )

    @classmethod
    def fixed(cls) -> 'Body':
        """Make a body that nothing moves, such as a table."""
        return cls(mass=np.inf)

    def inverse_mass(self) -> Array:
        """Velocity per impulse, (3, 3) [1/kg]."""
        if self.mass == np.inf:
            return np.zeros((3, 3))
        if self.guide is None:
            return np.eye(3) / self.mass
        guide = np.asarray(self.guide)
        along = np.outer(guide, guide)
        end = 0.0 if self.end_mass is None else 1.0 / self.end_mass
        return along / self.mass + (np.eye(3) - along) * end

    def inverse_inertia(self) -> Array:
        """Spin per angular impulse in the common frame, (3, 3) [1/(kg m^2)]."""
        if self.inertia is None or self.mass == np.inf:
            return np.zeros((3, 3))
        inertia = np.asarray(self.inertia)
        if (inertia == inertia[0, 0] * np.eye(3)).all():  # as of a ball, in any orientation
            return np.eye(3) / inertia[0, 0]
        turn = rotation_matrix(np.asarray(self.orientation))
        inverse: Array = turn @ np.linalg.inv(inertia) @ turn.T
        return inverse


def inertia_matrix(value: ArrayLike) -> Array:
    """Inertia matrix from one moment, three, or the matrix itself, checked."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.shape in ((), (3,)):
        array = np.diag(np.broadcast_to(array, 3))
    sound = array.shape == (3, 3) and np.isfinite(array).all()
    sound = sound and np.abs(array - array.T).max() <= 1e-9 * np.abs(array).max()
    if sound and (array == array[0, 0] * np.eye(3)).all():
        sound = array[0, 0] > 0.0
    elif sound:
        moments = np.linalg.eigvalsh(array)
        sound = moments[0] > 1e-12 * moments[2] and moments[2] <= (1 + 1e-9) * (
            moments[0] + moments[1]
        )
    if not sound:
        raise ValueError(
            'inertia must be positive moments [kg m^2], none above the sum of the other two, or '
            f'their symmetric 3 x 3 matrix, got {value!r}'
        )
    array.flags.writeable = False
    return array


def rotation_matrix(quaternion: Array) -> Array:
    """Rotation matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """
    A point at which body a touches body b.

    Parameters
    ----------
    a, b : int
        Indices of two different bodies.
    point : (3,) array-like
        Point at which they touch [m], common frame.
    normal : (3,) array-like
        Direction from b into a, of any length but zero.
    restitution : float
        Coefficient of restitution, 0 to 1.
    friction : float
        Coulomb coefficient, 0 or above.
    stiffness : float
        Stiffness of the contact's virtual spring [N/m^exponent], above 0. Without gaps, velocities
        and impulses depend only on the ratios of the stiffnesses, if all exponents are equal.
    exponent : None or float
        Exponent of its spring, at least 1; None if it is that of `collide`.
    gap : float
        Distance of the bodies [m], 0 or above; see `reactivation` of `collide`.

    Raises
    ------
    ValueError
        Naming the field, its value and the allowed range.

    """

    a: int
    b: int
    point: ArrayLike
    normal: ArrayLike
    restitution: float = 1.0
    friction: float = 0.0
    stiffness: float = 1.0
    gap: float = 0.0
    exponent: float | None = None

    def __post_init__(self) -> None:
        """Check all fields; `check_indices` checks that the bodies exist."""
        object.__setattr__(self, 'point', vector('point', self.point))
        object.__setattr__(self, 'normal', direction('normal', self.normal))
        checked_number('restitution', self.restitution, 0.0, 1.0)
        checked_number('friction', self.friction, 0.0)
        checked_number('stiffness', self.stiffness, 0.0, open_low=True)
        if self.exponent is not None:
            checked_number('exponent', self.exponent, 1.0)
        checked_number('gap', self.gap, 0.0)
        if self.a == self.b:
            raise ValueError(f'a and b must be different bodies, got {self.a} twice')


def check_indices(bodies: Sequence[Body], contacts: Sequence[Contact]) -> None:
    """Raise ValueError if a contact names a body that does not exist."""
    for i, contact in enumerate(contacts):
        for field in ('a', 'b'):
            if not 0 <= getattr(contact, field) < len(bodies):
                raise ValueError(
                    f'{field} of contact {i} must be a body from 0 to {len(bodies) - 1}, '
                    f'got {getattr(contact, field)}'
                )


PLANAR = 1e-12  # smallest singular value, relative to the largest, of directions in one plane


class System(NamedTuple):
    """B bodies and their N contacts as arrays, in the common frame."""

    positions: Array  # (B, 3) m, centres of mass
    velocities: Array  # (B, 3) m/s
    spins: Array  # (B, 3) rad/s
    mobility: Array  # (B, 6, 6) velocity and spin per impulse and angular impulse
    turns: NDArray[np.bool_]  # (B,) whether a body can turn
    guides: Array  # (guided bodies, 3) unit vectors
    pairs: NDArray[np.int64]  # (N, 2) indices of the bodies a and b of a contact
    points: Array  # (N, 3) m
    normals: Array  # (N, 3) unit vectors, from b into a

    def arms(self) -> Array:
        """From the centres of bodies a and b to the contact points (N, 2, 3) [m]."""
        return self.points[:, np.newaxis] - self.positions[self.pairs]


def system_of(bodies: Sequence[Body], contacts: Sequence[Contact]) -> System:
    """Write bodies and contacts as arrays."""
    return System(
        np.array([body.position for body in bodies]).reshape(-1, 3),
        np.array([body.velocity for body in bodies]).reshape(-1, 3),
        np.array([body.spin for body in bodies]).reshape(-1, 3),
        mobilities(bodies),
        np.array([body.inertia is not None for body in bodies], bool),
        np.array([body.guide for body in bodies if body.guide is not None]).reshape(-1, 3),
        pairs=np.array([(contact.a, contact.b) for contact in contacts], int).reshape(-1, 2),
        points=np.array([contact.point for contact in contacts]).reshape(-1, 3),
        normals=np.array([contact.normal for contact in contacts]).reshape(-1, 3),
    )


@dataclass(frozen=True, slots=True, eq=False)
class ContactSpace:
    """
    A system in the contact space of its N contacts.

    Attributes
    ----------
    axes : (N, 3, 3) float array
        A row each for the normal and two tangents.
    delassus : (3 N, 3 N) float array
        W [1/kg]: the contact velocities that unit contact impulses cause.
    approach : (3 N,) float array
        Contact velocities [m/s].

    """

    axes: Array
    delassus: Array
    approach: Array


def contact_space(system: System) -> ContactSpace:
    """
    Compute the contact space of a system.

    W is symmetric. Its couplings, and contact velocities, that are only rounding are exactly zero.
    """
    axes = _axes(system)
    count, bodies = len(system.pairs), len(system.positions)
    by_contact = np.zeros((count, 3, bodies, 6))  # contact velocities per velocity and spin
    arms = system.arms()
    for side, sign in enumerate((1.0, -1.0)):
        rows = np.concatenate([axes, cross_rows(arms[:, side, np.newaxis], axes)], axis=2)
        by_contact[np.arange(count), :, system.pairs[:, side]] = sign * rows
    jacobian = by_contact.reshape(3 * count, bodies, 6)
    moved = np.einsum('jbk,bkl->jbl', jacobian, system.mobility)
    flat = jacobian.reshape(3 * count, 6 * bodies)
    lower = np.tril(moved.reshape(flat.shape) @ flat.T)
    delassus = lower + np.tril(lower, -1).T
    sizes = np.sqrt(delassus.diagonal())
    rounded = np.abs(delassus) <= rounding.COUPLING * np.outer(sizes, sizes)
    delassus[rounded & ~np.eye(3 * count, dtype=bool)] = 0.0
    approach = flat @ np.concatenate([system.velocities, system.spins], axis=1).ravel()
    approach[np.abs(approach) <= rounding.SUM * np.abs(system.velocities).max(initial=0.0)] = 0.0
    return ContactSpace(axes, delassus, approach)


def _axes(system: System) -> Array:
    """
    Compute the axes (N, 3, 3) of contacts: normals and two tangents.

    If all motion is in one plane, the second tangents are normal to it, so that nothing couples to
    them. Otherwise first tangents point along the slip.
    """
    normals, across = system.normals, _normal_of_plane(system)
    if across.any():
        along = cross_rows(across, normals)
    else:
        spins = cross_rows(system.spins[system.pairs], system.arms())
        sides = system.velocities[system.pairs] + spins
        along = sides[:, 0] - sides[:, 1]
    tangents = _perpendicular(along, normals)
    any_other = np.eye(3)[np.abs(normals).argmin(axis=1)]
    none = ~tangents.any(axis=1)
    tangents[none] = _perpendicular(any_other, normals)[none]
    return np.stack([normals, tangents, cross_rows(normals, tangents)], axis=1)


def _perpendicular(vectors: Array, normals: Array) -> Array:
    """Return the directions (N, 3) of the parts of vectors normal to others, or zeros."""
    result = vectors
    for _ in range(2):  # the second pass removes what rounding has left
        result = result - (result * normals).sum(axis=1, keepdims=True) * normals
        lengths = np.linalg.norm(result, axis=1, keepdims=True)
        allowed = PARALLEL * np.linalg.norm(vectors, axis=1, keepdims=True)
        result = np.where(lengths > allowed, result / np.where(lengths > 0.0, lengths, 1.0), 0.0)
        vectors = result
    return result


def _normal_of_plane(system: System) -> Array:
    """
    Find the normal (3,) of the plane of all motion; zero if the motion is not planar.

    If the second tangents are normal to that plane, nothing couples to them.
    """
    arms, pairs = system.arms(), system.pairs
    turns = system.turns[pairs]
    directions = [
        system.normals,
        arms[turns],
        cross_rows(system.spins[pairs], arms)[turns],
        system.velocities[np.unique(pairs)],
        system.guides,
    ]
    vectors = np.concatenate(directions)
    lengths = np.linalg.norm(vectors, axis=1)
    units = vectors[lengths > 0.0] / lengths[lengths > 0.0, np.newaxis]
    at_least_three = np.concatenate([units, np.zeros((3, 3))])
    _, spread, axes = np.linalg.svd(at_least_three, full_matrices=False)
    normal: Array = axes[2] if spread[2] < PLANAR * spread[0] else np.zeros(3)
    return normal


def velocity_changes(system: System, impulses: Array) -> Array:
    """Compute the changes of velocity and spin (B, 6) by impulses (N, 3) on bodies a [N s]."""
    arms, given = system.arms(), np.zeros((len(system.positions), 6))
    for side, sign in enumerate((1.0, -1.0)):
        moments = cross_rows(arms[:, side], impulses)
        np.add.at(given, system.pairs[:, side], sign * np.hstack([impulses, moments]))
    changes: Array = np.einsum('bkl,bl->bk', system.mobility, given)
    return changes


def mobilities(bodies: Sequence[Body]) -> Array:
    """Velocity and spin per impulse and angular impulse of each body: (bodies, 6, 6)."""
    result = np.zeros((len(bodies), 6, 6))
    for i, body in enumerate(bodies):
        result[i, :3, :3] = body.inverse_mass()
        result[i, 3:, 3:] = body.inverse_inertia()
    return result


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
    ends, outcome = solved.contacts[0], solved.outcomes[0]
    impulses = np.einsum('ik,ikl->il', ends['impulse'], space.axes)
    changes = velocity_changes(system, impulses)
    losses = np.stack([ends['restitution_loss'], ends['friction_loss']], axis=-1)
    return CollisionResult(
        Status(outcome['status']), system.velocities + changes[:, :3],
        system.spins + changes[:, 3:], impulses, losses, ends['final_slip'],
        lengths=ends['length'], duration=float(outcome['duration']),
        phases=read_log(solved.log, space.axes), evaluations=int(outcome['steps']),
    )  # fmt: skip
