"""What people type: it is read, or a sentence says what is wrong."""

from contextlib import suppress
from dataclasses import replace
import math
import re

from hypothesis import example, given, strategies
import numpy as np
import pytest

from billiard_shot import aim, predict, Scene
from billiard_shot.game.referee import start
from billiard_shot.game.state import Call
from billiard_shot.game.strokes import listed_shots
from billiard_shot.game.typed import (
    read_choice,
    read_confirmation,
    read_outcome,
    read_place,
    read_shot,
    ShotReport,
)
from billiard_shot.shot.lowest_elevation import refusals_in
from billiard_shot.shot.stroke import vectors_of

BALLS = {'cue': (-0.3, 0.0), '1': (0.3, 0.1), '9': (0.6, -0.3), '8': (0.0, 0.4)}
SCENE = replace(Scene.load('pool_table'), balls=BALLS)
STATE = replace(start('practice', SCENE), in_hand='', balls=BALLS)
SECOND = replace(STATE, game='nine_ball', phase='second')
LISTED = listed_shots(SCENE, STATE)
CHOICES = replace(STATE, game='nine_ball', choices=('accept', 'pass'))


def shot(line, scene=SCENE, state=STATE):
    return read_shot(line, scene, state, LISTED)


def test_a_shot_of_the_list():
    chances = [each.chance for each in LISTED]
    assert chances == sorted(chances, reverse=True)
    chosen = LISTED[1]
    found = shot('1')
    assert shot('1e0').stroke == found.stroke
    assert found.call == chosen.call
    assert found.stroke.offsets[3:] == pytest.approx((chosen.azimuth, chosen.speed), abs=1e-9)
    assert found.reason == f'{chosen.call.ball} to {chosen.call.pocket}'
    found = shot('safe 1 2.5 0.3')
    assert found.call == replace(chosen.call, safety=True)
    assert found.stroke.offsets[1] == pytest.approx(0.3)
    assert found.stroke.speed == pytest.approx(2.5)


def test_a_ball_and_a_pocket_are_the_shot_of_the_list():
    ball, pocket = LISTED[1].call.ball, LISTED[1].call.pocket
    assert shot(f'aim {ball} {pocket}') == shot('1')
    assert shot(f'aim {ball} {pocket} 3 -0.2 0.1') == shot('1 3 -0.2 0.1')


def test_a_ball_is_aimed_at_whose_shot_is_not_in_the_list():
    """The line is that of the geometry then: without throw."""
    aimed = read_shot('aim 9 foot_right 3', SCENE, STATE, [])
    assert aimed.call == Call('9', 'foot_right')
    expected = aim(SCENE, '9', speed=3.0, pocket='foot_right')
    assert aimed.stroke.offsets[3] == pytest.approx(expected.offsets[3], abs=1e-9)
    full = shot('aim 9 3')
    assert full.call == Call()
    assert full.stroke.offsets[3] == pytest.approx(math.atan2(-0.3, 0.9), abs=1e-9)


def test_side_spin_does_not_turn_the_path_of_the_cue_ball():
    without, with_spin = (predict(SCENE, shot(f'aim 9 3 0 {a}').stroke) for a in (0, 0.4))
    heading = [math.atan2(each.velocity[1], each.velocity[0]) for each in (without, with_spin)]
    assert heading[0] == pytest.approx(heading[1], abs=1e-6)
    assert with_spin.stroke.offsets[3] != pytest.approx(without.stroke.offsets[3], abs=1e-3)


def test_any_stroke_with_a_call():
    found = shot('push 0 0.1 5 90 2 1 foot_left', state=SECOND)
    assert found.call == Call('1', 'foot_left', push_out=True)
    offsets = 0.0, 0.1, math.radians(5.0), math.radians(90.0), 2.0
    assert found.stroke.offsets == pytest.approx(offsets)
    assert shot('0 0 5 90 2').call == Call()


@pytest.mark.parametrize('x', [0.0, -1.2])
def test_the_cue_is_as_low_as_errors_allow(x):
    """Far from cushions and next to one, the noise makes no stroke unplayable."""
    scene = replace(SCENE, balls={'cue': (x, 0.0), '1': (0.3, 0.1)})
    state = replace(STATE, balls=scene.balls)
    free = shot('0 0 - 0 2', scene, state).stroke
    with pytest.raises(ValueError, match=r'ELEVATION must be at least .*, got 0') as caught:
        shot('0 0 0 0 2', scene, state)
    least = re.search('least ([0-9.]+), to leave room', str(caught.value))[1]
    stated = shot(f'0 0 {least} 0 2', scene, state).stroke
    degrees = [math.degrees(each.offsets[2]) for each in (free, stated)]
    assert degrees[1] == pytest.approx(float(least))
    assert degrees[1] - 0.2 < degrees[0] <= degrees[1]
    played = SCENE.noise.sample([free.offsets, stated.offsets], 300, np.random.default_rng(1))
    assert not refusals_in(scene, *vectors_of(played.reshape(-1, 5))).any()
    assert shot('aim 1 2 0 0 30', scene, state).stroke.offsets[2] == pytest.approx(np.pi / 6)


