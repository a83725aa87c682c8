"""The table of the safety states, looked at exhaustively."""

from itertools import chain, combinations

import pytest

from billiard_shot.cue.safety import Condition, decide, Event, MOVING, SAFE, State, TABLE

ALL = frozenset(Condition)
LATCHED = (State.ESTOP, State.FAULT)
EVERY_SET = [
    frozenset(chosen)
    for chosen in chain.from_iterable(
        combinations(Condition, count) for count in range(len(Condition) + 1)
    )
]

# What is written here is what people rely on; whatever is not, is refused.
LEGAL = {
    (State.DISARMED, Event.AIM): State.AIMING,
    (State.AIMING, Event.REACH): State.AIMED,
    (State.AIMED, Event.ARM): State.ARMED,
    (State.ARMED, Event.FIRE): State.FIRING,
    (State.FIRING, Event.BRAKED): State.RETRACTING,
    (State.RETRACTING, Event.HOME): State.DISARMED,
    (State.AIMING, Event.EXPIRE): State.DISARMED,
    (State.AIMED, Event.EXPIRE): State.DISARMED,
    (State.ARMED, Event.EXPIRE): State.DISARMED,
    (State.AIMING, Event.INTERLOCK_LOST): State.DISARMED,
    (State.AIMED, Event.INTERLOCK_LOST): State.DISARMED,
    (State.ARMED, Event.INTERLOCK_LOST): State.DISARMED,
    (State.FIRING, Event.INTERLOCK_LOST): State.FAULT,
    (State.RETRACTING, Event.INTERLOCK_LOST): State.FAULT,
    (State.AIMING, Event.INTERRUPTED): State.DISARMED,
    (State.AIMED, Event.INTERRUPTED): State.DISARMED,
    (State.ARMED, Event.INTERRUPTED): State.DISARMED,
    (State.FIRING, Event.INTERRUPTED): State.FAULT,
    (State.RETRACTING, Event.INTERRUPTED): State.FAULT,
    (State.DISARMED, Event.DISARM): State.DISARMED,
    (State.AIMING, Event.DISARM): State.DISARMED,
    (State.AIMED, Event.DISARM): State.DISARMED,
    (State.ARMED, Event.DISARM): State.DISARMED,
    (State.FIRING, Event.DISARM): State.DISARMED,
    (State.RETRACTING, Event.DISARM): State.DISARMED,
    (State.ESTOP, Event.CLEAR): State.DISARMED,
    (State.FAULT, Event.CLEAR): State.DISARMED,
    **{(state, Event.ESTOP): State.ESTOP for state in State},
    **{(state, Event.FAIL): State.FAULT for state in State if state is not State.ESTOP},
}


@pytest.mark.parametrize('event', Event)
@pytest.mark.parametrize('state', State)
def test_every_transition_and_every_refusal(state, event):
    for conditions in EVERY_SET:
        decision = decide(state, event, conditions)
        allowed = (state, event) in LEGAL and TABLE[state, event][1] <= conditions
        assert decision.accepted == allowed
        assert decision.state is (LEGAL[state, event] if allowed else state)
        assert bool(decision.reason) != allowed
        if not allowed:
            assert decision.reason.startswith(f'{event}: ')
        for condition in decision.missing:
            assert condition in decision.reason
    assert decide(state, event, ALL).accepted == ((state, event) in LEGAL)


def reachable(conditions, without=()):
    """States that some events lead to from DISARMED, under conditions that do not change."""
    found, new = {State.DISARMED}, [State.DISARMED]
    while new:
        state = new.pop()
        for event in Event:
            after = decide(state, event, conditions).state
            if after not in found and after not in without:
                found.add(after)
                new.append(after)
    return found


def test_no_way_to_fire_but_through_armed():
    ways = [state for (state, _), (after, _) in TABLE.items() if after is State.FIRING]
    assert ways == [State.ARMED]
    assert State.FIRING not in reachable(ALL, without=[State.ARMED])
    assert reachable(ALL) == set(State)


def test_nothing_fires_or_moves_without_fresh_estop_and_interlock():
    for conditions in EVERY_SET:
        for state in State:
            for event in Event:
                decision = decide(state, event, conditions)
                if decision.accepted and decision.state in MOVING:
                    assert conditions >= SAFE
                    assert {Condition.ESTOP_FRESH, Condition.INTERLOCK_FRESH} <= conditions
                if decision.accepted and decision.state is State.FIRING:
                    assert conditions == ALL


def test_latches_hold():
    for state in LATCHED:
        leaving = {event for event in Event if decide(state, event, ALL).state not in LATCHED}
        assert leaving == {Event.CLEAR}
    assert decide(State.ESTOP, Event.FAIL, ALL).state is State.ESTOP
    assert decide(State.FAULT, Event.ESTOP, ALL).state is State.ESTOP
    assert not decide(State.ESTOP, Event.CLEAR, ALL - {Condition.ESTOP_FRESH}).accepted
    assert not decide(State.FAULT, Event.CLEAR, ALL - {Condition.MECHANISM_HEALTHY}).accepted
    assert not decide(State.FAULT, Event.CLEAR, ALL - {Condition.ALONE}).accepted


def test_stops_need_no_permission():
    nothing = frozenset()
    for state in State:
        assert decide(state, Event.ESTOP, nothing).state is State.ESTOP
        if state not in LATCHED:
            assert decide(state, Event.FAIL, nothing).state is State.FAULT
            assert decide(state, Event.DISARM, nothing).state is State.DISARMED
