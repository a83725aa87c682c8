"""The rules of eight-ball, by the numbers of WPA, The Rules of Play, 15 March 2016, part 3."""

from dataclasses import replace
from functools import partial

from outcomes import numbers, outcome
import pytest

from billiard_shot.game import Call, choose, judge, start

START = start('eight_ball', 'pool_table', seed=4)
PLACES = {**START.balls, 'cue': (-0.7, 0.1)}
BREAK = START.with_cue_ball(-0.7, 0.1)
OPEN = replace(BREAK, phase='play', in_hand='')
SOLIDS = replace(OPEN, groups=('solids', 'stripes'))
ON_EIGHT = replace(SOLIDS, balls={ball: PLACES[ball] for ball in ('cue', '8', '9', '10')})
CALL = Call(ball='3', pocket='foot_left')
CALL_8 = Call(ball='8', pocket='head_left')
after = partial(outcome, BREAK, first='3')


def test_the_called_ball_keeps_the_turn_and_takes_the_group():
    ruling = judge(OPEN, CALL, after(('3', 'foot_left'), ('9', 'side_left')))
    assert ruling.legal
    assert ruling.state.player == 0
    assert ruling.state.groups == ('solids', 'stripes')  # 3.4: of the called ball
    assert set(OPEN.balls) - set(ruling.state.balls) == {'3', '9'}


def test_the_second_player_takes_a_group_for_itself():
    ruling = judge(replace(OPEN, player=1), CALL, after(('3', 'foot_left')))
    assert (ruling.state.player, ruling.state.groups) == (1, ('stripes', 'solids'))


@pytest.mark.parametrize('pot', [('3', 'foot_right'), ('4', 'foot_left')])
def test_a_ball_or_pocket_that_was_not_called_ends_the_turn_and_takes_no_group(pot):
    ruling = judge(OPEN, CALL, after(pot))
    assert ruling.legal
    assert (ruling.state.player, ruling.state.groups) == (1, ('', ''))
    assert ruling.state.in_hand == ''
    assert pot[0] not in ruling.state.balls  # 3.7: no ball but the 8 is ever spotted


def test_the_eight_must_not_be_met_first_on_an_open_table():
    ruling = judge(OPEN, CALL, after(('3', 'foot_left'), first='8'))  # 3.4
    assert (numbers(ruling), ruling.state.groups) == (['6.2'], ('', ''))


def test_a_called_safety_ends_the_turn_though_the_ball_falls():
    ruling = judge(SOLIDS, replace(CALL, safety=True), after(('3', 'foot_left')))
    assert ruling.legal
    assert ruling.state.player == 1


@pytest.mark.parametrize(
    ('rule', 'outcome'),
    [
        ('6.1', after(('3', 'foot_left'), ('cue', 'head_left'))),
        ('6.1', after(('3', 'foot_left'), gone=('cue',))),
        ('6.2', after(('3', 'foot_left'), first='9')),
        ('6.2', after(('3', 'foot_left'), first='8')),
        ('6.3', after(first=None, cushion=('cue',))),
        ('6.3', after(cushion=())),
        ('6.5', after(('3', 'foot_left'), gone=('5',))),
        ('6.6', after(refused='the cue would have to pass through ball 9')),
        ('6.7', after(('3', 'foot_left'), double_hit=True)),
    ],
)
def test_a_foul_gives_the_cue_ball_in_hand_anywhere(rule, outcome):
    ruling = judge(SOLIDS, CALL, outcome)
    assert numbers(ruling) == [rule]
    assert rule in ruling.text
    assert (ruling.state.player, ruling.state.in_hand) == (1, 'anywhere')
    assert 'cue' not in ruling.state.balls
    assert ruling.state.places_cue_ball


def test_play_from_the_kitchen_must_leave_it():
    behind = replace(SOLIDS, in_hand='kitchen')
    assert numbers(judge(behind, CALL, after(('3', 'foot_left'), from_kitchen=True))) == ['6.11']
    assert judge(SOLIDS, CALL, after(('3', 'foot_left'), from_kitchen=True)).legal


def test_the_eight_wins_when_called_after_the_group():
    ruling = judge(ON_EIGHT, CALL_8, after(('8', 'head_left'), first='8'))
    assert (ruling.state.over, ruling.state.winner) == (True, 0)


