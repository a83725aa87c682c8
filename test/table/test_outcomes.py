"""What batches say of each ball is what the events of single runs say."""

from dataclasses import replace
import math

import numpy as np
import pytest
from tables import POOL, R, random_states, state

from billiard_shot import BallState, Scene, simulate, simulate_batch, Status, TableStates
from billiard_shot.table.model.motion import FROZEN, Motion
from billiard_shot.table.run.results import EventKind, NOSE_NAMES

CAROM = Scene.load('carom')
WITHOUT_POCKETS = replace(POOL, table=replace(POOL.table, pockets=False))
MEETINGS = EventKind.BALL, EventKind.CLUSTER


def fast_tables(scene, seed, count):
    """Tables of one to six balls, of which the first moves fast."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        states = random_states(random, scene.table, int(random.integers(1, 7)))
        first = next(iter(states))
        heading, speed = random.uniform(0.0, 2.0 * math.pi), random.uniform(1.0, 5.0)
        velocity = speed * np.array([math.cos(heading), math.sin(heading), 0.0])
        yield states | {first: BallState(states[first].position, velocity, (0, 0, 0))}


@pytest.mark.parametrize('scene', [POOL, WITHOUT_POCKETS])
def test_a_batch_says_what_the_events_of_single_runs_say(scene):
    met_balls = fallen = after_contact = 0
    for states in fast_tables(scene, 5, 100):
        run, batch = simulate(scene, states), simulate_batch(scene, states)
        cue = run.names[0]
        met_times, cushions, before = {}, dict.fromkeys(run.names, 0), {}
        last = dict.fromkeys(run.names, -math.inf)
        for event in run.events:
            if event.kind in MEETINGS and cue in event.balls:
                for ball in event.balls:
                    if ball != cue and ball not in met_times:
                        met_times[ball], before[ball] = event.time, cushions[cue]
            if event.kind == EventKind.CUSHION:
                ball, nose = event.balls[0], event.place in NOSE_NAMES
                rows = run.balls[ball].rows
                before_it = rows['position'][np.searchsorted(rows['time'], event.time) - 1]
                moved = abs(event.position - before_it)[0 if event.place in NOSE_NAMES[:2] else 1]
                if not nose or moved > FROZEN:
                    last[ball] = event.time
                cushions[ball] += nose
        alone = not any(event.kind == EventKind.CLUSTER for event in run.events)
        for i, name in enumerate(run.names):
            if i > 0 and (alone or np.isfinite(batch.met_time[0, i])):
                assert batch.met_time[0, i] == met_times.get(name, math.inf)
                assert batch.met_after[0, i] == before.get(name, 0)
                met_balls += name in met_times
            assert batch.cushions[0, i] == cushions[name]
            assert batch.last_cushion[0, i] == last[name]
            assert batch.off_table[0, i] == (name in run.off_table)
            assert batch.rest_time[0, i] == run.balls[name].duration
        first = min(batch.met_time[0])
        assert batch.first_contact_time[0] == first
        expected = [time > first for time in last.values()]
        assert batch.to_cushion[0].tolist() == expected
        after_contact += sum(expected)
        assert list(batch.pocketed[0].items()) == list(run.pocketed.items())
        fallen += len(run.pocketed)
    assert met_balls > 20
    assert after_contact > 30
    assert fallen > 5 or scene is WITHOUT_POCKETS


def test_a_ball_that_was_met_in_a_cluster_is_known():
    # the cue ball hits the first of two balls in touch; it does not touch the second
    states = {
        'cue': state(-0.3, 0, (2, 0, 0)),
        '1': state(0, 0),
        '2': state(2 * R, 0),
        '3': state(0, 0.4),
    }
    batch = simulate_batch(POOL, states)
    assert np.isfinite(batch.met_time[0]).tolist() == [False, True, False, False]


def test_cushions_that_the_cue_ball_met_before_a_ball_are_counted():
    # along the x axis: the head cushion, and then the ball behind the place where it began
    r = CAROM.ball.radius
    states = {'cue': BallState((0.5, 0.0, r), (-6, 0, 0)), '1': BallState((0.7, 0.0, r))}
    batch = simulate_batch(CAROM, states)
    assert batch.first_met[0, 0] == 1
    assert batch.met_after[0, 1] == 1
    assert not batch.to_cushion[0, 1] or batch.last_cushion[0, 1] > batch.met_time[0, 1]


def test_pots_are_in_the_order_of_time():
    r = R
    fast, slow = (1.0, 0.4, r), (-1.0, 0.4, r)
    states = {
        'slow': BallState(slow, (-0.8, 0.8, 0)),
        'fast': BallState(fast, (2.0, 2.0, 0)),
        'rests': state(0.0, 0.0),
    }
    batch = simulate_batch(POOL, [states, {'rests': state(0.1, 0.1)}])
    assert list(batch.pocketed[0].items()) == [('fast', 'foot_left'), ('slow', 'head_left')]
    assert batch.pocketed[1] == {}
    assert (batch.motion[1] == [Motion.ABSENT, Motion.ABSENT, Motion.REST]).all()


def test_a_data_frame_has_what_rules_ask():
    pytest.importorskip('pandas')
    states = {'cue': state(0.5, 0.0, (2, 0.1, 0)), '1': state(0.9, 0.02)}
    frame = simulate_batch(POOL, [states, {'cue': state(5.0, 0.0)}]).to_frame()
    assert frame['status'].tolist() == [Status.OK.name, Status.INVALID_REQUEST.name]
    assert frame['first_contact'][0] == '1'
    assert frame['first_contact'].isna().tolist() == [False, True]
    assert '1' in frame['to_cushion'][0]
    times = frame['first_contact_time']
    assert times.isna().tolist() == [False, True]
    assert times.describe()['mean'] == times[0]  # not infinite
    assert {'pocketed', 'off_table', 'double_hit', 'cushions', 'cue_x', '1_y'} < set(frame.columns)


# --- tables with different balls in one batch: each does what it does alone ----------------------

NAMES = 'cue', '1', '2', '3', '4'


def mixed_tables(seed, count):
    """Tables that have two to five of the balls, moving at random."""
    random = np.random.default_rng(seed)
    tables = []
    for _ in range(count):
        states = list(random_states(random, POOL.table, int(random.integers(2, 6))).values())
        names = random.permutation(NAMES)[: len(states)]
        tables.append(dict(zip(names.tolist(), states, strict=True)))
    return tables


def test_tables_with_different_balls_do_what_they_do_alone():
    tables = mixed_tables(1, 40)
    many = simulate_batch(POOL, tables)
    assert set(many.names) == set(NAMES)
    for i, table in enumerate(tables):
        # equal times are ordered by the balls' order, which is that of the batch
        alone = simulate(POOL, {name: table[name] for name in many.names if name in table})
        assert many.status[i] == alone.status
        assert many.duration[i] == alone.duration
        for k, name in enumerate(many.names):
            if name in table:
                assert (many.final_position[i, k] == alone.final_position[name]).all()
                first = many.first_met[i, k]
                met = None if first < 0 else many.names[first]
                assert met == alone.first_met.get(name)
            else:
                assert many.motion[i, k] == Motion.ABSENT
                assert many.first_met[i, k] == many.pocket[i, k] == -1


def test_a_mask_leaves_out_balls_of_columns():
    places = {'cue': state(0, 0, (2, 0, 0)), '1': state(0.3, 0), '2': state(0.6, 0)}
    columns = {
        name: BallState(np.tile(each.position, (3, 1)), each.velocity, each.spin)
        for name, each in places.items()
    }
    present = [[True, True, True], [True, False, True], [True, False, False]]
    many = simulate_batch(POOL, columns, present=present)
    assert many.first_met[:, 0].tolist() == [1, 2, -1]
    assert (many.motion == Motion.ABSENT).tolist() == (~np.array(present)).tolist()
    # absent balls may have numbers that cannot be: nobody looks at them
    columns['1'].position[1:] = np.nan
    again = simulate_batch(POOL, columns, present=present)
    assert (again.status == Status.OK).all()
    assert (again.final_position == many.final_position).all()


def test_the_balls_that_a_batch_leaves_on_the_table_begin_the_next_one():
    many = simulate_batch(POOL, mixed_tables(2, 60))
    rest = many.states
    assert (rest.present == (many.motion == Motion.REST)).all()
    again = simulate_batch(POOL, rest.take(many.status == Status.OK))
    assert (again.status == Status.OK).all()
    assert (again.duration == 0.0).all()
    kept = rest.take(many.status == Status.OK)
    assert (again.final_position[kept.present] == kept.position[kept.present]).all()


def test_states_are_checked():
    places = np.zeros((2, 1, 3))
    assert len(TableStates(['cue'], places)) == 2
    with pytest.raises(ValueError, match=r'position must be of shape \(2, 2, 3\), got'):
        TableStates(['cue', '1'], places)
    with pytest.raises(ValueError, match=r'present must be of shape \(2, 1\), got \(1, 1\)'):
        TableStates(['cue'], places, present=[[True]])
    with pytest.raises(ValueError, match='present must be true or false, got int64'):
        TableStates(['cue'], places, present=[[1], [0]])
    with pytest.raises(ValueError, match='names must be one name or more, all different'):
        TableStates(['cue', 'cue'], np.zeros((2, 2, 3)))
    with pytest.raises(ValueError, match='present must not be given if states is not a mapping'):
        simulate_batch(POOL, [{'cue': state(0, 0)}], present=[[True]])


# --- runs that end at a time, places at given times, and numbers that differ from table to table

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
