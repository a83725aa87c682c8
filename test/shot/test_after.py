"""The scene after a shot: always one in which the next stroke can be played."""

import math

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.scene import Noise


def test_shots_follow_each_other():
    """Every scene is accepted, and what fell is gone."""
    first = scene = Scene.load('eight_ball')
    draw = np.random.default_rng(3)
    for _ in range(40):
        azimuth, speed = draw.uniform(-3.1, 3.1), draw.uniform(1.0, 9.0)
        shot = predict(scene, Stroke.from_offsets(0.0, 0.1, 0.3, azimuth, speed), tolerance=1e-3)
        if shot.status.refused:  # the cue would go through a ball
            continue
        after = shot.after()
        gone = {*shot.run.pocketed, *shot.run.off_table} - {'cue'}
        assert set(after.balls) == set(scene.balls) - gone | {'cue'}
        for name in set(after.balls) - {'cue'}:
            assert np.allclose(after.balls[name], shot.run.final_position[name][:2])
        scene = after if len(after.balls) > 4 else first


def test_a_cue_ball_that_fell_is_in_hand():
    data = Scene.load('pool_table').to_dict()
    data['balls'] = {'cue': (1.0, 0.48), '1': (-0.635, 0.0)}
    scene = Scene.from_dict(data)
    shot = predict(scene, Stroke.from_offsets(0.0, 0.0, 0.1, np.arctan2(0.115, 0.23), 2.0))
    assert 'cue' in shot.run.pocketed
    x, y = shot.after().balls['cue']
    assert np.isclose(x, -0.25 * scene.table.length)
    assert 0.0 < abs(y) < 0.1  # beside the ball on the head spot


def test_perturbed_strokes_have_the_errors_of_the_player():
    noise, draw = Noise(), np.random.default_rng(1)
    stroke = Stroke.from_offsets(0.1, -0.1, 0.2, 1.0, 2.0)
    played = np.array([noise.perturb(stroke, draw, 0.03).offsets for _ in range(4000)])
    wanted = (noise.a / 0.03, noise.b / 0.03, np.radians(0.1), np.radians(0.125), 0.075)
    assert np.allclose(played.std(axis=0), wanted, rtol=0.05)
    assert np.allclose(played.mean(axis=0), stroke.offsets, atol=5e-3)


def test_samples_are_perturbed_strokes_as_arrays():
    noise = Noise(elevation_deg=1.0, speed=0.5)
    planned = [(0.1, -0.1, 0.2, 1.0, 2.0), (0.2, 0.1, 1.57, -3.1, 0.3)]
    for row in planned:
        stroke = Stroke.from_offsets(*row)
        alone = [noise.perturb(stroke, draw).offsets for draw in _draws()]
        many = [noise.sample(stroke, 1, draw)[0] for draw in _draws()]
        assert np.allclose(many, alone, atol=1e-9)
    both = noise.sample(planned, 50, np.random.default_rng(1))
    assert both.shape == (2, 50, 5)
    assert (both[..., 2] <= 0.5 * math.pi).all()
    assert (np.abs(both[..., 3]) <= math.pi).all()
    assert (both[..., 4] >= 1e-3).all()
    assert (both[0, :, 4] != both[1, :, 4] + 1.7).all()  # errors of their own
    with pytest.raises(ValueError, match=r'strokes must be of shape \(5,\) or \(m, 5\), got'):
        noise.sample([1.0, 2.0], 3, np.random.default_rng(1))
    with pytest.raises(ValueError, match=r'n must be .*, got 0'):
        noise.sample(planned, 0, np.random.default_rng(1))


def _draws():
    return [np.random.default_rng(seed) for seed in range(30)]


@pytest.mark.parametrize('radius', [0, -0.03, math.nan, None])
def test_perturbed_strokes_need_a_radius(radius):
    with pytest.raises(ValueError, match=r'ball_radius must be finite and above 0, got .* \(m\)'):
        Noise().perturb(Stroke.from_offsets(speed=1), np.random.default_rng(1), radius)


@pytest.mark.parametrize('speed', [0.35, 0.43, 0.437, 0.44])
def test_a_ball_may_rest_beside_the_hole_of_a_pocket(speed):
    shot = predict(
        'pool_table',
        Stroke.from_offsets(elevation_deg=10, azimuth_deg=20.136, speed=speed),
        position=(1.0, 0.55),
    )
    assert not shot.scratched
    scene = shot.after()
    back = Stroke.from_offsets(elevation_deg=40, azimuth_deg=200, speed=1.0)
    assert not predict(scene, back).status.refused


def test_errors_may_turn_a_steep_stroke_beyond_the_vertical():
    noise = Noise(elevation_deg=1.0, azimuth_deg=0.0, a=0.0, b=0.0, speed=0.0)
    stroke = Stroke.from_offsets(0.1, 0.2, elevation_deg=89.9, speed=1)
    draw = np.random.default_rng(1)
    turned = [noise.perturb(stroke, draw) for _ in range(50)]
    ways = np.array([each.velocity[0] for each in turned])
    assert (ways > 0.0).any()
    assert (ways < 0.0).any()
    for each in turned:
        assert np.linalg.norm(np.subtract(each.normal, stroke.normal)) < math.radians(5.0)
        assert np.linalg.norm(np.subtract(each.velocity, stroke.velocity)) < math.radians(5.0)
