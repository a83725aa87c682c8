"""
Three bodies or more in touch when one of them is hit: all at once, by billiard_shot.impact.

Who takes part: the balls that are connected to those that meet by gaps within the tolerance, the
cushions that these touch, and the cloth below balls that touch a cushion, which presses them down.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, collide, Contact
from billiard_shot.impact.laws import LAWS
from billiard_shot.status import Status
from billiard_shot.table.flight_boundary import edge_at, projects_onto_edge
from billiard_shot.table.geometry import Table
from billiard_shot.table.motion import advance, Ball, CLUSTER, FLIGHT, NOTHING
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.rolling_boundary import ARCS, FACINGS
from billiard_shot.table.simulation_state import energy_of, log_event, position_at, Simulation

TOLERANCE = 1e-7  # of the impact, relative to the approach
LAW_NAMES = {number: name for name, number in LAWS.items()}
UP = (0.0, 0.0, 1.0)


def touching_group(
    places: dict[int, NDArray[np.float64]], seeds: set[int], reach: float
) -> list[int]:
    """Balls that are within reach of one of the seeds, or of each other, from there on."""
    found, fresh = set(seeds), list(seeds)
    while fresh:
        here = places[fresh.pop()]
        near = {i for i in places if i not in found and np.linalg.norm(places[i] - here) <= reach}
        found |= near
        fresh += sorted(near)
    return sorted(found)


def ball_contacts(table: Table, balls: list[Ball]) -> list[Contact]:
    """Contacts between balls, those that come first against those that come later."""
    n, contacts = table.numbers, []
    places = [np.array(ball.position) for ball in balls]
    for i, a in enumerate(balls):
        for j in range(i + 1, len(balls)):
            apart = places[i] - places[j]
            distance = np.linalg.norm(apart)
            if distance > 2.0 * table.params.radius + n.contact_gap:
                continue
            normal = apart / distance
            point = places[j] + 0.5 * apart
            slip = _surface_velocity(a, point) - _surface_velocity(balls[j], point)
            slip -= normal * (normal @ slip)
            friction = n.friction_fast + n.friction_slow * np.exp(
                -n.friction_decay * np.linalg.norm(slip)
            )
            contacts.append(
                Contact(i, j, point, normal, n.ball_restitution, float(friction), n.ball_stiffness)
            )
    return contacts


def cushion_contacts(table: Table, balls: list[Ball]) -> list[Contact]:
    """Contacts of balls with the cushions they touch, and then with the cloth."""
    n, params, radius = table.numbers, table.params, table.params.radius
    contacts, fixed, jaws = [], len(balls), len(table.jaws)
    features = (*range(4), *range(FACINGS, FACINGS + jaws), *range(ARCS, ARCS + jaws))
    for i, ball in enumerate(balls):
        x, y, z = ball.position
        if z != radius:
            continue
        held = False
        for feature in features:
            nx, ny, away = edge_at(table, feature, x, y)
            touches = abs(away - n.nose_standoff) <= n.contact_gap
            if touches and projects_onto_edge(table, feature, x, y):
                normal = (
                    np.array([nx * n.nose_standoff, ny * n.nose_standoff, radius - n.nose_height])
                    / radius
                )
                contacts.append(
                    Contact(
                        i,
                        fixed,
                        np.array(ball.position) - radius * normal,
                        normal,
                        n.cushion_restitution,
                        n.cushion_friction,
                        n.cushion_stiffness,
                    )
                )
                held = True
        if held:
            contacts.append(
                Contact(
                    i,
                    fixed,
                    (x, y, 0.0),
                    UP,
                    params.cloth_restitution,
                    params.cloth_friction,
                    params.cloth_stiffness,
                )
            )
    return contacts


def contacts_among(table: Table, balls: list[Ball]) -> list[Contact]:
    """Contacts of balls with each other, and with what is fixed: the body after the balls."""
    n, contacts = table.numbers, ball_contacts(table, balls)
    outside = max(
        max(abs(ball.position[0]) - n.nose_half_length, abs(ball.position[1]) - n.nose_half_width)
        for ball in balls
    )
    if outside + table.params.radius >= 0.0:  # to look at all edges takes a while
        contacts += cushion_contacts(table, balls)
    return contacts


def body_of(params: BallClothParams, ball: Ball) -> Body:
    """Ball as a rigid body."""
    return Body(params.mass, params.inertia, ball.velocity, ball.spin, ball.position)


def resolve(table: Table, s: Simulation, participants: list[tuple[int, int]]) -> None:
    """
    Let all bodies collide whose impact is pending; then the simulation can go on.

    If their collision is not solved, the simulation ends there, with its status.

    Parameters
    ----------
    table : Table
        Laid out in objects.
    s : Simulation, changed
        In objects or in rows.
    participants : list of (int, int), appended to
        Number of the event, and a ball that takes part.

    """
    params, progress = table.params, s.progress
    time, number = float(progress.time), int(progress.events)
    every = _as_objects(s.balls)
    places = {
        i: np.array(position_at(ball, time))
        for i, ball in enumerate(every)
        if ball.motion <= FLIGHT
    }
    reach = 2.0 * params.radius + table.numbers.contact_gap
    members = touching_group(places, {int(progress.ball), int(progress.other)}, reach)
    balls = [every[i] for i in members]
    for ball in balls:
        advance(ball, time)
    before = sum(energy_of(params, ball) for ball in balls)
    contacts = contacts_among(table, balls)
    result = collide(
        [*(body_of(params, ball) for ball in balls), Body.fixed()],
        contacts,
        law=LAW_NAMES[params.law],
        exponent=params.exponent,
        tolerance=TOLERANCE,
    )
    if result.status in (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED):
        progress.unsolved = int(result.status)
    velocities, spins = result.velocities.tolist(), result.spins.tolist()
    for k, (i, ball) in enumerate(zip(members, balls, strict=True)):
        for axis in range(3):
            ball.velocity[axis], ball.spin[axis] = velocities[k][axis], spins[k][axis]
        ball.modified = True
        met = [c.a + c.b - k for c in contacts if k in (c.a, c.b) and len(balls) not in (c.a, c.b)]
        if ball.first_contact == NOTHING and met:
            ball.first_contact = members[min(met)]
        participants.append((number, i))
    after = sum(energy_of(params, ball) for ball in balls)
    _write_back(s.balls, every)
    ball = every[int(progress.ball)]
    log_event(s, time, CLUSTER, ball, int(progress.other), before, after, ball.motion)


_CHANGED = ('time', 'position', 'velocity', 'spin', 'first_contact', 'modified')
_READ = (*_CHANGED, 'acceleration', 'spin_acceleration', 'motion', 'ball')


def _as_objects(balls: Any) -> list[Ball]:
    """Balls as objects, whose attributes Python reads much faster than fields of rows."""
    if isinstance(balls, list):
        return balls
    objects = [Ball() for _ in range(len(balls))]
    for name in _READ:
        for ball, value in zip(objects, balls[name].tolist(), strict=True):
            setattr(ball, name, value)
    return objects


def _write_back(balls: Any, objects: list[Ball]) -> None:
    """Write what an impact changes of balls into the rows that they were read from."""
    if balls is not objects:
        for name in _CHANGED:
            balls[name] = [getattr(ball, name) for ball in objects]


def _surface_velocity(ball: Ball, point: NDArray[np.float64]) -> NDArray[np.float64]:
    turning: NDArray[np.float64] = np.cross(ball.spin, point - np.array(ball.position))
    return np.array(ball.velocity) + turning
