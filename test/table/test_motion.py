import numpy as np
import pytest
from rolling import POOL, run
from scipy.optimize import brentq

from billiard_shot.status import Status
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
    hollow = POOL._replace(inertia=2 / 3 * 0.17 * 0.028**2)
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
    path, status, _ = run(velocity, spin, POOL._replace(**change))
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
        energy = POOL.mass * (state.velocity**2).sum(1) + POOL.inertia * (state.spin**2).sum(1)
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
    params = POOL._replace(inertia=share * POOL.mass * POOL.radius**2)
    path, _, _ = run((speed_to_arrive(params, way, arrival), 0, 0), params=params)
    if arrival == 0.0:
        assert path.final_position[0] == pytest.approx(way, rel=1e-9)
        return
    time = brentq(lambda t: path.at(t).position[0] - way, 0.0, path.duration, xtol=1e-13)
    state = path.at(time)
    assert state.velocity[0] == pytest.approx(arrival, rel=1e-8)
    rolls = rolling_after(params, path.at(0.0).velocity[0], way)
    assert rolls * arrival == pytest.approx(params.radius * state.spin[1], rel=1e-7)
