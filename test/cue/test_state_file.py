"""The file that keeps a latched state from one start of the driver to the next."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from billiard_shot.cue.inputs import read_latched, UNKNOWN, write_latched
from billiard_shot.cue.safety import LATCHED_STATES, SafetyState


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
