"""The rules of ten-ball, by the numbers of WPA, The Rules of Play, 15 March 2016, part 9."""

from dataclasses import replace
from functools import partial

from outcomes import numbers, outcome
import pytest

from billiard_shot.game import Call, choose, judge, start

START = start('ten_ball', 'pool_table', seed=4)
BREAK = START.with_cue_ball(-0.7, 0.1)
SECOND = replace(BREAK, phase='second', in_hand='')
PLAY = replace(SECOND, phase='play')
FOUR = ('1', '2', '3', '4')
PUSH = Call(push_out=True)
ONE = Call(ball='1', pocket='foot_left')
TEN = Call(ball='10', pocket='foot_left')
after = partial(outcome, BREAK)


@pytest.mark.parametrize('seed', range(5))
def test_the_rack_is_a_triangle_with_1_10_2_and_3_in_their_places(seed):
    balls = start('ten_ball', 'pool_table', seed).balls
    assert sorted(balls, key=int) == [str(ball) for ball in range(1, 11)]
    assert min(balls, key=lambda ball: balls[ball][0]) == '1'
    middle = balls['10']
    assert abs(middle[1]) < 1e-3
    assert sum(balls[ball][0] > middle[0] + 0.01 for ball in balls) == 4  # one row behind it
    back = {max(balls, key=lambda ball: balls[ball][1]), min(balls, key=lambda b: balls[b][1])}
    assert back == {'2', '3'}


def test_ball_and_pocket_are_called():
    ruling = judge(PLAY, ONE, after(('1', 'foot_left')))
    assert (ruling.legal, ruling.state.player, ruling.state.choices) == (True, 0, ())
    elsewhere = judge(PLAY, ONE, after(('1', 'foot_right')))
    assert elsewhere.legal
    assert (elsewhere.state.player, elsewhere.state.choices) == (1, ('accept', 'pass'))  # 9.7
    assert choose(elsewhere.state, 'pass').player == 0
    assert judge(PLAY, ONE, after()).state.choices == ()


def test_a_safety_that_pots_gives_the_other_player_the_choice():
    call = Call(ball='1', pocket='foot_left', safety=True)
    ruling = judge(PLAY, call, after(('1', 'foot_left')))
    assert (ruling.state.player, ruling.state.choices) == (1, ('accept', 'pass'))  # 9.6


def test_the_lowest_ball_is_met_first():
    assert numbers(judge(PLAY, ONE, after(first='2'))) == ['6.2']
    assert judge(PLAY, ONE, after(first='2')).state.in_hand == 'anywhere'


def test_the_ten_wins_only_as_the_last_ball():
    early = judge(PLAY, TEN, after(('10', 'foot_left')))
    assert not early.state.over
    assert early.state.player == 0
    assert '10' in early.state.balls  # 9.9
    last = replace(PLAY, balls={'cue': (0.0, 0.0), '10': (0.5, 0.2)})
    pot = after(('10', 'foot_left'), of=last, first='10', cushion=('cue',))
    assert judge(last, TEN, pot).state.winner == 0
    elsewhere = replace(TEN, pocket='foot_right')
    ruling = judge(last, elsewhere, pot)
    assert not ruling.state.over
    assert '10' in ruling.state.balls
    foul = replace(pot, pocketed=(*pot.pocketed, ('cue', 'side_left')), places={})
    assert '10' in judge(last, TEN, foul).state.balls


def test_a_break_needs_a_pot_or_four_balls_at_cushions_and_no_call():
    assert numbers(judge(BREAK, Call(), after(cushion=FOUR[:3]))) == ['9.3']
    dry = judge(BREAK, Call(), after(cushion=FOUR)).state
    assert (dry.phase, dry.player) == ('second', 1)
    pot = judge(BREAK, Call(), after(('5', 'side_left'))).state
    assert (pot.phase, pot.player) == ('second', 0)
    ten = judge(BREAK, Call(), after(('10', 'side_left'))).state
    assert not ten.over
    assert '10' in ten.balls


def test_a_push_out_may_meet_nothing_and_lets_the_other_choose():
    ruling = judge(SECOND, PUSH, after(('10', 'foot_left'), first=None, cushion=()))
    assert ruling.legal
    assert '10' in ruling.state.balls
    assert (ruling.state.player, ruling.state.choices) == (1, ('accept', 'pass'))


def test_the_third_foul_in_a_row_loses():
    state = replace(PLAY, fouls=(2, 0))
    ruling = judge(state, ONE, after(first='2'))
    assert numbers(ruling) == ['6.2', '6.14']
    assert ruling.state.winner == 1
