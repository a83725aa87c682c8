"""Effects on the table: what is forced, and that leaving out what is not called for is safe."""

import dataclasses

import numpy as np
import pytest
from tables import after, ENDLESS, play, POOL, R, random_states, rolling, scene_with, state

from billiard_shot.scene import Effects
from billiard_shot.status import Status
from billiard_shot.table.run.effects import AUTO, EffectContext, report, TABLE_GATES
from billiard_shot.table.run.results import EventKind
from billiard_shot.table.run.simulate import simulate, simulate_batch

CUT = {'cue': rolling(-0.5, 0.0, 2.0, 0.0), '1': state(0.1, R, (0, 0, 0))}


def wishing(scene, **settings):
    return dataclasses.replace(scene, effects=Effects(**settings))


def looks(scene, states, cue='cue'):
    """What gates look at, for a scene that forces something and for the same without."""

    def look(scene):
        run = simulate(scene, states)
        return EffectContext(scene, states[cue].velocity, run, False)

    return look(scene), look


def effects(scene, states):
    mine, again = looks(scene, states)
    return {gate.name: report(gate, mine, again) for gate in TABLE_GATES}


def test_without_cushions_the_cloth_is_endless():
    run = play(wishing(POOL, cushion='off'), **CUT)
    endless = play(ENDLESS, **CUT)
    assert {name: rest.tolist() for name, rest in run.final_position.items()} == {
        name: rest.tolist() for name, rest in endless.final_position.items()
    }
    assert abs(run.final_position['1'][0]) > POOL.table.length / 2
    found = effects(wishing(POOL, cushion='off'), CUT)
    assert found['cushion'].called_for
    assert 'the scene turns it off; it would be simulated: balls meet a cushion' in (
        found['cushion'].reason
    )


def test_without_pockets_the_cushions_go_on():
    into = {'cue': rolling(0.0, 0.0, 0.0, 1.5)}
    assert play(POOL, **into).pocketed == {'cue': 'side_left'}
    run = play(wishing(POOL, pocket='off'), **into)
    assert run.pocketed == {}
    assert next(event.place for event in run.events if event.kind == EventKind.CUSHION) == 'left'
    assert effects(POOL, into)['pocket'].reason == 'balls that fall: cue in side_left'


def test_without_ball_ball_they_go_through_each_other():
    run = play(wishing(POOL, ball_ball='off'), **CUT)
    alone = play(POOL, cue=CUT['cue'])
    assert run.final_position['cue'].tolist() == alone.final_position['cue'].tolist()
    assert run.final_position['1'].tolist() == CUT['1'].position.tolist()
    found = effects(wishing(POOL, ball_ball='off'), CUT)['ball_ball']
    assert (found.simulated, found.called_for) == (False, True)


def test_without_throw_balls_are_smooth():
    """The object ball leaves along the line of centres, and does not turn."""
    run = play(wishing(POOL, throw='off'), **CUT)
    state = after(run, '1', EventKind.BALL)
    line = run.balls['1'].at(0.0).position - after(run, 'cue', EventKind.BALL).position
    assert np.cross(state.velocity, line) == pytest.approx(np.zeros(3), abs=1e-12)
    assert state.spin == pytest.approx(np.zeros(3), abs=1e-12)
    rough = play(POOL, **CUT)
    thrown = np.cross(after(rough, '1', EventKind.BALL).velocity, line)
    assert np.abs(thrown).max() > 1e-4
    smooth = scene_with(ball_ball={'friction_fast': 0, 'friction_slow': 0})
    assert play(smooth, **CUT).final_position['1'].tolist() == run.final_position['1'].tolist()


def test_without_clusters_balls_meet_two_by_two():
    """Three balls in a line that touch: the last one takes all of it, as in a chain of pairs."""
    scene = scene_with(
        ENDLESS, ball_ball={'restitution': 1, 'friction_fast': 0, 'friction_slow': 0}
    )
    line = {
        'cue': state(-0.5, 0, (2, 0, 0)),
        **{name: state(x, 0) for name, x in (('1', 0), ('2', 2 * R), ('3', 4 * R))},
    }
    runs = simulate(scene, line), simulate(wishing(scene, cluster='off'), line)
    kinds = [{event.kind for event in run.events} for run in runs]
    assert EventKind.CLUSTER in kinds[0]
    assert EventKind.CLUSTER not in kinds[1]
    assert EventKind.BALL in kinds[1]
    pairs = after(runs[1], '3', EventKind.BALL).velocity
    assert pairs[0] > 1.02 * after(runs[0], '3', EventKind.CLUSTER).velocity[0]
    found = effects(wishing(scene, cluster='off'), line)['cluster']
    assert (found.simulated, found.called_for) == (False, True)
    assert found.reason.endswith('impacts of more than two bodies: 1, of up to 4 balls')


