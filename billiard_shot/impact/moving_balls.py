"""
Balls that move while they collide: a contact takes its normal when it closes.

Positions, velocities and spins of balls are polynomials, like the forces. They give the distance
of the balls of an open contact, which closes at the distance at which it last ended. An open
contact has no rows in W. When it closes, it gets its normal and its rows. Its force is zero then,
so both laws with distances keep their energy balance.

All balls are equal. Spins are multiplied by the radius, so they are velocities.
"""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.options import OPTIONS
from billiard_shot.impact.state import (
    Balls,
    ContactState,
    INACTIVE,
    resists,
    Workspace,
)
from billiard_shot.numerics import rounding
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.numerics.polynomial import evaluate
from billiard_shot.numerics.vectors import dot
from billiard_shot.records import Floats, Vector

PLACE, VELOCITY, SPIN = 0, 3, 6  # rows of a ball in `Workspace.motion`, three each


@inner
def place_contact(
    contacts: list[ContactState], motion: Floats, axes: Floats, j: int, gap: float
) -> None:
    """
    Set the axes of a contact of balls at the start of their collision.

    Parameters
    ----------
    contacts : N ContactState
        `ball_a` and `ball_b` must be set; contact j is written.
    motion : `Workspace.motion`
        Constant coefficients: places [m], velocities, and radius times spins [m/s].
    axes : (3, 3) floats
        Scratch.
    j : int
    gap : float
        Distance over which the contact is open [m].

    """
    c = contacts[j]
    c.closing_distance = distance(c, motion) - gap
    a, b = motion[c.ball_a], motion[c.ball_b]
    # Tangents parallel and normal to the cloth: balls that lie on it stay in a plane.
    c.tangent_1[0], c.tangent_1[1], c.tangent_1[2] = b[1][0] - a[1][0], a[0][0] - b[0][0], 0.0
    turn_axes(c, motion, axes)


@inner
def write_contact_motion(
    balls: Balls, contacts: list[ContactState], motion: Floats, velocity: Floats, w: Floats
) -> None:
    """Write the velocities (3 N,) at all contacts, and W (3 N, 3 N)."""
    for j in range(len(contacts)):
        for k in range(3):
            for column in range(3 * len(contacts)):
                w[3 * j + k][column] = 0.0
        velocity[3 * j], velocity[3 * j + 1], velocity[3 * j + 2] = velocity_of(
            contacts[j], motion
        )
        for k in range(j + 1):
            couple(balls, contacts, w, j, k)


@inner
def in_units(balls: Balls, mobility: float) -> Balls:
    """Divide the responses of balls by a unit of 1 / mass."""
    return Balls(balls.number, balls.response / mobility, balls.turning / mobility)


@inner
def distance(c: ContactState, motion: Floats) -> float:
    """Distance of the centres of a contact's balls."""
    a, b, square = motion[c.ball_a], motion[c.ball_b], 0.0
    for k in range(3):
        apart = a[k][0] - b[k][0]
        square += apart * apart
    return sqrt(square)


@inner
def change_units(
    contacts: list[ContactState], motion: Floats, count: int, speed: float, length: float
) -> None:
    """Divide the motion of balls by units of speed and length."""
    for b in range(count):
        for k in range(3):
            motion[b][k][0] /= length
            motion[b][VELOCITY + k][0] /= speed
            motion[b][SPIN + k][0] /= speed
    for j in range(len(contacts)):
        contacts[j].closing_distance /= length


@inner
def release_open_contacts(contacts: list[ContactState], ws: Workspace) -> None:
    """Clear the rows and columns of all open contacts in W."""
    for j in range(len(contacts)):
        if contacts[j].normal_mode == INACTIVE:
            release(contacts, ws, j)


@inner
def release(contacts: list[ContactState], ws: Workspace, j: int) -> None:
    """Clear the rows and columns of a contact in W."""
    for row in range(3 * j, 3 * j + 3):
        for column in range(3 * len(contacts)):
            ws.delassus[row][column] = ws.delassus[column][row] = 0.0


@inner
def part(contacts: list[ContactState], ws: Workspace, j: int) -> None:
    """Store the distance at which a contact ends, and closes again; clear its rows in W."""
    contacts[j].closing_distance = distance(contacts[j], ws.motion)
    release(contacts, ws, j)


