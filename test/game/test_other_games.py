"""Straight pool (WPA, part 4), three-cushion (UMB, 1989) and practice."""

from dataclasses import replace
from functools import partial
import math

from outcomes import numbers, outcome
import pytest

from billiard_shot.game import Call, choose, judge, Outcome, start

POOL = start('straight_pool', 'pool_table', seed=2, target=5)
BREAK = POOL.with_cue_ball(-0.7, 0.1)
PLAY = replace(BREAK, phase='play', in_hand='', scores=(2, 1))
CALL = Call(ball='3', pocket='foot_left')
CAROM = start('three_cushion', 'carom', target=2)
after = partial(outcome, PLAY, first='3')


def test_every_ball_that_falls_with_the_called_one_is_a_point():
    ruling = judge(PLAY, CALL, after(('3', 'foot_left'), ('7', 'side_left')))
    assert (ruling.state.scores, ruling.state.player, ruling.state.over) == ((4, 1), 0, False)
    won = judge(
        ruling.state,
        replace(CALL, ball='1'),
        after(('1', 'foot_left'), first='1', of=ruling.state),
    )
    assert (won.state.over, won.state.winner, won.state.scores) == (True, 0, (5, 1))


@pytest.mark.parametrize(
    ('call', 'pot', 'score'),
    [
        (CALL, ('4', 'foot_left'), 2),
        (replace(CALL, safety=True), ('3', 'foot_left'), 2),
        (CALL, ('cue', 'foot_left'), 1),
    ],
)
def test_balls_without_a_point_go_back(call, pot, score):
    state = judge(PLAY, call, after(pot)).state
    assert state.scores == (score, 1)
    assert state.player == 1
    assert set(PLAY.object_balls) <= set(state.balls)
    assert state.in_hand == ('kitchen' if pot[0] == 'cue' else '')


def test_the_opening_break_drives_cue_ball_and_two_balls():
    assert judge(BREAK, Call(safety=True), after(cushion=('cue', '1', '2'))).legal
    ruling = judge(BREAK, Call(safety=True), after(cushion=('cue', '1')))
    assert numbers(ruling) == ['4.10']
    assert ruling.state.scores == (-2, 0)
    assert ruling.state.fouls == (0, 0)  # 4.11: it is not counted
    again = choose(ruling.state, 'rebreak')
    assert (again.player, again.phase, again.scores) == (0, 'break', (-2, 0))


def test_the_third_foul_costs_fifteen_points_and_a_new_break():
    ruling = judge(replace(PLAY, fouls=(2, 0)), CALL, after(cushion=()))
    state = ruling.state
    assert numbers(ruling) == ['6.3', '6.14']
    assert (state.scores, state.fouls, state.player) == ((2 - 16, 1), (0, 0), 0)
    assert (state.phase, state.in_hand, len(state.balls)) == ('break', 'kitchen', 15)


FOOT, HEAD = 0.635, -0.635
IN_RACK = (FOOT + 0.05, 0.01)


