"""TPA, runs and ratings, from racks with known events or known strengths."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import combinations
import json
import math

import numpy as np
import pytest

from billiard_shot.cli import main, rate
from billiard_shot.game import Call, judge, Outcome, Pairing, play, start, State
from billiard_shot.game.rack import play_racks, PlayedShot, RackRecord
from billiard_shot.game.rating import ratings, tally
from billiard_shot.scene import Scene

TABLE = Scene.load('seven_foot')
ANCHOR = 'player:effort=0.5@fargo_500'
FIRST = start('eight_ball', TABLE).with_cue_ball(-0.6, 0.1).to_dict()


def rack(*visits, players=('a', 'b'), winner=None, number=0, game='eight_ball'):
    """Record visits of players in turn: balls that each shot made, and the end of the visit."""
    shots, balls = [], dict(FIRST['balls'])
    for i, (made, end) in enumerate(visits):
        for count in (*made, None):
            if count is None and end == 'won':
                break
            before = {**FIRST, 'balls': dict(balls), 'player': i % 2}
            for ball in [ball for ball in balls if ball != 'cue'][: count or 0]:
                del balls[ball]
            kept = count is not None
            shots.append(PlayedShot(before, kept=kept, end='' if kept else end))
    state = {**FIRST, 'balls': balls, 'over': winner is not None, 'winner': winner}
    return RackRecord(game, number, 1, players, tuple(shots), state)


@pytest.mark.parametrize(
    ('visits', 'errors'),
    [
        ([((1, 1), 'miss')], 1),
        ([((1, 2), 'scratch')], 1),
        ([((1,), 'foul')], 1),
        ([((1,), 'leave')], 1),  # its own shot left it
        ([((), 'leave')], 0),  # the other player left it
        ([((), 'break')], 0),
        ([((1,), 'safety'), ((), 'leave')], 0),
        ([((1,), 'safety'), ((1,), 'leave')], 1),  # the other player made a ball
        ([((1,), 'safety')], 0),
    ],
)
def test_an_error_is_what_tpa_calls_one(visits, errors):
    balls = sum(visits[0][0])
    found = tally([rack(*visits)], 'a')
    assert (found.balls, found.errors, found.ends) == (balls, errors, 1)
    assert found.longest == balls
    if errors:
        share, low, high = found.tpa
        assert share == balls / (balls + errors)
        assert low < share < high or share == 0.0


def test_balls_that_are_racked_again_do_not_hide_a_pot():
    few = {**FIRST, 'balls': {'cue': (0, 0), '1': (0.5, 0), '2': (0.5, 0.3)}}
    shots = PlayedShot(few, kept=True), PlayedShot(FIRST, end='miss')
    found = tally([RackRecord('straight_pool', 0, 1, ('a', 'b'), shots, FIRST)], 'a')
    assert found.balls == 1  # of the shot after which the balls were racked


def test_a_mean_run_is_that_of_equal_chances():
    """Runs with the chance 0.9 of each ball have the mean 9; the interval holds it."""
    draw = np.random.default_rng(3)
    inside = 0
    for _ in range(20):
        racks = [rack(((1,) * min(int(draw.geometric(0.1)) - 1, 15), 'miss')) for _ in range(60)]
        mean, low, high = tally(racks, 'a').mean_run
        assert low < mean < high
        p = 0.9  # runs are cut at 15 balls, after which the visit ends, too
        inside += low < sum(p**k for k in range(1, 16)) < high
    assert inside >= 17


def games(strengths, count, draw):
    """Play pairs of players with ratings in points."""
    for one, other in combinations(strengths, 2):
        chance = 1.0 / (1.0 + 2.0 ** (-(strengths[one] - strengths[other]) / 100.0))
        for won in draw.random(count) < chance:
            yield rack(((), 'won'), players=(one, other), winner=0 if won else 1)


def test_ratings_are_found_from_games():
    """Of 3 x 30 intervals of 95 % at least 90 % hold the true rating."""
    draw, inside = np.random.default_rng(5), []
    strengths = {ANCHOR: 500.0, 'b': 580.0, 'c': 460.0, 'd': 700.0}
    for _ in range(30):
        found = ratings([*games(strengths, 40, draw)])
        assert found[ANCHOR].points == pytest.approx(500.0)
        assert found[ANCHOR].reach == pytest.approx(0.0, abs=1e-6)
        inside += [abs(found[name].points - strengths[name]) < found[name].reach for name in 'bcd']
    assert np.mean(inside) > 0.9


def test_two_to_one_is_a_hundred_points():
    racks = [rack(players=('a', 'b'), winner=int(i % 3 == 0)) for i in range(600)]
    found = ratings(racks)
    assert found['a'].points - found['b'].points == pytest.approx(100.0, abs=1.0)
    assert found['a'].points + found['b'].points == pytest.approx(0.0, abs=1e-9)


def test_who_wins_all_has_a_finite_rating():
    found = ratings([rack(players=('a', 'b'), winner=0) for _ in range(10)])
    assert 300.0 < found['a'].points - found['b'].points < 600.0
    assert found['a'].reach > 100.0
    assert ratings([rack(players=('a',), winner=0), rack(players=('a', 'b'))]) == {}


def test_players_without_common_games_are_not_compared():
    apart = [rack(players=pair, winner=0) for pair in (('a', 'b'), ('c', 'd'))]
    with pytest.raises(ValueError, match='no games link a with c'):
        ratings(apart)


def test_a_ladder_is_played_by_any_executor_and_rated(tmp_path, capsys):
    """Twenty games: with fewer errors the same agent is stronger."""
    players = 'greedy@none', 'greedy@fargo_400'
    with ThreadPoolExecutor(2) as executor:
        racks = [*play_racks(Pairing('nine_ball', TABLE, players), range(20), executor)]
    path = tmp_path / 'racks.jsonl'
    path.write_text(''.join(json.dumps(each.to_dict()) + '\n' for each in racks))
    assert main(['rate', '--match', str(path), '--json']) == 0
    rows = {row['player']: row for row in json.loads(capsys.readouterr().out)}
    won, lost = (rows[name]['wins'] for name in players)
    assert (won > lost, won + lost) == (True, 20)
    points = 50.0 * math.log2((won + 0.5) / (lost + 0.5))
    assert [rows[name]['rating'] for name in players] == pytest.approx([points, -points])
    assert rows['greedy@none']['tpa'][0] > rows['greedy@fargo_400']['tpa'][0]
    assert main(['rate', '--match', str(path)]) == 0
    said = capsys.readouterr().out
    assert f'{rows["greedy@none"]["rating"]:.0f} (± ' in said
    assert 'fargorate.com' in said


def test_a_ladder_goes_on_where_it_was_ended(tmp_path, capsys, monkeypatch):
    rungs = 'greedy@fargo_400', 'greedy@fargo_500'
    monkeypatch.setattr(rate, 'RUNGS', rungs)
    path = tmp_path / 'ladder.jsonl'
    words = ['rate', 'greedy@none', '--scene', 'seven_foot', '--workers', '1', '--json']
    for count in (5, 20, 20):
        assert main([*words, '--ladder', str(path), '--racks', str(count)]) == 0
        rows = {row['player']: row for row in json.loads(capsys.readouterr().out)}
        assert len(path.read_text().splitlines()) == count
    assert [rows[name]['racks'] for name in ('greedy@none', *rungs)] == [20, 10, 10]
    assert sum(row['wins'] for row in rows.values()) == 20
    best = rows['greedy@none']
    assert best['rating'] > rows['greedy@fargo_400']['rating']
    assert 50.0 < best['reach'] < 400.0


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ([], 'rate needs either AGENT or --match'),
        (['greedy', '--match', 'FILE'], 'rate needs either AGENT or --match'),
        (['--match', 'FILE'], "line 1 must be the record of a rack, got 'hello'"),
        (['--match', 'nowhere.jsonl'], 'nowhere.jsonl'),
        (['--match', 'FILE', '--ladder', 'FILE'], '--ladder needs AGENT, not --match'),
        (['greedy', '--ladder', 'FILE'], 'line 1 must be the record of a rack'),
    ],
)
def test_matches_that_cannot_be_rated_are_refused(words, message, tmp_path, capsys):
    (tmp_path / 'file').write_text('hello\n')
    words = [str(tmp_path / 'file') if word == 'FILE' else word for word in words]
    assert main(['rate', *words]) == 2
    assert message in capsys.readouterr().err


# --- racks against the ghost, and how `rate` counts them -----------------------------------------

GHOSTS = 'eight_ball_ghost', 'nine_ball_ghost', 'ten_ball_ghost'
RUNS = 'straight_pool_ghost'
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


def test_a_third_foul_ends_a_run_in_straight_pool():
    """The same player would break again; so the rack went on, without a cue ball."""
    state = replace(in_break(RUNS), phase='second', in_hand='', fouls=(2, 0))
    ended = judge(state, Call(), Outcome(None, places=state.balls)).state
    assert (ended.over, ended.winner) == (True, None)


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


def test_a_run_of_straight_pool_goes_on_over_racks():
    """Each ball counts once; the last one but one is racked again."""
    state = replace(start(RUNS, 'pool_table'), phase='play', in_hand='')
    balls = {'cue': (-0.5, 0.0), '1': (-0.9, 0.4), '2': (-0.9, -0.4)}
    state = replace(state, balls=balls, scores=(21, 0))
    call = Call(ball='1', pocket='head_left')
    again = judge(state, call, seen(state, ('1', 'head_left'))).state
    assert (again.scores[0], again.player, again.over) == (22, 0, False)
    assert len(again.object_balls) == 15
    missed = judge(state, call, seen(state)).state
    assert (missed.scores[0], missed.over, missed.winner) == (21, True, None)
    last = replace(state, scores=(149, 0))
    ended = judge(last, call, seen(last, ('1', 'head_left'))).state
    assert (ended.scores[0], ended.over, ended.winner) == (150, True, 0)


def test_racks_are_played_and_kept_as_those_of_other_games():
    record = play(Pairing('nine_ball_ghost', Scene.load('seven_foot'), ('greedy',)), 3)
    assert State.from_dict(record.state).over
    assert record.shots[0].state['phase'] == 'break'
    assert all(shot.kept for shot in record.shots[1:-1])


def test_rate_counts_racks_and_balls(capsys):
    words = ['rate', 'greedy', '--scene', 'seven_foot', '--racks', '2', '--workers', '1']
    assert main([*words, '--json']) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row['game'] for row in rows] == [*GHOSTS, RUNS]
    scene = Scene.load('seven_foot')
    for row in rows:
        racks = [play(Pairing(row['game'], scene, ('greedy',)), number) for number in range(2)]
        assert row['wins'] == sum(rack.winner == 'greedy' for rack in racks)
        assert row['balls'] == sum(rack.state['scores'][0] for rack in racks) / 2
        assert row['balls_interval'][0] <= row['balls'] <= row['balls_interval'][1]
    mean, low, high = rows[-1]['run']
    assert low < mean < high
    assert mean == pytest.approx(rows[-1]['balls'])
    assert main(words) == 0
    said = capsys.readouterr().out
    assert f'{10 * rows[2]["balls"]:.0f} of 100 balls' in said
    assert f'runs in straight pool: mean {mean:.1f} ({low:.1f} to {high:.1f})' in said
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