@inner
def push_balls(balls: Balls, c: ContactState, motion: Floats, impulses: Vector, at: int) -> None:
    """Add the effect of impulses of a contact to coefficient `at` of the motion of its balls."""
    n, t, s = c.normal, c.tangent_1, c.tangent_2
    a, b = motion[c.ball_a], motion[c.ball_b]
    for k in range(3):
        change = impulses[0] * n[k] + impulses[1] * t[k] + impulses[2] * s[k]
        a[VELOCITY + k][at] += balls.response * change
        b[VELOCITY + k][at] -= balls.response * change
        if impulses[1] != 0.0 or impulses[2] != 0.0:  # both balls by -n x impulse
            turn = balls.turning * (impulses[1] * s[k] - impulses[2] * t[k])
            a[SPIN + k][at] -= turn
            b[SPIN + k][at] -= turn


@inner
def expand_motion(
    balls: Balls,
    contacts: list[ContactState],
    ws: Workspace,
    scale: float,
    order: int,
    length: float,
) -> None:
    """Fill the polynomials of the balls, and those of the open contacts, for x up to a length."""
    motion, impulses = ws.motion, ws.vector[0]
    for b in range(balls.number):
        for row in range(VELOCITY, 9):
            for k in range(1, order + 1):
                motion[b][row][k] = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode != INACTIVE:
            rubs = resists(c)
            for k in range(order):
                factor = scale / (k + 1)
                impulses[0] = factor * c.force[k]
                impulses[1] = factor * c.friction_1[k] if rubs else 0.0
                impulses[2] = factor * c.friction_2[k] if rubs else 0.0
                push_balls(balls, c, motion, impulses, k + 1)
    for b in range(balls.number):
        for row in range(3):
            for k in range(order):
                motion[b][row][k + 1] = scale * motion[b][VELOCITY + row][k] / (k + 1)
    for j in range(len(contacts)):
        if contacts[j].normal_mode == INACTIVE:
            expand_distance(contacts[j], ws, scale, order, length)


