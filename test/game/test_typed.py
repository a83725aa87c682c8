"""What people type: it is read, or a sentence says what is wrong."""

from contextlib import suppress
from dataclasses import replace
import math

from hypothesis import example, given, strategies
import pytest

from billiard_shot import Scene, Stroke
from billiard_shot.game.call import Call
from billiard_shot.game.game import start
from billiard_shot.game.placing import call_of, direct_shots
from billiard_shot.game.seen import Told
from billiard_shot.game.typed import read_choice, read_outcome, read_place, read_shot

SCENE = Scene.load('pool_table')
BALLS = {'cue': (-0.3, 0.0), '1': (0.3, 0.1), '9': (0.6, -0.3), '8': (0.0, 0.4)}
STATE = replace(start('practice', SCENE), in_hand='', balls=BALLS)
DIRECT = direct_shots(replace(SCENE, balls=BALLS), STATE)
CHOICES = replace(STATE, game='nine_ball', choices=('accept', 'pass'))


def test_a_shot_of_the_list():
    call, offsets = call_of(DIRECT, 1), DIRECT.offsets[1].tolist()
    found = read_shot('1', STATE, DIRECT)
    assert (found.call, found.stroke) == (call, Stroke.from_offsets(*offsets))
    found = read_shot('safe 1 2.5 0.3 -0.1', STATE, DIRECT)
    assert found.call == replace(call, safety=True)
    assert found.stroke == Stroke.from_offsets(-0.1, 0.3, offsets[2], offsets[3], 2.5)


def test_any_stroke_with_a_call():
    found = read_shot('push 0 0.1 5 90 2 1 foot_left', STATE, DIRECT)
    assert found.call == Call('1', 'foot_left', push_out=True)
    assert found.stroke == Stroke.from_offsets(
        0.0, 0.1, math.radians(5.0), math.radians(90.0), 2.0
    )
    assert read_shot('0 0 5 90 2', STATE, DIRECT).call == Call()


def test_a_place_and_a_choice():
    in_hand = replace(STATE, in_hand='anywhere').without('cue')
    assert read_place(' -0.8 0.1 ', in_hand) == (-0.8, 0.1)
    with pytest.raises(ValueError, match=r'the cue ball must be at least .* got \(0\.3, 0\.1\)'):
        read_place('0.3 0.1', in_hand)
    assert read_choice(' pass ', CHOICES).choice == 'pass'
    with pytest.raises(ValueError, match="choice must be one of accept, pass, got 'abc'"):
        read_choice('abc', CHOICES)


def test_an_outcome():
    assert read_outcome('met 3, cushion 3 cue, 3 foot_left, double') == Told(
        '3', ('3', 'cue'), {'3': 'foot_left'}, True
    )
    assert read_outcome('met none') == Told()


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        ('', "'' is not a shot"),
        ('?', "N must be a number, got '?'"),
        ('abc', "got 'abc'"),
        ('99', "N must be one of the .* shots of the list, got '99'"),
        ('1.5', 'N must be one of the'),
        ('-1', 'N must be one of the'),
        ('nan', 'N must be one of the'),
        ('corner', "got 'corner'"),
        ('0 fast', "SPEED must be a number, got 'fast'"),
        ('0 0', 'speed must be'),
        ('safe', "'safe' is not a shot"),
        ('0 0 5 90 2 1 corner', 'pocket must be one of'),
        ('0 0 5 90 2 99 foot_left', "BALL must be one of 1, 9, 8, got '99'"),
        ('0 0 5 90 2 1', 'is not a shot'),
    ],
)
def test_a_line_that_is_not_a_shot(line, words):
    with pytest.raises(ValueError, match=words):
        read_shot(line, STATE, DIRECT)


@pytest.mark.parametrize(
    'line', ['', '?', 'abc', '99', 'corner', 'met', 'cushion', 'met 1,,', ',']
)
def test_a_line_that_is_not_an_outcome(line):
    with pytest.raises(ValueError, match='type \\? for help'):
        read_outcome(line)


@given(strategies.text(max_size=30))
@example('1e999 0 0 0 0')
@example('nan nan')
@example('9' * 5000)
def test_any_line_is_read_or_is_a_value_error(line):
    for read in (
        read_outcome,
        lambda line: read_shot(line, STATE, DIRECT),
        lambda line: read_place(line, STATE),
        lambda line: read_choice(line, CHOICES),
    ):
        with suppress(ValueError):
            read(line)