def test_what_is_called_for_and_why_not_the_rest():
    found = effects(POOL, CUT)
    assert found['ball_ball'].reason.startswith('balls meet another ball 1 time, first cue at 0.')
    assert found['throw'].reason.startswith('balls meet with slip, of ')
    assert found['slide'].simulated
    alone = effects(POOL, {'cue': rolling(-0.5, 0.0, 0.3, 0.0)})
    assert alone['roll'].reason == 'balls that come to roll: cue'
    assert {name: effect.reason for name, effect in alone.items() if not effect.simulated} == {
        'flight': 'the ball does not leave the cloth',
        'bounce': 'there is no flight',
        'slide': 'no ball that would slip on the cloth',
        'spin_decay': 'no ball that would spin about the vertical',
        'cushion': 'no path reaches a cushion',
        'pocket': 'no path reaches a jaw of a pocket',
        'ball_ball': 'there is no other ball',
        'throw': 'no ball meets another one',
        'cluster': 'no more than two bodies ever meet',
    }
    endless = effects(ENDLESS, {'cue': rolling(-0.5, 0.0, 0.3, 0.0)})
    assert endless['cushion'].reason == 'the scene has no table: the cloth is endless'


def test_gates_of_places_and_pairs_change_nothing_and_cost_less():
    """
    500 random tables: with every pocket and every pair looked at, the same runs.

    To rounding, which grows by a factor of ten or more at each meeting of balls: what is compared
    is where they are up to the third one. With cushions in closed form: the steps of the other
    model turn rounding into its error.
    """
    draw = np.random.default_rng(11)
    closed = scene_with(cushion={'model': 'han'})
    searched = wishing(closed, pocket='on', ball_ball='on')
    searches, met = np.zeros(2), 0
    for number in range(500):
        states = random_states(draw, POOL.table, 1 + number % 6)
        runs = simulate(closed, states), simulate(searched, states)
        searches += [run.searches for run in runs]
        assert runs[0].searches <= runs[1].searches
        meetings = [event.time for event in runs[0].events if event.kind == EventKind.BALL]
        times = np.linspace(0, [*meetings, runs[0].duration, runs[0].duration][:3][-1], 9)
        found = [run.at(times) for run in runs]
        apart = [
            np.abs(found[0][name].position - found[1][name].position).max() for name in states
        ]
        assert max(apart) < 1e-7
        met += len(meetings) > 0
    assert met > 200
    assert searches[1] > 2.0 * searches[0]


def test_hops_left_out_move_the_cue_ball_less_than_the_tolerance():
    """300 tables: all hops followed, or those that the tolerance calls for, to the cushion."""
    draw = np.random.default_rng(12)
    everything = wishing(POOL, flight='on', bounce='on')
    tolerance, events = 1e-4, np.zeros(2)
    for _ in range(300):
        speed = draw.choice([0.3, 2.0, 6.0])
        spin = draw.normal(size=3) * speed * 20
        velocity = (*draw.normal(size=2) * speed, abs(draw.normal()) * draw.choice([0, 0.02, 0.5]))
        states = {'cue': state(*draw.uniform(-0.4, 0.4, 2), velocity, spin)}
        runs = [simulate(scene, states, tolerance) for scene in (POOL, everything)]
        events += [len(run.events) for run in runs]
        cushions = [
            event.time
            for event in runs[0].events
            if event.kind != EventKind.BOUNCE
            and event.kind in (EventKind.CUSHION, EventKind.POCKET, EventKind.OFF)
        ]
        times = np.linspace(0, min([runs[0].duration, *cushions]), 20)[:-1]
        apart = [run.at(times)['cue'].position for run in runs]
        assert np.abs(apart[0] - apart[1]).max() < tolerance
    assert events[0] < events[1]


def test_batches_are_forced_alike():
    for setting in ('ball_ball', 'pocket', 'throw', 'cushion'):
        scene = wishing(POOL, **{setting: 'off'})
        run, batch = simulate(scene, CUT), simulate_batch(scene, [CUT, CUT])
        assert batch.final_position[1].tolist() == [
            run.final_position['cue'].tolist(),
            run.final_position['1'].tolist(),
        ]
        assert batch.searches.tolist() == [run.searches] * 2
        assert run.status in (Status.OK, Status.NEVER_RESTS)


def test_every_effect_can_be_left_to_its_gate():
    assert all(getattr(Effects(), gate.name) == AUTO for gate in TABLE_GATES)
