"""The geometry of candidates, intervals, limits: what must be true of them."""

from hypothesis import given, settings
from hypothesis import strategies as st
from layouts import cloth_with, table_with
import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.planning.curved_paths import build_strike_library, curved_candidates
from billiard_shot.planning.limits import limits_of
from billiard_shot.planning.noises import NOISES
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.routes import candidates_along, random_candidates, routes_to
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.planning.targets import target_of
from billiard_shot.planning.waypoints import is_clear, mirror_path, sequences, waypoints

NOISE = NOISES['tournament']
SCENE = table_with(cue=(-0.4, 0.1), b8=(0.5, 0.2), b1=(0.2, -0.3))


def problem_in(scene, target, **constraints):
    return problem_of(scene, target_of(scene, target), limits_of(scene, constraints, NOISE), NOISE)


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


EFFECTS = {'bounce': 'on', 'double_hit': 'off'}  # double hits do not scale with the speed


def test_one_path_serves_all_speeds():
    """A cue that is v times as fast sends the ball along the same path, v^2 times as large."""
    problem = problem_in(cloth_with(cue=(0, 0), b8=(1, 0)), {'hit': '8'})
    strikes = build_strike_library(problem)
    scene = Scene.from_dict({**Scene.load('pool').to_dict(), 'effects': EFFECTS})
    for k in range(0, len(strikes.offsets), 29):
        a, b, elevation = strikes.offsets[k]
        path = predict(scene, Stroke.from_offsets(a, b, elevation, 0.0, 2.0)).trajectory
        ends = np.array([path.at(t).position[:2] for t in np.linspace(0, path.duration, 4000)])
        for point in 4.0 * strikes.paths[k, ::8, :2]:
            away = np.hypot(*(ends - point).T).min()
            assert away < 0.01 + 0.01 * np.hypot(*point)


def test_curved_candidates_pass_the_ball_in_the_way():
    scene = cloth_with(cue=(-0.5, 0), b8=(0.5, 0), b1=(0, 0))
    problem = problem_in(scene, {'hit': '8'})
    candidates = curved_candidates(
        problem, build_strike_library(problem), waypoints(problem, 0)[0], 40, lambda: True
    )
    assert len(candidates.route) > 5
    free = [
        predict(scene, Stroke.from_offsets(*each)).first_contact != '1'
        for each in candidates.strokes
    ]
    assert np.mean(free) > 0.8


def test_curves_end_when_the_search_does():
    scene = cloth_with(cue=(-0.5, 0), b8=(0.5, 0), b1=(0, 0))
    problem = problem_in(scene, {'hit': '8'})
    library, point = build_strike_library(problem), waypoints(problem, 0)[0]
    none = curved_candidates(problem, library, point, 40, lambda: False)
    assert len(none.route) == 0
    every = curved_candidates(problem, library, point, 40, lambda: True)
    answers = iter([True] * 13 + [False])  # the fastest of 14 speeds is left out
    some = curved_candidates(problem, library, point, 40, lambda: next(answers))
    assert 0.0 < some.strokes[:, 4].max() < every.strokes[:, 4].max()


def test_errors_have_the_noise_that_was_asked_for():
    problem = problem_in(SCENE, {'pot': '8'})
    assert problem.sigmas == pytest.approx(
        [0.0005 / 0.028575, 0.0005 / 0.028575, np.radians(0.1), np.radians(0.125), 0.075]
    )
