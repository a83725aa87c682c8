"""
Contacts of balls that touch each other, a cushion or the cloth: for a strike on one of them.

On the table alone balls meet within the contact of a cushion one after the other, because it is so
long. A strike is longer, and includes the cushion and the cloth below.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, Contact
from billiard_shot.table.ball_collision import friction_of_balls
from billiard_shot.table.ball_impact import slip_at
from billiard_shot.table.flight_boundary import edge_at, projects_onto_edge
from billiard_shot.table.geometry import Table
from billiard_shot.table.motion import Ball
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.rolling_boundary import ARCS, FACINGS

UP = (0.0, 0.0, 1.0)


def touching_group(places: NDArray[np.float64], seed: int, reach: float) -> list[int]:
    """Balls (n, 3) within reach [m] of a ball, or of each other from there on; in order."""
    near = np.linalg.norm(places[:, np.newaxis] - places, axis=2) <= reach
    found = near[seed]
    while not np.array_equal(found, grown := near[found].any(axis=0)):
        found = grown
    return np.flatnonzero(found).tolist()


def ball_contacts(table: Table, balls: list[Ball]) -> list[Contact]:
    """Contacts between balls that touch; the first ball of each comes first in the list."""
    n, radius, contacts = table.numbers, table.params.radius, []
    for (i, a), (j, b) in combinations(enumerate(balls), 2):
        between = np.subtract(a.position, b.position)
        distance = float(np.linalg.norm(between))
        if distance <= 2.0 * radius + n.contact_gap:
            normal = between / distance
            slip = np.subtract(slip_at(a, -radius, *normal), slip_at(b, radius, *normal))
            friction = friction_of_balls(n, float(np.linalg.norm(slip)))
            point = 0.5 * np.add(a.position, b.position)
            contacts.append(
                Contact(i, j, point, normal, n.ball_restitution, friction, n.ball_stiffness)
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
