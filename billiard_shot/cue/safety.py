"""
The safety states of the cue, as one explicit table.

The table gives, for each state and event, the next state and the conditions for the transition.
An event that the table does not have is refused, with the reason.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum, StrEnum


class SafetyState(IntEnum):
    """
    State of the cue.

    The numbers are part of the interface: the constants in `billiard_shot_msgs/msg/CueState` map
    to them one to one.
    """

    DISARMED = 0  # nothing moves; the first and the last state of every shot
    AIMING = 1  # the carriage and the incline move
    AIMED = 2  # in place, cue drawn back, waiting to be armed
    ARMED = 3  # may fire; times out
    FIRING = 4  # from the start of the stroke until the cue has stopped
    RETRACTING = 5  # the cue is drawn back and raised off the table
    ESTOP = 6  # latched: emergency stop
    FAULT = 7  # latched: the mechanism did not follow its commands


MOVING = (
    SafetyState.AIMING,
    SafetyState.AIMED,
    SafetyState.ARMED,
    SafetyState.FIRING,
    SafetyState.RETRACTING,
)
"""States in which the mechanism is commanded, so that a silent input is dangerous."""

LATCHED_STATES = (SafetyState.ESTOP, SafetyState.FAULT)
"""States that last until they are cleared."""

BEFORE_STROKE = (SafetyState.AIMING, SafetyState.AIMED, SafetyState.ARMED)
"""Moving states that can be left without harm, because no ball has been struck."""


class SafetyEvent(StrEnum):
    """Event that may change the state."""

    AIM = 'aim'
    REACH = 'reach'  # the joints have reached the aim
    ARM = 'arm'
    FIRE = 'fire'
    BRAKED = 'braked'  # the cue has stopped after the strike
    HOME = 'home'  # the cue is drawn back and raised
    DISARM = 'disarm'
    EXPIRE = 'expire'  # the goal has expired, or the cue was armed for too long
    INTERRUPTED = 'interrupted'  # interlock lost, controller did not run, or clock jumped
    ESTOP = 'estop'
    FAIL = 'fail'
    CLEAR = 'clear'


class Condition(StrEnum):
    """Condition that a transition may need."""

    ACTIVE = 'the node is active'
    ESTOP_FRESH = 'estop is fresh, and not pressed'
    INTERLOCK_FRESH = 'interlock is fresh, and safe'
    GOAL_VALID = 'neither goal nor arming has expired, and every ball is known to lie at its place'
    MECHANISM_HEALTHY = 'joint_states is fresh, and its numbers are valid'
    COMMANDS_FOLLOWED = 'the mechanism follows commands, which come from this node alone'
    CLOCK_RUNS = 'the clock advances, and has not jumped back'


SAFE = frozenset(
    {
        Condition.ACTIVE,
        Condition.ESTOP_FRESH,
        Condition.INTERLOCK_FRESH,
        Condition.MECHANISM_HEALTHY,
        Condition.COMMANDS_FOLLOWED,
    }
)
"""Conditions for motion."""

_GOAL = SAFE | {Condition.GOAL_VALID, Condition.CLOCK_RUNS}

_NONE: frozenset[Condition] = frozenset()
_S, _E = SafetyState, SafetyEvent
_STROKE = (_S.FIRING, _S.RETRACTING)
_ALL = tuple(SafetyState)

TRANSITIONS: dict[tuple[SafetyState, SafetyEvent], tuple[SafetyState, frozenset[Condition]]] = {
    (_S.DISARMED, _E.AIM): (_S.AIMING, _GOAL),
    (_S.AIMING, _E.REACH): (_S.AIMED, SAFE),
    (_S.AIMED, _E.ARM): (_S.ARMED, _GOAL),
    (_S.ARMED, _E.FIRE): (_S.FIRING, _GOAL),
    (_S.FIRING, _E.BRAKED): (_S.RETRACTING, SAFE),
    (_S.RETRACTING, _E.HOME): (_S.DISARMED, _NONE),
    # Before the stroke it is safe to start over; during the stroke an interruption is a fault.
    **{(state, _E.EXPIRE): (_S.DISARMED, _NONE) for state in BEFORE_STROKE},
    **{(state, _E.INTERRUPTED): (_S.DISARMED, _NONE) for state in BEFORE_STROKE},
    **{(state, _E.INTERRUPTED): (_S.FAULT, _NONE) for state in _STROKE},
    **{
        (state, _E.DISARM): (_S.DISARMED, _NONE)
        for state in (_S.DISARMED, *BEFORE_STROKE, *_STROKE)
    },
    # ESTOP is the stronger latch: a failure does not replace it.
    **{(state, _E.ESTOP): (_S.ESTOP, _NONE) for state in _ALL},
    **{(state, _E.FAIL): (_S.FAULT, _NONE) for state in _ALL if state is not _S.ESTOP},
    (_S.ESTOP, _E.CLEAR): (_S.DISARMED, SAFE & {Condition.ACTIVE, Condition.ESTOP_FRESH}),
    (_S.FAULT, _E.CLEAR): (_S.DISARMED, SAFE - {Condition.INTERLOCK_FRESH}),
}
"""From state and event to the next state, and the conditions that must hold."""


@dataclass(frozen=True, slots=True)
class SafetyDecision:
    """Whether an event is accepted, the state after it, and the reason if it is refused."""

    accepted: bool
    state: SafetyState
    reason: str = ''


def decide(
    state: SafetyState, event: SafetyEvent, problems: Mapping[Condition, str]
) -> SafetyDecision:
    """Look up an event in the table; `problems` says of each condition why it does not hold."""
    if (state, event) not in TRANSITIONS:
        possible = [start.name for start, happening in TRANSITIONS if happening is event]
        return SafetyDecision(
            False,
            state,
            f'{event}: not possible in state {state.name}, only in {", ".join(possible)}',
        )
    after, needed = TRANSITIONS[state, event]
    missing = [each for each in Condition if each in needed and problems[each]]
    if missing:
        why = '; '.join(problems[each] for each in missing)
        return SafetyDecision(False, state, f'{event}: needs: {"; ".join(missing)} ({why})')
    return SafetyDecision(True, after)