@pytest.mark.parametrize(
    ('fifteenth', 'cue', 'places', 'in_hand'),
    [
        ((0.2, 0.3), (-0.3, 0.2), {'9': (0.2, 0.3), 'cue': (-0.3, 0.2)}, ''),
        (None, (-0.3, 0.2), {'9': (FOOT, 0.0), 'cue': (-0.3, 0.2)}, ''),
        (None, IN_RACK, {'9': (FOOT, 0.0)}, 'kitchen'),
        (IN_RACK, (FOOT + 0.1, -0.06), {'9': (FOOT, 0.0)}, 'kitchen'),
        (IN_RACK, (-0.3, 0.2), {'9': (HEAD, 0.0), 'cue': (-0.3, 0.2)}, ''),
        (IN_RACK, (HEAD, 0.01), {'9': (0.0, 0.0), 'cue': (HEAD, 0.01)}, ''),
        ((0.2, 0.3), IN_RACK, {'9': (0.2, 0.3)}, 'kitchen'),
        ((-0.9, 0.3), IN_RACK, {'9': (-0.9, 0.3), 'cue': (HEAD, 0.0)}, ''),
        ((HEAD - 0.01, 0.02), IN_RACK, {'9': (HEAD - 0.01, 0.02), 'cue': (0.0, 0.0)}, ''),
    ],
)
def test_fourteen_balls_are_racked_again(fifteenth, cue, places, in_hand):
    """The table of WPA 4.8."""
    balls = {'cue': cue, '3': (1.1, 0.5)}
    rests, pots = {'cue': cue}, [('3', 'foot_left')]
    if fifteenth is None:
        balls['9'] = (1.0, -0.5)
        pots.append(('9', 'foot_right'))
    else:
        balls['9'] = rests['9'] = fifteenth
    last = replace(PLAY, balls=balls, scores=(0, 0))
    state = judge(last, CALL, after(*pots, of=last, places=rests)).state
    assert len(state.object_balls) == 15
    assert state.player == 0
    assert state.in_hand == in_hand
    assert ('cue' in state.balls) == (in_hand == '')
    for ball, place in places.items():
        if place != (FOOT, 0.0):  # where any ball may lie
            assert math.dist(state.balls[ball], place) < 1e-3
    apex_is_free = all(math.dist(place, (FOOT, 0.0)) > 1e-3 for place in state.balls.values())
    assert apex_is_free == (math.dist(places['9'], (FOOT, 0.0)) > 1e-3)


def carom(*met, gone=(), **more):
    left = {ball: place for ball, place in CAROM.balls.items() if ball not in gone}
    balls, cushions = [ball for ball, _ in met], tuple(number for _, number in met)
    first = balls[0] if balls else None
    return Outcome(
        first, (), gone, met=tuple(balls), cushions_before=cushions, places=left, **more
    )


def test_three_cushions_before_the_second_ball_are_a_point():
    play = replace(CAROM, phase='play')
    state = judge(play, Call(), carom(('other', 0), ('red', 3))).state
    assert (state.scores, state.player, state.balls) == ((1, 0), 0, CAROM.balls)
    missed = judge(play, Call(), carom(('red', 1), ('other', 2))).state
    assert (missed.scores, missed.player) == ((0, 0), 1)
    assert missed.balls['cue'] == CAROM.balls['other']
    assert missed.balls['other'] == CAROM.balls['cue']
    won = judge(replace(play, scores=(1, 0)), Call(), carom(('other', 3), ('red', 3))).state
    assert (won.over, won.winner) == (True, 0)


def test_fouls_of_three_cushion():
    assert numbers(judge(CAROM, Call(), carom(('other', 0), ('red', 3)))) == ['23']
    play = replace(CAROM, phase='play')
    assert numbers(judge(play, Call(), carom(('red', 3), double_hit=True))) == ['41']
    lost = judge(play, Call(), carom(('red', 0), gone=('red',)))
    assert numbers(lost) == ['28']
    assert lost.state.balls['red'] == CAROM.balls['red']


def test_practice_ends_with_the_first_shot_without_a_pot():
    practice = start('practice', 'pool_table', seed=1, balls=2).with_cue_ball(-1.0, 0.0)
    one = judge(practice, Call(), after(('1', 'foot_left'), first='1', of=practice)).state
    assert (one.player, one.over) == (0, False)
    cleared = judge(one, Call(), after(('2', 'foot_left'), first='2', of=one)).state
    assert (cleared.over, cleared.winner) == (True, 0)
    for shot in (
        after(of=one, first='2'),
        after(('2', 'foot_left'), ('cue', 'foot_left'), of=one, first='2'),
    ):
        ended = judge(one, Call(), shot).state
        assert (ended.over, ended.winner) == (True, None)


@pytest.mark.parametrize('of', [start('nine_ball', 'pool_table'), CAROM])
def test_a_table_without_object_balls_has_a_ruling(of):
    alone = replace(of, balls={'cue': (0.0, 0.0)}, in_hand='')
    ruling = judge(alone, shot=Outcome(places={'cue': (0.5, 0.0)}))
    assert ruling.fouls or ruling.state.game.name == 'three_cushion'
    assert ruling.state.in_hand or 'cue' in ruling.state.balls
