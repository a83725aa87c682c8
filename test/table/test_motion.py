from dataclasses import replace
import math

import numpy as np
import pytest
from rolling import CLOTH, run
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tables import POOL, R, state

from billiard_shot import BallState, predict, Scene, simulate, Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.geometry import stiffness_of
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.motion.cloth import rolling_after, speed_to_arrive
from billiard_shot.table.run.results import EventKind

G = 9.8


def motions(path):
    return [segment.motion for segment in path.segments]


def test_stun_shot_keeps_five_sevenths():
    path, status, _ = run((1, 0, 0))
    assert status == Status.OK
    assert motions(path) == [Motion.SLIDE, Motion.ROLL, Motion.REST]
    _, roll, rest = path.segments
    assert roll.start == pytest.approx(2 / (7 * 0.2 * G), rel=1e-14)
    assert roll.velocity == pytest.approx([5 / 7, 0, 0], rel=1e-14)
    assert roll.spin == pytest.approx([0, 5 / 7 / 0.028, 0], rel=1e-14)
    assert rest.start - roll.start == pytest.approx(5 / 7 / (0.01 * G), rel=1e-13)
    rolled = (5 / 7) ** 2 / (2 * 0.01 * G)
    assert path.final_position == pytest.approx(
        [12 / 49 / (0.2 * G) + rolled, 0, 0.028], rel=1e-13
    )
    assert [event.kind for event in path.events] == [EventKind.ROLL, EventKind.REST]


def test_a_rolling_ball_only_rolls():
    path, _, _ = run((0.7, 0, 0), (0, 0.7 / 0.028, 0))
    assert motions(path) == [Motion.ROLL, Motion.REST]
    assert path.final_position[0] == pytest.approx(0.49 / (2 * 0.01 * G), rel=1e-13)


def test_masse_is_a_parabola_and_the_slip_keeps_its_direction():
    path, _, _ = run((1, 0.2, 0), (30, -10, 20))
    t = np.linspace(0, path.segments[1].start * (1 - 1e-9), 20)
    state = path.at(t)
    slip = state.velocity[:, :2] + 0.028 * np.stack([-state.spin[:, 1], state.spin[:, 0]], axis=1)
    direction = slip / np.linalg.norm(slip, axis=1, keepdims=True)
    assert np.abs(direction - direction[0]).max() < 1e-6
    slowed = (1, 0.2) - 0.2 * G * t[:, None] * direction[0]
    assert np.allclose(state.velocity[:, :2], slowed, atol=1e-9)


def test_spin_in_place_and_spin_that_ends_on_the_way():
    path, _, _ = run((0, 0, 0), (0, 0, -50))
    assert motions(path) == [Motion.SPIN, Motion.REST]
    assert path.duration == pytest.approx(5.0)
    path, _, _ = run((1, 0, 0), (0, 0, 1))
    assert motions(path) == [Motion.SLIDE, Motion.SLIDE, Motion.ROLL, Motion.REST]
    assert path.events[0].kind == EventKind.SPIN_END
    assert path.events[0].time == pytest.approx(0.1)
    longer, _, _ = run((1, 0, 0))
    assert path.final_position == pytest.approx(longer.final_position, rel=1e-13)


def test_inertia_counts():
    hollow = CLOTH._replace(inertia=2 / 3 * 0.17 * 0.028**2)
    path, _, _ = run((1, 0, 0), params=hollow)
    assert path.segments[1].velocity[0] == pytest.approx(0.6, rel=1e-13)


