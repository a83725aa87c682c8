"""Many collisions of the same contacts, given as arrays: the Python interface of the solver."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
import threading

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.impact.beginning import Collisions, ContactProperties, UNLIMITED
from billiard_shot.impact.kernel import new_scratch, Scratch, solve_collisions
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult, Results
from billiard_shot.impact.state import BodyState, PhaseLog
from billiard_shot.records import as_rows, Floats, ROWS, Storage, Vector


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


def solve_in_contact_space(
    properties: Properties,
    delassus: NDArray[np.float64],
    velocity: NDArray[np.float64],
    tolerance: ArrayLike,
    phases: int = 0,
    lengths: NDArray[np.float64] | None = None,
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
        lengths=lengths,
    )
    rows = as_rows(ContactResult, results).reshape(n, count)
    ends = as_rows(CollisionOutcome, outcomes)
    return Solved(
        np.stack([rows['impulse'], rows['impulse_1'], rows['impulse_2']], axis=-1),
        np.stack([rows['restitution_loss'], rows['friction_loss']], axis=-1),
        rows['final_slip'],
        rows['length'],
        rows['closings'],
        status=ends['status'],
        phases=ends['phases'],
        steps=ends['steps'],
        durations=ends['duration'],
        log=logged,
    )


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


def solve_stored(
    storage: Storage,
    properties: Properties,
    delassus: Floats,
    velocity: Floats,
    tolerance: Vector,
    phases: int,
    lengths: NDArray[np.float64] | None = None,
) -> tuple[list[ContactResult], list[CollisionOutcome], NDArray[np.void]]:
    """
    Solve collisions whose arrays are in a storage; see `solve_in_contact_space`.

    Returns the results (n N), the outcomes (n) and the log (phases, N) of the last collision.
    """
    n, count = len(velocity), np.shape(properties.friction)[-1]
    given = ROWS.records(ContactProperties, n * count)
    table = given.reshape(n, count)
    for name in ('friction', 'fading', 'decay', 'restitution', 'stiffness', 'exponent'):
        table[name] = getattr(properties, name)
    table['max_closings'] = UNLIMITED
    collisions = Collisions(
        properties=storage.from_rows(ContactProperties, given),
        law=properties.law,
        bodies=storage.records(BodyState, 0),
        moves=False,
        interval=inf,
        swing=0.0,
        delassus=delassus,
        velocity=velocity,
        distances=lengths is not None,
        lengths=storage.zeros(n, count) if lengths is None else storage.array(lengths),
        tolerance=tolerance,
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
    return results, outcomes, as_rows(PhaseLog, log)[: needed * count].reshape(needed, count)
