"""End of a collision: its results in SI units, and the check of its energy balance."""

from math import inf
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import Units
from billiard_shot.impact.laws import elastic_energy, POISSON
from billiard_shot.impact.moving_balls import change_units, kinetic_energy
from billiard_shot.impact.options import OPTIONS
from billiard_shot.impact.state import (
    components,
    ContactState,
    INACTIVE,
    is_active,
    Model,
    PhaseLog,
    Progress,
    RESTITUTION,
    Workspace,
)
from billiard_shot.impact.transitions import loss_since_peak
from billiard_shot.records import record, Vector
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED


@record
class ContactResult:
    """Impulse, losses and final slip of a contact after a collision."""

    impulse: float  # [N s] on body a: along the normal, and along the tangents
    impulse_1: float
    impulse_2: float
    restitution_loss: float  # [J]
    friction_loss: float  # [J]
    final_slip: float  # [m/s] when the contact last ended
    # Least margin of a decision between restitution and recompression, relative to the peak of
    # compression; infinite without a decision. Near 0, the result is close to a discontinuity.
    discontinuity_margin: float
    length: float  # [m] of the spring's compression; below zero: minus the distance
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
    log: list[PhaseLog]  # of the last collision, N for each phase as far as there is room
    outcomes: list[CollisionOutcome]  # n


@inner
def finish(
    m: Model,
    velocity: Vector,
    units: Units,
    contacts: list[ContactState],
    ws: Workspace,
    p: Progress,
    results: Results,
    number: int,
) -> None:
    """Check the balance of energy of a collision, and write its results in SI units."""
    count = len(contacts)
    for j in range(count):
        if contacts[j].normal_mode == RESTITUTION:  # the time was up
            contacts[j].restitution_loss += loss_since_peak(m, contacts[j])
    if (p.status == OK or p.status == INFINITE_SEQUENCE) and m.law != POISSON:
        allowed = max(OPTIONS.imbalance * m.tolerance, OPTIONS.min_imbalance)
        if m.balls.number > 0:
            imbalance = energy_imbalance_of_balls(m, contacts, p.energy, ws)
        else:
            imbalance = energy_imbalance(m, contacts, velocity, units.speed, ws)
        if not imbalance <= allowed:  # also if it is NaN
            p.status = TOLERANCE_NOT_REACHED
    if m.balls.number > 0:
        length = units.speed * units.time
        change_units(contacts, ws.motion, m.balls.number, 1.0 / units.speed, 1.0 / length)
    for j in range(count):
        write_result(contacts[j], results.contacts[number * count + j], units)
    for i in range(min(p.phases * count, len(results.log))):
        logged = results.log[i]
        logged.impulse *= units.impulse
        logged.impulse_1 *= units.impulse
        logged.impulse_2 *= units.impulse
        logged.energy *= units.impulse * units.speed


@inner
def clear_result(result: ContactResult, length: float) -> None:
    """Set a result to that of a contact at which nothing happens."""
    result.impulse, result.impulse_1, result.impulse_2 = 0.0, 0.0, 0.0
    result.restitution_loss, result.friction_loss, result.final_slip = 0.0, 0.0, 0.0
    result.discontinuity_margin, result.length, result.closings = inf, length, 0


@inner
def write_result(c: ContactState, result: ContactResult, units: Units) -> None:
    """Write the result of a contact."""
    unit, speed = units.impulse, units.speed
    result.length = speed * units.time * c.compression[0]
    result.impulse, result.impulse_1 = unit * c.impulse, unit * c.impulse_1
    result.impulse_2 = unit * c.impulse_2
    result.restitution_loss = unit * speed * c.restitution_loss
    result.friction_loss = unit * speed * c.friction_loss
    result.final_slip = speed * c.final_slip
    result.discontinuity_margin, result.closings = c.discontinuity_margin, c.closings


@inner
def energy_imbalance(
    m: Model, contacts: list[ContactState], velocity: Vector, speed: float, ws: Workspace
) -> float:
    """
    Energy imbalance, relative to all the energy exchanged.

    Impulses times the mean of the velocities before and after are the work done on the bodies.
    """
    gap, turnover = 0.0, 0.0
    after = ws.vector[0]
    for j in range(len(contacts)):
        c = contacts[j]
        components(c, after, j)
        impulses = (c.impulse, c.impulse_1, c.impulse_2)
        for k in range(3):
            before = velocity[3 * j + k] / speed
            gap += 0.5 * impulses[k] * (before + after[3 * j + k])
            turnover += 0.5 * abs(impulses[k]) * (abs(before) + abs(after[3 * j + k]))
        gap += c.restitution_loss + c.friction_loss - c.initial_energy
        if c.normal_mode != INACTIVE:  # the time was up
            gap += elastic_energy(c.stiffness, c.compression[0], m.exponent)
    return abs(gap) / turnover if turnover > 0.0 else 0.0


@inner
def energy_imbalance_of_balls(
    m: Model, contacts: list[ContactState], before: float, ws: Workspace
) -> float:
    """Energy imbalance of moving balls, relative to normal impulses times the approach speed."""
    gap, turnover = kinetic_energy(m.balls, ws.motion) - before, 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        gap += c.restitution_loss + c.friction_loss - c.initial_energy
        gap += elastic_energy(c.stiffness, c.compression[0], m.exponent) if is_active(c) else 0.0
        turnover += abs(c.impulse)
    return abs(gap) / turnover if turnover > 0.0 else 0.0