@inner
def expand_distance(
    c: ContactState, ws: Workspace, scale: float, order: int, length: float
) -> None:
    """
    Fill the polynomials of an open contact.

    Its compression is (D^2 - d^2) / (2 D) for a distance d that closes at D, because the square of
    d is a polynomial. If the balls cannot close in this step, the polynomials are constants.
    """
    a, b, apart = ws.motion[c.ball_a], ws.motion[c.ball_b], ws.polynomials
    farthest = 0.0  # largest distance that one ball can move relative to the other
    for row in range(3):
        power = 1.0
        for k in range(order + 1):
            apart[row][k] = a[row][k] - b[row][k]
            if k > 0:
                power *= length
                farthest += power * abs(apart[row][k])
    left = -c.compression[0]
    if farthest * (c.closing_distance + left) < left * c.closing_distance:
        for k in range(1, order + 1):
            c.compression[k] = c.velocity[k] = 0.0
        return
    for k in range(1, order + 1):
        half = 0.0  # of coefficient k of d^2
        for row in range(3):
            r = apart[row]
            for i in range((k + 1) // 2):
                half += r[i] * r[k - i]
            if k % 2 == 0:
                half += 0.5 * r[k // 2] * r[k // 2]
        c.compression[k] = -half / c.closing_distance
        c.velocity[k - 1] = half * k / (scale * c.closing_distance)


@inner
def advance_motion(
    balls: Balls,
    contacts: list[ContactState],
    ws: Workspace,
    order: int,
    x: float,
) -> None:
    """Move the balls to x on their polynomials, and update the open contacts."""
    for b in range(balls.number):
        for row in range(9):
            series = ws.motion[b][row]
            series[0] = evaluate(series, order, x)
    for j in range(len(contacts)):
        if contacts[j].normal_mode == INACTIVE:
            measure(contacts[j], ws.motion)


@inner
def measure(c: ContactState, motion: Floats) -> None:
    """Find the compression of an open contact, and the velocity at which it opens."""
    a, b, square, opening = motion[c.ball_a], motion[c.ball_b], 0.0, 0.0
    for k in range(3):
        apart = a[k][0] - b[k][0]
        square += apart * apart
        opening += apart * (a[VELOCITY + k][0] - b[VELOCITY + k][0])
    closes_at = c.closing_distance
    c.compression[0] = min(0.5 * (closes_at - square / closes_at), 0.0)
    c.velocity[0] = opening / closes_at
    if abs(c.velocity[0]) <= OPTIONS.rounding:
        c.velocity[0] = 0.0
        if c.compression[0] >= -OPTIONS.rounding:  # nothing has reached it yet
            c.compression[0] = 0.0


@inner
def take_normal(
    balls: Balls, planar: bool, contacts: list[ContactState], ws: Workspace, j: int
) -> None:
    """Set axes, velocity and rows in W of a contact that closes; `planar`: see `Model`."""
    c, impulse = contacts[j], ws.vector[0]
    for k in range(3):
        impulse[k] = (
            c.impulse * c.normal[k] + c.impulse_1 * c.tangent_1[k] + c.impulse_2 * c.tangent_2[k]
        )
    turn_axes(c, ws.motion, ws.polynomials)
    c.impulse, c.impulse_1 = dot(c.normal, impulse), dot(c.tangent_1, impulse)
    c.impulse_2 = dot(c.tangent_2, impulse)
    normal, first, second = velocity_of(c, ws.motion)
    c.velocity[0] = normal
    c.slip_1[0] = first if abs(first) > OPTIONS.rounding else 0.0
    c.slip_2[0] = second if abs(second) > OPTIONS.rounding and not planar else 0.0
    for k in range(len(contacts)):
        if k == j or contacts[k].normal_mode != INACTIVE:
            couple(balls, contacts, ws.delassus, j, k)


@inner
def turn_axes(c: ContactState, motion: Floats, axes: Floats) -> None:
    """Align the axes of a contact with its balls; turn the first tangent as little as possible."""
    a, b, direction, size = motion[c.ball_a], motion[c.ball_b], c.normal, distance(c, motion)
    for k in range(3):
        direction[k] = (a[k][0] - b[k][0]) / size
    contact_axes(direction, c.tangent_1, direction, axes, 0)
    for k in range(3):
        c.tangent_1[k], c.tangent_2[k] = axes[1][k], axes[2][k]


@inner
def velocity_of(c: ContactState, motion: Floats) -> tuple[float, float, float]:
    """Velocity of ball a relative to ball b where they touch: normal, and slip."""
    a, b, n, t, s = motion[c.ball_a], motion[c.ball_b], c.normal, c.tangent_1, c.tangent_2
    normal, first, second = 0.0, 0.0, 0.0
    for k in range(3):
        approach = a[VELOCITY + k][0] - b[VELOCITY + k][0]
        spin = a[SPIN + k][0] + b[SPIN + k][0]
        normal += n[k] * approach
        first += t[k] * approach - s[k] * spin
        second += s[k] * approach + t[k] * spin
    return normal, first, second


@inner
def couple(balls: Balls, contacts: list[ContactState], w: Floats, j: int, k: int) -> None:
    """Write the coupling of contacts j and k into W."""
    c, d = contacts[j], contacts[k]
    same = (1.0 if c.ball_a == d.ball_a else 0.0) + (1.0 if c.ball_b == d.ball_b else 0.0)
    other = (1.0 if c.ball_a == d.ball_b else 0.0) + (1.0 if c.ball_b == d.ball_a else 0.0)
    if same + other == 0.0:
        return
    pulls, turns = balls.response * (same - other), balls.turning * (same + other)
    row, column = 3 * j, 3 * k
    n, t, s = c.normal, c.tangent_1, c.tangent_2
    p, q, r = d.normal, d.tangent_1, d.tangent_2
    w[row][column] = pulls * dot(n, p)
    w[row][column + 1] = pulls * dot(n, q)
    w[row][column + 2] = pulls * dot(n, r)
    w[row + 1][column] = pulls * dot(t, p)
    w[row + 1][column + 1] = pulls * dot(t, q) + turns * dot(s, r)
    w[row + 1][column + 2] = pulls * dot(t, r) - turns * dot(s, q)
    w[row + 2][column] = pulls * dot(s, p)
    w[row + 2][column + 1] = pulls * dot(s, q) - turns * dot(t, r)
    w[row + 2][column + 2] = pulls * dot(s, r) + turns * dot(t, q)
    rounded = 2.0 * rounding.COUPLING * (balls.response + balls.turning)
    for x in range(row, row + 3):
        for y in range(column, column + 3):
            if abs(w[x][y]) <= rounded:
                w[x][y] = 0.0
            w[y][x] = w[x][y]


@inner
def kinetic_energy(balls: Balls, motion: Floats) -> float:
    """Kinetic energy of the balls."""
    energy = 0.0
    for b in range(balls.number):
        for k in range(3):
            v, spin = motion[b][VELOCITY + k][0], motion[b][SPIN + k][0]
            energy += 0.5 * (v * v / balls.response + spin * spin / balls.turning)
    return energy
