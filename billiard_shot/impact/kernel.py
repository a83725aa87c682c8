"""
Collisions in contact space, from approach to parting: what machine code is made of.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = stiffness y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y (integrator.py). Everything inside is in
units of the largest approach speed, response and stiffness: answers cannot depend on them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
import threading
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.geometric_tail import ends_in_geometric_tail
from billiard_shot.impact.integrator import end, integrate
from billiard_shot.impact.laws import elastic_energy, POISSON, restitution_end, unloading_rate
from billiard_shot.impact.moving_balls import (
    change_units,
    kinetic_energy,
    release_open_contacts,
)
from billiard_shot.impact.options import DEFAULT_OPTIONS, Options
from billiard_shot.impact.state import (
    Balls,
    components,
    COMPRESSION,
    ContactState,
    FRICTIONLESS,
    INACTIVE,
    is_active,
    Model,
    NO_BALLS,
    PhaseLog,
    Progress,
    RESTITUTION,
    Workspace,
    workspace,
)
from billiard_shot.impact.transitions import loss_since_peak
from billiard_shot.records import as_rows, Floats, record, Storage, Vector
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED

Scratch = tuple[list[ContactState], Workspace, list[Progress]]


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
    # compression; infinite if there was none. Near 0, the result is close to a discontinuity.
    discontinuity_margin: float
    length: float  # [m] of the spring's compression; below zero: minus the distance
    closings: int  # how often the contact became active


@record
class CollisionOutcome:
    """How a collision ended."""

    status: int  # Status
    phases: int
    steps: int
    duration: float  # [s] if stiffnesses are in N/m^exponent


@dataclass(frozen=True, slots=True)
class Properties:
    """
    Law and contacts of n collisions of N contacts.

    Numbers of contacts are (N,), the same for all collisions, or (n, N).
    """

    friction: Sequence[float] | NDArray[np.float64]  # Coulomb coefficients
    restitution: Sequence[float] | NDArray[np.float64]
    stiffness: Sequence[float] | NDArray[np.float64]  # N/m^exponent; see `Contact`
    law: int  # see laws.py
    exponent: float = 1.0
    options: Options = DEFAULT_OPTIONS


class Units(NamedTuple):
    """The units in which a collision is solved; 0 if nothing approaches."""

    speed: float  # m/s
    impulse: float  # N s
    time: float  # s, if stiffnesses are in N/m^exponent


@inner
def begin(
    properties: Floats,
    law: int,
    exponent: float,
    distances: bool,
    options: Options,
    delassus: Floats,
    velocity: Vector,
    lengths: Vector,
    until: float,
    balls: Balls,
    tolerance: float,
    contacts: list[ContactState],
    ws: Workspace,
    p: Progress,
) -> tuple[Model, Units]:
    """
    Set contacts and progress to where a collision begins, in its own units.

    Returns the model and the units, which are zero if nothing approaches and nothing is pressed.
    """
    count = len(contacts)
    speed, mobility, firmness = 0.0, 0.0, 0.0
    for j in range(count):
        speed = max(speed, -velocity[3 * j])
        if distances and lengths[j] > 0.0:
            energy = elastic_energy(properties[j][2], lengths[j], exponent)
            speed = max(speed, sqrt(2.0 * energy * delassus[3 * j][3 * j]))
        mobility = max(mobility, delassus[3 * j][3 * j])
        firmness = max(firmness, properties[j][2])
    approaches = speed > 0.0 and mobility > 0.0
    start(p)
    if approaches:
        for row in range(3 * count):
            for column in range(3 * count):
                ws.delassus[row][column] = delassus[row][column] / mobility
        units = units_of(speed, mobility, firmness, exponent)
        for j in range(count):
            length = lengths[j] / (units.speed * units.time) if distances else 0.0
            start_contact(
                contacts[j], properties[j], velocity, units, firmness, distances, j, options
            )
            start_length(contacts[j], law, exponent, length)
        planar = is_planar(contacts, ws)
        if balls.number > 0:
            balls = Balls(balls.number, balls.response / mobility, balls.turning / mobility)
            change_units(contacts, ws.motion, balls.number, units.speed, units.speed * units.time)
            release_open_contacts(contacts, ws)
            p.energy = kinetic_energy(balls, ws.motion)
    else:
        units, planar = Units(0.0, 0.0, 0.0), False
    limit = until / units.time if approaches else inf
    tolerance = min(tolerance, options.max_tolerance)
    return Model(law, exponent, tolerance, planar, distances, limit, balls, options), units


@inner
def units_of(speed: float, mobility: float, firmness: float, exponent: float) -> Units:
    """
    Find the units of a collision.

    F = k y^exponent, u' = W F and y' = u are free of units if W k time^(1 + exponent) =
    speed^(1 - exponent).
    """
    time = (speed ** (1.0 - exponent) / (mobility * firmness)) ** (1.0 / (1.0 + exponent))
    return Units(speed, speed / mobility, time)


@inner
def finish(
    m: Model,
    velocity: Vector,
    units: Units,
    contacts: list[ContactState],
    ws: Workspace,
    p: Progress,
    results: list[ContactResult],
    first: int,
    log: list[PhaseLog],
) -> None:
    """Check the balance of energy, and write the results in SI units, from number `first` on."""
    count = len(contacts)
    for j in range(count):
        if contacts[j].normal_mode == RESTITUTION:  # the time was up
            contacts[j].restitution_loss += loss_since_peak(m, contacts[j])
    if (p.status == OK or p.status == INFINITE_SEQUENCE) and m.law != POISSON:
        allowed = max(m.options.imbalance * m.tolerance, m.options.min_imbalance)
        if m.balls.number > 0:
            imbalance = energy_imbalance_of_balls(m, contacts, p.energy, ws)
        else:
            imbalance = energy_imbalance(m, contacts, velocity, units.speed, ws)
        if imbalance > allowed:
            p.status = TOLERANCE_NOT_REACHED
    if m.balls.number > 0:
        length = units.speed * units.time
        change_units(contacts, ws.motion, m.balls.number, 1.0 / units.speed, 1.0 / length)
    for j in range(count):
        write_result(contacts[j], results[first + j], units)
    for i in range(min(p.phases * count, len(log))):
        logged = log[i]
        logged.impulse *= units.impulse
        logged.impulse_1 *= units.impulse
        logged.impulse_2 *= units.impulse
        logged.energy *= units.impulse * units.speed


@inner
def start_contact(
    c: ContactState,
    properties: Vector,
    velocity: Vector,
    units: Units,
    firmness: float,
    distances: bool,
    j: int,
    options: Options,
) -> None:
    """Set a contact to where the collision begins."""
    c.friction, c.restitution, c.stiffness = properties[0], properties[1], properties[2] / firmness
    speed = units.speed
    c.velocity[0] = velocity[3 * j] / speed
    c.slip_1[0], c.slip_2[0] = velocity[3 * j + 1] / speed, velocity[3 * j + 2] / speed
    for values in (c.velocity, c.slip_1, c.slip_2):
        if abs(values[0]) < options.rounding:
            values[0] = 0.0
        for k in range(1, len(values)):
            values[k] = 0.0
    c.compression_rate = 1.0 if distances else 0.0
    c.friction_mode = FRICTIONLESS
    c.peak_compression, c.restitution_end = 0.0, 0.0
    c.activation_impulse, c.negligible_compression = 0.0, 0.0
    c.slip_dir_1, c.slip_dir_2 = 0.0, 0.0
    c.impulse, c.impulse_1, c.impulse_2 = 0.0, 0.0, 0.0
    c.restitution_loss, c.friction_loss, c.final_slip = 0.0, 0.0, 0.0
    c.discontinuity_margin = inf


@inner
def start_length(c: ContactState, law: int, exponent: float, length: float) -> None:
    """Set a contact's compression, or minus its distance, to what the collision begins with."""
    c.compression[0] = length
    c.initial_energy = elastic_energy(c.stiffness, length, exponent)
    c.normal_mode = INACTIVE
    if length >= 0.0 and c.velocity[0] < 0.0:
        c.normal_mode, c.compression_rate = COMPRESSION, 1.0
    elif length > 0.0:
        c.normal_mode, c.peak_compression = RESTITUTION, length
        c.compression_rate = unloading_rate(law, c.restitution)
        c.restitution_end = restitution_end(law, c.restitution, exponent, length)
    c.closings = 0 if c.normal_mode == INACTIVE else 1


