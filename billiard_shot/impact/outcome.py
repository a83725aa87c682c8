"""End of a collision: its results in SI units, and the check of its energy balance."""

from math import inf
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import Units
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.moving_bodies import (
    change_units,
    energy_of_bodies,
    impulse_along,
    push_bodies,
    store_body,
    VELOCITY_ROWS,
)
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.shaft import logged_contacts
from billiard_shot.impact.shear import spring_energy
from billiard_shot.impact.state import (
    BodyState,
    components,
    ContactState,
    ImpactProgress,
    is_active,
    Model,
    PhaseLog,
    Workspace,
)
from billiard_shot.records import record
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED


@record
class ContactResult:
    """Impulse, losses, slips and times of a contact after a collision."""

    # [N s] on body a: along the normal, and along the tangents; or along x, y and z, if the
    # bodies are those of moving_bodies.py.
    impulse: float
    impulse_1: float
    impulse_2: float
    restitution_loss: float  # [J]
    friction_loss: float  # [J]
    final_slip: float  # [m/s] when the contact ended last
    # If stiffnesses are in N/m^exponent: how far a tip slid on a ball until the contact ended
    # first, and before its largest compression [m]; when it became active last, since the
    # beginning, and how long it was active in all [s].
    slid: float
    slid_to_peak: float
    began: float
    touched: float
    # [m] Largest distance of a ball from the cloth when a tip closed on it again.
    lifted: float
    # Least margin of a decision between restitution and recompression, relative to the peak of
    # compression; infinite without a decision. Near 0, the result is close to a discontinuity.
    discontinuity_margin: float
    length: float  # [m] minus the distance: since the contact ended
    closings: int  # how often the contact became active


@record
class CollisionOutcome:
    """Status and cost of a collision."""

    status: int  # Status
    phases: int
    steps: int
    duration: float  # [s] if stiffnesses are in N/m^exponent


class Results(NamedTuple):
    """Results of n collisions of N contacts."""

    contacts: list[ContactResult]  # n N
    bodies: list[BodyState]  # n B, at the end of the collisions; may be those given
    log: list[PhaseLog]  # of the last collision, N for each phase as far as there is room
    outcomes: list[CollisionOutcome]  # n


@inner
def finish(
    m: Model,
    units: Units,
    contacts: list[ContactState],
    ws: Workspace,
    p: ImpactProgress,
    results: Results,
    number: int,
) -> None:
    """Check the balance of energy of a collision, and write its results in SI units."""
    count = len(contacts)
    if (p.status == OK or p.status == INFINITE_SEQUENCE) and m.law != POISSON:
        allowed = max(METHOD_OPTIONS.imbalance * m.tolerance, METHOD_OPTIONS.min_imbalance)
        if m.moves:
            imbalance = energy_imbalance_of_bodies(m, contacts, p.energy, ws)
        else:
            imbalance = energy_imbalance(contacts, units.speed, ws)
        if not imbalance <= allowed:  # also if it is NaN
            p.status = TOLERANCE_NOT_REACHED
    for j in range(count):
        write_result(m, contacts[j], results.contacts[number * count + j], units)
    if m.bodies > 0:
        finish_bodies(m, units, contacts, ws, results, number)
    for i in range(min(p.phases * logged_contacts(contacts), len(results.log))):
        logged = results.log[i]
        logged.impulse *= units.impulse
        logged.impulse_1 *= units.impulse
        logged.impulse_2 *= units.impulse
        logged.energy *= units.impulse * units.speed


@inner
def finish_bodies(
    m: Model,
    units: Units,
    contacts: list[ContactState],
    ws: Workspace,
    results: Results,
    number: int,
) -> None:
    """Write the bodies of a collision in SI units; push those that did not move."""
    if m.moves:
        length = units.speed * units.time
        change_units(contacts, ws, m.bodies, 1.0 / units.speed, 1.0 / length)
    else:
        impulses = ws.vector[0]
        for j in range(len(contacts)):
            c = contacts[j]
            impulses[0] = units.impulse * c.impulse
            impulses[1] = units.impulse * c.impulse_1
            impulses[2] = units.impulse * c.impulse_2
            push_bodies(ws, c, impulses, VELOCITY_ROWS, 0)
    for b in range(m.bodies):
        ws.bodies[b].lost *= units.impulse * units.speed
        store_body(results.bodies[number * m.bodies + b], ws, b)


@inner
def clear_result(result: ContactResult, length: float) -> None:
    """Set a result to that of a contact at which nothing happens."""
    result.impulse, result.impulse_1, result.impulse_2 = 0.0, 0.0, 0.0
    result.restitution_loss, result.friction_loss = 0.0, 0.0
    result.final_slip, result.slid, result.slid_to_peak = 0.0, 0.0, 0.0
    result.began, result.touched, result.lifted = 0.0, 0.0, 0.0
    result.discontinuity_margin, result.length = inf, length
    result.closings = 0


@inner
def write_result(m: Model, c: ContactState, result: ContactResult, units: Units) -> None:
    """Write the result of a contact."""
    unit, speed = units.impulse, units.speed
    result.length = speed * units.time * c.compression[0]
    result.impulse, result.impulse_1 = unit * c.impulse, unit * c.impulse_1
    result.impulse_2 = unit * c.impulse_2
    if m.bodies > 0:
        result.impulse, result.impulse_1 = unit * impulse_along(c, 0), unit * impulse_along(c, 1)
        result.impulse_2 = unit * impulse_along(c, 2)
    result.restitution_loss = unit * speed * c.restitution_loss
    result.friction_loss = unit * speed * c.friction_loss
    result.final_slip, result.slid = speed * c.final_slip, speed * units.time * c.slid
    result.slid_to_peak = speed * units.time * c.slid_to_peak
    result.began, result.touched = units.time * c.began, units.time * c.touched
    result.lifted = speed * units.time * c.lifted
    result.discontinuity_margin, result.closings = c.discontinuity_margin, c.closings


@inner
def energy_imbalance(contacts: list[ContactState], speed: float, ws: Workspace) -> float:
    """
    Energy imbalance, relative to all the energy exchanged.

    Impulses times the mean of the velocities before and after are the work done on the bodies.
    """
    gap, turnover = 0.0, 0.0
    first, after = ws.vector[2], ws.vector[0]
    for j in range(len(contacts)):
        c = contacts[j]
        components(c, after, j)
        impulses = (c.impulse, c.impulse_1, c.impulse_2)
        for k in range(3):
            before = first[3 * j + k] / speed
            gap += 0.5 * impulses[k] * (before + after[3 * j + k])
            turnover += 0.5 * abs(impulses[k]) * (abs(before) + abs(after[3 * j + k]))
        gap += c.restitution_loss + c.friction_loss
    return abs(gap) / turnover if turnover > 0.0 else 0.0


@inner
def energy_imbalance_of_bodies(
    m: Model, contacts: list[ContactState], before: float, ws: Workspace
) -> float:
    """Energy imbalance of moving bodies, relative to normal impulses times the approach speed."""
    gap, turnover = energy_of_bodies(ws, m.bodies) - before, 0.0
    for b in range(m.bodies):
        gap += ws.bodies[b].lost
    for j in range(len(contacts)):
        c = contacts[j]
        gap += c.restitution_loss + c.friction_loss
        gap += spring_energy(c) if is_active(c) else 0.0
        turnover += abs(c.impulse)
    return abs(gap) / turnover if turnover > 0.0 else 0.0
