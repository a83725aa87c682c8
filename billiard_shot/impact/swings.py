"""
Swings that repeat: how they are noticed, and what changes from one to the next.

Where a stiff contact swings, or is left and met again, while a soft one is slowly pressed, a
collision goes through one and the same sequence of events again and again, and each time ends up
almost where it was. A swing begins where a contact is met, else where one turns to restitution,
else, where nothing happens at all, where a normal acceleration passes zero. What is done about
them: leaps.py.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, frugal
from billiard_shot.impact.events import JOIN, SWING, TURN
from billiard_shot.impact.laws import end_of_restitution, POISSON
from billiard_shot.impact.multirevolution import empty_span, Span
from billiard_shot.impact.state import CONTACT, Model, RESTORING, State

MOST = 8  # contacts: the leap's equations grow with the cube of their number
ALIKE = 24  # swings in a row that pass the same events before a leap is tried
EVENTS = 60  # in a swing, at most
STEPS = 1_500  # in a swing, at most
QUIET = 200  # steps without an event after which swings are looked for that pass without one
SHORTEST = 64  # swings of a leap: a shorter one would not pay
FIRST = 256  # swings of the first leap
PAST = 9  # ends of swings that are remembered

WATCHING, UNCHANGED = -1, -2  # in place of a node; smaller ones are columns of the Jacobian

# What is known of the swings, and of the leap that is under way.
_FIELDS = np.dtype(
    [
        ('event', np.int64),  # with which a swing begins and ends: JOIN, TURN or SWING
        ('contact', np.int64),  # where; -1: none chosen yet
        ('mark', np.int64),  # of the events since the swing began
        ('last_mark', np.int64),  # of those of the last swing
        ('leap_mark', np.int64),  # of those of the leap's first swing, followed more precisely
        ('events', np.int64),  # since the swing began
        ('steps', np.int64),  # since the swing began
        ('alike', np.int64),  # swings in a row with the same mark
        ('past', np.int64),  # ends of swings since the contact was chosen
        ('node', np.int64),  # from which a swing is under way, or WATCHING
        ('sweep', np.int64),
        ('fresh', np.int64),  # 1: nothing is known of F yet
        ('span', np.float64),  # swings that the leap shall take
        ('next_span', np.float64),
        ('tail', np.float64),  # of the last sweep: what its polynomials do not resolve
        ('nudge', np.float64),  # of the number whose column of the Jacobian is being found
        ('leapt', np.float64),  # swings so far that were leapt over
        ('scale', np.float64),  # of the first step of a swing
    ],
    align=True,
)
SWINGS = np.dtype((np.record, _FIELDS))


class Swings(NamedTuple):
    """The swings of a collision; states as long vectors, see `pack`."""

    now: NDArray[np.void]  # (1,) SWINGS
    contact: NDArray[np.void]  # (N,) CONTACT as a swing begins
    begun: NDArray[np.float64]  # (11 N,) where the swing under way began
    first: NDArray[np.float64]  # (11 N,) F at the leap's start
    reach: NDArray[np.float64]  # (5 N,) how far the numbers go within a swing
    past: NDArray[np.float64]  # (PAST, 11 N) ends of the last swings, in turn
    mark: NDArray[np.int64]  # (PAST,) of the events of each
    span: Span


@compiled
def no_swings(count: int) -> Swings:
    """For a collision of N contacts that has not begun."""
    room = count if count <= MOST else 0
    swings = Swings(
        np.zeros(1, SWINGS),
        np.zeros(count, CONTACT),
        np.empty(11 * room),
        np.empty(11 * room),
        np.zeros(5 * room),
        np.empty((PAST, 11 * room)),
        np.zeros(PAST, np.int64),
        empty_span(11 * room, 5 * room),
    )
    now = swings.now[0]
    now.contact, now.node, now.next_span = -1, WATCHING, FIRST
    return swings


@frugal
def can_leap(m: Model, s: State) -> bool:
    """Whether swings are watched; law poisson has memories that are not followed."""
    return m.law != POISSON and len(s.contact) <= MOST


@frugal
def pack(s: State, x: NDArray[np.float64]) -> None:
    """Write all that changes from swing to swing into one vector; first what feeds back."""
    count = len(s.contact)
    for row in range(3 * count):
        x[row] = s.u[row, 0]
        x[5 * count + row] = s.impulse[row]
    for j in range(count):
        c = s.contact[j]
        x[3 * count + j], x[4 * count + j] = s.y[j, 0], c.peak
        x[8 * count + j], x[9 * count + j], x[10 * count + j] = c.kept, c.rubbed, c.last_slip


@frugal
def unpack(m: Model, s: State, w: Swings, x: NDArray[np.float64]) -> None:
    """Set the state to a vector, at the beginning of a swing."""
    count = len(s.contact)
    for row in range(3 * count):
        s.u[row, 0] = x[row]
        s.impulse[row] = x[5 * count + row]
    for j in range(count):
        tie = s.contact[j].tie
        s.contact[j] = w.contact[j]
        c = s.contact[j]
        s.y[j, 0], c.peak = x[3 * count + j], x[4 * count + j]
        c.kept, c.rubbed, c.last_slip = x[8 * count + j], x[9 * count + j], x[10 * count + j]
        c.tie = tie
        if c.phase == RESTORING:
            if w.now[0].event == TURN and j == w.now[0].contact:
                c.peak = s.y[j, 0]
            c.goal = end_of_restitution(m.law, c.restitution, m.exponent, c.peak)


@frugal
def stays_zero(w: Swings, row: int) -> bool:
    """Whether a number that feeds back is zero wherever a swing of the leap begins."""
    return bool(w.span.start[row] == 0.0 and w.first[row] == 0.0)


@frugal
def changed(m: Model, s: State, w: Swings, x: NDArray[np.float64]) -> None:
    """
    Set x to what the swing has changed.

    Velocities change by the response to its impulses: their difference would be lost in rounding
    where they are much larger. What is zero wherever a swing begins stays exactly that: a contact
    that has just been met would else be one that is a rounding error away.
    """
    pack(s, x)
    size = s.u.shape[0]
    for i in range(x.shape[0]):
        x[i] -= w.begun[i]
    for row in range(size):
        if s.u[row, 0] != 0.0 and w.begun[row] != 0.0:
            x[row] = 0.0
            for k in range(size):
                x[row] += m.response[row, k] * x[size + 2 * len(s.contact) + k]
    for row in range(w.reach.shape[0]):
        if stays_zero(w, row):
            x[row] = 0.0


@frugal
def begin_swing(s: State, w: Swings, node: int) -> None:
    """Note that a swing begins, and for which node; what only adds up is counted from zero."""
    now = w.now[0]
    now.node, now.mark, now.events, now.steps = node, 0, 0, 0
    if node != WATCHING:
        now.past = 0
        for row in range(s.u.shape[0]):
            s.impulse[row] = 0.0
        for j in range(len(s.contact)):
            s.contact[j].kept, s.contact[j].rubbed = 0.0, 0.0
    pack(s, w.begun)


@frugal
def as_velocity(m: Model, s: State, row: int) -> float:
    """Return what a number that feeds back counts as a velocity: a spring, what it can give."""
    size = s.u.shape[0]
    if row < size:
        return 1.0
    j = (row - size) % len(s.contact)
    return float(np.sqrt(s.contact[j].stiffness * m.response[3 * j, 3 * j]))


@frugal
def copy(source: NDArray[Any], x: NDArray[Any]) -> None:
    """Set one vector, of numbers or of contacts, to another."""
    for i in range(x.shape[0]):
        x[i] = source[i]


@frugal
def watch(s: State, w: Swings, event: int, j: int) -> bool:
    """Note an event; True where a swing has ended."""
    now = w.now[0]
    if sections(s, w, event, j):
        return True
    now.mark = (now.mark * 31 + 8 * j + event + 1) % 1_000_000_007
    now.events += 1
    if now.events > EVENTS:
        now.contact, now.events, now.mark, now.alike = -1, 0, 0, 0
    return False


@frugal
def sections(s: State, w: Swings, event: int, j: int) -> bool:
    """Whether an event is the one with which swings begin; where none is chosen, choose it."""
    now = w.now[0]
    if event not in (JOIN, SWING) and not (event == TURN and s.contact[j].phase == RESTORING):
        return False
    if now.contact < 0 or (event == JOIN and now.event != JOIN):
        now.event, now.contact, now.last_mark, now.alike, now.past = event, j, 0, 0, 0
    return event == now.event and j == now.contact


@frugal
def listen(w: Swings) -> None:
    """Look for swings that pass without any event from now on."""
    now = w.now[0]
    now.contact, now.event, now.alike, now.past = -1, SWING, 0, 0


@frugal
def follow(s: State, w: Swings) -> None:
    """Note how far the state has gone within the swing."""
    size = s.u.shape[0]
    for row in range(size):
        w.reach[row] = max(w.reach[row], abs(s.u[row, 0] - w.begun[row]))
    for j in range(len(s.contact)):
        w.reach[size + j] = max(w.reach[size + j], abs(s.y[j, 0] - w.begun[size + j]))
