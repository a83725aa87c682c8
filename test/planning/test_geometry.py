"""The geometry of candidates, intervals, limits: what must be true of them."""

from concurrent.futures import ThreadPoolExecutor
import math

from hypothesis import given, settings
from hypothesis import strategies as st
from layouts import cloth_with, problem, table_with
import numpy as np
import pytest

from billiard_shot import predict, Stroke
from billiard_shot.planning.routes import (
    candidates_along,
    is_clear,
    mirror_path,
    random_candidates,
    routes_to,
    sequences,
    waypoints,
)
from billiard_shot.planning.runner import Runner, StoppedError
from billiard_shot.planning.score import nearest
from billiard_shot.planning.stages import curved_candidates, CURVES_AT_ONCE, ENOUGH
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.planning.targets import read_target
from billiard_shot.scene.player import NOISES
from billiard_shot.table.model.motion import SegmentRecord

NOISE = NOISES['tournament']
SCENE = table_with(cue=(-0.4, 0.1), b8=(0.5, 0.2), b1=(0.2, -0.3))


def problem_in(scene, target, **constraints):
    return problem(scene, target, NOISE, constraints)


@pytest.mark.parametrize(
    ('successes', 'trials', 'low', 'high'),
    [
        (81, 263, 0.2553, 0.3662),  # Newcombe, Statistics in Medicine 17 (1998), table I, method 3
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_intervals_are_the_published_ones(successes, trials, low, high):
    assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


@given(
    st.floats(-1.1, 1.1),
    st.floats(-0.5, 0.5),
    st.floats(-1.1, 1.1),
    st.floats(-0.5, 0.5),
    st.sampled_from([via for via in sequences(3) if via]),
)
@settings(max_examples=60, deadline=None)
def test_cushions_are_mirrors(x, y, u, v, via):
    """Equal angles at every nose, corners on the noses, and no shorter route by the same ones."""
    problem = problem_in(SCENE, {'pot': '8'})
    path = mirror_path(problem, np.array([x, y]), np.array([u, v]), via)
    if path is None:
        return
    assert len(path) == len(via) + 2
    for corner, nose, before, after in zip(
        path[1:-1], via, np.diff(path, axis=0)[:-1], np.diff(path, axis=0)[1:], strict=True
    ):
        axis = nose // 2
        wall = problem.half_sizes[axis] * (1 - 2 * (nose % 2))
        assert corner[axis] == pytest.approx(wall)
        if np.hypot(*before) > 1e-6 and np.hypot(*after) > 1e-6:
            before, after = before / np.hypot(*before), after / np.hypot(*after)
            assert after[axis] == pytest.approx(-before[axis], abs=1e-6)
            assert after[1 - axis] == pytest.approx(before[1 - axis], abs=1e-6)


def test_ghost_balls_touch_and_push_to_the_pocket():
    problem = problem_in(SCENE, {'pot': '8', 'pocket': 'foot_left'})
    ghost = waypoints(problem, 0)[0]
    ball, hole = problem.places[problem.balls[0]], problem.holes[0]
    assert np.hypot(*(ghost.place - ball)) == pytest.approx(2.0 * problem.radius)
    assert ghost.push == pytest.approx((hole - ball) / np.hypot(*(hole - ball)))
    (route,) = routes_to(problem, ghost, 0)
    assert route.length == pytest.approx(np.hypot(*(ghost.place - problem.cue_ball)))


def test_routes_do_not_go_through_balls():
    blocked = table_with(cue=(-0.4, 0), b8=(0.5, 0), b1=(0.1, 0))
    problem = problem_in(blocked, {'hit': '8'})
    full = waypoints(problem, 0)[0]
    assert routes_to(problem, full, 0) == []
    assert not is_clear(problem, np.array([[-0.4, 0], [0.4, 0]]), (0, 1))
    assert len(routes_to(problem, full, 1)) == 2  # by the two long cushions


def test_candidates_keep_to_the_limits():
    limits = {
        'speed_max': 1.5,
        'offset_max': 0.3,
        'azimuth_deg': 10.0,
        'azimuth_half_range_deg': 30.0,
        'elevation_max_deg': 40.0,
    }
    problem = problem_in(SCENE, {'pot': '8'}, **limits)
    routes = [route for point in waypoints(problem, 0) for route in routes_to(problem, point, 0)]
    for candidates in (candidates_along(problem, routes), random_candidates(problem, 200, 0)):
        a, b, elevation, azimuth, speed = candidates.strokes.T
        assert len(a) > 0
        assert (np.hypot(a, b) <= 0.3 + 1e-9).all()
        assert (speed <= 1.5 + 1e-9).all()
        assert (elevation <= np.radians(40.0) + 1e-9).all()
        assert (np.abs(np.degrees(azimuth) - 10.0) <= 30.0 + 1.0).all()  # squirt is allowed for


BLOCKED = cloth_with(cue=(-0.5, 0), b8=(0.5, 0), b1=(0, 0))


def curved(most=1000, *, spent=False, cancel=None):
    problem = problem_in(BLOCKED, {'hit': '8'})
    with ThreadPoolExecutor(2) as threads:
        runner = Runner(problem, 1000, threads, cancel=cancel)
        runner.simulations = runner.budget if spent else 0
        return curved_candidates(problem, waypoints(problem, 0)[:1], most, runner).strokes


def test_curved_candidates_pass_the_ball_in_the_way():
    """Nearly all also hit, because their paths are those of solved strikes."""
    strokes = curved()
    assert len(strokes) > 5
    met = [predict(BLOCKED, Stroke.from_offsets(*each)).first_contact for each in strokes]
    assert '1' not in met
    assert np.mean([ball == '8' for ball in met]) > 0.9
    assert np.degrees(strokes[:, 2]).max() > 40.0  # also where normals move


def test_curves_end_when_the_search_does_or_enough_are_found():
    with pytest.raises(StoppedError):
        curved(cancel=lambda: True)
    every = curved()
    assert len(curved(spent=True)) < 0.5 * len(every)
    assert ENOUGH <= len(curved(most=10_000)) < ENOUGH + CURVES_AT_ONCE


def test_curves_leave_time_to_the_trials_of_those_that_are_found(monkeypatch):
    """On a busy machine curves took all the time, and no stroke was tried."""
    every = curved()
    monkeypatch.setattr(Runner, 'has_used', lambda self, share: True)
    assert 0 < len(curved()) < 0.5 * len(every)


def test_errors_have_the_noise_that_was_asked_for():
    problem = problem_in(SCENE, {'pot': '8'})
    assert problem.sigmas == pytest.approx(
        [0.0005 / 0.028575, 0.0005 / 0.028575, np.radians(0.1), np.radians(0.125), 0.075]
    )


# --- penalties: distances between paths and points -----------------------------------------------


def segment_of(draw):
    """A stretch of motion on the cloth."""
    segment = SegmentRecord()
    segment.position[:2] = draw.uniform(-1.0, 1.0, 2).tolist()
    segment.velocity[:2] = draw.uniform(-2.0, 2.0, 2).tolist()
    segment.acceleration[:2] = draw.uniform(-2.0, 2.0, 2).tolist()
    return segment


def test_a_segment_counts_only_if_it_comes_nearer_than_others():
    draw = np.random.default_rng(1)
    skipped = 0
    for _ in range(400):
        segment, lasting = segment_of(draw), float(draw.choice([0.0, 0.1, 1.0]))
        x, y, least = draw.uniform((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)).tolist()
        distance = nearest(segment, lasting, x, y, math.inf)
        assert nearest(segment, lasting, x, y, least) == min(distance, least)
        skipped += distance > least
        times = np.linspace(0.0, lasting, 200)[:, np.newaxis]
        p, v, a = (
            np.array(each[:2])
            for each in (segment.position, segment.velocity, segment.acceleration)
        )
        path = p + times * (v + 0.5 * times * a)
        exact = np.hypot(*(path - (x, y)).T).min()
        assert distance == pytest.approx(exact, abs=0.02)  # by straight pieces
    assert 50 < skipped < 350


# --- targets judged by the balls at rest ---------------------------------------------------------

CUE, EIGHT, ONE = {'cue': (0.2, 0.1)}, {'8': (0.5, 0.5)}, {'1': (-0.5, 0.2)}


@pytest.mark.parametrize(
    ('target', 'places', 'reached', 'words'),
    [
        ({'rest': (0.2, 0.0), 'radius': 0.11}, CUE, True, '100.0 mm from the point, 110 mm'),
        (
            {'rest': (0.2, 0.0), 'radius': 0.09},
            CUE,
            False,
            'not reached: the cue ball rests 100.0',
        ),
        ({'rest': (0.2, 0.0)}, EIGHT, False, 'the cue ball is not on the table'),
        ({'pot': '8'}, CUE, True, 'pocketed: 8'),
        ({'pot': '8'}, CUE | EIGHT, False, 'still on the table: 8'),
        ({'pot': ['8', '1']}, CUE | ONE, True, 'pocketed: 8'),
        ({'pot': ['8', '1']}, CUE | ONE | EIGHT, False, 'still on the table: 8, 1'),
        ({'pot': '8', 'leave': (0.2, 0.0), 'radius': 0.09}, CUE, False, '100.0 mm from'),
        ({'pot': '8', 'leave': (0.2, 0.0), 'radius': 0.2}, CUE | EIGHT, False, 'still on'),
        ({'pot': 'any'}, CUE, True, 'not judged'),
        ({'pass': (0.0, 0.0)}, CUE, True, 'not judged'),
    ],
)
def test_a_target_is_judged(target, places, reached, words):
    found, text = read_target(target).judged_at_rest(places)
    assert found is reached
    assert words in text
