"""
A strike on a ball that touches another one, or a cushion: tip, balls, cushion and cloth at once.

The cue is a body on its guide, as in the strike of a ball alone; the rest is a cluster of the
table (billiard_shot.table.cluster), and all of it goes through billiard_shot.impact.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, collide, CollisionResult, Contact
from billiard_shot.impact.laws import LAWS
from billiard_shot.shot.model import StrikeModel, TABLE, TIP, tip_reach
from billiard_shot.shot.strike import final_status, MISCUE_SLIP
from billiard_shot.status import Status
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.motion import Ball, start_ball
from billiard_shot.table.params import TableParams
from billiard_shot.table.touching import body_of, contacts_among, touching_group

TOLERANCE = 1e-9  # of the impact, relative to the cue's speed
UP = (0.0, 0.0, 1.0)
LAW_NAMES = {number: name for name, number in LAWS.items()}


def touches(table: TableParams, radius: float, places: NDArray[np.float64]) -> bool:
    """Whether the first of some balls (n, 3) touches another one, or perhaps a cushion."""
    gaps = np.linalg.norm(places[1:] - places[0], axis=1) - 2.0 * radius
    if (gaps <= table.contact_gap).any():
        return True
    above = table.nose_height - radius
    reach = np.sqrt(radius**2 - above**2) if table.length < np.inf else 0.0
    outside = max(abs(places[0, 0]) - 0.5 * table.length, abs(places[0, 1]) - 0.5 * table.width)
    return bool(outside + reach >= -table.contact_gap)


def strike_together(
    model: StrikeModel,
    table: TableParams,
    given: NDArray[np.float64],
    normal: NDArray[np.float64],
    velocity: NDArray[np.float64],
    strike: np.void,
) -> CollisionResult:
    """
    Strike the first ball together with all that it touches.

    Parameters
    ----------
    model, table : StrikeModel, TableParams
    given : (balls, STATE_COLUMNS) float array, changed
        States, the struck ball first; in the end those after the strike.
    normal, velocity : (3,) float arrays
        Of the stroke; unit vector and [m/s].
    strike : Strike, changed
        The strike of the ball alone; in the end this one.

    """
    surface, still = model.surface, [0.0, 0.0, 0.0]
    places = given[:, :3]
    members = touching_group(places, 0, 2.0 * surface.radius + table.contact_gap)
    balls = [Ball() for _ in members]
    for i, ball in zip(members, balls, strict=True):
        start_ball(ball, places[i].tolist(), still, still)
    count = len(balls)
    speed = float(np.linalg.norm(velocity))
    c = velocity / speed
    tip = places[0] + surface.radius * normal
    cue = Body(
        model.cue_mass,
        velocity=velocity,
        position=tip,
        guide=c,
        end_mass=1.0 / model.inverse_end_mass if model.inverse_end_mass > 0.0 else None,
    )
    contacts = [
        Contact(
            count + 1,
            0,
            tip,
            normal,
            model.restitution[TIP],
            model.friction[TIP],
            model.stiffness[TIP],
        ),
        Contact(
            0,
            count,
            places[0] - surface.radius * np.array(UP),
            UP,
            model.restitution[TABLE],
            model.friction[TABLE],
            model.stiffness[TABLE],
        ),
    ]
    contacts += [
        contact
        for contact in contacts_among(layout_of(surface, table), balls)
        if not (contact.a == 0 and contact.b == count and np.array_equal(contact.normal, UP))
    ]
    bodies = [body_of(surface, ball) for ball in balls]
    result = collide(
        [*bodies, Body.fixed(), cue],
        contacts,
        law=LAW_NAMES[model.law],
        exponent=model.exponent,
        tolerance=TOLERANCE,
    )
    for k, i in enumerate(members):
        given[i, 3:6], given[i, 6:9] = result.velocities[k], result.spins[k]
    write_group_result(strike, result, c, speed)
    strike['tip'] = tip_reach(model) * normal
    return result


def write_group_result(
    strike: np.void, result: CollisionResult, c: NDArray[np.float64], speed: float
) -> None:
    """Complete a `Strike` from a collision of many bodies: the struck ball, tip and table."""
    axes = strike['axes'].reshape(2, 3, 3)
    strike['velocity'][:], strike['spin'][:] = result.velocities[0], result.spins[0]
    strike['cue_speed'] = result.velocities[-1] @ c
    strike['losses'][:] = result.dissipated[:2].ravel()
    strike['impulses'][:] = np.einsum('ckl,cl->ck', axes, result.impulses[:2]).ravel()
    strike['hits'] = 1
    strike['phases'], strike['steps'] = len(result.phases), result.evaluations
    miscue = result.slips[TIP] > MISCUE_SLIP * speed
    strike['status'] = final_status(int(result.status), miscue, int(Status.OK), exact=True)
