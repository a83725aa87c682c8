"""The table of the safety states, looked at exhaustively."""

from itertools import chain, combinations

import pytest

from billiard_shot.cue.safety import Condition, MOVING, SAFE, SafetyEvent, SafetyState, TRANSITIONS
from billiard_shot.cue.safety import decide as decide_with

ALL = frozenset(Condition)
LATCHED = (SafetyState.ESTOP, SafetyState.FAULT)
EVERY_SET = [
    frozenset(chosen)
    for chosen in chain.from_iterable(
        combinations(Condition, count) for count in range(len(Condition) + 1)
    )
]

# What is written here is what people rely on; whatever is not, is refused.
LEGAL = {
    (SafetyState.DISARMED, SafetyEvent.AIM): SafetyState.AIMING,
    (SafetyState.AIMING, SafetyEvent.REACH): SafetyState.AIMED,
    (SafetyState.AIMED, SafetyEvent.ARM): SafetyState.ARMED,
    (SafetyState.ARMED, SafetyEvent.FIRE): SafetyState.FIRING,
    (SafetyState.FIRING, SafetyEvent.BRAKED): SafetyState.RETRACTING,
    (SafetyState.RETRACTING, SafetyEvent.HOME): SafetyState.DISARMED,
    (SafetyState.AIMING, SafetyEvent.EXPIRE): SafetyState.DISARMED,
    (SafetyState.AIMED, SafetyEvent.EXPIRE): SafetyState.DISARMED,
    (SafetyState.ARMED, SafetyEvent.EXPIRE): SafetyState.DISARMED,
    (SafetyState.AIMING, SafetyEvent.INTERRUPTED): SafetyState.DISARMED,
    (SafetyState.AIMED, SafetyEvent.INTERRUPTED): SafetyState.DISARMED,
    (SafetyState.ARMED, SafetyEvent.INTERRUPTED): SafetyState.DISARMED,
    (SafetyState.FIRING, SafetyEvent.INTERRUPTED): SafetyState.FAULT,
    (SafetyState.RETRACTING, SafetyEvent.INTERRUPTED): SafetyState.FAULT,
    (SafetyState.DISARMED, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.AIMING, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.AIMED, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.ARMED, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.FIRING, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.RETRACTING, SafetyEvent.DISARM): SafetyState.DISARMED,
    (SafetyState.ESTOP, SafetyEvent.CLEAR): SafetyState.DISARMED,
    (SafetyState.FAULT, SafetyEvent.CLEAR): SafetyState.DISARMED,
    **{(state, SafetyEvent.ESTOP): SafetyState.ESTOP for state in SafetyState},
    **{
        (state, SafetyEvent.FAIL): SafetyState.FAULT
        for state in SafetyState
        if state is not SafetyState.ESTOP
    },
}


def decide(state, event, conditions):
    """Decide when these conditions hold, and no others."""
    problems = {each: '' if each in conditions else f'no {each.name}' for each in Condition}
    return decide_with(state, event, problems)


@pytest.mark.parametrize('event', SafetyEvent)
@pytest.mark.parametrize('state', SafetyState)
def test_every_transition_and_every_refusal(state, event):
    for conditions in EVERY_SET:
        decision = decide(state, event, conditions)
        allowed = (state, event) in LEGAL and TRANSITIONS[state, event][1] <= conditions
        assert decision.accepted == allowed
        assert decision.state is (LEGAL[state, event] if allowed else state)
        assert bool(decision.reason) != allowed
        if not allowed:
            assert decision.reason.startswith(f'{event}: ')
        if (state, event) in LEGAL:
            for condition in TRANSITIONS[state, event][1] - conditions:
                assert condition in decision.reason
                assert f'no {condition.name}' in decision.reason
    assert decide(state, event, ALL).accepted == ((state, event) in LEGAL)


def reachable(conditions, without=()):
    """States that some events lead to from DISARMED, under conditions that do not change."""
    found, new = {SafetyState.DISARMED}, [SafetyState.DISARMED]
    while new:
        state = new.pop()
        for event in SafetyEvent:
            after = decide(state, event, conditions).state
            if after not in found and after not in without:
                found.add(after)
                new.append(after)
    return found


def test_no_way_to_fire_but_through_armed():
    ways = [state for (state, _), (after, _) in TRANSITIONS.items() if after is SafetyState.FIRING]
    assert ways == [SafetyState.ARMED]
    assert SafetyState.FIRING not in reachable(ALL, without=[SafetyState.ARMED])
    assert reachable(ALL) == set(SafetyState)


def test_nothing_fires_or_moves_without_fresh_estop_and_interlock():
    for conditions in EVERY_SET:
        for state in SafetyState:
            for event in SafetyEvent:
                decision = decide(state, event, conditions)
                if decision.accepted and decision.state in MOVING:
                    assert conditions >= SAFE
                    assert {Condition.ESTOP_FRESH, Condition.INTERLOCK_FRESH} <= conditions
                if decision.accepted and decision.state is SafetyState.FIRING:
                    assert conditions == ALL


def test_latches_hold():
    for state in LATCHED:
        leaving = {
            event for event in SafetyEvent if decide(state, event, ALL).state not in LATCHED
        }
        assert leaving == {SafetyEvent.CLEAR}
    assert decide(SafetyState.ESTOP, SafetyEvent.FAIL, ALL).state is SafetyState.ESTOP
    assert decide(SafetyState.FAULT, SafetyEvent.ESTOP, ALL).state is SafetyState.ESTOP
    assert not decide(SafetyState.ESTOP, SafetyEvent.CLEAR, ALL - {Condition.ESTOP_FRESH}).accepted
    assert not decide(
        SafetyState.FAULT, SafetyEvent.CLEAR, ALL - {Condition.MECHANISM_HEALTHY}
    ).accepted
    assert not decide(
        SafetyState.FAULT, SafetyEvent.CLEAR, ALL - {Condition.COMMANDS_FOLLOWED}
    ).accepted


def test_stops_need_no_permission():
    nothing = frozenset()
    for state in SafetyState:
        assert decide(state, SafetyEvent.ESTOP, nothing).state is SafetyState.ESTOP
        if state not in LATCHED:
            assert decide(state, SafetyEvent.FAIL, nothing).state is SafetyState.FAULT
            assert decide(state, SafetyEvent.DISARM, nothing).state is SafetyState.DISARMED
