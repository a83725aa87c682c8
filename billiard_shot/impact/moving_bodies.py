"""Bodies that move while they collide: balls, the tips of cues, and fixed planes and edges."""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact import state
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.numerics import rounding
from billiard_shot.numerics.polynomial import evaluate
from billiard_shot.numerics.vectors import contact_axes, dot
from billiard_shot.records import Floats, Vector

# Rows of a body in `Workspace.motion`, three each. Only places are polynomials.
PLACE_ROWS, VELOCITY_ROWS, SPIN_ROWS, ACCELERATION_ROWS = 0, 3, 6, 9


@inner
def load_body(body: state.BodyState, ws: state.Workspace, b: int) -> None:
    """Copy a body into the workspace."""
    copy, motion = ws.bodies[b], ws.motion[b]
    copy.kind, copy.response, copy.across = body.kind, body.response, body.across
    copy.turning, copy.lost = body.turning, 0.0
    for k in range(3):
        copy.axis[k], copy.position[k] = body.axis[k], body.position[k]
        motion[PLACE_ROWS + k][0] = body.position[k]
        motion[VELOCITY_ROWS + k][0], motion[SPIN_ROWS + k][0] = body.velocity[k], body.spin[k]
        motion[ACCELERATION_ROWS + k][0] = 0.0


@inner
def store_body(body: state.BodyState, ws: state.Workspace, b: int) -> None:
    """Copy the motion of a body at the end of a collision, and its loss, from the workspace."""
    motion = ws.motion[b]
    body.lost = ws.bodies[b].lost
    for k in range(3):
        body.position[k] = motion[PLACE_ROWS + k][0]
        body.velocity[k], body.spin[k] = motion[VELOCITY_ROWS + k][0], motion[SPIN_ROWS + k][0]


@inner
def place_contacts(
    contacts: list[state.ContactState], ws: state.Workspace, velocity: Floats
) -> None:
    """Set the axes of contacts at the start of a collision; write velocities (3 N,) and W."""
    w = ws.delassus
    for j in range(len(contacts)):
        turn_axes(contacts[j], ws, 0.0)
    for j in range(len(contacts)):
        for k in range(3):
            for column in range(3 * len(contacts)):
                w[3 * j + k][column] = 0.0
        velocity[3 * j], velocity[3 * j + 1], velocity[3 * j + 2] = velocity_of(contacts[j], ws)
        for k in range(j + 1):
            if contacts[j].hold == state.FREE and contacts[k].hold == state.FREE:
                couple(contacts, ws, j, k)


@inner
def separation_coefficient(
    c: state.ContactState, ws: state.Workspace, row: int, k: int
) -> tuple[float, float, float]:
    """
    Coefficient k of the way from body b to body a: of the place, or of its derivatives.

    If body b is fixed, the way begins at the point of it that is nearest to body a.
    """
    a, b, fixed = ws.motion[c.body_a], ws.motion[c.body_b], ws.bodies[c.body_b]
    x, y, z = a[row][k] - b[row][k], a[row + 1][k] - b[row + 1][k], a[row + 2][k] - b[row + 2][k]
    if fixed.response == 0.0:
        axis = fixed.axis
        along = x * axis[0] + y * axis[1] + z * axis[2]
        if fixed.kind == state.PLANE:
            return along * axis[0], along * axis[1], along * axis[2]
        return x - along * axis[0], y - along * axis[1], z - along * axis[2]
    return x, y, z


@inner
def distance_of_centres(c: state.ContactState, ws: state.Workspace) -> float:
    """Distance of the centres of a contact's bodies, or of a ball from a fixed one."""
    x, y, z = separation_coefficient(c, ws, PLACE_ROWS, 0)
    return sqrt(x * x + y * y + z * z)


@inner
def change_units(
    contacts: list[state.ContactState],
    ws: state.Workspace,
    count: int,
    speed: float,
    length: float,
) -> None:
    """Divide the motion of bodies by units of speed and length."""
    for b in range(count):
        motion, origin = ws.motion[b], ws.bodies[b].position
        for k in range(3):
            motion[k][0] /= length
            motion[VELOCITY_ROWS + k][0] /= speed
            motion[SPIN_ROWS + k][0] /= speed
            origin[k] /= length
    for j in range(len(contacts)):
        contacts[j].closing_distance /= length
        contacts[j].reach /= length


