"""Straight pool over racks: which ball is left, where the cue ball stops, how a rack breaks."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene
from billiard_shot.game import judge, start
from billiard_shot.game.agents.player import Player
from billiard_shot.game.next_rack import BLOCKED, into_rack, LEAST, run_goes_on
from billiard_shot.game.rack import scene_of
from billiard_shot.game.state import find_game
from billiard_shot.game.strokes import direct_shots, placed
from billiard_shot.game.valuation import at_table, EQUAL
from billiard_shot.table.run.results import POCKET_NAMES

SCENE = Scene.load('pool_table')
BARE = replace(SCENE, balls={})
GAME = find_game('straight_pool_ghost')
BESIDE = (0.75, 0.25)  # of the rack, whose nearest ball is 0.14 m away


def state_of(game=GAME, **balls):
    return replace(start(game, SCENE, 1), balls=balls, phase='play', in_hand='')


def geometric(ball, cue, pocket):
    """Chance that the run goes on after the last ball, by the geometry of its pot."""
    state = state_of(**{'5': ball, 'cue': cue})
    direct = direct_shots(BARE, state)
    found = into_rack(start(GAME, SCENE), direct, placed(state))
    return found[direct.pocket == POCKET_NAMES.index(pocket)].item()


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_the_chance_to_break_follows_from_the_way_of_the_cue_ball(side):
    at, (pocket, other) = (0.75, 0.25 * side), ('foot_left', 'foot_right')[:: int(side)]
    assert geometric(at, (0.35, 0.25 * side), pocket) > 0.7  # a cut into the rack
    assert LEAST <= geometric(at, (0.45, 0.05 * side), pocket) < 0.3  # straight into the pocket
    assert geometric((1.1, 0.0), (0.3, 0.3 * side), other) == BLOCKED  # the rack is between


def test_a_cushion_sends_the_cue_ball_into_the_rack_with_less_speed():
    direct = geometric(BESIDE, (0.35, 0.25), 'foot_left')
    by_cushion = geometric((-0.05, 0.5), (-0.4, 0.3), 'side_left')
    assert LEAST < by_cushion < direct


def chances(state):
    """Chance that the run goes on after the best direct shot of each ball."""
    direct = direct_shots(BARE, state)
    found = run_goes_on(BARE, state, direct, placed(state))
    return {
        ball: found[direct.ball == direct.names.index(ball)].max() for ball in state.object_balls
    }


TWO = {'1': BESIDE, '2': (-0.6, 0.45), 'cue': (0.3, 0.05)}


def test_the_ball_beside_the_rack_is_the_better_one_to_be_left():
    found = chances(state_of(**TWO))
    assert found['2'] > 0.5
    assert found['1'] < 0.7 * found['2']


def test_where_no_rack_follows_the_balls_that_are_left_do_not_count():
    wins = replace(state_of(**TWO), target=20, scores=(18, 0))
    assert chances(wins) == chances(state_of(find_game('practice'), **TWO)) == {'1': 1, '2': 1}
    assert chances(replace(wins, scores=(17, 0))) == chances(state_of(**TWO))


@pytest.mark.parametrize('game', ['straight_pool', 'straight_pool_ghost'])
def test_without_a_ball_that_is_left_a_rack_is_hard_to_break(game):
    """It was worth as much as a rack that is won."""
    worth = at_table(np.zeros(2), find_game(game), np.array([[0, 1], [0, 0]]), EQUAL)
    assert worth.tolist() == [LEAST, LEAST]
    assert at_table(np.zeros(1), find_game('practice'), np.array([[0, 0]]), EQUAL) == 1.0


def test_the_player_keeps_the_ball_beside_the_rack():
    state = state_of(**TWO)
    assert Player(SCENE, 1, effort=0.3).decide(state).call.ball == '2'
    alone = replace(state, game=replace(GAME, reracked=0))
    assert Player(SCENE, 1, effort=0.3).decide(alone).call.ball == '1'


def test_the_last_ball_breaks_the_rack():
    state = start(GAME, SCENE, 1)
    balls = {**state.balls, '1': BESIDE, 'cue': (0.35, 0.25)}
    state = replace(state, balls=balls, phase='play', in_hand='')
    decision = Player(SCENE, 1, effort=0.3).decide(state)
    shot = predict(scene_of(SCENE, state), decision.stroke)
    after = judge(state, decision.call, shot).state
    assert not after.over
    moved = [
        np.hypot(*np.subtract(after.balls[ball], state.balls[ball])) > 2.0 * state.radius
        for ball in after.object_balls
    ]
    assert '1' not in after.balls
    assert sum(moved) >= 5
