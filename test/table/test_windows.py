"""Runs that end at a time, places at given times, and numbers that differ from table to table."""

import math

import numpy as np
import pytest
from tables import POOL, random_states, state

from billiard_shot import Scene, simulate, simulate_batch, Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import BallState

TIMES = np.array([0.0, 0.05, 0.3, 0.31, 1.0, 2.5, 60.0])


def tables(seed, count):
    random = np.random.default_rng(seed)
    return [random_states(random, POOL.table, int(random.integers(1, 7))) for _ in range(count)]


def break_of_nine_ball():
    scene = Scene.load('nine_ball')
    states = {name: state(x, y) for name, (x, y) in scene.balls.items()}
    return scene, states | {'cue': BallState(states['cue'].position, (6, -0.6, 0))}


def test_places_at_times_are_those_of_single_runs():
    for scene, states in [(POOL, each) for each in tables(3, 30)] + [break_of_nine_ball()]:
        batch, run = simulate_batch(scene, states, at=TIMES), simulate(scene, states)
        for i, name in enumerate(run.names):
            expected = run.balls[name].at(TIMES).position
            assert np.allclose(batch.position_at[0, i], expected, atol=1e-12)
    assert simulate_batch(POOL, states).position_at.shape == (1, len(states), 0, 3)


def test_a_run_that_ends_early_is_the_beginning_of_the_whole_run():
    for scene, states in [(POOL, each) for each in tables(4, 30)] + [break_of_nine_ball()]:
        whole, part = simulate(scene, states), simulate(scene, states, until=0.7)
        if whole.duration <= 0.7:
            assert part.duration == whole.duration
            assert part.status == whole.status
        else:
            assert part.duration == 0.7
            assert part.status in (Status.OK, Status.OFF_TABLE)
        early = [(e.time, e.kind, e.balls) for e in whole.events if e.time <= 0.7]
        assert [(e.time, e.kind, e.balls) for e in part.events] == early
        times = np.linspace(0.0, min(0.7, whole.duration), 30)
        for name in whole.names:
            for one, other in zip(
                (whole.balls[name].at(times).position, whole.balls[name].at(times).spin),
                (part.balls[name].at(times).position, part.balls[name].at(times).spin),
                strict=True,
            ):
                assert np.allclose(one, other, atol=1e-9)
            there = whole.balls[name].at(0.7).position
            assert np.allclose(part.final_position[name], there, atol=1e-12)


def test_a_batch_that_ends_early_has_the_places_of_its_end():
    rows = tables(6, 20)
    batch = simulate_batch(POOL, rows, until=0.4, at=[0.4])
    for t, states in enumerate(rows):
        alone = simulate(POOL, {n: states[n] for n in batch.names if n in states}, until=0.4)
        for i, name in enumerate(batch.names):
            if name in states:
                assert np.allclose(batch.final_position[t, i], alone.final_position[name])
                assert np.allclose(batch.position_at[t, i, 0], alone.final_position[name])
    assert (batch.duration <= 0.4).all()
    assert (batch.motion == Motion.ROLL).any()


def test_numbers_may_differ_from_table_to_table():
    states = {'cue': state(0.2, 0.1, (1.5, 0.4, 0)), '1': state(0.9, 0.3)}
    columns = {
        name: BallState(np.tile(each.position, (6, 1)), each.velocity, each.spin)
        for name, each in states.items()
    }
    numbers = {
        'table.cushion.restitution': np.array([0.9, 0.7, 0.9, 0.8, 0.7, 0.9]),
        'cloth.rolling_resistance': 0.012,
        'contacts.ball_ball.restitution': np.array([0.9, 0.95, 0.95, 0.95, 0.95, 0.9]),
    }
    batch = simulate_batch(POOL, columns, parameters=numbers, at=[0.5])
    for t in range(6):
        values = [float(np.broadcast_to(column, 6)[t]) for column in numbers.values()]
        alone = simulate_batch(POOL.with_parameters(list(numbers), values), states, at=[0.5])
        assert (batch.final_position[t] == alone.final_position[0]).all()
        assert (batch.position_at[t] == alone.position_at[0]).all()
    assert len(np.unique(batch.final_position[:, 0, 0])) == 4


def test_windows_and_numbers_are_checked():
    states = {'cue': state(0, 0)}
    for at in ([], [1.0, 0.5], [-1.0], [math.nan]):
        with pytest.raises(ValueError, match='at must be ascending times, at least 0, got'):
            simulate_batch(POOL, states, at=at)
    for until in (0, -1.0, math.nan):
        with pytest.raises(ValueError, match=r'until .* \(s\)'):
            simulate(POOL, states, until=until)
        with pytest.raises(ValueError, match=r'until .* \(s\)'):
            simulate_batch(POOL, states, until=until)
    with pytest.raises(ValueError, match=r'parameters: ball\.mas is unknown'):
        simulate_batch(POOL, states, parameters={'ball.mas': [1.0]})
    with pytest.raises(ValueError, match=r'ball.mass.* must be of shape \(1,\), got \(2,\)'):
        simulate_batch(POOL, states, parameters={'ball.mass': [1.0, 2.0]})
