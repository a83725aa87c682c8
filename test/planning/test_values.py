"""Plans by values of outcomes, safeties, breaks: what they state holds with fresh errors."""

from layouts import table_with
import numpy as np
import pytest

from billiard_shot import plan, predict_batch, Scene, shots
from billiard_shot.scene.placement import head_string

TRIALS = 1500
POCKET_8 = table_with(cue=(0.2, 0.05), b8=(0.9, 0.3), b1=(-0.9, -0.4))


def near_the_head(outcomes):
    """Value of a pot of the 8: the nearer the cue ball rests to the head, the better."""
    eight, x = outcomes.names.index('8'), outcomes.final_position[:, 0, 0]
    made = (outcomes.pocket[:, eight] >= 0) & (outcomes.pocket[:, 0] < 0)
    return np.where(made, np.clip(0.5 - x / 2.54, 0.0, 1.0), 0.0)


def played(scene, stroke, seed=5):
    """Play a stroke with fresh errors, by exact predictions."""
    draw = np.random.default_rng(seed)
    offsets = scene.noise.sample(stroke.offsets, TRIALS, draw, scene.ball.radius)
    return predict_batch(scene, offsets=offsets)


def usable(batch):
    return ~batch.refused & ~batch.miscue & ~batch.double_hit


def test_the_best_value_is_better_than_that_of_the_surest_pot():
    surest = plan(POCKET_8, {'pot': '8'}, budget=20000).best
    best = plan(POCKET_8, {'pot': '8'}, budget=20000, value=near_the_head).best
    batch = played(POCKET_8, best.stroke)
    values = np.where(usable(batch), near_the_head(batch), 0.0)
    error = np.hypot(values.std() / TRIALS**0.5, best.value_error)
    assert abs(values.mean() - best.value) < 4.0 * error
    assert best.value > near_the_head(played(POCKET_8, surest.stroke)).mean() + 0.1
    assert best.success < surest.success + 0.05


def test_without_values_the_value_is_the_success():
    for each in plan(POCKET_8, {'pot': '8'}, budget=3000).ranking:
        assert each.value == each.success


@pytest.mark.parametrize(
    ('value', 'named'),
    [
        (lambda outcomes: 0.5, r'value must return \(\d+,\) numbers from 0 to 1, got shape'),
        (lambda outcomes: np.full(len(outcomes.status), 1.5), 'from 0 to 1, got 1.5'),
        (lambda outcomes: np.full(len(outcomes.status), np.nan), 'from 0 to 1, got nan'),
    ],
)
def test_values_that_make_no_sense_are_refused(value, named):
    with pytest.raises(ValueError, match=named):
        plan(POCKET_8, {'pot': '8'}, budget=100, value=value)


def test_a_safety_leaves_no_good_shot():
    scene = table_with(
        cue=(-0.4, 0.2), b1=(0.7, 0.1), b8=(1.1, 0.5), b9=(-1.1, 0.5), b10=(0.3, -0.4)
    )
    goal = {'safe': '1', 'against': '9', 'chance': 0.3}
    best = plan(scene, goal, budget=15000).best
    run = played(scene, best.stroke)
    ball = run.names.index('1')
    legal = usable(run) & (run.first_met[:, 0] == ball) & (run.pocket[:, 0] < 0)
    legal &= run.to_cushion.any(axis=1) | (run.pocket >= 0).any(axis=1)
    left = shots(scene, run.states, ['9']).best
    success = (legal & (left <= 0.3)).mean()
    assert best.success > 0.5
    assert abs(success - best.success) < 4.0 * np.sqrt(0.25 / TRIALS + 0.25 / best.trials)
    assert 'safety' in best.kind


def test_a_break_pots_a_ball():
    scene = Scene.load('nine_ball')
    result = plan(scene, {'break': '1'}, budget=400, place='kitchen')
    assert result.place[0] < head_string(scene.table)
    best = result.best
    run = best.shot.run
    assert best.shot.first_contact == '1'
    assert best.success > 0.3
    assert 'break' in best.kind
    assert set(run.pocketed) != {'cue'}


@pytest.mark.parametrize(
    ('target', 'named'),
    [
        ({'safe': '9'}, "safe must be one of .*, got '9'"),
        ({'safe': '8', 'against': '9'}, "against must be one of .*, got '9'"),
        ({'safe': '8', 'chance': 2}, 'chance must be .*, got 2'),
        ({'break': 'cue'}, "break must be .*, got 'cue'"),
        ({'break': '8', 'pots': 0}, 'pots must be .*, got 0'),
        ({'breaking': '8'}, 'breaking is unknown; the nearest key is break'),
        ({'safe': '8', 'place': 'kitchen'}, 'place'),
    ],
)
def test_bad_targets_are_refused(target, named):
    with pytest.raises(ValueError, match=named):
        plan(POCKET_8, target, budget=10)
    with pytest.raises(ValueError, match='needs a table with pockets; the scene has none'):
        plan(Scene.load('carom'), {'safe': 'any'}, budget=10)


def test_a_safety_has_no_place():
    with pytest.raises(ValueError, match='place needs the target pot or break, got the target '):
        plan(POCKET_8, {'safe': '8'}, budget=10, place='kitchen')
