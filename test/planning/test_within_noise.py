"""Strokes at the accuracy of the noise: the same shares as exact strokes, the same refusals."""

from layouts import cloth_with, table_with
import numpy as np
import pytest

from billiard_shot import predict_batch, predict_within_noise, Scene, Status
from billiard_shot.scene import Noise


def sampled(scene, planned, count, seed):
    """Strokes as a player executes them."""
    draw = np.random.default_rng(seed)
    return scene.noise.sample(planned, count, draw, scene.ball.radius).reshape(-1, 5)


@pytest.mark.parametrize(
    'others', [{}, {'b1': (0.75, 0.33), 'b2': (0.4, -0.3), 'b3': (-0.7, 0.4)}]
)
def test_shares_of_many_strokes_are_those_of_exact_strokes(others):
    scene = table_with(cue=(0.1, 0.1), b8=(0.8, 0.27), **others)
    planned = [(0.0, b, 0.06, azimuth, 1.8) for b in (-0.3, 0.0, 0.3) for azimuth in (0.2, 0.24)]
    offsets = sampled(scene, planned, 120, 1)
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    assert fast.mapped.mean() > 0.9
    assert (exact.status == Status.OK).mean() > 0.95
    one, other = fast, exact
    assert one.names == other.names
    share = np.abs(
        (one.pocket >= 0).reshape(6, 120, -1).mean(axis=1)
        - (other.pocket >= 0).reshape(6, 120, -1).mean(axis=1)
    )
    assert share.max() < 0.08
    met = one.first_met[:, 0] == other.first_met[:, 0]
    assert met.mean() > 0.95
    apart = np.linalg.norm(fast.velocity - exact.velocity, axis=1)
    assert np.quantile(apart, 0.95) < 0.01 * 2.4  # m/s; the noise of the speed is 0.09
    rest = np.linalg.norm(one.final_position[:, 0] - other.final_position[:, 0], axis=1)
    assert np.median(rest) < 0.03


def test_refusals_are_those_of_exact_strokes():
    scene = table_with(cue=(-1.15, 0.1), b8=(0.8, 0.27), b1=(-1.1, 0.4))
    draw = np.random.default_rng(2)
    offsets = np.column_stack(
        [
            draw.uniform(-0.75, 0.75, (300, 2)),
            draw.uniform(-0.1, 0.4, 300),
            draw.uniform(-3.1, 3.1, 300),
            draw.uniform(0.5, 3.0, 300),
        ]
    )
    offsets[:2] = np.nan
    offsets[2:400:9, 4] = -1.0
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    refused = exact.refused
    assert refused.any()
    assert not refused.all()
    assert (fast.status[refused] == exact.status[refused]).all()
    assert not fast.refused[~refused].any()
    assert exact.miscue.any()
    assert (fast.miscue == exact.miscue).all()
    assert not exact.miscue[refused].any()
    assert len(np.unique(exact.status)) >= 4


def test_without_errors_every_strike_is_solved():
    scene = table_with(cue=(0.1, 0.1), b8=(0.8, 0.27))
    offsets = sampled(scene, (0.0, 0.1, 0.06, 0.2, 1.8), 200, 3)
    none = predict_within_noise(scene, offsets, noise=Noise(0.0, 0.0, 0.0, 0.0, 0.0))
    assert not none.mapped.any()
    exact = predict_batch(scene, offsets=offsets, tolerance=1e-3)
    assert np.allclose(none.velocity, exact.velocity, atol=1e-3)
    assert predict_within_noise(scene, np.zeros((0, 5))).status.shape == (0,)
    with pytest.raises(ValueError, match=r'offsets must be of shape \(n, 5\), got \(5,\)'):
        predict_within_noise(scene, offsets[0])


def test_a_cloth_without_a_table_will_do():
    scene = cloth_with(cue=(0.0, 0.0), b1=(0.5, 0.01))
    offsets = sampled(scene, (0.0, 0.1, 0.06, 0.0, 1.0), 200, 4)
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    assert (fast.first_met[:, 0] == exact.first_met[:, 0]).mean() > 0.98
    assert Scene.load('pool').noise == scene.noise
