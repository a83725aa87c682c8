"""Collisions in contact space, from approach to parting: the compiled entry, and its interface."""

from collections.abc import Sequence
from dataclasses import dataclass
import threading
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry
from billiard_shot.impact.beginning import (
    begin_collision,
    Collisions,
    ContactProperties,
    UNLIMITED,
)
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.ending import (
    clear_result,
    CollisionOutcome,
    ContactResult,
    ends_in_geometric_tail,
    finish,
    Results,
)
from billiard_shot.impact.integrator import end, integrate
from billiard_shot.impact.moving_bodies import end_swings, store_body
from billiard_shot.impact.state import (
    BodyState,
    ContactState,
    ImpactProgress,
    PhaseLog,
    Workspace,
    workspace,
)
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.status import INFINITE_SEQUENCE


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
    properties[0].max_closings = UNLIMITED
    one = Collisions(
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
def solve_collisions(given: Collisions, scratch: Scratch, results: Results) -> None:
    """Solve n collisions of the same N contacts, one after the other; write the results."""
    contacts, ws, p = scratch.contacts, scratch.workspace, scratch.progress[0]
    count, log = len(contacts), results.log
    for i in range(len(given.tolerance)):
        if not given.tolerance[i] > 0.0:
            continue
        m, units = begin_collision(given, i, contacts, ws, p)
        if units.speed > 0.0:
            while not integrate(m, contacts, ws, p, log):
                if ends_in_geometric_tail(m, contacts, ws, p):
                    end(m, contacts, ws, p, log, INFINITE_SEQUENCE)
                    break
            if m.moves:
                end_swings(contacts, ws)
            finish(m, units, contacts, ws, p, results, number=i)
        else:
            for j in range(count):
                length = given.lengths[i][j] if given.distances and m.bodies == 0 else 0.0
                clear_result(results.contacts[i * count + j], length)
            for b in range(m.bodies):
                store_body(results.bodies[i * m.bodies + b], ws, b)
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
    # The coefficient at slip v is friction - fading (1 - exp(-decay v)); decay in s/m.
    fading: Sequence[float] | NDArray[np.float64] | float = 0.0
    decay: Sequence[float] | NDArray[np.float64] | float = 0.0


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
    final_slips, lengths : (n, N) float arrays
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
    lengths: NDArray[np.float64]
    closings: NDArray[np.int64]
    status: NDArray[np.int64]
    phases: NDArray[np.int64]
    steps: NDArray[np.int64]
    durations: NDArray[np.float64]
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
    for name in ('friction', 'fading', 'decay', 'restitution', 'stiffness', 'exponent'):
        table[name] = getattr(properties, name)
    table['max_closings'] = UNLIMITED
    collisions = Collisions(
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
    rows = as_rows(ContactResult, results).reshape(n, count)
    ends = as_rows(CollisionOutcome, outcomes)
    return Solved(
        rows['impulse'],
        np.stack([rows['restitution_loss'], rows['friction_loss']], axis=-1),
        rows['final_slip'],
        rows['length'],
        rows['closings'],
        status=ends['status'],
        phases=ends['phases'],
        steps=ends['steps'],
        durations=ends['duration'],
        log=as_rows(PhaseLog, log)[: needed * count].reshape(needed, count),
    )
