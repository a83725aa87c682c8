"""Balls that have moved are told from balls that were measured with errors."""

from dataclasses import replace
import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.perception.sightings import (
    largest_deviation,
    moved,
    positions_of,
    REST_DISTANCE,
    REST_TIME,
    RestWatch,
    Sighting,
)
from billiard_shot.perception.sightings import uncertain as is_uncertain

TOLERANCE = 1e-3


def sightings(places):
    return {name: Sighting(place) for name, place in places.items()}


PLANNED = sightings({'cue': (0.0, 0.0), '8': (0.5, 0.0)})


def uncertain(x, y, deviation):
    return Sighting((x, y), (deviation**2, 0.0, deviation**2))


@pytest.mark.parametrize(
    ('seen', 'words'),
    [
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0)}, ''),
        ({'cue': (0.0005, 0.0), '8': (0.5, -0.0009)}, ''),
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0011)}, "'8' lies 1.1 mm"),
        ({'cue': (0.0, 0.0)}, "'8' of the plan is not on the table"),
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0), '9': (0, 1)}, "'9' is on the table, but not in"),
        ({'cue': (float('nan'), 0.0), '8': (0.5, 0.0)}, "'cue' lies nan"),
    ],
)
def test_exact_positions(seen, words):
    said = moved(PLANNED, sightings(seen), TOLERANCE)
    assert words in said
    assert bool(words) == bool(said)


@pytest.mark.parametrize(
    ('change', 'words'),
    [({'is_seen': False}, "'8' is not seen"), ({'is_moving': True}, "'8' moves")],
)
def test_a_ball_that_is_not_known_to_rest_there(change, words):
    seen = {**PLANNED, '8': replace(PLANNED['8'], **change)}
    assert words in moved(PLANNED, seen, TOLERANCE)


@pytest.mark.parametrize('noise', [0.13e-3, 0.5e-3, 2.3e-3])
def test_the_uncertainty_of_both_positions_is_no_motion(noise):
    """Of 20,000 pairs of single detections of a ball at rest, at most 1 in 3000 differs."""
    random = np.random.default_rng(1)
    wrong = sum(
        bool(
            moved(
                {'8': uncertain(*random.normal(0.0, noise, 2), noise)},
                {'8': uncertain(*random.normal(0.0, noise, 2), noise)},
                0.0,
            )
        )
        for _ in range(20_000)
    )
    assert wrong <= 20_000 / 3000 + 3 * math.sqrt(20_000 / 3000)


@given(
    st.floats(-math.pi, math.pi),
    st.floats(1e-5, 1e-3),
    st.floats(1e-5, 1e-3),
    st.floats(-math.pi, math.pi),
)
def test_only_the_uncertainty_along_the_distance_counts(heading, along, across, turn):
    """Turning everything changes nothing."""

    def said(angle):
        c, s = math.cos(angle), math.sin(angle)
        matrix = np.array([[c, -s], [s, c]])
        (xx, xy), (_, yy) = matrix @ np.diag([along**2, across**2]) @ matrix.T
        planned = {'8': Sighting((0.0, 0.0), (xx, xy, yy))}
        away = TOLERANCE + 4.0 * along
        return [
            bool(moved(planned, sightings({'8': (share * away * c, share * away * s)}), TOLERANCE))
            for share in (0.99, 1.01)
        ]

    assert said(heading) == said(turn) == [False, True]


def test_a_systematic_error_counts_for_plans_but_hides_no_motion():
    """Plan and picture are of one camera: its errors are the same in both."""
    biased = {name: replace(ball, systematic_error=0.5e-3) for name, ball in PLANNED.items()}
    assert largest_deviation(biased) == pytest.approx(0.5e-3)
    both = {'cue': replace(uncertain(0.0, 0.0, 1.2e-3), systematic_error=0.5e-3)}
    assert largest_deviation(both) == pytest.approx(1.3e-3)
    assert not is_uncertain(biased, biased, 1.5e-3)
    assert not moved(biased, biased, TOLERANCE)
    seen = biased | {'8': replace(biased['8'], position=(0.5, 1.1e-3))}
    assert "ball '8' lies 1.1 mm from its planned place" in moved(biased, seen, TOLERANCE)


# --- balls that touch each other or a cushion, seen by a camera that errs ------------------------

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


# --- when all balls rest -------------------------------------------------------------------------

LYING = {'cue': Sighting((0.1, 0.2)), '8': Sighting((0.5, 0.0))}


def test_balls_that_lie_long_enough_rest():
    watch = RestWatch()
    assert watch.restless(LYING, 0.0)
    assert watch.restless(LYING, 0.9 * REST_TIME) == 'the balls have not rested for 0.5 s'
    assert not watch.restless(LYING, 1.1 * REST_TIME)


def test_a_ball_that_creeps_moves_on():
    watch = RestWatch()
    watch.restless(LYING, 0.0)
    for step in range(1, 20):
        creeping = LYING | {'8': Sighting((0.5 + 1.1 * step * REST_DISTANCE, 0.0))}
        assert watch.restless(creeping, step * REST_TIME) == "ball '8' moves on"


def test_a_ball_that_is_not_seen_or_comes_anew_does_not_rest():
    watch = RestWatch()
    watch.restless(LYING, 0.0)
    hidden = LYING | {'cue': replace(LYING['cue'], is_seen=False)}
    assert watch.restless(hidden, 1.0) == "ball 'cue' is not seen"
    moving = LYING | {'cue': replace(LYING['cue'], is_moving=True)}
    assert watch.restless(moving, 2.0) == "ball 'cue' moves on"
    assert watch.restless(LYING, 2.1)
    assert watch.restless({'8': LYING['8']}, 9.0)
    assert not watch.restless({'8': LYING['8']}, 10.0)


def test_a_ball_that_is_not_seen_counts_as_resting_after_a_while():
    """The others must rest meanwhile; a ball that appears begins anew."""
    watch = RestWatch()
    hidden = LYING | {'cue': replace(LYING['cue'], is_seen=False, is_moving=True)}
    for now in (0.0, 1.0, 5.0):
        assert watch.restless(hidden, now, unseen_time=5.0) == "ball 'cue' is not seen"
    assert not watch.restless(hidden, 5.1, unseen_time=5.0)
    assert watch.restless(hidden, 99.0) == "ball 'cue' is not seen"
    assert watch.restless(LYING, 99.1, unseen_time=5.0)
    assert watch.restless(hidden, 99.2, unseen_time=5.0) == "ball 'cue' is not seen"
    rolling = hidden | {'8': replace(LYING['8'], is_moving=True)}
    assert watch.restless(rolling, 110.0, unseen_time=5.0) == "ball '8' moves on"