@inner
def change_responses(ws: state.Workspace, count: int, mobility: float) -> None:
    """Divide the responses of bodies by a unit of 1 / mass."""
    for b in range(count):
        body = ws.bodies[b]
        body.response /= mobility
        body.across /= mobility
        body.turning /= mobility


@inner
def release_open_contacts(contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """Clear the rows and columns of all open contacts in W."""
    for j in range(len(contacts)):
        if contacts[j].normal_mode == state.INACTIVE:
            clear_rows(contacts, ws, j)


@inner
def clear_rows(contacts: list[state.ContactState], ws: state.Workspace, j: int) -> None:
    """Clear the rows and columns of a contact in W."""
    for row in range(3 * j, 3 * j + 3):
        for column in range(3 * len(contacts)):
            ws.delassus[row][column] = ws.delassus[column][row] = 0.0


@inner
def part(contacts: list[state.ContactState], ws: state.Workspace, j: int) -> None:
    """Store the distance at which a contact ends, and closes again; clear its rows in W."""
    c = contacts[j]
    clear_rows(contacts, ws, j)
    if ws.bodies[c.body_a].kind == state.TIP_BODY and not has_shaft(contacts, c.body_a):
        swing_back(contacts, ws, j)
    else:
        c.closing_distance = distance_of_centres(c, ws)
    if c.closings >= c.max_closings:
        c.hold = state.GONE


@inner
def has_shaft(contacts: list[state.ContactState], body: int) -> bool:
    """Whether a shaft holds a body."""
    for j in range(len(contacts)):
        if contacts[j].normal_mode == state.SHAFT and contacts[j].body_a == body:
            return True
    return False


@inner
def end_swings(contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """Move the tips of all cues with shafts to their axes, at the end of a collision."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode != state.SHAFT and has_shaft(contacts, c.body_a):
            swing_back(contacts, ws, j)


@inner
def swing_back(contacts: list[state.ContactState], ws: state.Workspace, j: int) -> None:
    """Move the tip of a contact that ended to the axis of its cue, where it overlaps no ball."""
    c = contacts[j]
    body, motion = ws.bodies[c.body_a], ws.motion[c.body_a]
    axis, origin = body.axis, body.position
    way, speed, energy = 0.0, 0.0, 0.0
    for k in range(3):
        way += axis[k] * (motion[PLACE_ROWS + k][0] - origin[k])
        speed += axis[k] * motion[VELOCITY_ROWS + k][0]
    for k in range(3):
        across = motion[VELOCITY_ROWS + k][0] - speed * axis[k]
        energy += 0.5 * across * across
        motion[PLACE_ROWS + k][0] = origin[k] + way * axis[k]
        motion[VELOCITY_ROWS + k][0] = speed * axis[k]
    body.lost += energy / body.across if body.across > 0.0 else 0.0
    x, y, z = separation_coefficient(c, ws, PLACE_ROWS, 0)
    ahead = x * axis[0] + y * axis[1] + z * axis[2]
    inside = x * x + y * y + z * z - c.reach * c.reach
    if inside < 0.0:
        back = ahead + sqrt(ahead * ahead - inside)
        for k in range(3):
            motion[PLACE_ROWS + k][0] -= back * axis[k]
    c.closing_distance = c.reach
    measure(c, ws)
    if inside < 0.0:
        c.compression[0] = 0.0
        if c.velocity[0] < 0.0 and not meets_another(contacts, ws, j):
            c.hold = state.HELD


@inner
def height_of(contacts: list[state.ContactState], ws: state.Workspace, ball: int) -> float:
    """Distance of a ball from the plane below it, 0 if it presses that plane."""
    for k in range(len(contacts)):
        c = contacts[k]
        if c.body_a == ball and ws.bodies[c.body_b].kind == state.PLANE and not state.is_active(c):
            return -c.compression[0]
    return 0.0


@inner
def meets_another(contacts: list[state.ContactState], ws: state.Workspace, j: int) -> bool:
    """Whether the ball of a tip's contact presses another ball or an edge."""
    ball = contacts[j].body_b
    for k in range(len(contacts)):
        c = contacts[k]
        touches = k != j and state.is_active(c) and ball in (c.body_a, c.body_b)
        if touches and ws.bodies[c.body_b].kind != state.PLANE:
            return True
    return False


@inner
def free_tips(contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """Free the tips whose balls meet other bodies: each may press its ball from where it is."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.hold == state.HELD and meets_another(contacts, ws, j):
            c.hold = state.FREE
            c.closing_distance = min(c.reach, distance_of_centres(c, ws))
            measure(c, ws)


@inner
def push_bodies(
    ws: state.Workspace, c: state.ContactState, impulses: Vector, row: int, at: int
) -> None:
    """
    Add the effect of impulses of a contact on its bodies to coefficient `at` of three rows.

    If these are the velocities, the impulses change the spins, too.
    """
    n, t, s = c.normal, c.tangent_1, c.tangent_2
    one, other = ws.bodies[c.body_a], ws.bodies[c.body_b]
    a, b = ws.motion[c.body_a], ws.motion[c.body_b]
    turns = row == VELOCITY_ROWS and (impulses[1] != 0.0 or impulses[2] != 0.0)
    along = 0.0
    for k in range(3):
        change = impulses[0] * n[k] + impulses[1] * t[k] + impulses[2] * s[k]
        along += change * one.axis[k]
        a[row + k][at] += one.across * change
        b[row + k][at] -= other.across * change
        if turns:  # both balls by -n x impulse
            turn = impulses[1] * s[k] - impulses[2] * t[k]
            a[SPIN_ROWS + k][at] -= one.turning * turn
            b[SPIN_ROWS + k][at] -= other.turning * turn
    if one.kind == state.TIP_BODY:
        for k in range(3):
            a[row + k][at] += (one.response - one.across) * along * one.axis[k]


@inner
def drift(ws: state.Workspace, count: int, time: float) -> None:
    """Move bodies by their velocities for a time."""
    for b in range(count):
        motion = ws.motion[b]
        for k in range(3):
            motion[PLACE_ROWS + k][0] += time * motion[VELOCITY_ROWS + k][0]


@inner
def find_accelerations(
    count: int, contacts: list[state.ContactState], ws: state.Workspace, order: int, x: float
) -> None:
    """Write the accelerations of bodies under the forces of a step at x."""
    forces = ws.vector[0]
    for b in range(count):
        for k in range(3):
            ws.motion[b][ACCELERATION_ROWS + k][0] = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c):
            rubs = state.resists(c)
            forces[0] = evaluate(c.force, order - 1, x)
            forces[1] = evaluate(c.friction_1, order - 1, x) if rubs else 0.0
            forces[2] = evaluate(c.friction_2, order - 1, x) if rubs else 0.0
            push_bodies(ws, c, forces, ACCELERATION_ROWS, 0)


@inner
def expand_distances(
    count: int,
    contacts: list[state.ContactState],
    ws: state.Workspace,
    scale: float,
    order: int,
    length: float,
) -> None:
    """Fill the polynomials of open contacts, for x up to a length: constants if none may close."""
    some_may_close = False
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode == state.INACTIVE:
            some_may_close = some_may_close or c.hold != state.GONE
            for k in range(1, order + 1):
                c.compression[k] = c.velocity[k] = 0.0
    if some_may_close:
        expand_places(count, contacts, ws, scale, order)
        for j in range(len(contacts)):
            if contacts[j].normal_mode == state.INACTIVE and contacts[j].hold != state.GONE:
                expand_distance(contacts[j], ws, scale, order, length)


@inner
def expand_places(
    count: int, contacts: list[state.ContactState], ws: state.Workspace, scale: float, order: int
) -> None:
    """Fill the polynomials of the places of bodies."""
    shifts = ws.vector[0]
    for b in range(count):
        motion = ws.motion[b]
        for row in range(3):
            motion[row][1] = scale * motion[VELOCITY_ROWS + row][0]
            for k in range(2, order + 1):
                motion[row][k] = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c):
            rubs = state.resists(c)
            for k in range(order - 1):
                factor = scale * scale / ((k + 1) * (k + 2))
                shifts[0] = factor * c.force[k]
                shifts[1] = factor * c.friction_1[k] if rubs else 0.0
                shifts[2] = factor * c.friction_2[k] if rubs else 0.0
                push_bodies(ws, c, shifts, PLACE_ROWS, k + 2)


@inner
def expand_distance(
    c: state.ContactState, ws: state.Workspace, scale: float, order: int, length: float
) -> None:
    """
    Fill the polynomials of an open contact.

    Its compression is (D^2 - d^2) / (2 D) for a distance d that closes at D, because the square of
    d is a polynomial. If the bodies cannot close in this step, its polynomials stay constants.
    """
    way = ws.polynomials
    farthest = 0.0  # largest distance that one body can move relative to the other
    power = 1.0
    for k in range(order + 1):
        x, y, z = separation_coefficient(c, ws, PLACE_ROWS, k)
        way[0][k], way[1][k], way[2][k] = x, y, z
        if k > 0:
            power *= length
            farthest += power * (abs(x) + abs(y) + abs(z))
    left = abs(c.compression[0])
    if farthest * (c.closing_distance + left) < left * c.closing_distance:
        return
    for k in range(1, order + 1):
        half = 0.0  # of coefficient k of d^2
        for row in range(3):
            r = way[row]
            for i in range((k + 1) // 2):
                half += r[i] * r[k - i]
            if k % 2 == 0:
                half += 0.5 * r[k // 2] * r[k // 2]
        c.compression[k] = -half / c.closing_distance
        c.velocity[k - 1] = half * k / (scale * c.closing_distance)


@inner
def measure(c: state.ContactState, ws: state.Workspace) -> None:
    """Find the compression of an open contact, and the velocity at which it opens."""
    x, y, z = separation_coefficient(c, ws, PLACE_ROWS, 0)
    u, v, w = separation_coefficient(c, ws, VELOCITY_ROWS, 0)
    closes_at = c.closing_distance
    c.compression[0] = 0.5 * (closes_at - (x * x + y * y + z * z) / closes_at)
    c.velocity[0] = (x * u + y * v + z * w) / closes_at
    if c.hold != state.HELD:
        state.rest_open(c)


@inner
def take_normal(
    planar: bool, contacts: list[state.ContactState], ws: state.Workspace, j: int, lead: float
) -> None:
    """
    Set axes, velocity and rows in W of a contact.

    Parameters
    ----------
    planar : bool
        See `Model`.
    contacts, ws, j
        The contacts, the workspace, and the number of the contact.
    lead : float
        The normal is that of so much later, see beginning.py.

    """
    c, impulse = contacts[j], ws.vector[0]
    for k in range(3):
        impulse[k] = impulse_along(c, k)
    turn_axes(c, ws, lead)
    c.is_turned = False
    c.impulse[0], c.impulse[1] = dot(c.normal, impulse), dot(c.tangent_1, impulse)
    c.impulse[2] = dot(c.tangent_2, impulse)
    normal, first, second = velocity_of(c, ws)
    c.velocity[0] = normal
    c.slip_1[0] = first if abs(first) > METHOD_OPTIONS.rounding else 0.0
    c.slip_2[0] = second if abs(second) > METHOD_OPTIONS.rounding and not planar else 0.0
    for k in range(len(contacts)):
        if k == j or contacts[k].normal_mode != state.INACTIVE:
            couple(contacts, ws, j, k)


@inner
def impulse_along(c: state.ContactState, k: int) -> float:
    """Component k, in the frame of the bodies, of the impulse of a contact on body a so far."""
    along = c.impulse[0] * c.normal[k] + c.impulse[1] * c.tangent_1[k]
    return along + c.impulse[2] * c.tangent_2[k]


@inner
def turn_axes(c: state.ContactState, ws: state.Workspace, lead: float) -> None:
    """
    Align the axes of a contact with its bodies; turn the first tangent as little as possible.

    The axes are those of a time `lead` later, with the factor 1/3 for accelerations of
    beginning.py. The normal of a shaft is the axis of its cue.
    """
    axes, direction = ws.polynomials, c.normal
    x, y, z = separation_coefficient(c, ws, PLACE_ROWS, 0)
    if c.normal_mode == state.SHAFT:
        axis = ws.bodies[c.body_a].axis
        x, y, z = axis[0], axis[1], axis[2]
    if lead > 0.0:
        for row, factor in ((VELOCITY_ROWS, lead), (ACCELERATION_ROWS, lead * lead / 3.0)):
            u, v, w = separation_coefficient(c, ws, row, 0)
            x, y, z = x + factor * u, y + factor * v, z + factor * w
    size = sqrt(x * x + y * y + z * z)
    direction[0], direction[1], direction[2] = x / size, y / size, z / size
    contact_axes(direction, c.tangent_1, direction, axes, 0)
    for k in range(3):
        c.tangent_1[k], c.tangent_2[k] = axes[1][k], axes[2][k]


@inner
def velocity_of(c: state.ContactState, ws: state.Workspace) -> tuple[float, float, float]:
    """Velocity of body a relative to body b where they touch: normal, and slip."""
    a, b, n, t, s = ws.motion[c.body_a], ws.motion[c.body_b], c.normal, c.tangent_1, c.tangent_2
    normal, first, second = 0.0, 0.0, 0.0
    for k in range(3):
        approach = a[VELOCITY_ROWS + k][0] - b[VELOCITY_ROWS + k][0]
        spin = a[SPIN_ROWS + k][0] + b[SPIN_ROWS + k][0]
        normal += n[k] * approach
        first += t[k] * approach - s[k] * spin
        second += s[k] * approach + t[k] * spin
    return normal, first, second


@inner
def couple(contacts: list[state.ContactState], ws: state.Workspace, j: int, k: int) -> None:
    """Write the coupling of contacts j and k into W: that of all bodies that they share."""
    c, d, w = contacts[j], contacts[k], ws.delassus
    row, column = 3 * j, 3 * k
    for x in range(row, row + 3):
        for y in range(column, column + 3):
            w[x][y] = 0.0
    largest = 0.0
    for b in (c.body_a, c.body_b):
        body = ws.bodies[b]
        if body.response > 0.0 and (b == d.body_a or b == d.body_b):
            sign = 1.0 if (b == c.body_a) == (b == d.body_a) else -1.0
            add_response(body, c, d, sign, w, row, column=column)
            largest = max(largest, body.response, body.across + body.turning)
    rounded = 2.0 * rounding.COUPLING * largest
    for x in range(row, row + 3):
        for y in range(column, column + 3):
            if abs(w[x][y]) <= rounded:
                w[x][y] = 0.0
            w[y][x] = w[x][y]


@inner
def add_response(
    body: state.BodyState,
    c: state.ContactState,
    d: state.ContactState,
    sign: float,
    w: Floats,
    row: int,
    column: int,
) -> None:
    """Add the velocities of a body at contact c per impulse at contact d to a block of W."""
    n, t, s = c.normal, c.tangent_1, c.tangent_2
    p, q, r = d.normal, d.tangent_1, d.tangent_2
    pull, turn = sign * body.across, body.turning
    w[row][column] += pull * dot(n, p)
    w[row][column + 1] += pull * dot(n, q)
    w[row][column + 2] += pull * dot(n, r)
    w[row + 1][column] += pull * dot(t, p)
    w[row + 1][column + 1] += pull * dot(t, q) + turn * dot(s, r)
    w[row + 1][column + 2] += pull * dot(t, r) - turn * dot(s, q)
    w[row + 2][column] += pull * dot(s, p)
    w[row + 2][column + 1] += pull * dot(s, q) - turn * dot(t, r)
    w[row + 2][column + 2] += pull * dot(s, r) + turn * dot(t, q)
    if body.kind == state.TIP_BODY:
        axis, stiff = body.axis, body.response - body.across
        along = dot(axis, p), dot(axis, q), dot(axis, r)
        for k in range(3):
            w[row][column + k] += stiff * dot(axis, n) * along[k]
            w[row + 1][column + k] += stiff * dot(axis, t) * along[k]
            w[row + 2][column + k] += stiff * dot(axis, s) * along[k]


@inner
def energy_of_bodies(ws: state.Workspace, count: int) -> float:
    """Kinetic energy of bodies."""
    energy = 0.0
    for b in range(count):
        body, motion = ws.bodies[b], ws.motion[b]
        if body.response == 0.0:
            continue
        square, along, spins = 0.0, 0.0, 0.0
        for k in range(3):
            v, spin = motion[VELOCITY_ROWS + k][0], motion[SPIN_ROWS + k][0]
            square, spins, along = square + v * v, spins + spin * spin, along + v * body.axis[k]
        if body.kind == state.TIP_BODY:
            energy += 0.5 * along * along / body.response
            across = square - along * along
            energy += 0.5 * across / body.across if body.across > 0.0 else 0.0
        else:
            energy += 0.5 * square / body.response
            energy += 0.5 * spins / body.turning if body.turning > 0.0 else 0.0
    return energy
