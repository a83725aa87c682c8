"""
Three bodies or more in touch when one of them is hit: all at once, by billiard_shot.impact.

Who takes part: the balls that are connected to those that meet by gaps within the tolerance, the
cushions that these touch, and the cloth below balls that touch a cushion, which presses them down.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import Body, collide, Contact
from billiard_shot.impact.laws import LAWS
from billiard_shot.status import Status
from billiard_shot.table.airborne import beside, edge_at
from billiard_shot.table.furniture import Bed, Furniture, lay_out
from billiard_shot.table.motion import (
    advance,
    ANGULAR,
    CLUSTER,
    FLIGHT,
    MOTION,
    POSITION,
    VELOCITY,
)
from billiard_shot.table.rails import ARCS, FACINGS
from billiard_shot.table.surface import Surface
from billiard_shot.table.world import energy_of, log_event, place_at, World

TOLERANCE = 1e-7  # of the impact, relative to the approach
LAW_NAMES = {number: name for name, number in LAWS.items()}
UP = (0.0, 0.0, 1.0)


def connected(
    place: dict[int, NDArray[np.float64]], seeds: set[int], reach: float
) -> list[int]:
    """Balls that are within reach of one of the seeds, or of each other, from there on."""
    found, fresh = set(seeds), list(seeds)
    while fresh:
        here = place[fresh.pop()]
        near = {i for i in place if i not in found and np.linalg.norm(place[i] - here) <= reach}
        found |= near
        fresh += sorted(near)
    return sorted(found)


def ball_contacts(
    surface: Surface, furniture: Furniture, balls: list[NDArray[np.float64]]
) -> list[Contact]:
    """Contacts between balls, those that come first against those that come later."""
    contacts = []
    for i, a in enumerate(balls):
        for j in range(i + 1, len(balls)):
            apart = a[POSITION : POSITION + 3] - balls[j][POSITION : POSITION + 3]
            distance = np.linalg.norm(apart)
            if distance > 2.0 * surface.radius + furniture.gap:
                continue
            normal = apart / distance
            point = balls[j][POSITION : POSITION + 3] + 0.5 * apart
            slip = _surface_velocity(a, point) - _surface_velocity(balls[j], point)
            slip -= normal * (normal @ slip)
            friction = furniture.friction_fast + furniture.friction_slow * np.exp(
                -furniture.friction_decay * np.linalg.norm(slip)
            )
            contacts.append(Contact(
                i, j, point, normal, furniture.ball_restitution, float(friction),
                furniture.ball_stiffness,
            ))
    return contacts


def cushion_contacts(
    surface: Surface, furniture: Furniture, bed: Bed, balls: list[NDArray[np.float64]]
) -> list[Contact]:
    """Contacts of balls with the cushions they touch, and then with the cloth."""
    contacts, fixed = [], len(balls)
    for i, ball in enumerate(balls):
        x, y, z = ball[POSITION : POSITION + 3]
        if z != surface.radius:
            continue
        held = False
        jaws = len(bed.arcs)
        for what in (*range(4), *range(FACINGS, FACINGS + jaws), *range(ARCS, ARCS + jaws)):
            nx, ny, away = edge_at(bed, what, x, y)
            if abs(away - bed.reach) <= furniture.gap and beside(bed, what, x, y):
                normal = np.array([
                    nx * bed.reach, ny * bed.reach, surface.radius - furniture.height
                ]) / surface.radius
                contacts.append(Contact(
                    i, fixed, ball[POSITION : POSITION + 3] - surface.radius * normal, normal,
                    furniture.cushion_restitution, furniture.cushion_friction,
                    furniture.cushion_stiffness,
                ))
                held = True
        if held:
            contacts.append(Contact(
                i, fixed, (x, y, 0.0), UP, surface.restitution, surface.friction,
                surface.stiffness,
            ))
    return contacts


def contacts_among(
    surface: Surface, furniture: Furniture, balls: list[NDArray[np.float64]]
) -> list[Contact]:
    """Contacts of balls with each other, and with what is fixed: the body after the balls."""
    contacts = ball_contacts(surface, furniture, balls)
    outside = max(
        max(abs(ball[POSITION]) - 0.5 * furniture.length,
            abs(ball[POSITION + 1]) - 0.5 * furniture.width) for ball in balls
    )
    if outside + surface.radius >= 0.0:  # the table is laid out only where it is needed
        contacts += cushion_contacts(
            surface, furniture, lay_out(furniture, surface.radius), balls
        )
    return contacts


def body_of(surface: Surface, ball: NDArray[np.float64]) -> Body:
    """Ball as a rigid body."""
    return Body(
        surface.mass, surface.inertia, ball[VELOCITY : VELOCITY + 3],
        ball[ANGULAR : ANGULAR + 3], ball[POSITION : POSITION + 3],
    )


def resolve(surface: Surface, furniture: Furniture, w: World) -> None:
    """
    Let all bodies collide for which the play has paused; then it can go on.

    Where their collision is not solved, the play ends there, with its status.
    """
    time, ball, other = float(w.pause[1]), int(w.pause[2]), int(w.pause[3])
    reach = 2.0 * surface.radius + furniture.gap
    place = {i: np.array(place_at(row, time)) for i, row in enumerate(w.balls)
             if row[MOTION] <= FLIGHT}
    members = connected(place, {ball, other}, reach)
    balls = [w.balls[i] for i in members]
    for row in balls:
        advance(row, time)
    before, motion = sum(energy_of(surface, row) for row in balls), w.balls[ball, MOTION]
    bodies = [body_of(surface, row) for row in balls]
    contacts = contacts_among(surface, furniture, balls)
    result = collide(
        [*bodies, Body.fixed()], contacts, law=LAW_NAMES[surface.law], exponent=surface.exponent,
        tolerance=TOLERANCE,
    )
    if result.status in (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED):
        w.pause[0] = -float(result.status)
    for k, (i, row) in enumerate(zip(members, balls, strict=True)):
        row[VELOCITY : VELOCITY + 3] = result.velocities[k]
        row[ANGULAR : ANGULAR + 3] = result.spins[k]
        w.touched[i] = True
        met = [c.a + c.b - k for c in contacts if k in (c.a, c.b) and len(balls) not in (c.a, c.b)]
        if w.first[i] < 0 and met:
            w.first[i] = members[min(met)]
    after = sum(energy_of(surface, row) for row in balls)
    log_event(
        w, time, CLUSTER, ball, other, sum(2.0**i for i in members), before, after,
        motion + 8.0 * motion,
    )


def _surface_velocity(
    ball: NDArray[np.float64], point: NDArray[np.float64]
) -> NDArray[np.float64]:
    lever = point - ball[POSITION : POSITION + 3]
    turning: NDArray[np.float64] = np.cross(ball[ANGULAR : ANGULAR + 3], lever)
    return ball[VELOCITY : VELOCITY + 3] + turning
