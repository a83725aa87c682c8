"""Racks against the ghost, and how `rate` counts them."""

from dataclasses import replace
import json

import pytest

from billiard_shot.cli import main
from billiard_shot.game import Call, judge, Outcome, Pairing, play, start, State
from billiard_shot.scene import Scene

GHOSTS = 'eight_ball_ghost', 'nine_ball_ghost', 'ten_ball_ghost'
FOUR = frozenset('1234')


def in_break(game):
    return start(game, 'pool_table', seed=4).with_cue_ball(-0.7, 0.1)


def seen(state, *pots, first='1', gone=()):
    lost = {*gone, *(ball for ball, _ in pots)}
    left = {ball: place for ball, place in state.balls.items() if ball not in lost}
    return Outcome(first, pots, tuple(gone), FOUR & left.keys(), places=left)


@pytest.mark.parametrize('game', GHOSTS)
@pytest.mark.parametrize('pots', [(), (('5', 'side_left'),), (('cue', 'side_left'),)])
def test_the_cue_ball_is_in_hand_after_every_break(game, pots):
    state = in_break(game)
    after = judge(state, Call(), seen(state, *pots)).state
    assert (after.player, after.in_hand, after.phase) == (0, 'anywhere', 'play')
    assert not after.over
    assert after.choices == ()
    assert 'cue' not in after.balls
    assert after.scores[0] == (pots == (('5', 'side_left'),))


@pytest.mark.parametrize('game', GHOSTS)
def test_the_first_miss_and_the_first_foul_end_the_rack(game):
    state = replace(in_break(game), phase='play', in_hand='')
    call = Call(ball='1', pocket='foot_left')
    went_on = judge(state, call, seen(state, ('1', 'foot_left'))).state
    assert not went_on.over
    assert went_on.scores[0] == 1
    missed = judge(state, call, seen(state)).state
    scratched = judge(state, call, seen(state, ('1', 'foot_left'), ('cue', 'side_left'))).state
    for ended in (missed, scratched):
        assert (ended.over, ended.winner, ended.scores[0]) == (True, None, 0)


@pytest.mark.parametrize('game', GHOSTS)
def test_the_last_ball_wins(game):
    state = in_break(game)
    last = state.game.decisive
    state = replace(state, phase='play', in_hand='', balls={'cue': (0.0, 0.0), last: (0.5, 0.2)})
    call = Call(ball=last, pocket='foot_left')
    ended = judge(state, call, seen(state, (last, 'foot_left'), first=last)).state
    assert (ended.over, ended.winner, ended.scores[0]) == (True, 0, 1)


@pytest.mark.parametrize('game', GHOSTS)
def test_the_decisive_ball_of_a_break_goes_back_and_does_not_count(game):
    state = in_break(game)
    after = judge(state, Call(), seen(state, (state.game.decisive, 'side_left'))).state
    if game == 'nine_ball_ghost':
        assert after.winner == 0  # the 9 wins on any legal shot, also in the break (2.8)
    else:
        assert state.game.decisive in after.balls
        assert after.scores[0] == 0


def test_racks_are_played_and_kept_as_those_of_other_games():
    record = play(Pairing('nine_ball_ghost', Scene.load('seven_foot'), ('greedy',)), 3)
    assert State.from_dict(record.state).over
    assert record.shots[0].state['phase'] == 'break'
    assert all(shot.kept for shot in record.shots[1:-1])


def test_rate_counts_racks_and_balls(capsys):
    words = ['rate', 'greedy', '--scene', 'seven_foot', '--racks', '2', '--workers', '1']
    assert main([*words, '--json']) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row['game'] for row in rows] == list(GHOSTS)
    scene = Scene.load('seven_foot')
    for row in rows:
        racks = [play(Pairing(row['game'], scene, ('greedy',)), number) for number in range(2)]
        assert row['wins'] == sum(rack.winner == 'greedy' for rack in racks)
        assert row['balls'] == sum(rack.state['scores'][0] for rack in racks) / 2
        assert row['balls_interval'][0] <= row['balls'] <= row['balls_interval'][1]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert f'{5 * sum(rack.state["scores"][0] for rack in racks)} of 100 balls' in said
    assert 'billiards.colostate.edu' in said


def test_less_noise_is_a_stronger_player(capsys):
    words = ['rate', 'greedy', '--scene', 'seven_foot', '--racks', '4', '--workers', '1', '--json']
    found = {}
    for scale in ('0.01', '4'):
        assert main([*words, '--noise-scale', scale]) == 0
        rows = json.loads(capsys.readouterr().out)
        found[scale] = sum(row['balls'] for row in rows)
    assert found['0.01'] > found['4'] + 3


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['gredy'], 'the nearest is greedy'),
        (['greedy', '--racks', '0'], '--racks must be'),
        (
            ['greedy', '--noise-scale', '-1'],
            '--noise-scale must be a finite number at least 0, got -1.0',
        ),
        (['greedy', '--scene', 'carom'], 'eight_ball_ghost needs a table with pockets'),
    ],
)
def test_bad_requests_are_named(words, message, capsys):
    assert main(['rate', *words]) == 2
    assert message in capsys.readouterr().err
