"""
Impacts of three bodies or more, all at once, by billiard_shot.impact.

The balls take part that are connected to those that meet by gaps within reach of the impact
(contact_duration.py). A cushion does not: its contact is so long that balls meet within it one
after the other. A strike is longer, and includes the cushion and the cloth below.
"""

from math import inf, nextafter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, CollisionResult, Contact
from billiard_shot.impact.collide import collide_system
from billiard_shot.impact.contact_space import System
from billiard_shot.impact.kernel import Properties
from billiard_shot.impact.laws import LAWS
from billiard_shot.numerics.vectors import cross_rows
from billiard_shot.status import Status
from billiard_shot.table.contact_duration import stiffness_of
from billiard_shot.table.cushion import advance_free
from billiard_shot.table.flight_boundary import edge_at, projects_onto_edge
from billiard_shot.table.geometry import Table, TableNumbers
from billiard_shot.table.motion import Ball, CLUSTER, FLIGHT, NOTHING, SLIDE
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.rolling_boundary import ARCS, FACINGS
from billiard_shot.table.simulation_state import (
    energy_of,
    log_event,
    log_segment,
    position_at,
    Simulation,
)

TOLERANCE = 1e-7  # of the impact, relative to the approach
MAX_SWEEPS = 100
CLEARANCE = 1e-7  # m, to which balls are set apart
LONGEST = 2e-3  # s
OVERLAP = 1e-10  # m, that is only rounding
LAW_NAMES = {number: name for name, number in LAWS.items()}
UP = (0.0, 0.0, 1.0)


def touching_group(
    places: dict[int, NDArray[np.float64]], seeds: set[int], reach: float
) -> list[int]:
    """Balls that are within reach of one of the seeds, or of each other, from there on."""
    names, centres = list(places), np.array(list(places.values()))
    near = np.linalg.norm(centres[:, np.newaxis] - centres, axis=2) <= reach
    found = np.array([name in seeds for name in names])
    while not np.array_equal(found, grown := near[found].any(axis=0)):
        found = grown
    return sorted(name for name, taken in zip(names, found.tolist(), strict=True) if taken)


class States(NamedTuple):
    """States of B balls as arrays."""

    positions: NDArray[np.float64]  # (B, 3) m
    velocities: NDArray[np.float64]  # (B, 3) m/s
    spins: NDArray[np.float64]  # (B, 3) rad/s


def states_of(balls: list[Ball]) -> States:
    """Collect the states of balls."""
    return States(
        np.array([ball.position for ball in balls]),
        np.array([ball.velocity for ball in balls]),
        np.array([ball.spin for ball in balls]),
    )


class BallPairs(NamedTuple):
    """Pairs of balls that are in touch or nearly so, the first of a pair before the second."""

    numbers: NDArray[np.int64]  # (N, 2)
    distances: NDArray[np.float64]  # (N,) m, of the centres
    normals: NDArray[np.float64]  # (N, 3) from the second into the first
    points: NDArray[np.float64]  # (N, 3) m, between the centres
    frictions: NDArray[np.float64]  # (N,) at the slip before the impact


def ball_pairs(n: TableNumbers, states: States, farthest: float) -> BallPairs:
    """Find the pairs of balls whose centres are at most `farthest` [m] apart."""
    places, velocities, spins = states
    first, second = np.triu_indices(len(places), 1)
    distances = np.linalg.norm(places[first] - places[second], axis=1)
    near = distances <= farthest
    first, second, distances = first[near], second[near], distances[near]
    normals = (places[first] - places[second]) / distances[:, np.newaxis]
    points = 0.5 * (places[first] + places[second])
    slips = velocities[first] + cross_rows(spins[first], points - places[first])
    slips -= velocities[second] + cross_rows(spins[second], points - places[second])
    slips -= normals * (normals * slips).sum(axis=1, keepdims=True)
    frictions = n.friction_fast + n.friction_slow * np.exp(
        -n.friction_decay * np.linalg.norm(slips, axis=1)
    )
    return BallPairs(np.stack([first, second], axis=1), distances, normals, points, frictions)


def ball_contacts(table: Table, balls: list[Ball]) -> list[Contact]:
    """Contacts between balls that touch; the first ball of each comes first in the list."""
    n, params = table.numbers, table.params
    pairs = ball_pairs(n, states_of(balls), 2.0 * params.radius + n.contact_gap)
    return [
        Contact(i, j, point, normal, n.ball_restitution, friction, n.ball_stiffness)
        for (i, j), point, normal, friction in zip(
            pairs.numbers.tolist(),
            pairs.points,
            pairs.normals,
            pairs.frictions.tolist(),
            strict=True,
        )
    ]


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


