"""Every kind of shot is found where nothing else leads to the target."""

from layouts import KINDS, table_with
import numpy as np
import pytest

from billiard_shot import plan, predict, Stroke
from billiard_shot.planning.result import kind_of
from billiard_shot.planning.targets import Gate, Hit, Pass, Pot, Rest

ONLY = ('kick', 'position', 'curve', 'massé', 'jump')  # without this way there is none at all


def check_path(shot, hit, *, flies):
    """Check that the cue ball flies over the balls in its way to another, or goes around them."""
    radius = shot.scene.ball.radius
    met = next(e.time for e in shot.events if len(e.balls) > 1)
    path = shot.trajectory.at(np.linspace(0.0, met - 1e-6, 500)).position
    height = path[:, 2].max() - radius
    others = [place for name, place in shot.scene.balls.items() if name not in ('cue', hit)]
    apart = min(np.hypot(*(path[:, :2] - place).T).min() for place in others)
    if flies:
        assert height > 2.0 * radius * 0.9
        assert apart < 2.0 * radius
    else:
        assert height < 2.0 * radius
        assert apart > 2.0 * radius


@pytest.mark.parametrize('kind', KINDS)
def test_the_only_way_is_found(kind):
    scene, target, limits, _ = KINDS[kind]
    result = plan(scene, target, constraints=limits)
    assert result.best is not None, result.message
    assert result.best.success > 0.15
    for each in result.ranking:
        assert kind in each.kind.split(', ')
    if kind in ('jump', 'massé', 'curve'):
        check_path(result.best.shot, target['hit'], flies=kind == 'jump')


@pytest.mark.parametrize('kind', ONLY)
def test_without_it_there_is_no_way(kind):
    scene, target, limits, change = KINDS[kind]
    result = plan(scene, target, constraints={**limits, **change}, budget=3000)
    assert result.best is None


@pytest.mark.parametrize(
    ('numbers', 'target', 'kind'),
    [
        ((0, 0, 0.05, 0, 2), Hit('8'), 'direct'),
        ((0, 0, 0.05, 0.045, 2), Hit('8'), 'cut'),
        ((0, 0, 0.05, 2.3, 4), Hit('8'), 'kick'),
        ((0, 0, 0.05, 0.01, 2), Pot('1'), 'combination'),
    ],
)
def test_names(numbers, target, kind):
    scene = table_with(cue=(0, 0), b8=(0.6, 0), b1=(0.9, 0))
    assert kind in kind_of(predict(scene, Stroke.from_offsets(*numbers)), target)


def test_a_ball_that_touches_the_struck_one_is_a_combination():
    shot = predict('frozen_combination', Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3.0))
    assert shot.pocketed == {'8': 'foot_left'}
    assert 'combination' in kind_of(shot, Pot('8')).split(', ')
    assert 'combination' not in kind_of(shot, Pot('1')).split(', ')


@pytest.mark.parametrize(
    ('target', 'kind'),
    [
        (Pass((0.5, 0.0)), 'direct'),
        (Gate(((0.5, -0.05), (0.5, 0.05))), 'direct'),
        (Rest((1.0, 0.0)), 'kick'),  # the cue ball comes back from the cushion
        (Pass((0.5, 0.3), radius=0.01), 'kick'),  # it never passes this point
    ],
)
def test_a_cushion_counts_only_before_the_target(target, kind):
    shot = predict('pool_table', Stroke.from_offsets(b=0.1, elevation_deg=5, speed=2))
    assert kind_of(shot, target) == kind
