"""The table of the safety states, looked at exhaustively."""

from itertools import chain, combinations
import time

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot.cue.inputs import (
    CLOCK_RECOVERY,
    ClockWatch,
    HeartbeatInput,
    JointFeedback,
    read_latched,
    steady_time,
    UNKNOWN,
    write_latched,
)
from billiard_shot.cue.safety import (
    Condition,
    LATCHED_STATES,
    MOVING,
    SAFE,
    SafetyEvent,
    SafetyState,
    TRANSITIONS,
)
from billiard_shot.cue.safety import decide as decide_with

ALL = frozenset(Condition)
LATCHED = (SafetyState.ESTOP, SafetyState.FAULT)
WAITING = (SafetyState.AIMING, SafetyState.AIMED, SafetyState.ARMED)
STROKE = (SafetyState.FIRING, SafetyState.RETRACTING)
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
    **{(state, SafetyEvent.EXPIRE): SafetyState.DISARMED for state in WAITING},
    **{(state, SafetyEvent.INTERRUPTED): SafetyState.DISARMED for state in WAITING},
    **{(state, SafetyEvent.INTERRUPTED): SafetyState.FAULT for state in STROKE},
    **{
        (state, SafetyEvent.DISARM): SafetyState.DISARMED
        for state in (SafetyState.DISARMED, *WAITING, *STROKE)
    },
    **{(state, SafetyEvent.CLEAR): SafetyState.DISARMED for state in LATCHED},
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


# --- inputs that must be repeated: silence, old messages and wrong clocks are no permission ------

TIMES = st.floats(0.0, 100.0)


@pytest.fixture
def interlock():
    return HeartbeatInput('interlock', 0.5, safe=True)


def test_silence_is_not_permission(interlock):
    assert interlock.problem(0.0) == 'interlock: no message received'
    interlock.record(True, 1.0, 1.0)
    assert interlock.problem(1.5) == ''
    assert interlock.problem(1.51) == 'interlock: no message for 0.51 s, limit 0.5 s'
    interlock.record(False, 2.0, 2.0)
    assert interlock.problem(2.0) == 'interlock: is false'


def test_the_time_of_writing_counts(interlock):
    interlock.record(True, 1.0, 3.0)
    assert interlock.problem(3.0) == 'interlock: no message for 2 s, limit 0.5 s'


def test_a_message_that_was_overtaken_changes_nothing(interlock):
    interlock.record(False, 1.0, 1.0)
    interlock.record(True, 0.9, 1.1)
    assert interlock.problem(1.1) == 'interlock: is false'


def test_nothing_is_fresh_after_a_pause_until_something_newer_is_heard(interlock):
    interlock.record(True, 1.0, 1.0)
    interlock.forget(1.2)
    assert interlock.problem(1.1) == (
        'interlock: not trusted for another 0.1 s, because this process paused'
    )
    assert interlock.problem(1.3) == ('interlock: no message since this process paused')
    interlock.record(True, 1.1, 1.3)  # was written before the pause ended
    assert 'paused' in interlock.problem(1.3)
    interlock.record(True, 1.25, 1.3)
    assert interlock.problem(1.3) == ''


def test_a_clock_that_is_ahead_is_named(interlock):
    interlock.record(True, 1.0, 1.0)
    interlock.record(True, 8.0, 1.1)
    assert interlock.problem(1.1) == (
        'interlock: written 6.9 s in the future: the clocks of the publisher and of this '
        'machine differ'
    )
    interlock.record(True, 1.2, 1.2)
    assert interlock.problem(1.2) == ''


@pytest.fixture
def estop():
    """Return an emergency stop with two publishers, of which the second one says true."""
    estop = HeartbeatInput('estop', 0.5, safe=False)
    estop.record(False, 1.0, 1.0, 'panel')
    estop.record(True, 1.0, 1.0, 'gate')
    return estop


def test_one_publisher_that_calls_unsafe_counts_until_it_says_otherwise(estop):
    """A slow publisher of true among quick ones of false."""
    for step in range(5):
        estop.record(False, 1.0 + 0.05 * step, 1.0 + 0.05 * step, 'panel')
        assert estop.problem(1.2) == 'estop: is true (one of 2 publishers)'
    estop.record(False, 1.3, 1.3, 'gate')
    assert estop.problem(1.3) == ''


def test_a_publisher_that_falls_silent_is_not_covered_by_another(estop):
    estop.record(False, 1.1, 1.1, 'gate')
    estop.record(False, 1.9, 1.9, 'panel')
    assert 'estop: no message for 0.8 s' in estop.problem(1.9)
    estop.keep({'panel': '/panel'}, 1.9)
    assert estop.problem(1.9) == ''