@inner
def start(p: Progress) -> None:
    """Set the progress of a collision to its beginning."""
    p.steps_since_event, p.events, p.event_hash, p.stiff = 0, 0, 0, 0
    p.section, p.section_start, p.sections = -1, 0, 0
    p.scale, p.speed = 1.0, 1.0
    p.modes_changed, p.phase_open = True, False
    p.status, p.phases, p.steps, p.time = OK, 0, 0, 0.0


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
def is_planar(contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether no slip can ever turn: nothing happens along any second tangent."""
    w = ws.delassus
    for i in range(len(contacts)):
        if contacts[i].friction > 0.0:
            if contacts[i].slip_2[0] != 0.0:
                return False
            for j in range(len(contacts)):
                if w[3 * i + 2][3 * j] != 0.0:
                    return False
                if contacts[j].friction > 0.0 and w[3 * i + 2][3 * j + 1] != 0.0:
                    return False
    return True


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
    """Energy imbalance of balls that move, relative to all the energy exchanged at most."""
    gap, turnover = kinetic_energy(m.balls, ws.motion) - before, 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        gap += c.restitution_loss + c.friction_loss - c.initial_energy
        gap += elastic_energy(c.stiffness, c.compression[0], m.exponent) if is_active(c) else 0.0
        turnover += abs(c.impulse)
    return abs(gap) / turnover if turnover > 0.0 else 0.0


def _example(storage: Storage) -> tuple[Any, ...]:
    """One contact that approaches."""
    return (
        storage.array(np.full((1, 1, 3), 0.5)),
        0,
        1.0,
        False,
        DEFAULT_OPTIONS,
        storage.array(np.eye(3)[np.newaxis]),
        storage.array(-np.eye(1, 3)),
        storage.array(np.zeros((1, 1))),
        inf,
        NO_BALLS,
        storage.array([1e-9]),
        *new_scratch(storage, 1),
        storage.records(ContactResult, 1),
        storage.records(PhaseLog, 1),
        storage.records(CollisionOutcome, 1),
    )


@entry(_example)
def solve_collisions(
    properties: Floats,
    law: int,
    exponent: float,
    distances: bool,
    options: Options,
    delassus: Floats,
    velocity: Floats,
    lengths: Floats,
    until: float,
    balls: Balls,
    tolerance: Vector,
    contacts: list[ContactState],
    ws: Workspace,
    progress: list[Progress],
    results: list[ContactResult],
    log: list[PhaseLog],
    outcomes: list[CollisionOutcome],
) -> None:
    """
    Solve n collisions of the same N contacts, one after the other.

    Parameters
    ----------
    properties : (n, N, 3) floats
        Friction, restitution and stiffness of the contacts.
    law, exponent, distances, options : int, float, bool, Options
        See `Model`.
    delassus : (n, 3 N, 3 N) floats
        W [1/kg]: contact velocities per impulse. Contact j has components 3 j (normal), 3 j + 1
        and 3 j + 2 (tangential). If all motion stays in one plane per contact, component 3 j + 1
        should lie in it and couplings to 3 j + 2 be exactly zero: that is cheaper.
    velocity : (n, 3 N) floats
        Contact velocities before the collision [m/s]; approaching if the normal one is below 0.
    lengths : (n, N) floats
        Compressions of the springs before the collision; below zero: minus the distances [m]. Only
        law bistiffness knows how a compressed spring goes on. Without `distances` they are unused.
    until : float
        Time after which a collision ends, whatever is still active [s].
    balls : Balls
        That move: `ws.motion` says where they are when the only collision begins, and afterwards
        where they are then. Or NO_BALLS: bodies stay in place.
    tolerance : (n,) floats
        Error of the velocities relative to the largest approach speed. A collision with a
        tolerance that is not above 0 is left out.
    contacts, ws, progress : N ContactState, Workspace, 1 Progress
        Scratch.
    results : n N ContactResult, written
    log : records of PhaseLog, written
        The phases of the last collision, N records each. Phases beyond the room are counted only.
    outcomes : n CollisionOutcome, written

    """
    p, count = progress[0], len(contacts)
    for i in range(len(tolerance)):
        if not tolerance[i] > 0.0:
            continue
        m, units = begin(
            properties[i],
            law,
            exponent,
            distances,
            options,
            delassus[i],
            velocity[i],
            lengths[i],
            until,
            balls,
            tolerance[i],
            contacts,
            ws,
            p,
        )
        if units.speed > 0.0:
            while not integrate(m, contacts, ws, p, log):
                if ends_in_geometric_tail(m, contacts, ws, p):
                    end(m, contacts, p, log, INFINITE_SEQUENCE)
                    break
            finish(m, velocity[i], units, contacts, ws, p, results, i * count, log)
        else:
            for j in range(count):
                clear_result(results[i * count + j], lengths[i][j] if distances else 0.0)
        outcome = outcomes[i]
        outcome.status, outcome.phases, outcome.steps = p.status, p.phases, p.steps
        outcome.duration = units.time * p.time


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """
    Solved collisions.

    Attributes
    ----------
    impulses : (n, N, 3) float array
        On bodies a [N s].
    losses : (n, N, 2) float array
        Energy lost to restitution and to friction [J].
    final_slips, discontinuity_margins : (n, N) float arrays
        See `ContactResult`.
    lengths : (n, N) float array
        See `ContactResult`.
    closings : (n, N) int array
        See `ContactResult`.
    status, phases, steps : (n,) int arrays
    durations : (n,) float array
        See `CollisionOutcome`.
    log : (phases, N) array of PhaseLog
        Phases of the last collision.

    """

    impulses: NDArray[np.float64]
    losses: NDArray[np.float64]
    final_slips: NDArray[np.float64]
    discontinuity_margins: NDArray[np.float64]
    lengths: NDArray[np.float64]
    closings: NDArray[np.int64]
    status: NDArray[np.int64]
    phases: NDArray[np.int64]
    steps: NDArray[np.int64]
    durations: NDArray[np.float64]
    log: NDArray[np.void]


def solve_in_contact_space(
    properties: Properties,
    delassus: NDArray[np.float64],
    velocity: NDArray[np.float64],
    tolerance: ArrayLike,
    phases: int = 0,
    lengths: NDArray[np.float64] | None = None,
    until: float = inf,
) -> Solved:
    """
    Solve n collisions of the same N contacts.

    Parameters
    ----------
    properties : Properties
    delassus, velocity, tolerance
        (n, 3 N, 3 N), (n, 3 N) and (n,) arrays, see `solve_collisions`.
    phases : int
        Of the last collision that are logged. If it has more, all of them are.
    lengths : (n, N) float array, optional
        See `solve_collisions`; without them there are no distances at all.
    until : float
        See `solve_collisions`.

    """
    n, count = len(velocity), np.shape(properties.friction)[-1]
    storage = solve_collisions.current().storage
    results, outcomes, logged = solve_stored(
        storage,
        properties,
        storage.array(delassus),
        storage.array(velocity),
        storage.array(tolerance),
        phases,
        lengths,
        until,
    )
    rows = as_rows(ContactResult, results)
    table = rows.view(np.float64).reshape(n, count, 9)
    ends = as_rows(CollisionOutcome, outcomes)
    return Solved(
        table[..., :3],
        table[..., 3:5],
        table[..., 5],
        table[..., 6],
        table[..., 7],
        rows['closings'].reshape(n, count),
        ends['status'],
        ends['phases'],
        ends['steps'],
        ends['duration'],
        logged,
    )


def new_scratch(storage: Storage, count: int) -> Scratch:
    """Make what the solver writes to while it solves a collision of N contacts."""
    return (
        storage.records(ContactState, count),
        workspace(storage, count, TABLEAUS[storage]),
        storage.records(Progress, 1),
    )


class _Thread(threading.local):
    """The scratch of this thread: to make it anew would take a tenth of the time of a strike."""

    def __init__(self) -> None:
        self.kept: dict[tuple[Storage, int], Scratch] = {}

    def scratch(self, storage: Storage, count: int) -> Scratch:
        """Return scratch for N contacts; its contents are those of the last collision."""
        if (storage, count) not in self.kept:
            self.kept[storage, count] = new_scratch(storage, count)
        return self.kept[storage, count]


_thread = _Thread()
scratch = _thread.scratch


def solve_stored(
    storage: Storage,
    properties: Properties,
    delassus: Floats,
    velocity: Floats,
    tolerance: Vector,
    phases: int,
    lengths: NDArray[np.float64] | None = None,
    until: float = inf,
) -> tuple[list[ContactResult], list[CollisionOutcome], NDArray[np.void]]:
    """
    Solve collisions whose numbers are in a storage; see `solve_in_contact_space`.

    Returns the results (n N), the outcomes (n) and the log (phases, N) of the last collision.
    """
    run = solve_collisions.on(storage)
    n, count = len(velocity), np.shape(properties.friction)[-1]
    columns = properties.friction, properties.restitution, properties.stiffness
    given = np.empty((n, count, 3))
    for k, column in enumerate(columns):
        given[..., k] = column
    begun = storage.zeros(n, count) if lengths is None else storage.array(lengths)
    results = storage.records(ContactResult, n * count)
    outcomes = storage.records(CollisionOutcome, n)
    while True:
        log = storage.records(PhaseLog, phases * count)
        run(
            storage.array(given),
            properties.law,
            float(properties.exponent),
            lengths is not None,
            properties.options,
            delassus,
            velocity,
            begun,
            until,
            NO_BALLS,
            tolerance,
            *scratch(storage, count),
            results,
            log,
            outcomes,
        )
        needed = int(outcomes[-1].phases) if phases and n else 0
        if needed <= phases:
            break
        phases = needed
    return results, outcomes, as_rows(PhaseLog, log)[: needed * count].reshape(-1, count)
