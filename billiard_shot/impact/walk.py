"""
The walk through the states of a collision, step by step, until nothing is pressed or approaches.

Each step is a polynomial (series.py, or collocation.py where slip has just begun or only creeps);
what ends it is its first event (events.py), which changes the state (transitions.py).
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal, inlined
from billiard_shot.impact.advance import advance, ROUNDING
from billiard_shot.impact.collocation import implicit_step
from billiard_shot.impact.events import CONE, EMPTY, END, first_event, JOIN, NOTHING, SWING
from billiard_shot.impact.fading import fades
from billiard_shot.impact.friction import holds, settle
from billiard_shot.impact.laws import elastic_energy
from billiard_shot.impact.leaps import abandon, next_swing, NO_LEAP, TAKEN_BACK
from billiard_shot.impact.series import expand, step_size
from billiard_shot.impact.standstill import MOVES, stand, STOPPED
from billiard_shot.impact.state import (
    COLUMNS,
    INACTIVE,
    Model,
    Room,
    SLIDING,
    slip_speed,
    STAGES,
    State,
    stop_slip,
)
from billiard_shot.impact.swings import (
    ALIKE,
    can_leap,
    follow,
    listen,
    QUIET,
    STEPS,
    Swings,
    watch,
    WATCHING,
)
from billiard_shot.impact.transitions import part, slide_against, transition
from billiard_shot.status import Status

MAX_STEPS = 200_000  # of a collision,
STEPS_EACH = 25_000  # or so many a contact, where that is more
IMPLICIT = 4  # steps that an implicit one counts for, times the square of its young contacts
FLOOR = 10  # why a phase ended, beside the events END, JOIN and EMPTY: the energy floor
PINNED_STEP = 0.005  # longest step while contacts hold beyond their own cones
PRECISE = 1e-17  # tolerance while swings are sampled, whose errors are multiplied; of velocities
ROUNDED = 1e-16  # tolerance of a step, at least: velocities may come to be far above the first
CAUTION = 0.2  # part of the tolerance that a step may use up,
USUAL_STEPS = 300  # of so many; where there are more, their errors would add up
NO_SLIP = 0.02  # slip below this part of the tolerance is none
GLANCE = 16  # steps without an event after which velocities may have grown unnoticed
JAMMED = 1e-12  # normal velocity of contacts that do not move, in units of the largest
FINEST = 1e-15  # tolerance of implicit steps, at least, in units of the velocities
STRICTER = 0.1  # tolerance of implicit steps, whose errors count for more, against the others
FIRST = 0.3  # length of a first implicit step against an explicit one
LONGEST = 1e100  # step: nothing may be left that would end it
CREEP = 0.01  # explicit steps shorter than this, CREEP_STEPS in a row, mean that slip creeps
CREEP_STEPS = 8
AHEAD = 1e3  # then those become implicit that would not allow steps longer by this
STAY = 10.0  # and they stay implicit until slip allows explicit steps longer by this
CREEPING = 2  # kind of a young contact: one that has not just begun to slide

OK = int(Status.OK)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
NEGATIVE_ENERGY = int(Status.NEGATIVE_ENERGY)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@frugal
def excitation(m: Model, s: State) -> float:
    """Largest normal velocity that a contact has, or that its spring could still give."""
    largest = 0.0
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.phase == INACTIVE:
            largest = max(largest, -s.u[3 * j, 0])
        else:
            energy = elastic_energy(c.stiffness, s.y[j, 0], m.exponent)
            spring = np.sqrt(2.0 * energy * m.response[3 * j, 3 * j])
            largest = max(largest, abs(s.u[3 * j, 0]), spring)
    return largest


@frugal
def fade(m: Model, s: State, stirred: float) -> None:
    """Set the compressions below which forces are negligible and need not be expanded."""
    for j in range(len(s.contact)):
        c = s.contact[j]
        c.faint = (1e-3 * m.tolerance * stirred / c.stiffness) ** (1.0 / m.exponent)


@frugal
def explicit_step(
    m: Model, s: State, scale: float, order: int, tolerance: float
) -> tuple[float, float]:
    """Expand the state; return the scale that did not overflow, and the length in its units."""
    length = 0.0
    while length == 0.0 and scale > 1e-100:
        expand(m, s, scale, order)
        length = step_size(m, s, order, tolerance)
        if length == 0.0:
            scale *= 1e-3
    return scale, length


@frugal
def turning(m: Model, s: State, j: int) -> float:
    """How fast a contact's own friction can change its slip."""
    c = s.contact[j]
    own = max(s.effective[3 * j + 1, 3 * j + 1], s.effective[3 * j + 2, 3 * j + 2])
    return float(own * c.friction * c.stiffness * s.y[j, 0] ** m.exponent)


@frugal
def creeps(m: Model, s: State, j: int, length: float) -> bool:
    """Whether a contact slides too slowly for an explicit step of a length."""
    return slip_speed(s, j) < 0.1 * length * turning(m, s, j)


