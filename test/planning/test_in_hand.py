"""A cue ball in hand is put where the plan is good; candidates come before any race."""

import math

from layouts import table_with
import numpy as np
import pytest

from billiard_shot import candidates, plan, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.table.run.results import POCKET_NAMES

R = Scene.load('pool_table').ball.radius


@pytest.mark.parametrize('place', ['anywhere', 'kitchen'])
def test_a_cue_ball_in_hand_is_put_where_the_pot_is_likely(place):
    scene = table_with(cue=(1.0, -0.5), b8=(0.3, 0.2), b1=(0.6, 0.1), b2=(-0.2, 0.4))
    target = {'pot': '8', 'pocket': 'any'}
    fixed = plan(scene, target, budget=1500, seed=1)
    result = plan(scene, target, budget=1500, seed=1, place=place)
    assert result.status == Status.OK
    x, y = result.place
    assert fixed.place is None
    assert place == 'anywhere' or x < -0.25 * scene.table.length + 1e-9
    others = [xy for name, xy in scene.balls.items() if name != 'cue']
    assert min(math.dist((x, y), other) for other in others) >= 2.0 * R
    assert result.best.success > (0.95 if place == 'anywhere' else 0.3)
    assert result.best.shot.pocketed.keys() == {'8'}
    assert predict(scene, result.best.stroke, position=(x, y)).pocketed.keys() == {'8'}


def test_a_cue_ball_in_hand_needs_a_ball_to_be_potted():
    scene = table_with(cue=(1.0, -0.5), b8=(0.3, 0.2))
    with pytest.raises(ValueError, match='place must be anywhere or kitchen, got'):
        plan(scene, {'pot': '8'}, place='table')
    with pytest.raises(
        ValueError, match='place needs the target pot or break, got the target hit'
    ):
        plan(scene, {'hit': '8'}, place='anywhere')


def test_candidates_that_reach_the_target_do():
    scene = table_with(cue=(0.3, 0.1), b8=(0.8, 0.3))
    found = candidates(scene, {'pot': '8', 'pocket': 'foot_left'})
    good = found.offsets[found.penalty == 0.0]
    assert len(good) > 5
    assert (np.diff(found.penalty) >= 0.0).all()
    assert np.ptp(good[:, 4]) > 1.0  # of different speeds
    assert len(np.unique(good[:, 1].round(3))) > 1  # and heights
    batch = predict_batch(scene, offsets=good)
    ball = batch.names.index('8')
    potted = batch.pocket[:, ball] == POCKET_NAMES.index('foot_left')
    assert potted.mean() > 0.95  # the search is a little less accurate
    assert len(candidates(scene, {'pot': '8'}, budget=10)) == 10
    assert Stroke.from_offsets(*good[0].tolist()).speed == pytest.approx(good[0, 4])
