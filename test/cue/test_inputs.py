"""Inputs that must be repeated: silence, old messages and wrong clocks are no permission."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from billiard_shot.cue.inputs import HeartbeatInput

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
