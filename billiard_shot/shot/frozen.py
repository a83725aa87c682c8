"""
A strike on a ball that touches another one, or a cushion: tip, balls, cushion and cloth at once.

The cue is a body on its guide, as in the strike of a ball alone; the rest is a cluster of the
table (billiard_shot.table.cluster), and all of it goes through billiard_shot.impact.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, collide, CollisionResult, Contact
from billiard_shot.shot import row as at
from billiard_shot.shot.model import Model, TABLE, TIP
from billiard_shot.shot.strike import MISCUE_SLIP
from billiard_shot.status import Status
from billiard_shot.table.cluster import body_of, connected, contacts_among, LAW_NAMES
from billiard_shot.table.furniture import Furniture
from billiard_shot.table.motion import start

TOLERANCE = 1e-9  # of the impact, relative to the cue's speed
UP = (0.0, 0.0, 1.0)


def touches(furniture: Furniture, radius: float, places: NDArray[np.float64]) -> bool:
    """Whether the first of some balls (n, 3) touches another one, or perhaps a cushion."""
    gaps = np.linalg.norm(places[1:] - places[0], axis=1) - 2.0 * radius
    if (gaps <= furniture.gap).any():
        return True
    above = furniture.height - radius
    reach = np.sqrt(radius**2 - above**2) if furniture.length < np.inf else 0.0
    outside = max(
        abs(places[0, 0]) - 0.5 * furniture.length, abs(places[0, 1]) - 0.5 * furniture.width
    )
    return bool(outside + reach >= -furniture.gap)


def strike_together(
    model: Model, furniture: Furniture, given: NDArray[np.float64], normal: NDArray[np.float64],
    velocity: NDArray[np.float64], row: NDArray[np.float64],
) -> CollisionResult:
    """
    Strike the first ball together with all that it touches.

    Parameters
    ----------
    model, furniture : Model, Furniture
    given : (balls, INPUT) float array, changed
        States, the struck ball first; in the end those after the strike.
    normal, velocity : (3,) float arrays
        Of the stroke; unit vector and [m/s].
    row : (COLUMNS,) float array, changed
        The strike of the ball alone, see row.py; in the end this one.

    """
    surface, still = model.surface, np.zeros(3)
    places = given[:, :3]
    members = connected(
        dict(enumerate(places)), {0}, 2.0 * surface.radius + furniture.gap
    )
    balls = [start(places[i], still, still) for i in members]
    count = len(balls)
    speed = float(np.linalg.norm(velocity))
    c = velocity / speed
    tip = places[0] + surface.radius * normal
    cue = Body(
        model.cue_mass, velocity=velocity, position=tip, guide=c,
        end_mass=1.0 / model.softness if model.softness > 0.0 else None,
    )
    contacts = [
        Contact(
            count + 1, 0, tip, normal, model.restitution[TIP], model.friction[TIP],
            model.stiffness[TIP],
        ),
        Contact(
            0, count, places[0] - surface.radius * np.array(UP), UP, model.restitution[TABLE],
            model.friction[TABLE], model.stiffness[TABLE],
        ),
    ]
    contacts += [
        contact for contact in contacts_among(surface, furniture, balls)
        if not (contact.a == 0 and contact.b == count and np.array_equal(contact.normal, UP))
    ]
    bodies = [body_of(surface, ball) for ball in balls]
    result = collide(
        [*bodies, Body.fixed(), cue], contacts, law=LAW_NAMES[model.law],
        exponent=model.exponent, tolerance=TOLERANCE,
    )
    for k, i in enumerate(members):
        given[i, 3:6], given[i, 6:9] = result.velocities[k], result.spins[k]
    book(row, result, c, speed)
    return result


def book(
    row: NDArray[np.float64], result: CollisionResult, c: NDArray[np.float64], speed: float
) -> None:
    """Fill a row in from a strike of many bodies: the struck ball, tip and table."""
    axes = row[at.AXES].reshape(2, 3, 3)
    row[at.VELOCITY], row[at.SPIN] = result.velocities[0], result.spins[0]
    row[at.CUE_SPEED] = result.velocities[-1] @ c
    row[at.LOSS] = result.dissipated[:2].ravel()
    row[at.IMPULSE] = np.einsum('ckl,cl->ck', axes, result.impulses[:2]).ravel()
    row[at.PHASES], row[at.EVALUATIONS] = len(result.phases), result.evaluations
    status = result.status
    if status in (Status.OK, Status.INFINITE_SEQUENCE) and result.slips[TIP] > MISCUE_SLIP * speed:
        status = Status.MISCUE
    row[at.STATUS] = status