def test_a_publisher_that_was_never_heard_counts_as_silent():
    """It may hang with its button pressed, and have said so before this program started."""
    estop = HeartbeatInput('estop', 0.5, safe=False)
    listed = {'panel': '/panel', 'gate': '/left/gate'}
    for step in range(10):
        now = 1.0 + 0.1 * step
        estop.record(False, now, now, 'panel')
        estop.keep(listed, now)
        wrong = 'estop: no message received from /left/gate (one of 2 publishers)'
        assert estop.problem(now) == ('' if now < 1.55 else wrong), now
    estop.record(False, 1.9, 1.9, 'gate')
    assert estop.problem(1.9) == ''
    estop.keep({**listed, 'new': '/new'}, 2.0)
    estop.keep(listed, 2.1)
    assert estop.problem(2.2) == '', 'it has gone'


def test_without_ids_of_publishers_one_message_is_that_of_all():
    estop = HeartbeatInput('estop', 0.5, safe=False)
    estop.record(False, 1.0, 1.0, b'')
    estop.keep({'panel': '/panel'}, 1.0)
    estop.record(False, 2.0, 2.0, b'')
    assert estop.problem(2.0) == ''


def test_without_publishers_nothing_is_known(estop):
    estop.keep({}, 1.0)
    assert estop.problem(1.0) == 'estop: no message received'


@given(st.lists(st.tuples(st.booleans(), TIMES, TIMES), max_size=20), TIMES)
def test_permission_needs_a_safe_message_written_within_the_timeout(messages, later):
    """Whatever the order and the delays of the messages."""
    interlock = HeartbeatInput('interlock', 0.5, safe=True)
    received = sorted(messages, key=lambda message: message[2])
    for value, written, now in received:
        interlock.record(value, written, now)
    now = max([later, *(now for *_, now in received)])
    if not interlock.problem(now):
        assert any(value and now - 0.5 <= written <= now + 0.5 for value, written, _ in received)


# --- clocks that stand still or jump back are named; all others are trusted ----------------------


@pytest.fixture
def clock():
    """Return a watch that has seen a clock run for a second."""
    watch = ClockWatch('ROS clock', timeout=0.25)
    for step in range(51):
        watch.update(100.0 + 0.02 * step, 0.02 * step)
    assert watch.problem(1.0) == ''
    return watch


def test_a_clock_that_is_never_read_is_not_judged():
    assert ClockWatch('ROS clock', 0.25).problem(1.0) == ''


def test_simulated_time_without_a_clock():
    watch = ClockWatch('ROS clock', 0.25)
    watch.update(0.0, 1.0)
    assert watch.problem(1.0) == (
        'ROS clock: has not started: no message received on /clock (use_sim_time)'
    )


def test_standing_still(clock):
    clock.update(101.0, 1.2)
    assert clock.problem(1.2) == ''
    clock.update(101.0, 1.3)
    assert clock.problem(1.3) == 'ROS clock: has stood still for 0.3 s'
    clock.update(101.1, 1.4)
    assert clock.problem(1.4) == ''


def test_jumping_back(clock):
    clock.update(90.0, 1.02)
    assert clock.problem(1.02) == 'ROS clock: jumped back by 11 s'
    clock.update(90.0 + CLOCK_RECOVERY, 1.0 + CLOCK_RECOVERY)
    assert 'jumped back' in clock.problem(1.0 + CLOCK_RECOVERY)
    clock.update(90.1 + CLOCK_RECOVERY, 1.1 + CLOCK_RECOVERY)
    assert clock.problem(1.1 + CLOCK_RECOVERY) == ''


def test_jumping_ahead(clock):
    clock.update(3701.0, 1.02)
    assert clock.problem(1.02) == 'ROS clock: jumped ahead by 3.6e+03 s'
    clock.update(3701.1 + CLOCK_RECOVERY, 1.1 + CLOCK_RECOVERY)
    assert clock.problem(1.1 + CLOCK_RECOVERY) == ''


def test_corrections_pauses_and_the_first_time_are_no_jumps(clock):
    clock.update(100.995, 1.02)
    assert clock.problem(1.02) == ''
    clock.update(130.995, 31.02)  # this process was suspended
    assert clock.problem(31.02) == ''
    started = ClockWatch('ROS clock', 0.25)
    started.update(0.0, 1.0)
    started.update(1.7e9, 1.02)
    assert started.problem(1.02) == ''