@frugal
def mature(m: Model, s: State, length: float) -> None:
    """Release from implicit steps the contacts that an explicit step of like length follows."""
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.young and not creeps(m, s, j, length * (STAY if c.young == CREEPING else 1.0)):
            c.young = 0


@frugal
def record(
    m: Model, s: State, log: NDArray[np.float64], row: int, reason: int, contact: int
) -> None:
    """Write a phase that ends now, while the log has room."""
    if row >= log.shape[0]:
        return
    count = len(s.contact)
    log[row, 0] = reason
    log[row, 1] = contact
    for j in range(count):
        c = s.contact[j]
        log[row, 2 + j] = 1.0 if c.phase != INACTIVE else 0.0
        log[row, 2 + 4 * count + j] = elastic_energy(c.stiffness, s.y[j, 0], m.exponent)
    for i in range(3 * count):
        log[row, 2 + count + i] = s.impulse[i]


@frugal
def is_over(s: State) -> bool:
    """Whether no contact is active and none approaches."""
    for j in range(len(s.contact)):
        if s.contact[j].phase != INACTIVE or s.u[3 * j, 0] < -ROUNDING:
            return False
    return True


@frugal
def begin(m: Model, s: State) -> tuple[int, bool]:
    """Prepare a step: note slip directions, light contacts; count young ones, look for pinned."""
    young = 0
    pinned = False
    for j in range(len(s.contact)):
        c = s.contact[j]
        young += c.young != 0
        pinned = pinned or c.pinned != 0
        c.light = m.exponent != 1.0 and s.y[j, 0] < c.faint
        if c.grip == SLIDING and not c.onset and not m.straight:
            size = slip_speed(s, j)
            c.toward_x = s.u[3 * j + 1, 0] / size
            c.toward_y = s.u[3 * j + 2, 0] / size
    return young, pinned


@frugal
def give_up(m: Model, s: State, log: NDArray[np.float64], row: int) -> None:
    """Write the last phase, and end all contacts."""
    record(m, s, log, row, FLOOR, -1)
    for j in range(len(s.contact)):
        if s.contact[j].phase != INACTIVE:
            part(m, s, j)


@frugal
def hold_back(s: State) -> None:
    """
    Let contacts that are to slide before they press in earnest wait until they do.

    Where many contacts join at once the springs load one after the other, as ever higher powers of
    time: the first is under way before anything can be said of the last.
    """
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.young and s.y[j, 0] < c.faint:
            c.idle = 1
            c.onset = 0
            c.young = 0


@frugal
def calm(s: State, tolerance: float) -> None:
    """Take back the slips that were to begin, but could not. What slips in earnest goes on."""
    hold_back(s)
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.young and slip_speed(s, j) <= tolerance:
            stop_slip(s, j)
            c.onset = 0
        c.young = 0


@frugal
def wakes(s: State) -> bool:
    """Whether a contact that waited for friction has come to press in earnest."""
    awake = False
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.idle and s.y[j, 0] >= (1.0 - 1e-9) * c.faint:
            c.idle = 0
            awake = True
    return awake


@frugal
def has_stopped(s: State, least: float) -> bool:
    """Whether the slip of a sliding contact has come to nothing."""
    for j in range(len(s.contact)):
        if s.contact[j].grip == SLIDING and slip_speed(s, j) <= least:
            return True
    return False


