"""What an event does to the state of a collision: the arrows of the state transition diagram."""

import numpy as np

from billiard_shot.compiled import frugal
from billiard_shot.impact.events import CONE, EMPTY, JOIN, SLIP_STOP, SWING, TURN
from billiard_shot.impact.friction import hold, let_go
from billiard_shot.impact.laws import (
    BISTIFFNESS,
    elastic_energy,
    end_of_restitution,
    opening_rate,
    POISSON,
)
from billiard_shot.impact.polynomial import evaluate
from billiard_shot.impact.state import (
    COMPRESSING,
    FRICTIONLESS,
    INACTIVE,
    Model,
    RESTORING,
    Room,
    SLIDING,
    slip_speed,
    State,
    STICKING,
    stop_slip,
)


@frugal
def opening_loss(m: Model, s: State, j: int) -> float:
    """Energy lost while a spring opened from its peak: law bistiffness gives back e^2 of it."""
    c = s.contact[j]
    if m.law != BISTIFFNESS:
        return 0.0
    e = c.restitution
    peak = elastic_energy(c.stiffness, c.peak, m.exponent)
    return (1.0 - e * e) * (peak - elastic_energy(c.stiffness, s.y[j, 0], m.exponent))


@frugal
def normal_acceleration(m: Model, s: State, j: int) -> float:
    """Acceleration of a contact's normal velocity under the forces of this moment."""
    total = 0.0
    for k in range(len(s.contact)):
        c = s.contact[k]
        if c.phase != INACTIVE:
            response = s.effective[3 * j, 3 * k]
            if c.grip == SLIDING:
                response -= c.friction * s.effective[3 * j, 3 * k + 1] * c.toward_x
                response -= c.friction * s.effective[3 * j, 3 * k + 2] * c.toward_y
            total += response * c.stiffness * s.y[k, 0] ** m.exponent
    return total


@frugal
def margin_of_end(m: Model, s: State, j: int) -> float:
    """
    How much compression a contact that ends would still have lost before it was compressed anew.

    In parts of its peak; infinite where it was not about to be. Small: had it had a little more
    left, it would not have ended.
    """
    c = s.contact[j]
    if m.law == POISSON or c.phase != RESTORING or c.restitution == 0.0:
        return np.inf
    acceleration = normal_acceleration(m, s, j)
    if acceleration >= 0.0:
        return np.inf
    return float(s.u[3 * j, 0] ** 2 / (-2.0 * acceleration * c.peak))


@frugal
def turn(m: Model, s: State, j: int) -> None:
    """End a contact's compression, or begin it anew."""
    c = s.contact[j]
    s.u[3 * j, 0] = 0.0
    c.still = True
    if c.phase == COMPRESSING:
        c.phase = RESTORING
        c.peak = s.y[j, 0]
        c.rate = opening_rate(m.law, c.restitution)
        c.goal = end_of_restitution(m.law, c.restitution, m.exponent, s.y[j, 0])
        if m.law == POISSON:
            c.goal = s.impulse[3 * j] + c.restitution * (s.impulse[3 * j] - c.begun)
    else:
        if m.law != POISSON:
            c.tie = min(c.tie, (s.y[j, 0] - c.goal) / c.peak)
        c.phase = COMPRESSING
        c.rate = 1.0
        c.kept += opening_loss(m, s, j)


@frugal
def join(s: State, j: int, known: bool) -> None:
    """Make a contact active; `known`: its normal velocity is just now passing zero."""
    c = s.contact[j]
    c.phase = COMPRESSING
    c.grip = FRICTIONLESS
    s.y[j, 0] = 0.0
    c.rate = 1.0
    c.begun = s.impulse[3 * j]
    c.idle = 0
    if known:
        s.u[3 * j, 0] = 0.0
        c.still = True


@frugal
def part(m: Model, s: State, j: int) -> None:
    """End a contact: book the energy that its spring keeps, and note the slip it ends with."""
    c = s.contact[j]
    c.kept += opening_loss(m, s, j) if c.phase == RESTORING else 0.0
    c.kept += elastic_energy(c.stiffness, s.y[j, 0], m.exponent)
    c.last_slip = 0.0 if c.grip == STICKING else slip_speed(s, j)
    c.phase = INACTIVE
    c.grip = FRICTIONLESS
    s.y[j, 0] = 0.0
    c.still = s.u[3 * j, 0] == 0.0  # where it had only just joined


@frugal
def complete_impulse(s: State, room: Room, j: int) -> None:
    """
    Law poisson: give a contact with an empty spring the rest of its impulse, all others untouched.

    Friction acts as before the moment (it holds, or slides until it stops); the energy that
    the spring does not have is booked as a negative loss.
    """
    c = s.contact[j]
    n = 3 * j
    size = s.u.shape[0]
    remaining = c.goal - s.impulse[n]
    push, change = room.push[0], room.push[1]
    while remaining > 0.0:
        dx, dy = c.toward_x, c.toward_y
        for row in range(size):
            push[row] = s.gain[row, n]
        push[n] = 1.0
        if c.grip == SLIDING:
            push[n + 1], push[n + 2] = -c.friction * dx, -c.friction * dy
        for row in range(size):
            change[row] = s.effective[row, n]
            if c.grip == SLIDING:
                change[row] += s.effective[row, n + 1] * push[n + 1]
                change[row] += s.effective[row, n + 2] * push[n + 2]
        amount = remaining
        slip = s.u[n + 1, 0] * dx + s.u[n + 2, 0] * dy
        rate = change[n + 1] * dx + change[n + 2] * dy
        if c.grip == SLIDING and slip + rate * amount < 0.0:
            amount = -slip / rate
        for row in range(n, n + 3):
            work = amount * push[row] * (s.u[row, 0] + 0.5 * amount * change[row])
            if row == n:
                c.kept -= work
            else:
                c.rubbed -= work
        for row in range(size):
            s.u[row, 0] += amount * change[row]
            s.impulse[row] += amount * push[row]
        remaining -= amount
        if remaining > 0.0:
            # It stopped; the springs of the others set no direction.
            c.grip = FRICTIONLESS


@frugal
def slide_against(s: State, j: int, order: int, x: float) -> None:
    """Begin to slide at x: against the force that held until then."""
    c = s.contact[j]
    fx, fy = evaluate(s.force[3 * j + 1], order - 1, x), evaluate(s.force[3 * j + 2], order - 1, x)
    for k in range(order):
        if x == 0.0 and fx == 0.0 and fy == 0.0:
            fx, fy = s.force[3 * j + 1, k], s.force[3 * j + 2, k]
    size = np.sqrt(fx * fx + fy * fy)
    c.toward_x = -fx / size
    c.toward_y = -fy / size


@frugal
def transition(m: Model, s: State, room: Room, event: int, j: int, known: bool) -> bool:
    """Carry out an event at contact j; True where forces jumped, so that friction must settle."""
    if event == TURN:
        turn(m, s, j)
        return False
    if event == SWING:
        s.contact[j].armed = False
        return False
    if event == CONE:
        let_go(m, s, room, j)
        return False
    if event == SLIP_STOP:
        c = s.contact[j]
        stop_slip(s, j)
        if c.onset:  # what was to begin is less than noise: it holds
            c.onset = False
            c.grip = STICKING
            hold(m, s, room)
            return False
    elif event == JOIN:
        join(s, j, known)
    else:
        if event == EMPTY:
            complete_impulse(s, room, j)
        s.contact[j].tie = min(s.contact[j].tie, margin_of_end(m, s, j))
        part(m, s, j)
    return True
