"""
Pressed contacts of bodies that move take their normals anew (moving_bodies.py).

Between two such moments a normal stays. For half an interval h it is n + n' h + n'' h^2 / 3, which
is nearly that of the middle, n + n' h + n'' h^2 / 2. With that of the middle the impulses of a
force F would miss F n'' h^3 / 3 + 2 F' n' h^3 / 3 in each interval. From a contact's beginning to
its end, where F is zero, the second terms add up to minus twice the first ones.

The slip of a contact that sticks is zero along the old tangents, not along the new ones. A
friction impulse makes it zero again. It is the impulse of the force that turns the slip with the
tangents, over one interval. If friction has no room for that force beside the others, contacts
slip instead. That impulse reaches half an interval ahead, so a contact that is about to slip or to
end takes the normal of that moment first.
"""

from billiard_shot.compiled import inner
from billiard_shot.impact.friction import eliminate_sticking
from billiard_shot.impact.moving_bodies import (
    measure,
    push_bodies,
    take_normal,
    velocity_of,
    VELOCITY_ROWS,
)
from billiard_shot.impact.shear import shear_force
from billiard_shot.impact.state import (
    ContactState,
    ELASTIC,
    elastic_friction,
    friction_at,
    is_active,
    Model,
    shears,
    slip_speed,
    slips,
    sticks,
    Workspace,
)
from billiard_shot.impact.taylor import fill_stick_forces


@inner
def turn_normals(m: Model, contacts: list[ContactState], ws: Workspace) -> bool:
    """
    Take the normals of all pressed contacts anew that do not keep them.

    Returns whether friction modes stay as they are; then sticking friction is eliminated already.
    """
    for j in range(len(contacts)):
        if is_active(contacts[j]) and not contacts[j].keeps_normal:
            take_normal(m.planar, contacts, ws, j, 0.5 * m.interval)
    some_stick = find_stopping_impulses(contacts, ws)
    if some_stick and not have_room(m, contacts, ws):
        return False
    if some_stick:
        stop_slips(m, contacts, ws)
    return True


@inner
def turn_now(m: Model, contacts: list[ContactState], ws: Workspace, j: int) -> None:
    """Take the normal of this moment at a contact that sticks."""
    take_normal(m.planar, contacts, ws, j, 0.0)
    contacts[j].is_turned = True
    find_stopping_impulses(contacts, ws)
    stop_slips(m, contacts, ws)


@inner
def find_stopping_impulses(contacts: list[ContactState], ws: Workspace) -> bool:
    """
    Write the impulses (3 N,) that stop all slip of sticking contacts into a scratch vector.

    Returns whether any contact sticks.
    """
    eliminate_sticking(contacts, ws)  # leaves the inverse of the sticking part of W
    stuck, inverse, impulses = ws.indices, ws.matrix[1], ws.vector[0]
    count = 0
    for j in range(len(contacts)):
        if is_active(contacts[j]) and sticks(contacts[j]):
            count += 2
    for a in range(count):
        impulses[stuck[a]] = 0.0
        for b in range(count):
            c = contacts[stuck[b] // 3]
            slip = c.slip_1[0] if stuck[b] % 3 == 1 else c.slip_2[0]
            impulses[stuck[a]] -= inverse[a][b] * slip
    return count > 0


@inner
def have_room(m: Model, contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether the friction of each sticking contact can have its impulse in one interval."""
    impulses = ws.vector[0]
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c):
            c.force[0] = c.stiffness * c.compression[0] ** c.exponent
            if shears(c):
                c.force[0], c.friction_1[0], c.friction_2[0] = shear_force(
                    c, c.compression[0], c.shift_1[0], c.shift_2[0]
                )
            elif c.friction_mode == ELASTIC:
                c.friction_1[0], c.friction_2[0] = elastic_friction(c, 0)
            elif slips(c):
                rub, slip = friction_at(c, slip_speed(c)) * c.force[0], max(slip_speed(c), 1e-300)
                c.friction_1[0] = -rub * c.slip_1[0] / slip
                c.friction_2[0] = -rub * c.slip_2[0] / slip
    fill_stick_forces(contacts, ws, 1)
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c) and sticks(c):
            x = c.friction_1[0] + impulses[3 * j + 1] / m.interval
            y = c.friction_2[0] + impulses[3 * j + 2] / m.interval
            rim = c.friction * c.force[0]
            if x * x + y * y > rim * rim:
                return False
    return True


@inner
def stop_slips(m: Model, contacts: list[ContactState], ws: Workspace) -> None:
    """Apply the impulses that stop the slip of sticking contacts; count their work as lost."""
    impulses, push = ws.vector[0], ws.residual
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c) and sticks(c):
            push[0], push[1], push[2] = 0.0, impulses[3 * j + 1], impulses[3 * j + 2]
            push_bodies(ws, c, push, VELOCITY_ROWS, 0)
            c.impulse_1 += push[1]
            c.impulse_2 += push[2]
            c.friction_loss -= 0.5 * (push[1] * c.slip_1[0] + push[2] * c.slip_2[0])
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c):
            c.velocity[0], c.slip_1[0], c.slip_2[0] = velocity_of(c, ws)
            if m.planar:
                c.slip_2[0] = 0.0
        else:
            measure(c, ws)
