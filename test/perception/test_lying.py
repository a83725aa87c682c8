"""Balls that touch each other or a cushion, seen by a camera that errs."""

from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.perception.lying import positions_of
from billiard_shot.perception.sightings import Sighting

SCENE = Scene.load('pool_table')
RADIUS = SCENE.ball.radius


def seen(places, deviation, rng):
    covariance = (deviation**2, 0.0, deviation**2)
    return {
        name: Sighting(tuple((place + rng.normal(0.0, deviation, 2)).tolist()), covariance)
        for name, place in places.items()
    }


def at_the_rail():
    height = SCENE.table.cushion.height  # of the nose, in diameters of a ball
    y = SCENE.table.width / 2 - 2.0 * RADIUS * math.sqrt(height * (1.0 - height))
    return {'cue': np.array([0.3, y]), '1': np.array([0.3 + 2.0 * RADIUS, y])}


def rack():
    places = Scene.load('eight_ball').balls
    return {name: np.array(place) for name, place in places.items()}


@pytest.mark.parametrize('places', [rack(), at_the_rail()], ids=['rack', 'rail'])
@pytest.mark.parametrize('deviation', [0.0001, 0.0005])
def test_a_scene_takes_them(places, deviation):
    rng = np.random.default_rng(1)
    for _ in range(20):
        balls = seen(places, deviation, rng)
        found = positions_of(balls, SCENE)
        replace(SCENE, balls=found)  # raises ValueError if a ball overlaps another or a cushion
        moves = [np.hypot(*(found[name] - place)) for name, place in places.items()]
        assert max(moves) < 10.0 * deviation


def test_what_errors_do_not_explain_stays():
    balls = seen(
        {'cue': np.zeros(2), '1': np.array([1.5 * RADIUS, 0.0])}, 0.0005, np.random.default_rng(2)
    )
    assert positions_of(balls, SCENE) == {name: ball.position for name, ball in balls.items()}
    exact = {'cue': Sighting((0.0, 0.0)), '1': Sighting((2.0 * RADIUS - 1e-4, 0.0))}
    with pytest.raises(ValueError, match=r'balls\.1 must be at least 57\.15 mm from'):
        replace(SCENE, balls=positions_of(exact, SCENE))


def test_exact_balls_stay_where_they_are():
    balls = {name: Sighting(tuple(place)) for name, place in rack().items()}
    assert positions_of(balls, SCENE) == {name: ball.position for name, ball in balls.items()}
