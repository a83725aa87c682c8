"""Balls that touch each other or a cushion, seen by a camera that errs."""

from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.perception.sightings import positions_of, Sighting

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


@pytest.mark.parametrize('places', [rack(), at_the_rail()], ids=['rack', 'rail'])
def test_a_camera_with_systematic_errors_is_believed_within_them(places):
    """Each ball has an error of its own that no average takes away; its average is surer."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        averaged = seen(places, 0.7e-3 / math.sqrt(60), rng)
        balls = {
            name: replace(
                ball,
                position=tuple((ball.position + rng.normal(0.0, 0.5e-3, 2)).tolist()),
                systematic_error=0.5e-3,
            )
            for name, ball in averaged.items()
        }
        found = positions_of(balls, SCENE)
        replace(SCENE, balls=found)
        moves = [np.hypot(*(found[name] - place)) for name, place in places.items()]
        assert np.mean(moves) < 1e-3


def test_the_moves_are_the_smallest_and_shared_by_the_deviations():
    """Two balls overlap by 0.5 mm; the error of one is twice that of the other one."""
    balls = {
        'cue': Sighting((0.0, 0.0), systematic_error=0.2e-3),
        '1': Sighting((2.0 * RADIUS - 0.5e-3, 0.0), systematic_error=0.4e-3),
        '2': Sighting((0.0, 0.3), systematic_error=0.4e-3),
    }
    found = positions_of(balls, SCENE)
    assert found['cue'] == pytest.approx((-0.1e-3, 0.0), abs=1e-6)
    assert found['1'] == pytest.approx((2.0 * RADIUS - 0.1e-3, 0.0), abs=1e-6)
    assert found['2'] == balls['2'].position
    exact = balls | {'cue': Sighting((0.0, 0.0))}
    assert positions_of(exact, SCENE)['cue'] == (0.0, 0.0)


def test_balls_in_the_mouth_of_a_pocket_stay_there():
    half = SCENE.table.width / 2
    ball = Sighting((0.0, half - 0.01), systematic_error=0.5e-3)
    assert positions_of({'cue': ball}, SCENE) == {'cue': ball.position}
    replace(SCENE, balls={'cue': ball.position})


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
