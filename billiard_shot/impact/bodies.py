"""Rigid bodies, and the contacts between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.records import Array


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