@pytest.mark.parametrize(
    ('change', 'velocity', 'spin', 'last'),
    [
        ({'sliding_friction': 0.0, 'cloth_friction': 0.0}, (1, 0, 0.5), (0, 0, 0), Motion.SLIDE),
        ({'rolling_resistance': 0.0}, (1, 0, 0), (3, 0, 5), Motion.ROLL),
        ({'spin_deceleration': 0.0}, (1, 0, 0), (0, 0, 5), Motion.SPIN),
        ({'cloth_restitution': 1.0}, (1, 0, 1), (0, 0, 5), Motion.FLIGHT),
    ],
)
def test_endless_motion(change, velocity, spin, last):
    path, status, _ = run(velocity, spin, CLOTH._replace(**change))
    assert status == Status.NEVER_RESTS
    assert not path.comes_to_rest
    assert path.segments[-1].motion == last
    assert all(np.isfinite(path.rows[name]).all() for name in path.rows.dtype.names)
    assert np.isfinite(path.final_position).all()
    assert np.isfinite(path.duration)
    state = path.at(path.duration + 10)
    assert state.motion == last
    assert state.position == pytest.approx(path.final_position + 10 * state.velocity)


def test_all_is_continuous():
    random = np.random.default_rng(3)
    for _ in range(50):
        path, status, _ = run(random.normal(size=3) * (1, 1, 0), random.normal(size=3) * 30)
        assert status == Status.OK
        for event in path.events:
            before, after = path.at(event.time * (1 - 1e-12)), path.at(event.time)
            assert np.abs(before.position - after.position).max() < 1e-9
            assert np.abs(before.velocity - after.velocity).max() < 1e-9
            assert np.abs(before.spin - after.spin).max() < 1e-6
        state = path.at(np.linspace(0, path.duration, 200))
        energy = CLOTH.mass * (state.velocity**2).sum(1) + CLOTH.inertia * (state.spin**2).sum(1)
        assert (np.diff(energy) <= 1e-14).all()


def test_at_takes_any_shape_and_clamps():
    path, _, _ = run((1, 0, 0.3), (0, 0, 5))
    assert path.at(0.0).position.shape == (3,)
    assert path.at([[0, 1], [2, 3]]).position.shape == (2, 2, 3)
    assert path.at([0, 1]).motion.dtype == np.uint8
    assert (path.at(-1).position == path.at(0).position).all()
    rest = path.at(1e300)
    assert (rest.position == path.final_position).all()
    assert rest.motion == Motion.REST
    assert not rest.velocity.any()
    assert not rest.spin.any()
    for time in (np.nan, 'x', None, [0.0, [1.0]], 10**400):
        with pytest.raises(ValueError, match='time must be finite, got'):
            path.at(time)


@pytest.mark.parametrize('share', [0.1, 0.4, 2.0 / 3.0], ids=['dense', 'solid', 'hollow'])
@pytest.mark.parametrize('way', [0.05, 1.0])
@pytest.mark.parametrize('arrival', [0.0, 0.7])
def test_a_ball_arrives_at_the_speed_asked_for(share, way, arrival):
    """Of any moment of inertia; short ways end before the ball rolls."""
    params = CLOTH._replace(inertia=share * CLOTH.mass * CLOTH.radius**2)
    path, _, _ = run((speed_to_arrive(params, way, arrival), 0, 0), params=params)
    if arrival == 0.0:
        assert path.final_position[0] == pytest.approx(way, rel=1e-9)
        return
    time = brentq(lambda t: path.at(t).position[0] - way, 0.0, path.duration, xtol=1e-13)
    state = path.at(time)
    assert state.velocity[0] == pytest.approx(arrival, rel=1e-8)
    rolls = rolling_after(params, path.at(0.0).velocity[0], way)
    assert rolls * arrival == pytest.approx(params.radius * state.spin[1], rel=1e-7)


# --- rolling resistance that rises with speed: stretches beside the exact, exponential motion ----

RISING = CLOTH._replace(rolling_resistance=0.004, rolling_rise=0.0014)
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
        params = CLOTH._replace(rolling_resistance=resistance, rolling_rise=rise, gravity=gravity)
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
def test_a_ball_whose_resistance_rises_arrives_at_the_speed_asked_for(way, arrival):
    path, _, _ = run((speed_to_arrive(RISING, way, arrival), 0, 0), params=RISING)
    if arrival == 0.0:
        assert path.final_position[0] == pytest.approx(way, rel=2e-3)
        return
    time = brentq(lambda t: path.at(t).position[0] - way, 0.0, path.duration)
    assert path.at(time).velocity[0] == pytest.approx(arrival, rel=1e-3)


