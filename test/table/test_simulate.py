"""Whole tables: nothing missed, nothing gained, the same every time."""

import dataclasses
import os
import sys
import threading

import numpy as np
from programs import ran
import pytest
from tables import ENDLESS, play, POOL, R, random_states, rolling, state

from billiard_shot import machine_code
from billiard_shot.scene import Scene
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Cause, Motion
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.run.simulate import simulate, simulate_batch
from billiard_shot.table.run.task import in_threads

TINY = 1e-18  # J
DENT = 1e-5  # m: of balls in an impact, a twentieth of what a contact at 3 m/s has


def in_impacts(ball, times):
    """Whether a ball takes part in an impact of several balls at each time, while it is dented."""
    rows = ball.rows
    impacts = (rows['cause'][:-1] == Cause.CLUSTER) & (rows['cause'][1:] == Cause.RELEASE)
    index = np.searchsorted(rows['time'], times, side='right') - 1
    return np.append(impacts, False)[index]


def worst(run, step, x_most, y_most):
    """
    Deepest overlap of two balls, and of a ball with the walls where there is no pocket.

    Balls that take part in the same impact may be dented, but not deeper than a contact is.
    """
    times = np.arange(int(run.duration / step) + 1) * step
    states = run.at(times).values()
    places = np.array([each.position for each in states])
    on_table = np.array([each.motion for each in states]) < Motion.POCKETED
    dented = np.array([in_impacts(ball, times) for ball in run.balls.values()])
    x, y = np.abs(places[..., 0]), np.abs(places[..., 1])
    lying = on_table & (places[..., 2] == R)  # above the cloth it may reach farther
    outside = max(
        (x - x_most)[lying & (y < y_most - 0.1)].max(initial=0.0),
        (y - y_most)[lying & (x > 0.1) & (x < x_most - 0.1)].max(initial=0.0),
    )
    deepest = 0.0
    for i in range(len(places)):
        for j in range(i):
            overlap = 2.0 * R - np.linalg.norm(places[i] - places[j], axis=-1)
            overlap[dented[i] & dented[j]] -= DENT
            deepest = max(deepest, overlap[on_table[i] & on_table[j]].max(initial=0.0))
    return deepest, outside


REACH = np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)


def deepest_press(run):
    """How deep the balls of a run can press a nose, at most [m]."""
    speeds = (np.linalg.norm(ball.rows['velocity'], axis=1).max() for ball in run.balls.values())
    return 0.4 * POOL.table.cushion.duration * max(speeds) + 1e-9