@frugal
def is_jammed(s: State) -> bool:
    """Whether the active contacts are pressed together for good: nothing moves, nor will."""
    size = s.u.shape[0]
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.phase == INACTIVE:
            if s.u[3 * j, 0] < 0.0:
                return False
            continue
        if abs(s.u[3 * j, 0]) > JAMMED or c.grip == SLIDING:
            return False
        push = 0.0
        size_of_push = 0.0
        for k in range(size):
            if s.contact[k // 3].phase != INACTIVE:
                push += s.effective[3 * j, k] * s.force[k, 0]
                size_of_push += abs(s.effective[3 * j, k] * s.force[k, 0])
        if abs(push) > ROUNDING * size_of_push:
            return False
    return True


@frugal
def slow_down(m: Model, s: State, length: float) -> None:
    """
    Let what slides too slowly for explicit steps of a length continue in implicit ones.

    One that does so alone goes on for long. Several may share a constraint: how they divide their
    friction then has no continuous answer, and long steps would make one up.
    """
    found = 0
    for j in range(len(s.contact)):
        c = s.contact[j]
        c.young = c.grip == SLIDING and creeps(m, s, j, length)
        found += c.young != 0
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.young and found <= 2:
            c.young = CREEPING


@inlined
def run(
    m: Model, s: State, room: Room, w: Swings, log: NDArray[np.float64]
) -> tuple[int, int, int]:
    """Walk through the states of a collision; return its status, numbers of phases and steps."""
    usual_order = min(max(int(4.5 - np.log10(m.tolerance)), 6), COLUMNS - 4)
    floor = max(1e-2 * m.tolerance, 10.0 * ROUNDING)
    swings = w.now[0]
    leaps = can_leap(m, s)
    status = OK
    phases = 0
    creeping = 0
    scale = 1.0
    stirred = 1.0
    moved = False  # since the last change of state
    unsettled = True
    young = 0
    quiet = 0  # steps since the last event
    spent = 0
    budget = max(MAX_STEPS, STEPS_EACH * len(s.contact))
    while spent < budget:
        spent += 1 + IMPLICIT * young * young
        swings.steps += 1
        leaping = swings.node != WATCHING
        if unsettled:
            stirred = excitation(m, s)
        elif quiet % GLANCE == GLANCE - 1:
            stirred = max(stirred, excitation(m, s))
        fine = m.tolerance * max(stirred, 1.0)  # velocities below are none, in the end
        no_slip = NO_SLIP * fine
        if unsettled:
            settle(m, s, room, no_slip)
            unsettled = False
            fade(m, s, min(stirred, 1.0))
            if stirred < floor and not leaping:
                give_up(m, s, log, phases)
                return INFINITE_SEQUENCE, phases + 1, spent
        was_young = young
        young, pinned = begin(m, s)
        order = COLUMNS - 4 if leaping else usual_order
        share = CAUTION * m.tolerance * min(1.0, USUAL_STEPS / spent)
        tolerance = PRECISE * stirred
        if not leaping:
            tolerance = max(share * min(stirred, 1.0), ROUNDED * stirred)
        degree, noise, end, error = order, 0.0, 1.0, tolerance
        if leaping and (pinned or stirred < floor or swings.steps > STEPS):
            scale = 0.0
        elif young:
            if not was_young:
                scale *= FIRST
            degree = STAGES
            tolerance = max(STRICTER * tolerance, FINEST * stirred)
            scale, error = implicit_step(m, s, room, scale, tolerance)
            noise = error / stirred
        else:
            noise = max(ROUNDING, tolerance / stirred)
            scale, end = explicit_step(m, s, scale, order, tolerance)
        if scale == 0.0 and leaping:
            abandon(m, s, w)
            unsettled = True
            scale = swings.scale
            continue
        if scale == 0.0:
            calm(s, fine)
            unsettled = True
            scale = 1.0
            continue
        if not m.straight and not young and not pinned:
            fate = stand(m, s, room, scale, end, tolerance)
            if fate != MOVES:
                moved = True
                unsettled = fate == STOPPED
                scale = 1.0
                continue
        if not young and not leaping and is_jammed(s):
            give_up(m, s, log, phases)
            return status, phases + 1, spent
        if pinned:
            end = min(end, PINNED_STEP / scale)
        quiet += 1
        if quiet == QUIET and leaps:
            listen(w)
        x, event, j = first_event(
            m, s, scale, degree, noise, stirred, end, swings.event == SWING
        )
        known = x > 0.0 or (j >= 0 and s.contact[j].still != 0)
        if event == CONE:
            slide_against(s, j, degree, x)
        if x > 0.0:
            moved = True
            unsettled = pinned and not holds(m, s, room, degree, x)
            advance(s, scale, degree, x)
            unsettled = unsettled or (not m.straight and has_stopped(s, no_slip))
            if young:
                mature(m, s, scale)
        if swings.alike == ALIKE - 1:
            follow(s, w)
        unsettled = wakes(s) or unsettled
        if event in (JOIN, END, EMPTY) and not leaping:
            if moved:
                record(m, s, log, phases, event, j)
                phases += 1
            moved = False
        if event == EMPTY:
            status = NEGATIVE_ENERGY
        if event != NOTHING:
            unsettled = transition(m, s, room, event, j, known) or unsettled
        if event == CONE and young > 1:  # one after the other, they would begin for ever
            hold_back(s)
            unsettled = True
        if is_over(s) and not leaping:
            return status, phases, spent
        if young:
            scale *= min(max(0.8 * (tolerance / max(error, 1e-300)) ** (1.0 / STAGES), 0.2), 4.0)
        else:
            scale *= min(max(end, 1e-3), 1e3)
            creeping = creeping + 1 if event == NOTHING and x == end and scale < CREEP else 0
            if creeping >= CREEP_STEPS and not m.straight and not leaping:
                creeping = 0
                slow_down(m, s, AHEAD * scale)
        scale = min(scale, LONGEST)
        if event not in (NOTHING, SWING):
            quiet = 0
        if event != NOTHING and leaps and watch(s, w, event, j):
            if swings.node == WATCHING and fades(m, s, w):
                give_up(m, s, log, phases)
                return INFINITE_SEQUENCE, phases + 1, spent
            leap = next_swing(m, s, w, scale, share, stirred)
            if leap != NO_LEAP:
                scale = swings.scale
            unsettled = unsettled or leap == TAKEN_BACK
    if swings.node != WATCHING:
        abandon(m, s, w)
    return BUDGET_EXCEEDED, phases, spent
