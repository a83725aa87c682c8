"""
The safety states of the cue, as one explicit table.

It says what leads from where to where, and under which conditions. Whatever is not in it is
refused, with the reason.
"""

from collections.abc import Set
from dataclasses import dataclass
from enum import IntEnum, StrEnum


class State(IntEnum):
    """
    State of the cue.

    The numbers are part of the interface: the constants in `billiard_shot_msgs/msg/CueState` map
    to them one to one.
    """

    DISARMED = 0  # nothing moves; where everything starts and ends
    AIMING = 1  # the carriage and the incline move
    AIMED = 2  # in place, cue drawn back, waiting to be armed
    ARMED = 3  # may fire; times out
    FIRING = 4  # from the start of the stroke until the cue has stopped
    RETRACTING = 5  # draws back and rises off the table
    ESTOP = 6  # latched: emergency stop
    FAULT = 7  # latched: the mechanism did not do as told


MOVING = (State.AIMING, State.AIMED, State.ARMED, State.FIRING, State.RETRACTING)
"""States in which the mechanism is commanded, so that silence is dangerous."""

BEFORE_STROKE = (State.AIMING, State.AIMED, State.ARMED)
"""Those of them that can be left without harm: nothing has been struck."""


class Event(StrEnum):
    """What can happen to it."""

    AIM = 'aim'
    REACH = 'reach'  # the aim
    ARM = 'arm'
    FIRE = 'fire'
    BRAKED = 'braked'  # the cue has stopped after the strike
    HOME = 'home'  # drawn back and risen
    DISARM = 'disarm'
    EXPIRE = 'expire'  # armed for too long, or the order is
    INTERLOCK_LOST = 'interlock_lost'
    INTERRUPTED = 'interrupted'  # the controller did not run, or the clock jumped
    ESTOP = 'estop'
    FAIL = 'fail'
    CLEAR = 'clear'


class Condition(StrEnum):
    """What may have to be true for a transition."""

    ESTOP_FRESH = 'estop heard lately, and not pressed'
    INTERLOCK_FRESH = 'interlock heard lately, and safe'
    ARMED_LATELY = 'armed for no longer than the time-out'
    ORDER_VALID = 'the order is not expired, and no ball has moved'
    MECHANISM_FIT = 'the mechanism is heard, and its numbers make sense'
    ALONE = 'no other node commands the mechanism'
    CLOCK_RUNS = 'the clock advances, and has not jumped back'


SAFE = frozenset(
    {Condition.ESTOP_FRESH, Condition.INTERLOCK_FRESH, Condition.MECHANISM_FIT, Condition.ALONE}
)
"""What motion needs."""

_ORDER = SAFE | {Condition.ORDER_VALID, Condition.CLOCK_RUNS}

_NONE: frozenset[Condition] = frozenset()
_S, _E = State, Event
_STROKE = (_S.FIRING, _S.RETRACTING)
_ALL = tuple(State)

TABLE: dict[tuple[State, Event], tuple[State, frozenset[Condition]]] = {
    (_S.DISARMED, _E.AIM): (_S.AIMING, _ORDER),
    (_S.AIMING, _E.REACH): (_S.AIMED, SAFE),
    (_S.AIMED, _E.ARM): (_S.ARMED, _ORDER),
    (_S.ARMED, _E.FIRE): (_S.FIRING, _ORDER | {Condition.ARMED_LATELY}),
    (_S.FIRING, _E.BRAKED): (_S.RETRACTING, SAFE),
    (_S.RETRACTING, _E.HOME): (_S.DISARMED, _NONE),
    # Before the stroke nothing is lost by starting over; within it, something has gone wrong.
    **{(state, _E.EXPIRE): (_S.DISARMED, _NONE) for state in BEFORE_STROKE},
    **{(state, _E.INTERLOCK_LOST): (_S.DISARMED, _NONE) for state in BEFORE_STROKE},
    **{(state, _E.INTERLOCK_LOST): (_S.FAULT, _NONE) for state in _STROKE},
    **{(state, _E.INTERRUPTED): (_S.DISARMED, _NONE) for state in BEFORE_STROKE},
    **{(state, _E.INTERRUPTED): (_S.FAULT, _NONE) for state in _STROKE},
    **{
        (state, _E.DISARM): (_S.DISARMED, _NONE)
        for state in (_S.DISARMED, *BEFORE_STROKE, *_STROKE)
    },
    # The stronger latch stays.
    **{(state, _E.ESTOP): (_S.ESTOP, _NONE) for state in _ALL},
    **{(state, _E.FAIL): (_S.FAULT, _NONE) for state in _ALL if state is not _S.ESTOP},
    (_S.ESTOP, _E.CLEAR): (_S.DISARMED, frozenset({Condition.ESTOP_FRESH})),
    (_S.FAULT, _E.CLEAR): (
        _S.DISARMED,
        frozenset({Condition.ESTOP_FRESH, Condition.MECHANISM_FIT, Condition.ALONE}),
    ),
}
"""From state and event to the next state, and the conditions that must hold."""


@dataclass(frozen=True, slots=True)
class Decision:
    """
    Whether an event is accepted, and the state after it.

    If it is refused: the reason, and the conditions that would have to hold.
    """

    accepted: bool
    state: State
    reason: str = ''
    missing: tuple[Condition, ...] = ()


def decide(state: State, event: Event, conditions: Set[Condition]) -> Decision:
    """Look an event up in the table, under the conditions that hold."""
    if (state, event) not in TABLE:
        possible = [start.name for start, happening in TABLE if happening is event]
        return Decision(
            False,
            state,
            (f'{event}: not possible in state {state.name}, only in {", ".join(possible)}'),
        )
    after, needed = TABLE[state, event]
    missing = tuple(condition for condition in Condition if condition in needed - conditions)
    if missing:
        return Decision(False, state, f'{event}: needs: {"; ".join(missing)}', missing)
    return Decision(True, after)