def check_random_tables(count, seed, step=1e-3):
    """Simulate tables, and look at them every `step` seconds."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        states = random_states(random, POOL.table, int(random.integers(2, 8)))
        run = simulate(POOL, states)
        assert run.status in (Status.OK, Status.OFF_TABLE)
        deepest, outside = worst(run, step, 1.27 - REACH, 0.635 - REACH)
        assert deepest <= 1e-9
        assert outside <= deepest_press(run)
        assert worst(run, run.duration, 1.27 - REACH, 0.635 - REACH)[1] <= 1e-9
        before, after = (run._events.rows[name] for name in ('energy_before', 'energy_after'))
        assert (after <= before * (1 + 1e-12) + TINY).all()
        check_nothing_happens_to_balls_that_are_gone(run)


def check_nothing_happens_to_balls_that_are_gone(run):
    gone = set()
    for row, taking_part in zip(run._events.rows, run._events.balls(), strict=True):
        assert not gone & set(taking_part)
        if row['cause'] in (Cause.POCKET, Cause.OFF):
            gone |= set(taking_part)


def test_nothing_is_missed_nothing_overlaps_nothing_is_gained():
    check_random_tables(300, 1)


@pytest.mark.nightly
def test_nothing_is_missed_on_ten_thousand_tables():
    # A ball of 6 m/s that passes through another one overlaps it for 10 ms.
    check_random_tables(10_000, 2, step=4e-3)


@pytest.mark.parametrize('name', ['nine_ball', 'eight_ball'])
def test_breaks(name):
    scene = Scene.load(name)
    for seed in range(2):
        states = break_of(scene, 8.0, 0.005 * seed)
        run = simulate(scene, states)
        assert run.status == Status.OK
        deepest, outside = worst(run, 1e-4, 1.27 - REACH, 0.635 - REACH)
        assert deepest <= 1e-9
        assert outside <= deepest_press(run)
        assert worst(run, run.duration, 1.27 - REACH, 0.635 - REACH)[1] <= 1e-9
        assert all(e.dissipated >= -1e-12 * e.energy_before - TINY for e in run.events)
        assert any(e.kind == EventKind.CUSHION and e.balls != ('cue',) for e in run.events)
        check_nothing_happens_to_balls_that_are_gone(run)


def break_of(scene, speed, aside=0.0):
    states = {name: state(*place) for name, place in scene.balls.items()}
    x, y = scene.balls['cue']
    angle = np.arctan2(-y, 0.635 - x) + aside
    velocity = speed * np.array([np.cos(angle), np.sin(angle), 0])
    return states | {'cue': state(x, y, velocity)}


def test_runs_are_the_same_to_the_bit():
    states = break_of(Scene.load('eight_ball'), 7.0)
    one, two = (simulate(Scene.load('eight_ball'), states) for _ in range(2))
    assert one._segments.tobytes() == two._segments.tobytes()
    assert one._events.rows.tobytes() == two._events.rows.tobytes()


def test_a_batch_gives_what_single_runs_give():
    scene = Scene.load('nine_ball')
    states = break_of(scene, 8.0)
    velocity = states['cue'].velocity * np.linspace(0.2, 1, 25)[:, None]
    many = simulate_batch(scene, states | {'cue': BallState(states['cue'].position, velocity)})
    assert many.final_position.shape == (25, 10, 3)
    for i in (0, 7, 24):
        run = simulate(scene, states | {'cue': BallState(states['cue'].position, velocity[i])})
        assert many.status[i] == run.status
        assert many.duration[i] == run.duration
        for k, name in enumerate(many.names):
            assert (many.final_position[i, k] == run.final_position[name]).all()
            assert (many.pocket[i, k] >= 0) == (name in run.pocketed)
        assert many.names[many.first_met[i, many.names.index('cue')]] == run.first_met['cue']


def test_a_sequence_of_tables_is_a_batch_too():
    tables = [{'cue': state(0, 0, (v, 0, 0)), '1': state(0.5, 0.02)} for v in (0.5, 1.0)]
    many = simulate_batch(POOL, tables)
    assert (many.final_position[1, 0] == simulate(POOL, tables[1]).final_position['cue']).all()


def test_a_bad_row_has_a_status_of_its_own():
    places = np.array([[0, 0, R], [0.5, 0, R], [np.nan, 0, R]])
    many = simulate_batch(POOL, {'cue': BallState(places, (1, 0, 0)), '1': state(0.5, 0.01)})
    assert many.status.tolist() == [Status.OK, Status.INVALID_REQUEST, Status.INVALID_REQUEST]


@pytest.mark.parametrize(
    ('states', 'mistake'),
    [
        (
            {'cue': state(0, 0), '1': state(R, 0)},
            r"states\['1'\]\.position must be at least 57.15 mm from ball 'cue', which it",
        ),
        (
            {'cue': state(1.3, 0)},
            r"states\['cue'\]\.position must be between the cushions, .*, got \(1\.3, 0\)",
        ),
        (
            {'cue': state(1.26, 0.3)},
            r'position must be .* x from -1\.242 to 1\.242 and .*, got \(1\.26, 0\.3\)',
        ),
        ({'cue': state(1.26, 0.3, (-1, 0, 0))}, r'x from -1\.257 to 1\.257 and'),
        ({'cue': state(1.3, 0, height=0.2)}, 'position must be between the cushions'),
        ({'cue': state(0, 0, height=-0.01)}, r'position .* at least the radius'),
        ({'cue': state(0, 0, (np.inf, 0, 0))}, r"states\['cue'\]\.velocity .* finite"),
        ({'cue': state(0, 0, (1e100, 0, 0))}, r"\['cue'\]\.velocity must .* -1e\+12 to 1e\+12"),
        ({'cue': BallState((0, 0))}, r"states\['cue'\]\.position must be three numbers"),
        ({'cue': BallState((0, 0, 10**400))}, r"states\['cue'\]\.position must be three numbers"),
        ({'cue': {}}, r"states\['cue'\] must be a BallState, got {}"),
        (5, 'states must be a Mapping, got 5'),
    ],
)
def test_mistakes_are_named(states, mistake):
    with pytest.raises(ValueError, match=mistake):
        simulate(POOL, states)


def test_options_are_checked():
    with pytest.raises(ValueError, match=r'tolerance must be .*above 0, got 0 \(m\)'):
        simulate(POOL, {'cue': state(0, 0)}, tolerance=0)
    with pytest.raises(ValueError, match=r'max_events must be .*, got 0'):
        simulate(POOL, {'cue': state(0, 0)}, max_events=0)
    for states, refused in ((5, 'states must .*, got 5'), ([5], r'states\[0\] must .*, got 5')):
        with pytest.raises(ValueError, match=refused):
            simulate_batch(POOL, states)


def test_numbers_of_numpy_are_numbers():
    given = {'cue': state(0, 0, (3, 1, 0))}
    expected = simulate(POOL, given, tolerance=0.25, max_events=3)
    run = simulate(POOL, given, tolerance=np.float16(0.25), max_events=np.int64(3))
    assert (run.final_position['cue'] == expected.final_position['cue']).all()
    many = simulate_batch(POOL, given, tolerance=0.25, max_events=np.int8(3), workers=np.int64(1))
    assert (many.final_position[0, 0] == expected.final_position['cue']).all()


def test_a_run_too_long_says_so():
    run = simulate(POOL, {'cue': state(0, 0, (3, 1, 0))}, max_events=3)
    assert run.status == Status.BUDGET_EXCEEDED
    assert len(run._events.rows) == 3


def test_one_ball_does_what_it_does_alone():
    from rolling import run as alone

    from billiard_shot.table.run.layout import ball_cloth_params

    path, _, _ = alone((1, 0.2, 0), (30, -10, 20), ball_cloth_params(POOL))
    run = play(ENDLESS, cue=state(0, 0, (1, 0.2, 0), (30, -10, 20)))
    assert (run.balls['cue'].rows == path.rows).all()


def test_states_of_all_balls_at_any_time():
    run = play(POOL, cue=state(0, 0, (1, 0, 0)), one=state(0.4, 0.01))
    states = run.at([0.0, 0.1, 5.0])
    assert set(states) == {'cue', 'one'}
    assert states['one'].position.shape == (3, 3)
    times = [event.time for event in run.events]
    assert times == sorted(times)
    kinds = {event.kind for event in run.balls['one'].events}
    assert EventKind.BALL in kinds
    assert run.first_met == {'cue': 'one', 'one': 'cue'}


def test_no_friction_at_all_never_rests():
    from tables import scene_with

    cloth = dataclasses.replace(POOL.cloth, sliding_friction=0.0, rolling_resistance=0.0)
    scene = scene_with(ENDLESS, cloth=cloth)
    run = play(scene, cue=state(0, 0, (1, 0, 0)), one=state(0.5, 0.01))
    assert run.status == Status.NEVER_RESTS
    assert run.at(1e3)['one'].motion == Motion.SLIDE


def test_interpreted_it_moves_the_balls_alike(monkeypatch):
    states = {
        'cue': state(0, 0, (2, 0.3, 0), (9, 8, 7)),
        '1': state(0.3, 0.05),
        '2': state(-1, 0.2, (1, 1, 1)),
    }
    compiled = simulate(POOL, states)
    monkeypatch.setattr(machine_code, 'is_loaded', lambda: False)
    interpreted = simulate(POOL, states)
    assert compiled.status == interpreted.status
    for name, place in compiled.final_position.items():
        assert interpreted.final_position[name] == pytest.approx(place, rel=1e-9, abs=1e-9)


def test_an_impact_of_several_balls_is_the_same_interpreted(monkeypatch):
    scene = Scene.load('nine_ball')
    states = break_of(scene, 8.0)
    compiled = simulate(scene, states)
    monkeypatch.setattr(machine_code, 'is_loaded', lambda: False)
    interpreted = simulate(scene, states)
    impact = compiled.events[0]
    assert impact.kind == EventKind.CLUSTER
    assert impact.balls == interpreted.events[0].balls
    assert impact.energy_after == pytest.approx(interpreted.events[0].energy_after, rel=1e-9)
    for name, state_then in compiled.at(impact.time + 1e-3).items():
        there = interpreted.at(impact.time + 1e-3)[name]
        assert state_then.position == pytest.approx(there.position, abs=1e-9)


def test_batches_keep_their_threads():
    threads = set()
    for _ in range(5):
        threads.update(in_threads(lambda part: threading.current_thread(), 100, 2))
    assert len(threads) <= 2


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='needs fork')
def test_a_forked_process_has_threads_of_its_own():
    code = (
        'import os\n'
        'from billiard_shot.table.run.task import in_threads\n'
        'def total(): return sum(in_threads(lambda part: len(range(100)[part]), 100, 2))\n'
        'assert total() == 100\n'
        'child = os.fork()\n'
        'if not child: os._exit(total() != 100)\n'
        'print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n'
    )
    done = ran([sys.executable, '-W', 'ignore', '-c', code], check=True, timeout=60)
    assert done.stdout.strip() == '0'


def crowd():
    """A hundred balls on a big cloth, in rows of ten, three of them in touch; one that moves."""
    places = [(0.2 * (i % 10), 0.2 * (i // 10)) for i in range(100)]
    places[98], places[99] = (1.8 - 2 * R, 1.8), (1.8, 1.8)
    states = {f'ball {i}': state(*place) for i, place in enumerate(places)}
    states['ball 97'] = state(1.4, 1.8, (2, 0, 0))
    return states


def test_events_name_the_balls_that_take_part_of_a_hundred():
    """They were once a sum of powers of two, in a float, which has 53 bits."""
    run = simulate(ENDLESS, crowd())
    cluster = next(event for event in run.events if event.kind == EventKind.CLUSTER)
    assert cluster.balls == ('ball 97', 'ball 98', 'ball 99')
    run = simulate(ENDLESS, crowd() | {'ball 60': state(0, 1.2, (1, 0, 0))})
    first = next(event for event in run.events if event.kind == EventKind.BALL)
    assert first.balls == ('ball 60', 'ball 61')
    assert run.first_met['ball 60'] == 'ball 61'
    assert {event.balls[0] for event in run.events if len(event.balls) == 1} <= set(run.names)


def test_rows_that_cannot_be_say_so_and_nothing_else():
    good = {'cue': state(0.3, 0.1, (1, 0, 0)), 'one': state(0.6, 0.1)}
    no_number = {'cue': state(np.nan, 0.1), 'one': state(0.6, 0.1)}
    off_the_table = {'cue': state(5.0, 0.1), 'one': state(0.6, 0.1)}
    too_fast = {'cue': state(0.3, 0.1, (1e13, 0, 0)), 'one': state(0.6, 0.1)}
    for rows in ([no_number, good, off_the_table], [off_the_table, no_number, too_fast, good]):
        many = simulate_batch(POOL, rows)
        for i, row in enumerate(rows):
            if row is good:
                assert many.status[i] == Status.OK
                assert many.first_met[i, 0] == 1
            else:
                assert many.status[i] == Status.INVALID_REQUEST
                assert (many.first_met[i] == -1).all()
                assert (many.pocket[i] == -1).all()
                assert many.jaws_met[i] == 0
                assert (many.final_position[i] == 0.0).all()


@pytest.mark.parametrize('run', [simulate, simulate_batch])
def test_a_table_without_balls_is_refused(run):
    with pytest.raises(ValueError, match='states must contain at least one ball'):
        run(POOL, {})


def test_the_largest_numbers_end_in_numbers():
    far, fast = (
        BallState((1e12, 0, R), (1e12, -1e12, 0), (1e12, 0, 1e12)),
        state(0.3, 0, (1e12, 0, 0)),
    )
    for scene, states in (
        (ENDLESS, {'cue': far, '1': state(0, 0)}),
        (ENDLESS, {'cue': fast, '1': state(0.6, 0.01)}),
        (POOL, {'cue': fast, '1': state(0.6, 0.01)}),
    ):
        run = simulate(scene, states)
        assert all(np.isfinite(place).all() for place in run.final_position.values())
    with pytest.raises(ValueError, match=r"states\['cue'\]\.position .* -1e\+12 to 1e\+12"):
        simulate(ENDLESS, {'cue': BallState((1e308, 0, R), (1e100, 0, 0))})


def test_workers_and_rows_are_checked():
    states = {'cue': state(0.3, 0.1)}
    for workers in (0, -1):
        with pytest.raises(ValueError, match=r'workers '):
            simulate_batch(POOL, states, workers=workers)
    rows = BallState(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3)))
    with pytest.raises(
        ValueError, match=r"states\[0\]\['cue'\] must be three numbers a vector, got rows"
    ):
        simulate_batch(POOL, [{'cue': rows}])


def test_a_ball_may_begin_in_the_mouth_of_a_pocket():
    run = simulate('pool_table', {'cue': state(0.0, 0.638)})
    assert run.status == Status.OK
    with pytest.raises(ValueError, match='must be between the cushions'):
        simulate('pool_table', {'cue': state(0.3, 0.638)})


def test_a_ball_may_begin_above_a_nose_or_while_it_presses_one():
    assert simulate('pool_table', {'cue': state(1.26, 0.3, height=0.2)}).pocketed == {}
    run = simulate('pool_table', {'cue': state(1.2, 0.3, (8, 1, 0))})
    met = next(event.time for event in run.events if event.kind == EventKind.CUSHION)
    pressing = run.at(met + 1e-3)['cue']
    assert pressing.position[0] > 1.2425
    assert simulate('pool_table', {'cue': pressing}).status == Status.OK


@pytest.mark.parametrize(('spin', 'then'), [(1.0, Motion.REST), (30.0, Motion.SLIDE)])
def test_a_ball_that_spins_in_place_is_met_like_one_that_rests(spin, then):
    """Whether its spin ends before that, or later."""
    runs = [
        play(ENDLESS, a=state(0, 0, spin=(0, 0, each)), b=rolling(-0.3, 0, 0.5, 0))
        for each in (0.0, spin)
    ]
    met = [next(e.time for e in run.events if e.kind == EventKind.BALL) for run in runs]
    assert met[1] == pytest.approx(met[0], rel=1e-12)
    first, second = runs[1].balls['a'].segments[:2]
    assert (first.motion, second.motion) == (Motion.SPIN, then)
    assert second.start == min(spin / ENDLESS.cloth.spin_deceleration, met[1])
