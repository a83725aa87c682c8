"""Rulings from pictures: what the places of the balls before and after a shot allow."""

from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.game.rack import scene_of
from billiard_shot.game.referee import judge, start
from billiard_shot.game.state import Call, outcome_of
from billiard_shot.game.typed import MOVED, possible_rulings, ShotReport, told_outcome

SCENE = Scene.load('pool_table')


def state_of(game, balls, **fields):
    return replace(start(game, SCENE), phase='play', in_hand='', choices=(), balls=balls, **fields)


BALLS = {'cue': (-0.3, 0.0), '1': (0.3, 0.1), '9': (0.6, -0.3), '8': (0.0, 0.4)}


def test_a_lone_ball_that_fell_was_met():
    state = state_of('practice', BALLS)
    after = {**BALLS, 'cue': (0.1, 0.0)}
    del after['1']
    (ruling,) = possible_rulings(state, Call(), after)
    assert ruling.legal
    assert ruling.state.player == 0


def test_no_ball_moved():
    state = state_of('practice', BALLS)
    (ruling,) = possible_rulings(state, Call(), {**BALLS, 'cue': (0.1, 0.0)})
    assert [foul.rule for foul in ruling.fouls] == ['6.3']


def test_which_pocket_took_the_called_ball_is_not_seen():
    state = state_of('eight_ball', BALLS, groups=('solids', 'stripes'))
    after = {**BALLS, 'cue': (0.1, 0.0)}
    del after['1']
    rulings = possible_rulings(state, Call(ball='1', pocket='foot_left'), after)
    assert {ruling.state.player for ruling in rulings} == {0, 1}


def test_a_scratch_has_one_ruling_whatever_was_met():
    state = state_of('practice', BALLS)
    after = {'1': (0.5, 0.2), '9': (0.2, -0.3), '8': (0.0, 0.4)}
    (ruling,) = possible_rulings(state, Call(), after)
    assert ruling.state.over
    assert ruling.state.winner is None


@pytest.mark.parametrize('game', ['practice', 'eight_ball', 'nine_ball'])
def test_the_true_ruling_is_among_the_possible_ones(game):
    rng, compared = np.random.default_rng(5), 0
    for seed in range(60):
        state = replace(start('practice', SCENE, seed, balls=9), game=game, in_hand='')
        state = replace(state, groups=('solids', 'stripes') if game == 'eight_ball' else ('', ''))
        cue = (float(rng.uniform(-1.1, 1.1)), float(rng.uniform(-0.5, 0.5)))
        if any(math.dist(cue, place) < 0.07 for place in state.balls.values()):
            continue
        state = replace(state, balls={**state.balls, 'cue': cue})
        stroke = Stroke.from_offsets(
            elevation=0.1, azimuth=float(rng.uniform(-3.1, 3.1)), speed=float(rng.uniform(2, 5))
        )
        call = Call(ball='1', pocket='foot_left')
        outcome = outcome_of(predict(scene_of(SCENE, state), stroke))
        met = outcome.first_contact
        if outcome.refused or outcome.off_table or outcome.double_hit:
            continue
        if met in outcome.places and math.dist(outcome.places[met], state.balls[met]) < MOVED:
            continue
        ruling = judge(state, call, outcome)
        possible = possible_rulings(state, call, outcome.places)
        assert any(ruling.state == each.state for each in possible), (seed, ruling.text)
        told = ShotReport(met or '', outcome.to_cushion, dict(outcome.pocketed))
        complete = told_outcome(state, outcome.places, told)
        assert judge(state, call, complete).state == ruling.state
        compared += 1
    assert compared > 40


@pytest.mark.parametrize(
    ('told', 'words'),
    [
        ({'first_contact': '4'}, "first_contact must be one of '', '1'.*, got '4'"),
        ({'to_cushion': ['4']}, "to_cushion must be .*, got '4'"),
        ({'pockets': {'8': 'foot_left'}}, "pocketed must be one of '1', got '8'"),
        ({'pockets': {'1': 'corner'}}, "pockets must be .*, got 'corner'"),
    ],
)
def test_what_is_told_is_checked(told, words):
    after = {name: place for name, place in BALLS.items() if name != '1'}
    with pytest.raises(ValueError, match=words):
        told_outcome(state_of('practice', BALLS), after, ShotReport(**told))
