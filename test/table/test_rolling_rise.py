"""Rolling resistance that rises with speed: stretches beside the exact, exponential motion."""

import math

import numpy as np
import pytest
from rolling import POOL, run
from scipy.optimize import brentq

from billiard_shot import BallState, predict, Scene, simulate, Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.motion.cloth import speed_to_arrive
from billiard_shot.table.run.results import EventKind

RISING = POOL._replace(rolling_resistance=0.004, rolling_rise=0.0014)
HALVES_ERROR = 0.16  # of the tolerance, between the ends of a stretch


def rolling(params, speed, tolerance, side=0.0):
    return run((speed, 0, 0), (0, speed / params.radius, side), params, tolerance)


def exact(params, speed, time):
    """Way [m], speed [m/s] and time of rest [s] of dv/dt = -g (c + k v)."""
    rate, shift = (
        params.gravity * params.rolling_rise,
        (params.rolling_resistance / params.rolling_rise),
    )
    rest = math.log1p(speed / shift) / rate
    time = np.minimum(time, rest)
    fallen = -np.expm1(-rate * time)
    way = (speed + shift) * fallen / rate - shift * time
    return way, speed - (speed + shift) * fallen, rest


@pytest.mark.parametrize('speed', [0.05, 1.0, 8.0])
@pytest.mark.parametrize('tolerance', [1e-2, 2e-3, 1e-4, 1e-6])
def test_a_roll_keeps_the_tolerance_of_the_exact_motion(speed, tolerance):
    path, status, _ = rolling(RISING, speed, tolerance)
    times = np.linspace(0.0, 1.01 * path.duration, 2000)
    way, _, rest = exact(RISING, speed, times)
    assert status == Status.OK
    assert np.abs(path.at(times).position[:, 0] - way).max() < HALVES_ERROR * tolerance
    assert path.duration == pytest.approx(rest, abs=1e-5 * tolerance / speed, rel=1e-9)


def test_stretches_are_few_and_their_number_grows_slowly():
    numbers = [len(rolling(RISING, 1.0, tolerance)[0].rows) for tolerance in (2e-3, 2e-6)]
    assert numbers[0] <= 10
    assert numbers[1] <= 10.5 * numbers[0]  # with the cube root of the tolerance


def test_a_roll_in_stretches_is_continuous_and_no_event():
    path, _, _ = rolling(RISING, 2.0, 2e-3)
    assert {segment.motion for segment in path.segments} == {Motion.ROLL, Motion.REST}
    assert [event.kind for event in path.events] == [EventKind.REST]
    for segment in path.segments[1:]:
        before, after = path.at(np.nextafter(segment.start, 0.0)), path.at(segment.start)
        for one, other in (
            (before.position, after.position),
            (before.velocity, after.velocity),
            (RISING.radius * before.spin, RISING.radius * after.spin),
        ):
            assert np.abs(one - other).max() < 1e-12
    speeds = path.at(np.linspace(0.0, path.duration, 5000)).velocity[:, 0]
    assert (np.diff(speeds) <= 0.0).all()


@pytest.mark.parametrize('side', [1.0, 30.0, 150.0])  # used up after 0.1, 3 and 15 s
def test_side_spin_that_ends_changes_no_roll(side):
    path, _, _ = rolling(RISING, 1.0, 1e-4, side)
    times = np.linspace(0.0, path.duration, 1000)
    assert [event.kind for event in path.events] == [EventKind.SPIN_END, EventKind.REST]
    assert path.events[0].time == pytest.approx(side / RISING.spin_deceleration)
    way, _, _ = exact(RISING, 1.0, times)
    assert np.abs(path.at(times).position[:, 0] - way).max() < HALVES_ERROR * 1e-4


def test_without_resistance_a_rise_stops_nothing():
    """Such a scene is a mistake; and a roll against a rise alone would have no end."""
    path, status, _ = rolling(RISING._replace(rolling_resistance=0.0), 1.0, 1e-4)
    assert status == Status.NEVER_RESTS
    assert len(path.rows) == 1
    with pytest.raises(ValueError, match='rolling_rise must be 0 without rolling_resistance'):
        Scene.from_dict(
            {'like': 'pool', 'cloth': {'rolling_resistance': 0, 'rolling_rise': 0.001}}
        )


