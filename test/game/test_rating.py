"""TPA, runs and ratings, from racks with known events or known strengths."""

from concurrent.futures import ThreadPoolExecutor
from itertools import combinations
import json
import math

import numpy as np
import pytest

from billiard_shot.cli import main
from billiard_shot.game import Pairing, start
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


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ([], 'rate needs either AGENT or --match'),
        (['greedy', '--match', 'FILE'], 'rate needs either AGENT or --match'),
        (['--match', 'FILE'], "line 1 must be the record of a rack, got 'hello'"),
        (['--match', 'nowhere.jsonl'], 'nowhere.jsonl'),
    ],
)
def test_matches_that_cannot_be_rated_are_refused(words, message, tmp_path, capsys):
    (tmp_path / 'file').write_text('hello\n')
    words = [str(tmp_path / 'file') if word == 'FILE' else word for word in words]
    assert main(['rate', *words]) == 2
    assert message in capsys.readouterr().err