def system_of_balls(params: BallClothParams, states: States, pairs: BallPairs) -> System:
    """Balls and their contacts as `collide_system` takes them: no objects, which take longer."""
    count = len(states.positions)
    mobility = np.zeros((count, 6, 6))
    mobility[:, range(3), range(3)] = 1.0 / params.mass
    mobility[:, range(3, 6), range(3, 6)] = 1.0 / params.inertia
    return System(
        *states,
        mobility,
        np.ones(count, bool),
        np.zeros((0, 3)),
        pairs.numbers,
        pairs.points,
        pairs.normals,
    )


def collide_balls(
    table: Table, balls: list[Ball], reach: float
) -> tuple[BallPairs, CollisionResult]:
    """Let balls collide that are in touch or within reach [m] of each other."""
    n, params, diameter = table.numbers, table.params, 2.0 * table.params.radius
    states = states_of(balls)
    pairs = ball_pairs(n, states, diameter + reach)
    stiffness, gaps = n.ball_stiffness, None
    if n.ball_duration > 0.0:
        stiffness = stiffness_of(params.mass, n.ball_duration, params.exponent)
        gaps = pairs.distances - diameter
        gaps[gaps <= n.contact_gap] = 0.0
    count = len(pairs.distances)
    properties = Properties(
        pairs.frictions,
        np.full(count, n.ball_restitution),
        np.full(count, stiffness),
        int(params.law),
        params.exponent,
    )
    system = system_of_balls(params, states, pairs)
    return pairs, collide_system(
        system, properties, TOLERANCE, gaps, phases=False, radius=params.radius
    )


def end_of_impact(
    table: Table, s: Simulation, balls: list[Ball], members: list[int], result: CollisionResult
) -> NDArray[np.float64] | None:
    """
    Places (B, 3) of balls at the end of their impact, or None: the impact is to take no time.

    That is so if it takes longer than LONGEST, if anything else happens meanwhile, or if a ball
    gets to a cushion or to a ball that does not take part.

    Parameters
    ----------
    table : Table
    s : Simulation
    balls : list of Ball
        All of the table.
    members : list of int
        Balls that take part.
    result : CollisionResult

    """
    n, p, diameter = table.numbers, s.progress, 2.0 * table.params.radius
    end = float(p.time) + result.duration
    others = [i for i, ball in enumerate(balls) if i not in members and ball.motion <= FLIGHT]
    times = [min(balls[i].end, balls[i].boundary_time) for i in others]
    meetings = np.asarray(s.collisions)[np.ix_(others, others)]
    if (
        result.duration > LONGEST
        or min(float(p.cue_time), *times, meetings.min(initial=inf)) <= end
    ):
        return None
    places = np.array(result.positions)
    lying = np.array([balls[i].position[2] for i in members]) == table.params.radius
    places[lying, 2] = table.params.radius
    if n.nose_standoff > 0.0:
        beyond = np.abs(places[:, :2]) > (n.centre_half_length, n.centre_half_width)
        if beyond.any():
            return None
    if not set_apart(places, diameter):
        return None
    around = np.array([position_at(balls[i], end) for i in others]).reshape(-1, 1, 3)
    near = np.linalg.norm(places - around, axis=2) < diameter
    return None if near.any() else places


def go_on_to(
    s: Simulation, ball: Ball, hit: bool, waits: bool, place: list[float], end: float
) -> None:
    """Let a ball go on with its velocity after an impact, or wait; then set it to its place."""
    motion, velocity = ball.motion, list(ball.velocity)
    if hit:
        for k in range(3):
            ball.acceleration[k] = ball.spin_acceleration[k] = 0.0
        if motion != FLIGHT:
            ball.motion, ball.velocity[2] = SLIDE, 0.0
        ball.cause = CLUSTER
        log_segment(s, ball)
        if waits:
            ball.time = nextafter(ball.time, inf)
            for k in range(3):
                ball.velocity[k] = 0.0
            log_segment(s, ball)
    ball.motion, ball.time = motion, end
    for k in range(3):
        ball.position[k], ball.velocity[k] = place[k], velocity[k]