@pytest.mark.parametrize(
    ('state', 'call', 'outcome'),
    [
        (ON_EIGHT, CALL_8, after(('8', 'head_left'), ('cue', 'foot_left'), first='8')),  # (a)
        (ON_EIGHT, CALL_8, after(('8', 'head_left'), first='9')),
        (SOLIDS, CALL, after(('3', 'foot_left'), ('8', 'head_left'))),  # (b)
        (SOLIDS, CALL_8, after(('8', 'head_left'), first='3')),
        (OPEN, CALL_8, after(('8', 'head_left'), first='8')),
        (ON_EIGHT, CALL_8, after(('8', 'foot_left'), first='8')),  # (c)
        (ON_EIGHT, replace(CALL_8, safety=True), after(('8', 'head_left'), first='8')),
        (ON_EIGHT, CALL_8, after(gone=('8',), first='8')),  # (d)
    ],
)
def test_the_eight_loses_otherwise(state, call, outcome):
    ruling = judge(state, call, outcome)
    assert (ruling.state.over, ruling.state.winner) == (True, 1)


def test_a_scratch_on_the_eight_that_stays_is_only_a_foul():
    ruling = judge(ON_EIGHT, CALL_8, after(('cue', 'foot_left'), first='8'))
    assert not ruling.state.over
    assert ruling.state.in_hand == 'anywhere'


def test_three_fouls_have_no_penalty():
    ruling = judge(replace(SOLIDS, fouls=(2, 0)), CALL, after(first='9'))
    assert not ruling.state.over
    assert ruling.state.fouls == (3, 0)


FOUR = ('1', '2', '3', '4')


@pytest.mark.parametrize(
    ('outcome', 'player', 'choices', 'in_hand', 'legal'),
    [
        (after(cushion=FOUR), 1, (), '', True),
        (after(('5', 'foot_left'), cushion=()), 0, (), '', True),
        (after(cushion=FOUR[:3]), 1, ('accept', 'break', 'rebreak'), '', True),
        (after(cushion=(*FOUR[:3], 'cue')), 1, ('accept', 'break', 'rebreak'), '', True),
        (after(('8', 'foot_left'), cushion=()), 0, ('accept', 'break'), '', True),
        (
            after(('8', 'foot_left'), ('cue', 'foot_left')),
            1,
            ('accept', 'break'),
            'kitchen',
            False,
        ),
        (after(('cue', 'foot_left'), cushion=FOUR), 1, (), 'kitchen', False),
        (after(gone=('7',), cushion=FOUR), 1, ('accept', 'kitchen'), '', False),
        (after(first=None, cushion=()), 1, ('accept', 'break', 'rebreak'), '', True),
    ],
)
def test_the_break(outcome, player, choices, in_hand, legal):
    state = judge(BREAK, Call(), outcome).state
    assert judge(BREAK, Call(), outcome).legal == legal
    assert (state.player, state.choices, state.in_hand) == (player, choices, in_hand)
    assert '8' in state.balls  # 3.7
    assert state.groups == ('', '')  # 3.3: the table stays open
    assert not state.over


def test_the_eight_goes_back_to_the_foot_spot():
    free = {'cue': (-0.5, 0.0), '1': (0.0, 0.3)}
    state = judge(BREAK, Call(), after(('8', 'foot_left'), places=free)).state
    assert state.balls['8'] == (0.635, 0.0)


def test_choices_are_carried_out():
    state = judge(BREAK, Call(), after(cushion=FOUR[:3])).state
    with pytest.raises(ValueError, match='waits for a choice of accept, break, rebreak'):
        judge(state, Call(), after())
    with pytest.raises(ValueError, match=r"must be one of accept, .*got 'pass'"):
        choose(state, 'pass')
    accepted = choose(state, 'accept')
    assert (accepted.choices, accepted.balls, accepted.player) == ((), state.balls, 1)
    own = choose(state, 'break')
    assert (own.player, own.phase, own.in_hand, len(own.balls)) == (1, 'break', 'kitchen', 15)
    assert own.balls != START.balls  # another rack
    assert choose(state, 'rebreak').player == 0
    jumped = judge(BREAK, Call(), after(gone=('7',), cushion=FOUR)).state
    kitchen = choose(jumped, 'kitchen')
    assert kitchen.places_cue_ball
    assert kitchen.in_hand == 'kitchen'
