"""
Collisions in contact space, from approach to parting: the compiled entry of the solver.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = stiffness y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y (integrator.py). solve.py calls it.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.compiled import entry
from billiard_shot.impact.beginning import (
    begin_collision,
    Collisions,
    ContactProperties,
    UNLIMITED,
)
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.geometric_tail import ends_in_geometric_tail
from billiard_shot.impact.integrator import end, integrate
from billiard_shot.impact.moving_bodies import end_swings, store_body
from billiard_shot.impact.outcome import (
    clear_result,
    CollisionOutcome,
    ContactResult,
    finish,
    Results,
)
from billiard_shot.impact.state import (
    BodyState,
    ContactState,
    ImpactProgress,
    PhaseLog,
    Workspace,
    workspace,
)
from billiard_shot.records import Storage
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
        moves=False,
        interval=inf,
        swing=0.0,
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
