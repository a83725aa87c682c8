"""Coulomb friction: which contacts stick, how others start to slip, and the shear of a tip."""

from math import atan2, cos, sin, sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact import state
from billiard_shot.impact.options import elastic_energy, METHOD_OPTIONS
from billiard_shot.numerics.polynomial import evaluate, product_integral
from billiard_shot.numerics.vectors import pseudo_inverse
from billiard_shot.records import Floats

STRAIGHT, FOLLOWS, TURNS = range(3)  # what the direction of a contact that drags does in a step


@inner
def begin_shear(c: state.ContactState) -> None:
    """Let a contact that has just closed grip or drag, by the ratio of its slip and approach."""
    if c.friction_mode == state.FRICTIONLESS:
        slip = state.slip_speed(c)
        c.friction_mode = state.GRIP
        if c.shear * slip > c.friction * max(-c.velocity[0], 0.0):
            c.friction_mode = state.DRAG
            c.slip_dir_1, c.slip_dir_2 = c.slip_1[0] / slip, c.slip_2[0] / slip


@inner
def begin_drag(c: state.ContactState) -> None:
    """Let a contact whose force has reached the cone drag along its shear."""
    c.friction_mode = state.DRAG
    hold_to_cone(c, TURNS)


@inner
def cone_width(c: state.ContactState) -> float:
    """Shear on the cone relative to the compression."""
    return c.friction / c.shear


@inner
def turning_of(planar: bool, c: state.ContactState) -> int:
    """
    How the direction of a contact that drags turns in the step from now: one of the three above.

    It follows a fast slip within the time |u| / slip. While that is too short for explicit steps,
    it is the direction of the slip.
    """
    slip = state.slip_speed(c)
    along = c.slip_1[0] * c.slip_dir_1 + c.slip_2[0] * c.slip_dir_2
    fast = cone_width(c) * c.compression[0] < METHOD_OPTIONS.least_lag * slip
    if planar:
        return STRAIGHT
    if fast and along > METHOD_OPTIONS.aligned * slip:
        return FOLLOWS
    return STRAIGHT if state.force_is_negligible(c) else TURNS


@inner
def hold_to_cone(c: state.ContactState, turning: int) -> None:
    """Put the shear of a contact that drags onto the cone, along its direction now."""
    d_1, d_2 = (c.shift_1[0], c.shift_2[0]) if turning == TURNS else (c.slip_1[0], c.slip_2[0])
    size = sqrt(d_1 * d_1 + d_2 * d_2)
    if turning != STRAIGHT and size > 0.0:
        c.slip_dir_1, c.slip_dir_2 = d_1 / size, d_2 / size
    rim = cone_width(c) * c.compression[0]
    c.shift_1[0], c.shift_2[0] = rim * c.slip_dir_1, rim * c.slip_dir_2


@inner
def shear_force(
    c: state.ContactState, y: float, u_1: float, u_2: float
) -> tuple[float, float, float]:
    """Force on body a, along the normal and the tangents, at a compression and a shear."""
    square = y * y + c.shear * (u_1 * u_1 + u_2 * u_2)
    firmness = c.stiffness * square ** (0.5 * (c.exponent - 1.0))
    return firmness * y, -c.shear * firmness * u_1, -c.shear * firmness * u_2


@inner
def present_force(c: state.ContactState, loaded: bool) -> tuple[float, float, float]:
    """Force on body a now or, if no spring is loaded yet, one along the first force."""
    if loaded:
        return shear_force(c, c.compression[0], c.shift_1[0], c.shift_2[0])
    approach = max(-c.velocity[0], 0.0)
    if c.friction_mode == state.DRAG:
        rim = cone_width(c) * approach
        return shear_force(c, approach, rim * c.slip_dir_1, rim * c.slip_dir_2)
    return shear_force(c, approach, c.slip_1[0], c.slip_2[0])


@inner
def drag_stiffness(c: state.ContactState) -> float:
    """Stiffness k of the normal force k y^p of a contact that drags."""
    square = 1.0 + c.friction * cone_width(c)
    return c.stiffness * square ** (0.5 * (c.exponent - 1.0))