def wait(table: Table, balls: list[Ball], result: CollisionResult) -> NDArray[np.bool_]:
    """Which balls (B,) would overlap others if they left an impact when it begins."""
    first, second = np.triu_indices(len(balls), 1)
    places = states_of(balls).positions
    apart = places[first] - places[second]
    closest = np.minimum(np.linalg.norm(apart, axis=1), 2.0 * table.params.radius) - OVERLAP
    waiting = np.zeros(len(balls), bool)
    while True:
        velocities = np.where(waiting[:, np.newaxis], 0.0, result.velocities)
        leaving = velocities[first] - velocities[second]
        squares = (leaving * leaving).sum(axis=1)
        times = -(apart * leaving).sum(axis=1) / np.where(squares > 0.0, squares, 1.0)
        times = np.clip(times, 0.0, result.duration)[:, np.newaxis]
        overlap = np.linalg.norm(apart + times * leaving, axis=1) < closest
        if not overlap.any():
            return waiting
        waiting[first[overlap]] = waiting[second[overlap]] = True


def set_apart(places: NDArray[np.float64], diameter: float) -> bool:
    """
    Move balls apart that are still dented, each by half of what they overlap.

    Return whether none overlap in the end.
    """
    first, second = np.triu_indices(len(places), 1)
    for _ in range(MAX_SWEEPS):
        apart = places[first] - places[second]
        distances = np.sqrt((apart * apart).sum(axis=1))
        inside = np.flatnonzero(distances < diameter)
        if len(inside) == 0:
            return True
        size = distances[inside, np.newaxis]
        way = 0.5 * (diameter + CLEARANCE - size) / size * apart[inside]
        np.add.at(places, first[inside], way)
        np.add.at(places, second[inside], -way)
    return False


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
    n, params, progress = table.numbers, table.params, s.progress
    time, number = float(progress.time), int(progress.events)
    every = _as_objects(s.balls)
    centres = {
        i: np.array(position_at(ball, time))
        for i, ball in enumerate(every)
        if ball.motion <= FLIGHT
    }
    reach = float(progress.reach)
    seeds = {int(progress.ball), int(progress.other)}
    members = touching_group(centres, seeds, 2.0 * params.radius + reach)
    balls = [every[i] for i in members]
    for ball in balls:
        advance_free(table, ball, time)
    before = sum(energy_of(params, ball) for ball in balls)
    pairs, result = collide_balls(table, balls, reach)
    if result.status in (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED):
        progress.unsolved = int(result.status)
    velocities, spins = result.velocities.tolist(), result.spins.tolist()
    hits = [
        set(pair)
        for pair, impulse in zip(pairs.numbers.tolist(), result.impulses, strict=True)
        if impulse.any()
    ]
    places = None
    if n.ball_duration > 0.0 and result.duration > 0.0:
        places = end_of_impact(table, s, every, members, result)
        progress.time = time if places is None else time + result.duration
    waiting = [] if places is None else wait(table, balls, result).tolist()
    for k, (i, ball) in enumerate(zip(members, balls, strict=True)):
        for axis in range(3):
            ball.velocity[axis], ball.spin[axis] = velocities[k][axis], spins[k][axis]
        ball.modified = True
        if places is not None:
            met_any, end = any(k in hit for hit in hits), time + result.duration
            go_on_to(s, ball, met_any, waiting[k], places[k].tolist(), end)
        met = {members[j] for hit in hits if k in hit for j in hit - {k}}
        if ball.first_contact == NOTHING and met:
            ball.first_contact = min(met & seeds or met)
        if any(k in hit for hit in hits):
            participants.append((number, i))
    after = sum(energy_of(params, ball) for ball in balls)
    _write_back(s.balls, every)
    ball = every[int(progress.ball)]
    log_event(s, time, CLUSTER, ball, int(progress.other), before, after, ball.motion)


_CHANGED = ('time', 'position', 'velocity', 'spin', 'first_contact', 'modified', 'nose')
_FIXED = (
    'acceleration',
    'spin_acceleration',
    'motion',
    'ball',
    'end',
    'boundary_time',
    'exit_velocity',
    'exit_spin',
)


def _as_objects(balls: Any) -> list[Ball]:
    """Balls as objects, whose attributes Python reads much faster than fields of rows."""
    if isinstance(balls, list):
        return balls
    objects = [Ball() for _ in range(len(balls))]
    for name in (*_CHANGED, *_FIXED):
        for ball, value in zip(objects, balls[name].tolist(), strict=True):
            setattr(ball, name, value)
    return objects


def _write_back(balls: Any, objects: list[Ball]) -> None:
    """Write what an impact changes of balls into the rows that they were read from."""
    if balls is not objects:
        for name in _CHANGED:
            balls[name] = [getattr(ball, name) for ball in objects]