def test_a_quick_simulator_is_no_jump():
    """Ten times faster than real time, with ten messages a second."""
    watch = ClockWatch('ROS clock', 0.25)
    for step in range(500):
        watch.update(1.0 + float(step // 5), 0.02 * step)
        assert watch.problem(0.02 * step) == ''


@pytest.mark.skipif(not hasattr(time, 'CLOCK_BOOTTIME'), reason='Linux alone has this clock')
def test_the_steady_clock_goes_on_while_the_machine_is_suspended():
    before = time.clock_gettime(time.CLOCK_BOOTTIME)
    assert before <= steady_time() <= time.clock_gettime(time.CLOCK_BOOTTIME)


# --- measured joints: messages that have a part of them are collected; nothing is made up --------

NAMES = ('slide', 'lift', 'stroke')
POSITION, VELOCITY = (0.1, 0.2, 0.3), (1.0, 2.0, 3.0)


@pytest.fixture
def feedback():
    return JointFeedback(NAMES)


def test_a_complete_message_in_any_order_with_other_joints(feedback):
    position, velocity = feedback.update(
        ('arm', 'stroke', 'slide', 'lift'), (9.0, 0.3, 0.1, 0.2), (9.0, 3.0, 1.0, 2.0)
    )
    np.testing.assert_array_equal(position, POSITION)
    np.testing.assert_array_equal(velocity, VELOCITY)


def test_one_joint_a_message(feedback):
    """Every set has each joint once; a set without one joint is never complete."""
    for _ in range(2):
        assert feedback.update(('slide',), (0.1,), (1.0,)) is None
        assert feedback.update(('stroke',), (0.3,), (3.0,)) is None
        assert feedback.missing == 'lift'
        position, velocity = feedback.update(('lift',), (0.2,), (2.0,))
        np.testing.assert_array_equal(position, POSITION)
        np.testing.assert_array_equal(velocity, VELOCITY)


@pytest.mark.parametrize('velocities', [(), (np.nan,) * 3])
def test_velocities_that_are_not_measured_are_not_made_up(feedback, velocities):
    for moved in POSITION, VELOCITY:
        position, velocity = feedback.update(NAMES, moved, velocities)
        np.testing.assert_array_equal(position, moved)
        assert np.isnan(velocity).all()


def test_a_lost_encoder_is_passed_on(feedback):
    """So that the controller names it."""
    feedback.update(NAMES, POSITION, VELOCITY)
    position, _ = feedback.update(NAMES, (0.1, np.nan, 0.3), VELOCITY)
    assert np.isnan(position).tolist() == [False, True, False]


def test_joints_without_positions_are_missing(feedback):
    assert feedback.update(NAMES, (), ()) is None
    assert feedback.missing == 'slide, lift, stroke'


# --- the file that keeps a latched state from one start of the driver to the next ----------------


@pytest.mark.parametrize('state', LATCHED_STATES)
def test_a_latched_state_comes_back_until_it_is_cleared(tmp_path, state):
    path = tmp_path / 'cell1' / 'cue_driver.state'
    assert read_latched(path) is None
    write_latched(path, state, 'base_x: 3 m off')
    assert read_latched(path) == (state, 'base_x: 3 m off')
    assert read_latched(path) == (state, 'base_x: 3 m off'), 'reading changes nothing'
    write_latched(path, SafetyState.DISARMED, 'cleared')
    assert read_latched(path) is None
    write_latched(path, SafetyState.DISARMED, 'cleared')
    assert list(path.parent.iterdir()) == []


@given(st.text(min_size=1))
def test_every_reason_is_read_back_as_its_state(tmp_path_factory, reason):
    path = tmp_path_factory.mktemp('state') / 'state'
    write_latched(path, SafetyState.ESTOP, reason)
    assert read_latched(path)[0] is SafetyState.ESTOP


@pytest.mark.parametrize(
    'damaged', [b'', b'EST', b'ESTOP', b'DISARMED cleared', b'\xff\x00', b'{}', b'FAULT \n']
)
def test_a_damaged_file_is_a_fault(tmp_path, damaged):
    path = tmp_path / 'state'
    path.write_bytes(damaged)
    assert read_latched(path) == UNKNOWN
    assert UNKNOWN == (SafetyState.FAULT, 'state unknown: clear_fault')


@given(st.binary(max_size=40))
def test_any_content_is_a_latched_state(tmp_path_factory, content):
    path = tmp_path_factory.mktemp('state') / 'state'
    path.write_bytes(content)
    state, reason = read_latched(path)
    assert state in LATCHED_STATES
    assert reason


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / 'file').write_text('')
    for path in (tmp_path / 'file' / 'state', tmp_path):
        with pytest.raises(OSError, match=str(tmp_path)):
            read_latched(path)
