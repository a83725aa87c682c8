"""Maps of the strike agree with exact strikes, and are used only where they do."""

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.planning.evaluate import evaluate_strokes
from billiard_shot.planning.limits import limits_of
from billiard_shot.planning.noises import NOISES
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.strike_map import bounds_of, FEWEST, fit_cell, Maps
from billiard_shot.planning.targets import target_of
from billiard_shot.scene import Noise
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.strike import Strokes
from billiard_shot.shot.strike_batch import strike_batch
from billiard_shot.shot.stroke import vectors_of

SCENE = Scene.load('blocked')
NOISE = NOISES['tournament']


def problem(noise=NOISE):
    limits = limits_of(SCENE, None, noise)
    return problem_of(SCENE, target_of(SCENE, {'pot': '8'}), limits, noise)


def mapped(scene, strokes, sigmas):
    maps = Maps(model_of(scene), bounds_of(sigmas))
    for cell in maps.missing(strokes):
        maps.fits[cell] = fit_cell(maps.model, cell)
    return maps.motions(strokes)


def cloud(centre, count, seed=1):
    draws = np.random.default_rng(seed).standard_normal((count, 5))
    return np.array(centre) + draws * problem().sigmas


@pytest.mark.parametrize(
    'centre',
    [(0.1, -0.1, 0.07, 1.0, 2.0), (-0.2, 0.15, 0.1, -2.0, 0.7), (0.0, 0.0, 0.3, 3.0, 6.0)],
)
def test_maps_agree_with_exact_strikes(centre):
    """At any azimuth and speed, for both signs of a, to a small part of the player's errors."""
    strokes = cloud(centre, 400)
    motions = mapped(SCENE, strokes, problem().sigmas)
    model = model_of(SCENE)
    radius = model.surface.radius
    there = ~np.isnan(motions[:, 0])
    assert there.mean() > 0.9
    centre = np.array([0.0, 0.0, radius])
    exact = strike_batch(Strokes(model, *vectors_of(strokes[there]), centre), 1e-4).rows
    found = motions[there] / strokes[there, 4:]
    for columns, name, scale in ((slice(0, 3), 'velocity', 1.0), (slice(3, 6), 'spin', radius)):
        error = scale * (found[:, columns] - exact[name] / strokes[there, 4:])
        assert np.abs(error).max() < 2e-4


def test_miscues_are_never_mapped():
    strokes = cloud((0.56, 0.0, 0.1, 0.0, 2.0), 400)
    assert np.isnan(mapped(SCENE, strokes, problem().sigmas)).all()


def test_few_strokes_players_without_errors_and_springs_that_are_not_linear_are_not_mapped():
    strokes = np.tile((0.05, 0.05, 0.1, 0.0, 2.0), (4 * FEWEST, 1))
    assert not np.isnan(mapped(SCENE, strokes, problem().sigmas)).any()
    assert np.isnan(mapped(SCENE, strokes[: FEWEST - 1], problem().sigmas)).all()
    hertz = Scene.from_dict({**SCENE.to_dict(), 'exponent': 1.5})
    bounds = bounds_of(problem().sigmas)
    assert Maps(model_of(SCENE), bounds).applies
    assert not Maps(model_of(SCENE), bounds_of(np.zeros(5))).applies
    assert not Maps(model_of(hertz), bounds).applies


def test_success_of_mapped_strokes_is_that_of_exact_ones():
    asked = problem(Noise())
    strokes = cloud((0.0, 0.0, 0.1, 0.2, 2.0), 2000)
    strokes[:, 3] += np.linspace(-0.3, 0.3, len(strokes))
    motions = mapped(SCENE, strokes, asked.sigmas)
    assert not np.isnan(motions).all()
    exact = evaluate_strokes(asked, strokes)
    fast = evaluate_strokes(asked, strokes, motions)
    assert (exact.success != fast.success).mean() < 0.01


def test_an_early_end_never_makes_a_success():
    """Runs that end when a ball has missed lose flukes, and nothing else."""
    asked = problem()
    strokes = cloud((0.0, 0.0, 0.1, 0.2, 4.0), 1000)
    strokes[:, 3] += np.linspace(-0.5, 0.5, len(strokes))
    full = evaluate_strokes(asked, strokes)
    early = evaluate_strokes(asked, strokes, to_the_end=False)
    assert not (early.success & ~full.success).any()
    assert (full.success & ~early.success).mean() < 0.03