# --- friction between balls falls with their slip, also during an impact of several balls --------

MASS, TURNING = POOL.ball.mass, POOL.ball.inertia
BALLS = replace(POOL.contacts.ball_ball, restitution=1.0)
SCENE = replace(POOL, contacts=replace(POOL.contacts, ball_ball=BALLS))
STILL = 1e-5
"""Slip [m/s] below which the integration lets friction fall to zero."""


def integrated(speed, angle):
    """Velocities (3, 2) of balls that touch, by springs and friction in small steps."""
    stiffness = stiffness_of(MASS, BALLS.duration, 1.0)
    normals = np.array([[math.cos(angle), math.sin(angle)], [1.0, 0.0]])
    tangents = np.array([[-y, x] for x, y in normals])

    def rates(_, values):
        velocity, spin, pressed = values[:6].reshape(3, 2), values[6:9], values[9:]
        force, torque, closing = np.zeros((3, 2)), np.zeros(3), np.zeros(2)
        for i, (n, t) in enumerate(zip(normals, tangents, strict=True)):
            relative = velocity[i] - velocity[i + 1]
            closing[i] = relative @ n
            slip = relative @ t + R * (spin[i] + spin[i + 1])
            push = stiffness * max(pressed[i], 0.0)
            coefficient = BALLS.friction_fast + BALLS.friction_slow * math.exp(
                -BALLS.friction_decay * abs(slip)
            )
            rub = coefficient * push * math.tanh(slip / STILL)
            force[i] -= push * n + rub * t
            force[i + 1] += push * n + rub * t
            torque[i : i + 2] -= R * rub
        return np.concatenate([force.ravel() / MASS, torque / TURNING, closing])

    begin = np.zeros(11)
    begin[:2] = speed * normals[0]
    ended = solve_ivp(rates, (0.0, 1e-3), begin, method='LSODA', rtol=1e-8, atol=1e-9)
    return ended.y[:6, -1].reshape(3, 2)


@pytest.mark.parametrize('angle', [0.3, 0.8, 1.2])
@pytest.mark.parametrize('speed', [0.5, 2.0, 6.0])
def test_it_agrees_with_an_integration(speed, angle):
    """Balls move by up to 3 mm meanwhile, which the integration leaves out."""
    away = 2 * R * np.array([math.cos(angle), math.sin(angle)])
    velocity = speed * away / np.linalg.norm(away)
    states = {'cue': state(*-away, (*velocity, 0)), 'one': state(0, 0), 'two': state(2 * R, 0)}
    run = simulate(SCENE, states)
    found = [ball.velocity[:2] for ball in run.at(2e-3).values()]
    assert np.array(found) == pytest.approx(integrated(speed, angle), abs=0.01 * speed)


def throw(gap, speed):
    """Tangent of the angle by which a ball is thrown that another one pushes at 45 degrees."""
    away = math.sqrt(2) * R
    states = {
        'cue': state(-away, -away, (speed, speed, 0)),
        'one': state(0, 0),
        'two': state(2 * R + gap, 0),
    }
    x, y, _ = simulate(SCENE, states).at(4e-3)['two'].velocity
    return y / x


@pytest.mark.parametrize('speed', [0.5, 2.0])
def test_frozen_balls_throw_as_balls_do_that_nearly_touch(speed):
    """Before, frozen ones had the friction of balls that do not slip: 0.118 at any speed."""
    throws = [throw(gap, speed) for gap in (0.0, 1e-6, 1e-5, 3e-5, 1e-4)]
    assert np.abs(np.diff(throws)).max() < 0.015
    assert throw(0.0, 4.0) < throw(0.0, 2.0) < throw(0.0, 0.5)