def test_any_resistance_and_rise_let_a_ball_rest():
    random = np.random.default_rng(8)
    for _ in range(150):
        resistance, rise, gravity = 10.0 ** random.uniform((-12, -12, -1), (0, 0, 2))
        params = POOL._replace(rolling_resistance=resistance, rolling_rise=rise, gravity=gravity)
        speed, tolerance = 10.0 ** random.uniform((-3, -8), (1.3, -1))
        path, status, _ = rolling(params, speed, tolerance, random.normal(0.0, 20.0))
        assert status == Status.OK
        assert all(np.isfinite(path.rows[name]).all() for name in path.rows.dtype.names)
        assert (np.diff(path.rows['velocity'][:, 0]) <= 0.0).all()
        stopped = path.rows[path.rows['velocity'][:, 0] == 0.0][0]
        way, _, rest = exact(params, speed, np.array([math.inf]))
        if resistance < 1e6 * rise * speed:  # else the exact way is lost in rounding
            assert abs(stopped['position'][0] - way[0]) < tolerance + 1e-7 * way[0]
            assert stopped['time'] == pytest.approx(rest, rel=1e-6)


@pytest.mark.parametrize('seed', range(8))
def test_a_ball_meets_cushions_as_on_the_exact_path(seed):
    random = np.random.default_rng(seed)
    scene = Scene.load('carom').with_parameters(
        ['cloth.rolling_resistance', 'cloth.rolling_rise'], [0.004, 0.0014]
    )
    heading, speed = random.uniform(0.0, 2.0 * math.pi), random.uniform(0.3, 4.0)
    x, y = speed * math.cos(heading), speed * math.sin(heading)
    radius = scene.ball.radius
    spin = -y / radius, x / radius, random.normal(0.0, 20.0)
    ball = BallState((0.1, 0.2, radius), (x, y, 0.0), spin)
    run, fine = (simulate(scene, {'cue': ball}, tolerance) for tolerance in (2e-3, 1e-7))
    met, wanted = (
        [each.place for each in played.events if each.kind == EventKind.CUSHION]
        for played in (run, fine)
    )
    assert met == wanted
    times = np.linspace(0.0, fine.duration, 500)
    apart = run.at(times)['cue'].position - fine.at(times)['cue'].position
    assert np.abs(apart).max() < 0.5 * 2e-3


@pytest.mark.parametrize('tolerance', [1e-3, 1e-5])
def test_the_error_of_a_stroke_is_within_its_estimate(tolerance):
    scene = Scene.load('pool').with_parameters(['cloth.rolling_rise'], [0.002])
    stroke = Stroke.from_offsets(0.2, 0.3, speed=2.0)
    shot, fine = (predict(scene, stroke, limit) for limit in (tolerance, 1e-8))
    times = np.linspace(0.0, fine.trajectory.duration, 1000)
    apart = shot.trajectory.at(times).position - fine.trajectory.at(times).position
    assert np.abs(apart).max() < shot.error_estimate <= tolerance
    assert shot.status == Status.OK


def test_a_scene_without_the_effect_has_no_resistance():
    scene = Scene.from_dict(
        {'like': 'pool', 'cloth': {'rolling_rise': 0.001}, 'effects': {'roll': False}}
    )
    radius = scene.ball.radius
    ball = BallState((0, 0, radius), (1, 0, 0), (0, 1 / radius, 0))
    assert simulate(scene, {'cue': ball}).status == Status.NEVER_RESTS


@pytest.mark.parametrize('way', [0.3, 3.0])
@pytest.mark.parametrize('arrival', [0.0, 0.7])
def test_a_ball_arrives_at_the_speed_asked_for(way, arrival):
    path, _, _ = run((speed_to_arrive(RISING, way, arrival), 0, 0), params=RISING)
    if arrival == 0.0:
        assert path.final_position[0] == pytest.approx(way, rel=2e-3)
        return
    time = brentq(lambda t: path.at(t).position[0] - way, 0.0, path.duration)
    assert path.at(time).velocity[0] == pytest.approx(arrival, rel=1e-3)