@inner
def spring_energy(c: state.ContactState) -> float:
    """Energy in the springs of a contact; zero if it is open."""
    y = c.compression[0]
    if state.shears(c):
        u_1, u_2 = c.shift_1[0], c.shift_2[0]
        y = sqrt(y * y + c.shear * (u_1 * u_1 + u_2 * u_2))
    return elastic_energy(c.stiffness, y, c.exponent)


@inner
def count_losses(c: state.ContactState, scale: float, order: int, x: float) -> None:
    """Add the energy that a step to x costs a contact that shears."""
    if c.normal_mode == state.RESTITUTION:
        faster = scale * (c.compression_rate - 1.0)
        c.restitution_loss += faster * product_integral(c.force, c.velocity, order, x)
    if c.friction_mode == state.DRAG:
        c.friction_loss += scale * c.friction * product_integral(c.force, c.sliding, order, x)


@inner
def set_forces(contacts: list[state.ContactState]) -> None:
    """Write the forces of this moment, but for the friction of contacts that stick."""
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c):
            c.force[0] = c.stiffness * c.compression[0] ** c.exponent
            if state.shears(c):
                c.force[0], c.friction_1[0], c.friction_2[0] = shear_force(
                    c, c.compression[0], c.shift_1[0], c.shift_2[0]
                )
            elif c.friction_mode == state.ELASTIC:
                c.friction_1[0], c.friction_2[0] = state.elastic_friction(c, 0)
            elif state.slips(c):
                rub, slip = (
                    state.friction_at(c, state.slip_speed(c)) * c.force[0],
                    max(state.slip_speed(c), 1e-300),
                )
                c.friction_1[0] = -rub * c.slip_1[0] / slip
                c.friction_2[0] = -rub * c.slip_2[0] / slip


@inner
def normal_acceleration(
    contacts: list[state.ContactState], ws: state.Workspace, j: int
) -> tuple[float, float]:
    """Sum the normal acceleration of a contact by the first forces, and the size of its terms."""
    total, size, row = 0.0, 0.0, ws.reduced[3 * j]
    for k in range(len(contacts)):
        c = contacts[k]
        if state.is_active(c):
            push = row[3 * k] * c.force[0]
            total, size = total + push, size + abs(push)
            if state.friction_is_explicit(c):
                push = row[3 * k + 1] * c.friction_1[0] + row[3 * k + 2] * c.friction_2[0]
                total, size = total + push, size + abs(push)
    return total, size


