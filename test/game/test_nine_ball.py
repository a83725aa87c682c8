"""The rules of nine-ball, by the numbers of WPA, The Rules of Play, 15 March 2016, part 2."""

from dataclasses import replace
from functools import partial

from outcomes import numbers, outcome
import pytest

from billiard_shot.game import Call, choose, judge, start

START = start('nine_ball', 'pool_table', seed=4)
BREAK = START.with_cue_ball(-0.7, 0.1)
SECOND = replace(BREAK, phase='second', in_hand='')
PLAY = replace(SECOND, phase='play')
FOUR = ('1', '2', '3', '4')
PUSH = Call(push_out=True)
after = partial(outcome, BREAK)


def test_any_ball_that_falls_after_the_lowest_keeps_the_turn():
    ruling = judge(PLAY, Call(), after(('5', 'foot_left')))
    assert ruling.legal
    assert ruling.state.player == 0
    assert judge(PLAY, Call(), after()).state.player == 1


def test_the_lowest_ball_is_met_first():
    without_1 = replace(PLAY, balls={b: p for b, p in PLAY.balls.items() if b != '1'})
    assert numbers(judge(PLAY, Call(), after(first='2'))) == ['6.2']
    assert judge(without_1, Call(), after(first='2', cushion=('2',))).legal
    assert numbers(judge(BREAK, Call(), after(first='2', cushion=FOUR))) == ['6.2']


def test_the_nine_wins_on_any_legal_shot():
    assert judge(PLAY, Call(), after(('9', 'foot_left'))).state.winner == 0
    assert judge(BREAK, Call(), after(('9', 'foot_left'))).state.winner == 0


@pytest.mark.parametrize('gone', [{}, {'gone': ('9',)}])
def test_the_nine_goes_back_after_a_foul(gone):
    pots = () if gone else (('9', 'foot_left'),)
    ruling = judge(PLAY, Call(), after(*pots, first='2', **gone))
    assert not ruling.state.over
    assert '9' in ruling.state.balls
    assert ruling.state.in_hand == 'anywhere'


def test_a_break_drives_four_balls_to_cushions():
    assert numbers(judge(BREAK, Call(), after(cushion=(*FOUR[:3], 'cue')))) == ['2.3']
    ruling = judge(BREAK, Call(), after(cushion=FOUR))
    assert ruling.legal
    assert (ruling.state.phase, ruling.state.player) == ('second', 1)
    fouled = judge(BREAK, Call(), after(('cue', 'foot_left'), cushion=FOUR)).state
    assert (fouled.phase, fouled.in_hand) == ('play', 'anywhere')  # no push-out after a foul


def test_a_push_out_may_meet_nothing_and_lets_the_other_choose():
    ruling = judge(SECOND, PUSH, after(('9', 'foot_left'), first=None, cushion=()))
    assert ruling.legal
    assert '9' in ruling.state.balls  # 2.6
    assert (ruling.state.player, ruling.state.choices) == (1, ('accept', 'pass'))
    assert choose(ruling.state, 'accept').player == 1
    assert choose(ruling.state, 'pass').player == 0
    assert ruling.state.phase == 'play'
    scratched = judge(SECOND, PUSH, after(('cue', 'foot_left'), first=None, cushion=('1',)))
    assert numbers(scratched) == ['6.1']
    assert (scratched.state.choices, scratched.state.in_hand) == ((), 'anywhere')


def test_a_push_out_later_is_a_shot_like_others():
    assert numbers(judge(PLAY, PUSH, after(first=None, cushion=()))) == ['6.3']


def test_three_fouls_in_a_row_lose():
    twice = replace(PLAY, fouls=(2, 1))
    ruling = judge(twice, Call(), after(first='2'))
    assert numbers(ruling) == ['6.2', '6.14']
    assert (ruling.state.over, ruling.state.winner) == (True, 1)
    assert judge(twice, Call(), after()).state.fouls == (0, 1)  # a legal shot begins anew