def test_a_cue_without_room_is_refused():
    ring = {str(i): (0.06 * math.cos(i), 0.06 * math.sin(i)) for i in range(1, 7)}
    low = replace(SCENE.robot, elevation_max_deg=20.0)
    scene = replace(SCENE, balls={'cue': (0.0, 0.0), **ring}, robot=low)
    with pytest.raises(ValueError, match='no room there at any elevation up to 20 degrees'):
        shot('0 0 - 30 2', scene, replace(STATE, balls=scene.balls))


def test_a_place_and_a_choice():
    in_hand = replace(STATE, in_hand='anywhere').without('cue')
    assert read_place(' -0.8 0.1 ', in_hand) == (-0.8, 0.1)
    with pytest.raises(ValueError, match=r'the cue ball must be at least .* got \(0\.3, 0\.1\)'):
        read_place('0.3 0.1', in_hand)
    assert read_choice(' pass ', CHOICES).choice == 'pass'
    with pytest.raises(ValueError, match="choice must be one of accept, pass, got 'abc'"):
        read_choice('abc', CHOICES)


def test_an_outcome():
    assert read_outcome('met 3, cushion 3 cue, 3 foot_left, double') == ShotReport(
        '3', ('3', 'cue'), {'3': 'foot_left'}, True
    )
    assert read_outcome('met none') == ShotReport()


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        ('', 'an empty line is not a shot; type \\? for help'),
        ('abc', "'abc' is not a shot"),
        ('99', 'N must be 0 to .* in the list, got .99'),
        ('1.5', 'N must be 0 to'),
        ('-1', 'N must be 0 to'),
        ('nan', 'N must be 0 to'),
        ('corner', "'corner' is not a shot"),
        ('0 fast', "SPEED must be a number, got 'fast'"),
        ('0 0', 'speed must be'),
        ('0 9', r'SPEED must be 0\.1 to 4\.5, got 9'),
        ('0 2 0.4 0.4', r'distance from the middle must be 0 to 0\.5, got 0\.56'),
        ('0 0 89 90 2', r'ELEVATION must be 0 to 85, got 89'),
        ('0 0 95 90 2', 'elevation_deg must be 0 to 90, got 95'),
        ('safe', "'safe' is not a shot"),
        ('push 0', 'push is allowed only in the first shot after a break'),
        ('0 0 5 90 2 1 corner', "pocket must be one of .*, side_right, '', got 'corner'"),
        ('0 0 5 90 2 99 foot_left', "BALL must be one of 1, 9, 8, got '99'"),
        ('0 0 5 90 2 1', 'is not a shot'),
        ('aim', "'aim' is not a shot"),
        ('aim 99 3', "BALL must be one of 1, 9, 8, got '99'"),
        ('aim 1', 'must be 1 to 4 numbers'),
        ('aim 1 2 0 0 0 0', 'must be 1 to 4 numbers'),
        ('aim 1 foot_lift 3', 'pocket must be .*; the nearest is foot_left'),
        ('aim 1 head_left 3', "pocket must be one that ball '1' reaches"),
        ('aim 1 3 up', "SPEED B must be 2 numbers, got '3 up'"),
    ],
)
def test_a_line_that_is_not_a_shot(line, words):
    with pytest.raises(ValueError, match=words):
        shot(line)


def test_the_list_may_be_empty():
    carom = start('three_cushion', 'carom')
    scene = replace(Scene.load('carom'), balls=carom.balls)
    assert listed_shots(scene, carom) == []
    with pytest.raises(ValueError, match='N must be a shot in the list'):
        read_shot('0', scene, carom, [])
    assert read_shot('aim red 3', scene, carom, []).stroke.speed == pytest.approx(3.0)


def test_enter_confirms():
    assert [read_confirmation(line) for line in ('', ' ', 'u')] == [True, True, False]
    with pytest.raises(ValueError, match="'yes' is neither Enter nor u"):
        read_confirmation('yes')


@pytest.mark.parametrize(
    'line', ['', '?', 'abc', '99', 'corner', 'met', 'cushion', 'met 1,,', ',']
)
def test_a_line_that_is_not_an_outcome(line):
    with pytest.raises(ValueError, match='type \\? for help'):
        read_outcome(line)


@given(strategies.text(max_size=30))
@example('1e999 0 0 0 0')
@example('nan nan')
@example('aim 1 1e999')
@example('0 0 - 1e999 2')
@example('9' * 5000)
def test_any_line_is_read_or_is_a_value_error(line):
    for read in (
        read_outcome,
        shot,
        read_confirmation,
        lambda line: read_place(line, STATE),
        lambda line: read_choice(line, CHOICES),
    ):
        with suppress(ValueError):
            read(line)