@inner
def eliminate_sticking(contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """
    Eliminate the friction of sticking contacts: it is the force that keeps their slip at zero.

    With S the tangential components of the sticking contacts, 0 = W_SS F_S + W_S. F gives
    F_S = gain F (least norm if contacts share a constraint), and the contact velocities follow
    u' = reduced F, reduced = W + W_.S gain. Columns of S are zero: F holds the other forces.
    Columns of contacts that are not active are not written.
    """
    w, reduced, gain, stuck = ws.delassus, ws.reduced, ws.stick_gain, ws.indices
    count = 0
    for j in range(len(contacts)):
        if state.is_active(contacts[j]):
            if state.sticks(contacts[j]):
                stuck[count], stuck[count + 1] = 3 * j + 1, 3 * j + 2
                count += 2
            for i in range(3 * len(contacts)):
                for column in range(3 * j, 3 * j + 3):
                    reduced[i][column] = w[i][column]
                    gain[i][column] = 0.0
    if count > 0:
        eliminate(contacts, ws, count)
    find_coupled(contacts, ws)


@inner
def eliminate(contacts: list[state.ContactState], ws: state.Workspace, count: int) -> None:
    """Eliminate the first `count` components that `ws.indices` names."""
    w, reduced, gain, stuck = ws.delassus, ws.reduced, ws.stick_gain, ws.indices
    size = 3 * len(contacts)
    block, inverse = ws.matrix[0], ws.matrix[1]
    for a in range(count):
        for b in range(count):
            block[a][b] = w[stuck[a]][stuck[b]]
    pseudo_inverse(block, inverse, ws.matrix[2], count)
    for a in range(count):
        for j in range(size):
            if state.is_active(contacts[j // 3]):
                for b in range(count):
                    gain[stuck[a]][j] -= inverse[a][b] * w[stuck[b]][j]
    for a in range(count):
        for b in range(count):
            gain[stuck[a]][stuck[b]] = 0.0
    for a in range(count):
        for j in range(size):
            if state.is_active(contacts[j // 3]) and gain[stuck[a]][j] != 0.0:
                for i in range(size):
                    reduced[i][j] += w[i][stuck[a]] * gain[stuck[a]][j]
    # Sticking contacts may hold a contact completely. Rounding would leave it a mobility.
    for j in range(size):
        if state.is_active(contacts[j // 3]):
            for i in range(size):
                least = METHOD_OPTIONS.rounding * METHOD_OPTIONS.rounding * w[i][i] * w[j][j]
                if reduced[i][j] * reduced[i][j] <= least:
                    reduced[i][j] = 0.0
    for a in range(count):
        for i in range(size):
            reduced[i][stuck[a]] = 0.0
            reduced[stuck[a]][i] = 0.0


@inner
def find_coupled(contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """List the active contacts that accelerate each contact: in a rack, a third at most."""
    for i in range(len(contacts)):
        found = 0
        for j in range(len(contacts)):
            if state.is_active(contacts[j]) and feels(ws, i, j):
                ws.coupled[i][found] = j
                found += 1
        ws.coupled[i][found] = -1


@inner
def feels(ws: state.Workspace, i: int, j: int) -> bool:
    """Whether any force at contact j accelerates contact i."""
    for row in range(3 * i, 3 * i + 3):
        for column in range(3 * j, 3 * j + 3):
            if ws.reduced[row][column] != 0.0:
                return True
    return False


@inner
def minimize_over_disc(
    axx: float, axy: float, ayy: float, bx: float, by: float, radius: float
) -> tuple[float, float]:
    """
    Minimise F.A.F/2 + b.F over the disc |F| <= radius, for a symmetric semidefinite 2x2 A.

    Inside, F = -A^-1 b: the contact sticks. Else F = -(A + kappa)^-1 b with the one kappa >= 0
    that puts it on the rim: the contact starts to slip along kappa F = -(A F + b).
    """
    if radius <= 0.0:
        return 0.0, 0.0
    mean, half = 0.5 * (axx + ayy), 0.5 * (axx - ayy)
    spread = sqrt(half * half + axy * axy)
    high, low = mean + spread, max(mean - spread, 0.0)
    angle = 0.5 * atan2(axy, half)
    c, s = cos(angle), sin(angle)
    p, q = c * bx + s * by, -s * bx + c * by  # b in the principal axes
    kappa = 0.0
    tiny = 1e-14 * high
    u, v = p / max(high, 1e-300), q / max(low, tiny, 1e-300)
    inside = u * u + v * v <= radius * radius
    if not inside:
        size = sqrt(p * p + q * q)
        lower, upper = max(0.0, size / radius - high), size / radius
        kappa = max(lower, 0.0)
        for _ in range(60):  # Newton on 1/|F| - 1/radius, concave and increasing in kappa
            x, y = p / max(high + kappa, 1e-300), q / max(low + kappa, 1e-300)
            norm2 = x * x + y * y
            norm = sqrt(norm2)
            if norm > radius:
                lower = kappa
            else:
                upper = kappa
            slope = (x * x / max(high + kappa, 1e-300) + y * y / max(low + kappa, 1e-300)) / max(
                norm2, 1e-300
            )
            step = (norm / radius - 1.0) / max(slope, 1e-300)
            trial = kappa + step
            if not lower <= trial <= upper:
                trial = 0.5 * (lower + upper)
            if abs(trial - kappa) <= 1e-16 * (high + trial):
                kappa = trial
                break
            kappa = trial
    x = -p / max(high + kappa, 1e-300)
    y = -q / max(low + kappa, tiny if kappa == 0.0 else 1e-300, 1e-300)
    if not inside:
        norm = radius / max(sqrt(x * x + y * y), 1e-300)
        x *= norm
        y *= norm
    return c * x - s * y, s * x + c * y


@inner
def acceleration(
    contacts: list[state.ContactState], ws: state.Workspace, row: int, force: Floats, without: int
) -> tuple[float, float]:
    """
    Acceleration of one contact velocity under all forces but two, and its rounding scale.

    The two are components `without` and `without` + 1 of the forces.
    """
    total = 0.0
    scale = 0.0
    for i in range(3 * len(contacts)):
        if i != without and i != without + 1:
            total += ws.delassus[row][i] * force[i]
            scale += abs(ws.delassus[row][i] * force[i])
    return total, scale


@inner
def solve_stick_friction(
    contacts: list[state.ContactState], ws: state.Workspace, force: Floats
) -> None:
    """
    Find the friction of the contacts without slip, given all other forces.

    Gauss's principle of least constraint: among the friction forces inside their discs, the real
    ones minimise F.W.F/2 + b.F (a convex problem, b the slip acceleration without them). Projected
    Gauss-Seidel: contact by contact, until no force changes.
    """
    w = ws.delassus
    largest = 0.0
    for i in range(3 * len(contacts)):
        largest = max(largest, abs(force[i]))
    for _ in range(METHOD_OPTIONS.max_friction_sweeps):
        change = 0.0
        for j in range(len(contacts)):
            c = contacts[j]
            if state.is_active(c) and state.sticks(c):
                x, y = 3 * j + 1, 3 * j + 2
                bx, _scale = acceleration(contacts, ws, x, force, x)
                by, _scale = acceleration(contacts, ws, y, force, x)
                fx, fy = minimize_over_disc(
                    w[x][x], w[x][y], w[y][y], bx, by, c.friction * force[3 * j]
                )
                change = max(change, abs(fx - force[x]), abs(fy - force[y]))
                force[x], force[y] = fx, fy
        if change <= 1e-16 * largest:
            break


@inner
def exceeds_cone(
    contacts: list[state.ContactState], ws: state.Workspace, force: Floats, j: int, noise: float
) -> tuple[bool, float, float]:
    """Whether a contact cannot stick under these forces; then also the direction of its slip."""
    c = contacts[j]
    x, y = 3 * j + 1, 3 * j + 2
    ax, scale_x = acceleration(contacts, ws, x, force, -2)
    ay, scale_y = acceleration(contacts, ws, y, force, -2)
    size = sqrt(ax * ax + ay * ay)
    used = sqrt(force[x] * force[x] + force[y] * force[y])
    rim = c.friction * force[3 * j]
    exceeds = used >= rim * (1.0 - METHOD_OPTIONS.cone_margin) and size > noise * (
        scale_x + scale_y
    )
    return (True, ax / size, ay / size) if exceeds else (False, 0.0, 0.0)


@inner
def start_slip_onsets(
    contacts: list[state.ContactState], ws: state.Workspace, force: Floats
) -> None:
    """Let the contacts slip that cannot stick under the forces of `solve_stick_friction`."""
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c) and state.sticks(c):
            exceeds, along_1, along_2 = exceeds_cone(
                contacts, ws, force, j, METHOD_OPTIONS.onset_noise
            )
            if exceeds:
                c.friction_mode = state.SLIP_ONSET
                c.slip_dir_1, c.slip_dir_2 = along_1, along_2


@inner
def start_slip(contacts: list[state.ContactState], ws: state.Workspace, j: int) -> None:
    """
    Let a sticking contact begin to slip along its slip direction, if the other contacts allow it.

    If contacts share a constraint, the others may hold a contact whose own share of the friction
    (least norm) is outside its cone. All stick as long as some division of the friction can hold
    them.
    """
    c = contacts[j]
    c.friction_mode = state.SLIP_ONSET
    eliminate_sticking(contacts, ws)
    if yields_along(ws, j, c.slip_dir_1, c.slip_dir_2):
        state.stop_slip(c)
    else:
        c.friction_mode = state.REDUNDANT_STICK
        eliminate_sticking(contacts, ws)


@inner
def yields_along(ws: state.Workspace, j: int, d: float, e: float) -> bool:
    """Whether a force along the tangent (d, e) of a contact moves it along that tangent."""
    x, y = 3 * j + 1, 3 * j + 2
    one, mixed, two = ws.reduced[x][x], ws.reduced[x][y], ws.reduced[y][y]
    limit = METHOD_OPTIONS.min_yield * max(ws.delassus[x][x], ws.delassus[y][y])
    mean, half = 0.5 * (one + two), 0.5 * (one - two)
    if mean - sqrt(half * half + mixed * mixed) > limit:
        return True
    # The other contacts hold it along one tangent at least.
    u, v = one * d + mixed * e, mixed * d + two * e
    return sqrt(u * u + v * v) > limit and abs(d * v - e * u) <= limit


@inner
def sticking_is_feasible(
    contacts: list[state.ContactState], ws: state.Workspace, order: int, x: float
) -> bool:
    """Whether any division of friction keeps the contacts without slip in place at x."""
    force = ws.vector[0]
    for j in range(len(contacts)):
        c, n = contacts[j], 3 * j
        force[n] = evaluate(c.force, order - 1, x) if state.is_active(c) else 0.0
        force[n + 1] = evaluate(c.friction_1, order - 1, x) if state.resists(c) else 0.0
        force[n + 2] = evaluate(c.friction_2, order - 1, x) if state.resists(c) else 0.0
    solve_stick_friction(contacts, ws, force)
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c) and state.sticks(c):
            exceeds, _along_1, _along_2 = exceeds_cone(
                contacts, ws, force, j, METHOD_OPTIONS.division_noise
            )
            if exceeds:
                return False
    return True


@inner
def assign_friction_modes(
    contacts: list[state.ContactState], ws: state.Workspace, least: float
) -> None:
    """
    Give every active contact its friction mode, and eliminate the friction of those that stick.

    Contacts that slip keep slipping. The others stick or start to slip, depending on the present
    forces or, if all springs are still empty, on the forces of the next moment. Slip up to `least`
    counts as zero.
    """
    force = ws.vector[0]
    loaded = False
    waiting = False
    for j in range(len(contacts)):
        loaded = loaded or (state.is_active(contacts[j]) and contacts[j].compression[0] > 0.0)
        for i in range(3):
            force[3 * j + i] = 0.0
    for j in range(len(contacts)):
        c, n = contacts[j], 3 * j
        if c.normal_mode == state.INACTIVE:
            c.friction_mode = state.FRICTIONLESS
            continue
        if c.friction_mode == state.ELASTIC:
            force[n + 1], force[n + 2] = state.elastic_friction(c, 0)
            continue
        pressed = c.compression[0] if loaded else max(-c.velocity[0], 0.0)
        if c.shear > 0.0:
            begin_shear(c)
            force[n], force[n + 1], force[n + 2] = present_force(c, loaded)
            continue
        force[n] = c.stiffness * pressed**c.exponent
        if c.friction == 0.0 or c.friction_mode == state.DEFERRED:
            continue
        slip = state.slip_speed(c)
        if slip > least:
            if c.friction_mode != state.CREEP:
                c.friction_mode = state.SLIP
            c.slip_dir_1, c.slip_dir_2 = c.slip_1[0] / slip, c.slip_2[0] / slip
        elif c.friction_mode != state.SLIP_ONSET:
            state.stop_slip(c)
            c.friction_mode = state.STICK
            waiting = True
        if state.slips(c):
            rub = state.friction_at(c, slip) * force[n]
            force[n + 1], force[n + 2] = -rub * c.slip_dir_1, -rub * c.slip_dir_2
    if waiting:
        solve_stick_friction(contacts, ws, force)
        start_slip_onsets(contacts, ws, force)
    eliminate_sticking(contacts, ws)
