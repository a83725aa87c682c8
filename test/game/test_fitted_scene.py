"""A scene is fitted to another simulator by the places at which balls come to rest."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.game import fitted_scene, simulated
from billiard_shot.game.fitted_scene import FITTED_PARAMETERS

TABLE = Scene.load('seven_foot')
THEIRS = TABLE.with_parameters(FITTED_PARAMETERS, [0.92, 0.23, 0.0125, 0.85])


def foreign(scene, stroke, errors):
    """Play without errors by numbers that the player does not know."""
    exact = TABLE.noise.times(0.0)
    return simulated(replace(THEIRS, balls=scene.balls, noise=exact), stroke, errors)


@pytest.mark.slow
def test_a_fitted_scene_has_the_numbers_of_the_simulator():
    fitted = fitted_scene(TABLE, foreign, shots=30)
    found = [parameter.value for parameter in fitted.parameters(FITTED_PARAMETERS)]
    expected = [parameter.value for parameter in THEIRS.parameters(FITTED_PARAMETERS)]
    first = [parameter.value for parameter in TABLE.parameters(FITTED_PARAMETERS)]
    off, before = (np.abs(np.array(each) / expected - 1.0) for each in (found, first))
    assert off.max() < 0.05
    assert off.mean() < 0.3 * before.mean()
    assert fitted.noise == TABLE.noise


def test_too_few_shots_and_unknown_numbers_are_refused():
    with pytest.raises(ValueError, match='shots'):
        fitted_scene(TABLE, foreign, shots=9)
    with pytest.raises(ValueError, match='cloth'):
        fitted_scene(TABLE, foreign, shots=10, names=['cloth.colour'])
