"""Collisions that the studies share: balls in a line, strokes, a wedge and a block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import math

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.impact import Body, collide, CollisionResult, Contact
from billiard_shot.pictures.history import bodies_of_strike
from billiard_shot.records import Array, Triple
from billiard_shot.scene import Scene
from billiard_shot.shot.effects import strike_model, StrikeModel
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.cue import UP

# The paper's measured constants [kg, kg, m], and those of the contacts of tip and cloth.
PAPER_BALL_MASS, PAPER_CUE_MASS, PAPER_BALL_RADIUS = 0.1673, 0.5018, 0.0286
PAPER_FRICTION, PAPER_RESTITUTION = (0.4, 0.152479), (0.656532, 0.51625)


@dataclass(frozen=True, slots=True)
class Collision:
    """Bodies that touch, and the force exponent of their contacts."""

    bodies: tuple[Body, ...]
    contacts: tuple[Contact, ...]
    exponent: float = 1.0

    def solve(self, law: str, tolerance: float) -> CollisionResult:
        """Let them collide."""
        return collide(self.bodies, self.contacts, law, self.exponent, tolerance)

    @property
    def speed(self) -> float:
        """Largest speed of a body before the collision [m/s]."""
        return max(float(np.linalg.norm(body.velocity)) for body in self.bodies)

    def motion(self, velocities: Array, spins: Array) -> Array:
        """
        Velocities of all bodies that move, and spins of those that turn, as one array.

        Each is three numbers, relative to `speed`. Spins are times the radius of gyration.
        """
        parts = []
        for body, v, w in zip(self.bodies, velocities, spins, strict=True):
            if body.mass < math.inf:
                parts.append(np.asarray(v))
                if body.inertia is not None:
                    largest = np.linalg.eigvalsh(np.asarray(body.inertia))[-1]
                    parts.append(math.sqrt(largest / body.mass) * np.asarray(w))
        return np.concatenate(parts) / self.speed

    def energy(self, velocities: Array, spins: Array) -> float:
        """Kinetic energy [J]; for a guided body, of the motion that its guide allows."""
        total = 0.0
        for body, v, w in zip(self.bodies, velocities, spins, strict=True):
            if body.mass == math.inf:
                continue
            along = v if body.guide is None else np.asarray(body.guide) * (v @ body.guide)
            total += 0.5 * body.mass * float(along @ along)
            if body.end_mass is not None:
                total += 0.5 * body.end_mass * float((v - along) @ (v - along))
            if body.inertia is not None:
                total += 0.5 * float(w @ np.linalg.solve(body.inverse_inertia(), w))
        return total

    @property
    def start(self) -> tuple[Array, Array]:
        """Velocities and spins (bodies, 3) before the collision."""
        return (
            np.array([np.asarray(body.velocity) for body in self.bodies]),
            np.array([np.asarray(body.spin) for body in self.bodies]),
        )

    def reordered(self, order: Sequence[int]) -> Collision:
        """Make the same collision with its contacts in another order."""
        return replace(self, contacts=tuple(self.contacts[i] for i in order))

    def disturbed(self, size: float, seed: int) -> Collision:
        """Change all numbers by random fractions of about `size`, directions by such angles."""
        rng = np.random.default_rng(seed)

        def scale(value: float) -> float:
            return value * (1.0 + size * float(rng.uniform(-1.0, 1.0)))

        def turn(vector: object) -> Array:
            old = np.asarray(vector, float)
            return old + size * float(np.linalg.norm(old)) * rng.uniform(-1.0, 1.0, 3)

        bodies = []
        for body in self.bodies:
            if body.mass < math.inf:
                velocity = turn(body.velocity)
                guide = None
                if body.guide is not None:  # a guided body moves along its guide
                    guide = turn(body.guide)
                    along = np.linalg.norm(velocity) * guide / np.linalg.norm(guide)
                    velocity = along * math.copysign(1.0, velocity @ guide)
                body = replace(body, mass=scale(body.mass), velocity=velocity, guide=guide)
            bodies.append(body)
        contacts = tuple(
            replace(
                contact,
                normal=turn(contact.normal),
                friction=scale(contact.friction),
                restitution=min(scale(contact.restitution), 1.0),
                stiffness=scale(contact.stiffness),
            )
            for contact in self.contacts
        )
        return replace(self, bodies=tuple(bodies), contacts=contacts)


@dataclass(frozen=True, slots=True)
class StrikeCollision(Collision):
    """A stroke as a collision, and as `predict` takes it; the law of the scene is not set."""

    stroke: Stroke = field(kw_only=True)
    scene: Scene = field(kw_only=True)


def stacked(
    masses: tuple[float, float] = (1.0, 1.0),
    restitution: tuple[float, float] = (0.9**0.5, 0.4**0.5),
    ratio: float = 10.0,
    speed: float = 1.0,
    exponent: float = 1.0,
) -> Collision:
    """Let a ball fall onto another one on a table (the paper's section 2); ratio: k2 / k1."""
    return Collision(
        (Body(masses[0], velocity=(0, 0, -speed)), Body(masses[1]), Body.fixed()),
        (
            Contact(0, 1, (0, 0, 2), UP, restitution[0]),
            Contact(1, 2, (0, 0, 0), UP, restitution[1], stiffness=ratio),
        ),
        exponent,
    )


def strike_of(
    normal: ArrayLike,
    direction: ArrayLike,
    speed: float = 1.0,
    masses: tuple[float, float] = (PAPER_CUE_MASS, PAPER_BALL_MASS),
    friction: tuple[float, float] = PAPER_FRICTION,
    restitution: tuple[float, float] = PAPER_RESTITUTION,
    ratio: float = 1.5,
    end_mass: float | None = None,
    exponent: float = 1.0,
) -> StrikeCollision:
    """
    Strike a ball on a table with a guided cue (section 3), or one with a light end.

    Pairs are of tip and table (cue and ball); ratio: k_tip / k_table.
    """
    guided = (
        {'guided': True} if end_mass is None else {'end_mass': end_mass, 'ferrule_radius': 0.0}
    )
    tip, cloth = (
        {'restitution': restitution[i], 'friction': friction[i], 'stiffness': (ratio, 1.0)[i]}
        for i in range(2)
    )
    scene = Scene.from_dict(
        {
            'ball': {'mass': masses[1], 'radius': PAPER_BALL_RADIUS},
            'cue': {'mass': masses[0], **guided},
            'contacts': {'cue_ball': tip, 'ball_table': cloth},
            'exponent': exponent,
            'effects': {'shaft': 'off'},
        }
    )
    c = np.asarray(direction, float) / np.linalg.norm(direction)
    n = np.asarray(normal, float)
    made = collision_of(strike_model(scene), n, speed * c)
    stroke = Stroke(n, speed * c)
    return StrikeCollision(made.bodies, made.contacts, exponent, stroke=stroke, scene=scene)


def collision_of(model: StrikeModel, normal: Array, velocity: Array) -> Collision:
    """State a stroke that can be played as a collision; see `bodies_of_strike`."""
    return Collision(*bodies_of_strike(model, normal, velocity))


def cradle(
    count: int,
    stiffness: Sequence[float] | None = None,
    restitution: float = 1.0,
    exponent: float = 1.0,
) -> Collision:
    """Equal balls in a row that touch, the first one moving along x: Newton's cradle."""
    springs = [1.0] * (count - 1) if stiffness is None else stiffness
    return Collision(
        tuple(Body(1.0, velocity=(float(i == 0), 0, 0)) for i in range(count)),
        tuple(
            Contact(i, i + 1, (i + 0.5, 0, 0), (-1, 0, 0), restitution, 0.0, stiffness=springs[i])
            for i in range(count - 1)
        ),
        exponent,
    )


def wedge(
    restitution: float = 0.5,
    friction: float = 0.0,
    angle: float = math.pi / 6,
) -> Collision:
    """Let a ball fall between two equal walls: both contacts do the same at the same time."""
    s, c = math.sin(angle), math.cos(angle)
    ball = Body(1.0, 0.4, velocity=(0, 0, -1), position=(0, 0, 1))
    return Collision(
        (ball, Body.fixed()),
        tuple(Contact(0, 1, (-x, 0, 1 - s), (x, 0, s), restitution, friction) for x in (c, -c)),
    )


def block(
    velocity: Triple,
    spin: Triple = (0.0, 0.0, 0.0),
    friction: float = 0.3,
    restitution: float = 0.5,
) -> Collision:
    """Drop a flat block on its four lower corners: the contacts are redundant."""
    mass, (a, b, c) = 1.3, (0.3, 0.2, 0.1)
    inertia = mass / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    body = Body(mass, inertia, velocity, spin, (0.0, 0.0, c / 2))
    return Collision(
        (body, Body.fixed()),
        tuple(
            Contact(0, 1, (x * a / 2, y * b / 2, 0.0), UP, restitution, friction)
            for x in (-1, 1)
            for y in (-1, 1)
        ),
    )
