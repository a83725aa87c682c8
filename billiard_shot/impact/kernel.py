"""
Collisions in contact space, from approach to parting: the compiled entry of the solver.

After Jia, Mason and Erdmann (WAFR 2008), stated in time instead of impulse, where it is smooth:
    y' = -rate n.u     N = stiffness y^exponent     J' = F     u = u(0) + W J
for contact velocities u, impulses J and virtual springs y (integrator.py). solve.py calls it.
"""

from math import inf
from typing import Any

import numpy as np

from billiard_shot.compiled import entry
from billiard_shot.impact.beginning import begin
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.geometric_tail import ends_in_geometric_tail
from billiard_shot.impact.integrator import end, integrate
from billiard_shot.impact.options import DEFAULT_OPTIONS, Options
from billiard_shot.impact.outcome import clear_result, CollisionOutcome, ContactResult, finish
from billiard_shot.impact.state import (
    Balls,
    ContactState,
    NO_BALLS,
    PhaseLog,
    Progress,
    Workspace,
    workspace,
)
from billiard_shot.records import Floats, Storage, Vector
from billiard_shot.status import INFINITE_SEQUENCE

Scratch = tuple[list[ContactState], Workspace, list[Progress]]


def new_scratch(storage: Storage, count: int) -> Scratch:
    """Make what the solver writes to while it solves a collision of N contacts."""
    return (
        storage.records(ContactState, count),
        workspace(storage, count, TABLEAUS[storage]),
        storage.records(Progress, 1),
    )


def _example(storage: Storage) -> tuple[Any, ...]:
    """One contact that approaches."""
    return (
        storage.array(np.full((1, 1, 5), 0.5)),
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
    properties : (n, N, 5) floats
        Friction, restitution and stiffness of the contacts, fading and decay of the friction: see
        `Properties`.
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
