"""What batches say of each ball is what the events of single runs say."""

from dataclasses import replace
import math

import numpy as np
import pytest
from tables import POOL, R, random_states, state

from billiard_shot import Scene, simulate, simulate_batch, Status
from billiard_shot.table.model.motion import FROZEN, Motion
from billiard_shot.table.run.results import BallState, EventKind, NOSE_NAMES

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
