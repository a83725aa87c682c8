"""
The trace of a collision: velocities, forces, impulses and energies over its time.

The solver goes from event to event in steps that are polynomials in time, and does not store them.
Here the same solver runs as interpreted Python, some hundred times slower, and every step is
sampled before it is taken. No equation is integrated a second time, and the solver is unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import Entry
from billiard_shot.impact import integrator, kernel, solve
from billiard_shot.impact.advance import advance
from billiard_shot.impact.collide import properties_of
from billiard_shot.impact.contact_space import contact_space, system_of
from billiard_shot.impact.laws import elastic_energy, LAWS
from billiard_shot.impact.state import ContactState, is_active, Model, Workspace
from billiard_shot.records import Array, OBJECTS
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.shot import Shot
from billiard_shot.study.collisions import Collision, collision_of

SAMPLES_PER_STEP = 24  # of a step, beside its ends


@dataclass(frozen=True, slots=True, eq=False)
class CollisionTrace:
    """
    A collision of N contacts at n times, in order; the time of an event occurs twice.

    Contact j has components 3 j (normal), 3 j + 1 and 3 j + 2 (tangential).

    Attributes
    ----------
    time : (n,) float array
        Scaled: the unit is 1 / sqrt(W k), with the largest normal response W [1/kg] and the
        largest stiffness k. The compression of a single contact lasts pi / 2 (exponent 1).
    active : (n, N) bool array
    velocities : (n, 3 N) float array
        Contact velocities [m/s].
    forces : (n, 3 N) float array
        On bodies a [N s per unit of time].
    impulses : (n, 3 N) float array
        On bodies a, since the start [N s].
    energies : (n, N) float array
        Elastic energies of the contacts [J]; energy that a law leaves when a contact ends is lost.

    """

    time: Array
    active: NDArray[np.bool_]
    velocities: Array
    forces: Array
    impulses: Array
    energies: Array

    def phases(self) -> list[slice]:
        """Stretches of samples between which the set of active contacts changes."""
        changes = np.flatnonzero((self.active[1:] != self.active[:-1]).any(axis=1)) + 1
        ends = [0, *changes.tolist(), len(self.time)]
        return [slice(a, b) for a, b in pairwise(ends)]

    def slip(self, contact: int) -> Array:
        """Slip speed at a contact (n,) [m/s]."""
        return np.hypot(self.velocities[:, 3 * contact + 1], self.velocities[:, 3 * contact + 2])

    def friction(self, contact: int) -> Array:
        """Friction force at a contact (n,), as `forces`."""
        return np.hypot(self.forces[:, 3 * contact + 1], self.forces[:, 3 * contact + 2])


@dataclass(slots=True)
class _Recorder:
    """Takes the solver's steps in place of `advance`, and samples them."""

    now: float = 0.0
    rows: list[Array] = field(default_factory=list)

    def __call__(
        self,
        m: Model,
        contacts: list[ContactState],
        ws: Workspace,
        scale: float,
        order: int,
        x: float,
    ) -> None:
        part = np.linspace(0.0, x, SAMPLES_PER_STEP + 2)
        powers = part[:, np.newaxis] ** np.arange(order + 1)
        integrals = scale * part[:, np.newaxis] * powers[:, :order] / np.arange(1, order + 1)
        velocities, forces, impulses, energies, active = [], [], [], [], []
        for c in contacts:
            pushes = 1.0 if is_active(c) else 0.0
            active.append(np.full(len(part), pushes))
            velocities += [powers @ u[: order + 1] for u in (c.velocity, c.slip_1, c.slip_2)]
            axes = (c.force, c.impulse), (c.friction_1, c.impulse_1), (c.friction_2, c.impulse_2)
            for force, impulse in axes:
                coefficients = pushes * np.array(force[:order])
                forces.append(powers[:, :order] @ coefficients)
                impulses.append(impulse + integrals @ coefficients)
            energies.append(
                [
                    elastic_energy(c.stiffness, pushes * max(y, 0.0), c.exponent)
                    for y in powers @ c.compression[: order + 1]
                ]
            )
        self.rows.append(
            np.column_stack(
                [
                    self.now + scale * part,
                    *active,
                    *velocities,
                    *forces,
                    *impulses,
                    *energies,
                ]
            )
        )
        self.now += scale * x
        advance(m, contacts, ws, scale, order, x)


def _with_names(function: Callable[..., Any], **names: Any) -> Callable[..., Any]:
    """Copy a function, with other values for some of the global names that it uses."""
    meanings = {**function.__globals__, **names}
    return FunctionType(function.__code__, meanings, argdefs=function.__defaults__)


def _watched_solver(recorder: _Recorder) -> Callable[..., Any]:
    """Return `solve.solve_stored`, interpreted, with a recorder in place of `advance`."""
    take_step = _with_names(integrator.take_step, advance=recorder)
    integrate = _with_names(integrator.integrate, take_step=take_step)
    entry = kernel.solve_collisions
    solve_collisions = Entry(_with_names(entry.function, integrate=integrate), entry.example)
    return _with_names(solve.solve_stored, solve_collisions=solve_collisions)


def trace_of_collision(collision: Collision, law: str, tolerance: float = 1e-8) -> CollisionTrace:
    """Trace a collision of bodies."""
    contacts, recorder = collision.contacts, _Recorder()
    space, count = contact_space(system_of(collision.bodies, contacts)), len(contacts)
    _watched_solver(recorder)(
        OBJECTS,
        properties_of(contacts, LAWS[law], collision.exponent),
        OBJECTS.array(space.delassus[np.newaxis]),
        OBJECTS.array(space.approach[np.newaxis]),
        [tolerance],
        0,
    )
    rows = np.concatenate([np.zeros((0, 1 + 11 * count)), *recorder.rows])
    speed = max(float(-space.approach[::3].min()), 0.0)
    unit = speed / float(space.delassus.diagonal()[::3].max())  # N s
    time, active, u, force, impulse, energy = np.split(
        rows, np.cumsum([1, count, 3 * count, 3 * count, 3 * count]), axis=1
    )
    return CollisionTrace(
        time[:, 0], active > 0.0, speed * u, unit * force, unit * impulse, unit * speed * energy
    )


def trace_of_strike(shot: Shot) -> CollisionTrace:
    """
    Trace the strike of a shot, without the shaft of its cue.

    Raises
    ------
    ValueError
        If it was refused, or the ball touched others.

    """
    if shot.status.refused or len(shot.impact.dissipated) != 2:
        raise ValueError(
            'shot must be a stroke that can be played, of a ball that touches nothing but the '
            f'cloth, got {shot.status.name}: {shot.message}'
        )
    model = model_of(shot.scene)
    stroke = shot.stroke.touching(model.tip_curvature)
    normal, velocity = np.array(stroke.normal), np.array(stroke.velocity)
    return trace_of_collision(collision_of(model, normal, velocity), shot.scene.law)
