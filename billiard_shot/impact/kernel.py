"""Collisions in contact space, from approach to parting: the compiled entry, and its interface."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
import threading
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact import beginning, moving_bodies
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.friction import spring_energy
from billiard_shot.impact.integrator import end, integrate, logged_contacts
from billiard_shot.impact.options import elastic_energy, METHOD_OPTIONS, POISSON
from billiard_shot.impact.state import (
    BodyState,
    clear_results,
    components,
    ContactLog,
    ContactProperties,
    ContactState,
    HISTORY,
    ImpactProgress,
    is_active,
    Model,
    PhaseLog,
    SECTION,
    Workspace,
    workspace,
)
from billiard_shot.numerics import rounding
from billiard_shot.records import as_rows, Floats, record, ROWS, Storage
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED

MAX_SECTIONS = (HISTORY - 1) // 2  # of a cycle

# A contact's part of the history.
NORMAL_VELOCITY, SLIP_1, SLIP_2, SPRING_COMPRESSION, IMPULSE, IMPULSE_1, IMPULSE_2 = range(7)
RESTITUTION_LOSS, FRICTION_LOSS, FINAL_SLIP = range(7, SECTION)


@inner
def ends_in_geometric_tail(
    m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress
) -> bool:
    """At the end of a section, add the rest if it is a geometric series; return whether it is."""
    record_section(contacts, ws, p)
    return m.law != POISSON and add_tail(m, contacts, ws, p)


@inner
def record_section(contacts: list[ContactState], ws: Workspace, p: ImpactProgress) -> None:
    """Write the state into the history."""
    row = p.sections % HISTORY
    ws.hashes[row] = p.event_hash
    p.event_hash = 0
    p.sections += 1
    x = ws.history[row]
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        components(c, x, n + NORMAL_VELOCITY)
        x[n + SPRING_COMPRESSION] = c.compression[0]
        for k in range(3):
            x[n + IMPULSE + k] = c.impulse[k]
        x[n + RESTITUTION_LOSS], x[n + FRICTION_LOSS] = c.restitution_loss, c.friction_loss
        x[n + FINAL_SLIP] = c.final_slip


@inner
def add_tail(m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress) -> bool:
    """Add the rest of a sequence to the state if it is a geometric series; return whether."""
    row = p.sections - 1
    for sections in range(1, MAX_SECTIONS + 1):
        if p.sections <= 2 * sections or not same_events(ws, row, sections):
            continue
        last = ws.history[row % HISTORY]
        before = ws.history[(row - sections) % HISTORY]
        first = ws.history[(row - 2 * sections) % HISTORY]
        size = amplitude(contacts, ws, before, first)
        ratio = amplitude(contacts, ws, last, before) / size if size > 0.0 else 1.0
        if ratio < METHOD_OPTIONS.max_tail_ratio and is_geometric(
            m, contacts, ws, last, before, first, ratio=ratio
        ):
            add_cycles(contacts, last, before, first, ratio)
            return True
    return False


@inner
def same_events(ws: Workspace, row: int, sections: int) -> bool:
    """Whether the last two cycles, of this many sections each, had the same events."""
    for k in range(row - sections + 1, row + 1):
        if ws.hashes[k % HISTORY] != ws.hashes[(k - sections) % HISTORY]:
            return False
    return True


@inner
def amplitude(contacts: list[ContactState], ws: Workspace, now: Floats, before: Floats) -> float:
    """Amplitude of the motion after a cycle, as a velocity, at the contacts that it pressed."""
    square = 0.0
    for j in range(len(contacts)):
        n = SECTION * j
        if now[n + IMPULSE] > before[n + IMPULSE]:
            c = contacts[j]
            energy = elastic_energy(c.stiffness, now[n + SPRING_COMPRESSION], c.exponent)
            square += now[n + NORMAL_VELOCITY] * now[n + NORMAL_VELOCITY]
            square += 2.0 * energy * ws.delassus[3 * j][3 * j]
    return sqrt(square)


@inner
def limit(now: float, before: float, ratio: float) -> float:
    """Limit of a number whose changes shrink by a ratio."""
    return now + (now - before) * ratio / (1.0 - ratio)


@inner
def is_geometric(
    m: Model, contacts: list[ContactState], ws: Workspace, now: Floats, before: Floats,
    first: Floats, ratio: float,
) -> bool:  # fmt: skip
    """Whether the last two cycles differ by the ratio only, and so do the states after them."""
    allowed = METHOD_OPTIONS.tail_share * m.tolerance * (1.0 - ratio) * (1.0 - ratio)
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        response = ws.delassus[3 * j][3 * j]
        if now[n + IMPULSE] > before[n + IMPULSE]:
            shrinking = ratio ** (2.0 / (c.exponent + 1.0))  # energies go as ratio^2
            off = abs(now[n + SPRING_COMPRESSION] - shrinking * before[n + SPRING_COMPRESSION])
            if not off * sqrt(c.stiffness * response) <= allowed:
                return False
            if not abs(now[n + NORMAL_VELOCITY] - ratio * before[n + NORMAL_VELOCITY]) <= allowed:
                return False
        elif limit(now[n + NORMAL_VELOCITY], before[n + NORMAL_VELOCITY], ratio) < 0.0:
            return False  # it will close
        for k in range(3):
            response = ws.delassus[3 * j + k][3 * j + k]
            for row in (n + NORMAL_VELOCITY + k, n + IMPULSE + k):
                unit = 1.0 if row < n + IMPULSE else response
                off = abs((now[row] - before[row]) - ratio * (before[row] - first[row]))
                if not off * unit <= allowed + rounding.SUM * abs(now[row]) * unit:
                    return False
        slip_1, slip_2 = now[n + SLIP_1], now[n + SLIP_2]
        limit_1 = limit(slip_1, before[n + SLIP_1], ratio)
        limit_2 = limit(slip_2, before[n + SLIP_2], ratio)
        slip = sqrt(slip_1 * slip_1 + slip_2 * slip_2)
        if slip_1 * limit_1 + slip_2 * limit_2 < -METHOD_OPTIONS.tail_share * m.tolerance * slip:
            return False  # it will stop on the way
    return True


@inner
def add_cycles(
    contacts: list[ContactState], now: Floats, before: Floats, first: Floats, ratio: float
) -> None:
    """Set the state to the limit of a geometric sequence."""
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        c.velocity[0] = limit(now[n + NORMAL_VELOCITY], before[n + NORMAL_VELOCITY], ratio)
        c.slip_1[0] = limit(now[n + SLIP_1], before[n + SLIP_1], ratio)
        c.slip_2[0] = limit(now[n + SLIP_2], before[n + SLIP_2], ratio)
        for row in range(3):
            impulse = n + IMPULSE + row
            c.impulse[row] = limit(now[impulse], before[impulse], ratio)
        c.final_slip = limit(now[n + FINAL_SLIP], before[n + FINAL_SLIP], ratio)
        c.restitution_loss = limit_of_loss(
            now[n + RESTITUTION_LOSS],
            before[n + RESTITUTION_LOSS],
            first[n + RESTITUTION_LOSS],
            ratio,
        )
        c.friction_loss = limit_of_loss(
            now[n + FRICTION_LOSS], before[n + FRICTION_LOSS], first[n + FRICTION_LOSS], ratio
        )
        if is_active(c):
            c.compression[0] = 0.0
            c.peak_compression = 0.0


@inner
def limit_of_loss(now: float, before: float, first: float, ratio: float) -> float:
    """
    Limit of an energy loss.

    If slip continues, a part of the loss in a cycle shrinks with the ratio, the rest with its
    square. Two cycles determine that part.
    """
    square = ratio * ratio
    change = now - before
    part = (change - square * (before - first)) / (1.0 - ratio)
    return now + part * ratio / (1.0 - ratio) + (change - part) * square / (1.0 - square)


@record
class ContactResult(ContactLog):
    """
    A contact after a collision; its energies [J], slip [m/s] and lengths [m].

    Impulses [N s] are along x, y and z if the bodies are those of moving_bodies.py. The ways and
    times [s] need stiffnesses in N/m^exponent.
    """

    length: float  # minus the distance: since the contact ended


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
    units: beginning.Units,
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
    units: beginning.Units,
    contacts: list[ContactState],
    ws: Workspace,
    results: Results,
    number: int,
) -> None:
    """Write the bodies of a collision in SI units; push those that did not move."""
    if m.moves:
        length = units.speed * units.time
        moving_bodies.change_units(contacts, ws, m.bodies, 1.0 / units.speed, 1.0 / length)
    else:
        impulses = ws.vector[0]
        for j in range(len(contacts)):
            c = contacts[j]
            for k in range(3):
                impulses[k] = units.impulse * c.impulse[k]
            moving_bodies.push_bodies(ws, c, impulses, moving_bodies.VELOCITY_ROWS, 0)
    for b in range(m.bodies):
        ws.bodies[b].lost *= units.impulse * units.speed
        moving_bodies.store_body(results.bodies[number * m.bodies + b], ws, b)


@inner
def write_result(m: Model, c: ContactState, result: ContactResult, units: beginning.Units) -> None:
    """Write the result of a contact."""
    unit, speed = units.impulse, units.speed
    result.length = speed * units.time * c.compression[0]
    for k in range(3):
        result.impulse[k] = unit * (
            moving_bodies.impulse_along(c, k) if m.bodies > 0 else c.impulse[k]
        )
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
        components(c, after, 3 * j)
        for k in range(3):
            before = first[3 * j + k] / speed
            gap += 0.5 * c.impulse[k] * (before + after[3 * j + k])
            turnover += 0.5 * abs(c.impulse[k]) * (abs(before) + abs(after[3 * j + k]))
        gap += c.restitution_loss + c.friction_loss
    return abs(gap) / turnover if turnover > 0.0 else 0.0


@inner
def energy_imbalance_of_bodies(
    m: Model, contacts: list[ContactState], before: float, ws: Workspace
) -> float:
    """Energy imbalance of moving bodies, relative to normal impulses times the approach speed."""
    gap, turnover = moving_bodies.energy_of_bodies(ws, m.bodies) - before, 0.0
    for b in range(m.bodies):
        gap += ws.bodies[b].lost
    for j in range(len(contacts)):
        c = contacts[j]
        gap += c.restitution_loss + c.friction_loss
        gap += spring_energy(c) if is_active(c) else 0.0
        turnover += abs(c.impulse[0])
    return abs(gap) / turnover if turnover > 0.0 else 0.0


class Scratch(NamedTuple):
    """Scratch of the solver for a collision of N contacts."""

    contacts: list[ContactState]
    workspace: Workspace
    progress: list[ImpactProgress]  # 1


def new_scratch(storage: Storage, count: int) -> Scratch:
    """Make scratch for collisions of N contacts."""
    return Scratch(
        storage.records(ContactState, count),
        workspace(storage, count, TABLEAUS[storage]),
        storage.records(ImpactProgress, 1),
    )


def _example(storage: Storage) -> tuple[Any, ...]:
    """Make one contact that approaches."""
    properties = storage.records(ContactProperties, 1)
    properties[0].stiffness, properties[0].exponent = 1.0, 1.0
    properties[0].max_closings = beginning.UNLIMITED
    one = beginning.Collisions(
        properties=properties,
        law=0,
        bodies=storage.records(BodyState, 0),
        delassus=storage.array(np.eye(3)[np.newaxis]),
        velocity=storage.array(-np.eye(1, 3)),
        distances=False,
        lengths=storage.array(np.zeros((1, 1))),
        tolerance=storage.array([1e-9]),
    )
    results = Results(
        storage.records(ContactResult, 1),
        storage.records(BodyState, 0),
        storage.records(PhaseLog, 1),
        storage.records(CollisionOutcome, 1),
    )
    return one, new_scratch(storage, 1), results


@entry(_example)
def solve_collisions(given: beginning.Collisions, scratch: Scratch, results: Results) -> None:
    """Solve n collisions of the same N contacts, one after the other; write the results."""
    contacts, ws, p = scratch.contacts, scratch.workspace, scratch.progress[0]
    count, log = len(contacts), results.log
    for i in range(len(given.tolerance)):
        if not given.tolerance[i] > 0.0:
            continue
        m, units = beginning.begin_collision(given, i, contacts, ws, p)
        if units.speed > 0.0:
            while not integrate(m, contacts, ws, p, log):
                if ends_in_geometric_tail(m, contacts, ws, p):
                    end(m, contacts, ws, p, log, INFINITE_SEQUENCE)
                    break
            if m.moves:
                moving_bodies.end_swings(contacts, ws)
            finish(m, units, contacts, ws, p, results, number=i)
        else:
            for j in range(count):
                result = results.contacts[i * count + j]
                clear_results(result)
                has_length = given.distances and m.bodies == 0
                result.length = given.lengths[i][j] if has_length else 0.0
                result.closings = 0
            for b in range(m.bodies):
                moving_bodies.store_body(results.bodies[i * m.bodies + b], ws, b)
        outcome = results.outcomes[i]
        outcome.status, outcome.phases, outcome.steps = p.status, p.phases, p.steps
        outcome.duration = units.time * p.time


@dataclass(frozen=True, slots=True)
class Properties:
    """
    Law and contacts of n collisions of N contacts.

    Arrays are (N,), the same for all collisions, or (n, N).
    """

    friction: Sequence[float] | NDArray[np.float64]  # Coulomb coefficients, without slip
    restitution: Sequence[float] | NDArray[np.float64]
    stiffness: Sequence[float] | NDArray[np.float64]  # N/m^exponent; see `Contact`
    law: int  # see laws.py
    exponent: Sequence[float] | NDArray[np.float64] | float = 1.0


class Solved(NamedTuple):
    """
    Solved collisions.

    Attributes
    ----------
    contacts : (n, N) array of ContactResult
    outcomes : (n,) array of CollisionOutcome
    log : (phases, N) array of PhaseLog
        Phases of the last collision.

    """

    contacts: NDArray[np.void]
    outcomes: NDArray[np.void]
    log: NDArray[np.void]


class _Thread(threading.local):
    """Scratch of this thread; a new one would take a tenth of the time of a strike."""

    def __init__(self) -> None:
        self.kept: dict[tuple[Storage, int], Scratch] = {}

    def scratch(self, storage: Storage, count: int) -> Scratch:
        """Return scratch for N contacts; its contents are those of the last collision."""
        if (storage, count) not in self.kept:
            self.kept[storage, count] = new_scratch(storage, count)
        return self.kept[storage, count]


_thread = _Thread()
scratch = _thread.scratch


def solve_in_contact_space(
    properties: Properties,
    delassus: NDArray[np.float64],
    velocity: NDArray[np.float64],
    tolerance: ArrayLike,
    phases: int = 0,
    lengths: NDArray[np.float64] | None = None,
    storage: Storage | None = None,
) -> Solved:
    """
    Solve n collisions of the same N contacts.

    Parameters
    ----------
    properties : Properties
    delassus, velocity, tolerance
        (n, 3 N, 3 N), (n, 3 N) and (n,) arrays, see `Collisions`.
    phases : int
        Phases of the last collision that the log has room for; 0 for no log. If the collision has
        more, it is solved again, and all are logged.
    lengths : (n, N) float array, optional
        See `Collisions`. Without them, contacts have no distances.
    storage : Storage, optional
        Where the collisions live; by default where `solve_collisions` takes them.

    """
    n, count = len(velocity), np.shape(properties.friction)[-1]
    storage = storage or solve_collisions.current().storage
    given = ROWS.records(ContactProperties, n * count)
    table = given.reshape(n, count)
    for name in ('friction', 'restitution', 'stiffness', 'exponent'):
        table[name] = getattr(properties, name)
    table['max_closings'] = beginning.UNLIMITED
    collisions = beginning.Collisions(
        properties=storage.from_rows(ContactProperties, given),
        law=properties.law,
        bodies=storage.records(BodyState, 0),
        delassus=storage.array(delassus),
        velocity=storage.array(velocity),
        distances=lengths is not None,
        lengths=storage.zeros(n, count) if lengths is None else storage.array(lengths),
        tolerance=storage.array(tolerance),
    )
    results = storage.records(ContactResult, n * count)
    outcomes = storage.records(CollisionOutcome, n)
    while True:
        log = storage.records(PhaseLog, phases * count)
        found = Results(results, collisions.bodies, log, outcomes)
        solve_collisions.on(storage)(collisions, scratch(storage, count), found)
        needed = int(outcomes[-1].phases) if phases and n else 0
        if needed <= phases:
            break
        phases = needed
    return Solved(
        as_rows(ContactResult, results).reshape(n, count),
        as_rows(CollisionOutcome, outcomes),
        as_rows(PhaseLog, log)[: needed * count].reshape(needed, count),
    )
