"""The cue that hits the ball again."""

import dataclasses
import math

from jump_reference import rising_speed
from moving_strike import strike
import numpy as np
import pytest
from setups import SLOW_CLOTH

from billiard_shot import effects_of, EventKind, predict, predict_batch, Scene, Stroke
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import model_of
from billiard_shot.table.model.cue import follow_through_time
from billiard_shot.table.model.motion import Cause

POOL = dataclasses.replace(Scene.load('pool_table'), table=None)
SLOW = Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH})
R, TIP_DURATION = POOL.ball.radius, POOL.contacts.cue_ball.duration


def shot(gap, b=0.0, speed=1.5, elevation=0.1):
    scene = dataclasses.replace(POOL, balls={'cue': (0, 0), 'one': (2 * R + gap, 0)})
    return predict(
        scene, Stroke.from_offsets(a=0, b=b, elevation=elevation, azimuth=0, speed=speed)
    )


def test_a_ball_close_in_front_makes_a_double_hit():
    near = shot(0.01)
    assert near.double_hit is not None
    # the ball covers 10 mm, stops, and the cue follows with what speed the strike left it
    assert near.double_hit == pytest.approx(0.01 / near.cue_speed, rel=0.25)
    assert 'double hit' in near.message


def test_a_free_ball_runs_away_from_the_cue():
    for b in (-0.3, 0.0, 0.3):
        for elevation in (0.05, 0.3):
            assert shot(2.0, b, elevation=elevation).double_hit is None


def test_a_cue_that_recoils_never_does():
    light = dataclasses.replace(
        POOL,
        cue=dataclasses.replace(POOL.cue, mass=0.05, end_mass=0.004),
        balls={'cue': (0, 0), 'one': (2 * R + 0.01, 0)},
    )
    played = predict(light, Stroke.from_offsets(a=0, b=0, elevation=0.1, azimuth=0, speed=1))
    assert played.cue_speed < 0
    assert played.double_hit is None


def test_a_refused_stroke_has_none():
    refused = predict(
        POOL, Stroke.from_offsets(a=0, b=0, elevation=math.radians(-5), azimuth=0, speed=1)
    )
    assert refused.status.refused
    assert refused.double_hit is None


def test_it_is_one_of_the_effects():
    def effect(shot):
        return next(each for each in effects_of(shot) if each.name == 'double_hit')

    assert effect(shot(0.01)).simulated
    assert not effect(shot(0.6)).simulated
    near = shot(0.01)
    off = predict(dataclasses.replace(near.scene, effects=Effects(double_hit='off')), near.stroke)
    assert off.double_hit is None
    assert 'double hit' not in off.message
    assert (effect(off).simulated, effect(off).called_for) == (False, True)
    assert effect(off).reason.startswith('the scene turns it off; it would be simulated: the cue')


def test_a_slow_cue_is_braked_with_the_force_that_brakes_a_faster_one():
    """The energy of a cue that force takes is proportional to the way."""
    ways = [speed * follow_through_time(0.15, speed) for speed in (0.0, 0.2, 0.4, 0.8, 3.0)]
    assert ways == pytest.approx([0.0, 0.15 / 16, 0.15 / 4, 0.15, 0.15])
    assert follow_through_time(0.15, -0.3) == follow_through_time(0.15, 0.3)
    assert follow_through_time(0.0, 1.0) == 0.0


@pytest.mark.parametrize('name', ['pool_table', 'snooker', 'carom'])
def test_soft_draw_strokes_hit_once(name):
    """The ball slows down, but the cue stops first."""
    scene, rng, n = Scene.load(name), np.random.default_rng(5), 120
    scene = dataclasses.replace(scene, rack=None, balls={'cue': (0.0, 0.0)})
    rows = np.column_stack(
        [rng.uniform(-0.1, 0.1, n), rng.uniform(-0.5, -0.3, n), rng.uniform(0.03, 0.1, n),
         np.zeros(n), rng.uniform(0.4, 1.5, n)]
    )  # fmt: skip
    batch = predict_batch(scene, offsets=rows)
    assert not (batch.double_hit & ~batch.miscue).any()


def test_the_height_at_which_the_tip_touches_again_decides():
    """It touches this ball again after 3 ms, 0.2 mm above the cloth; later the ball is higher."""
    stroke = Stroke.from_offsets(
        0.18026360389175694, 0.15678435678049768, 0.7296389501272176, 2.0237, 1.6277938444668263
    )
    for tolerance in (1e-4, 1e-7):
        touched = predict('pool', stroke, tolerance)
        assert touched.chatter
        assert touched.double_hit is None


def test_no_tolerance_decides_what_is_a_double_hit():
    rng, n = np.random.default_rng(9), 400
    rows = np.column_stack(
        [rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(0.5, 1.4, n), np.zeros(n),
         rng.uniform(0.5, 5.0, n)]
    )  # fmt: skip
    coarse, fine = (predict_batch('pool', offsets=rows, tolerance=t) for t in (1e-3, 1e-7))
    assert fine.chatter.sum() > 100
    assert fine.double_hit.sum() > 10
    assert (coarse.chatter != fine.chatter).mean() < 0.01
    assert (coarse.double_hit != fine.double_hit).mean() < 0.01


@pytest.mark.parametrize('speed', [0.4, 0.7, 1.5, 3.0])
def test_a_push_stroke_is_a_double_hit_at_any_speed(speed):
    assert shot(0.01, speed=speed).double_hit is not None


def test_the_cue_goes_on_for_its_follow_through():
    far = shot(0.1)  # the cue meets the cue ball again after about 0.1 m
    assert far.double_hit is not None
    short = dataclasses.replace(far.scene, cue=dataclasses.replace(POOL.cue, follow_through=0.07))
    assert predict(short, far.stroke).double_hit is None
    with pytest.raises(ValueError, match=r'follow_through must be .* above 0 .*, got 0'):
        dataclasses.replace(POOL.cue, follow_through=0)


def doubled(scene):
    """Scene with twice the lengths and gravity: in the same times all goes twice as far."""
    cue = scene.cue
    return dataclasses.replace(
        scene,
        ball=dataclasses.replace(scene.ball, radius=2 * scene.ball.radius),
        cue=dataclasses.replace(
            cue,
            ferrule_radius=2 * cue.ferrule_radius,
            length=2 * cue.length,
            follow_through=2 * cue.follow_through,
        ),
        cloth=dataclasses.replace(scene.cloth, gravity=2 * scene.cloth.gravity),
        balls={name: (2 * x, 2 * y) for name, (x, y) in scene.balls.items()},
    )


@pytest.mark.parametrize('offsets', [(0.0, 0.0, 0.1), (0.1, -0.1, 0.1), (0.05, 0.0, 0.2)])
@pytest.mark.parametrize('gap', [0.01, 0.1])
def test_strokes_with_double_hits_scale_with_lengths_and_gravity(offsets, gap):
    smooth = dataclasses.replace(POOL.contacts.ball_ball, friction_slow=0)  # alike at all speeds
    scene = dataclasses.replace(
        POOL,
        contacts=dataclasses.replace(POOL.contacts, ball_ball=smooth),
        balls={'cue': (0, 0), 'one': (2 * R + gap, 0)},
    )
    one = predict(scene, Stroke.from_offsets(*offsets, azimuth=0, speed=1.5), 1e-6)
    two = predict(doubled(scene), Stroke.from_offsets(*offsets, azimuth=0, speed=3.0), 2e-6)
    assert one.double_hit is not None
    assert two.double_hit == pytest.approx(one.double_hit, rel=1e-9, abs=0.0)
    for name, place in one.final_position.items():
        assert two.final_position[name] == pytest.approx(2 * place, abs=1e-8)


def test_the_second_hit_pushes_the_ball_and_slows_the_cue():
    near = shot(0.01)
    off = predict(dataclasses.replace(near.scene, effects=Effects(double_hit='off')), near.stroke)
    hits = [event for event in near.events if event.kind == EventKind.CUE]
    assert hits[0].time == near.double_hit
    assert EventKind.CUE not in {event.kind for event in off.events}
    before = near.trajectory.at(near.double_hit - 1e-9).velocity[0]
    after = near.trajectory.at(near.double_hit + 3.0 * TIP_DURATION).velocity[0]
    assert after > before
    assert after > near.cue_speed  # it leaves the cue behind
    assert near.trajectory.final_position[0] > off.trajectory.final_position[0] + 0.05
    np.testing.assert_array_equal(near.velocity, off.velocity)


def without_friction(mass, restitution):
    scene = Scene.load('pool')
    contacts = dataclasses.replace(
        scene.contacts,
        cue_ball=dataclasses.replace(
            scene.contacts.cue_ball, friction=0.0, restitution=restitution
        ),
        ball_table=dataclasses.replace(scene.contacts.ball_table, friction=0.0),
    )
    cue = dataclasses.replace(scene.cue, mass=mass)
    return dataclasses.replace(scene, contacts=contacts, cue=cue, effects=Effects(shaft='off'))


def jump(scene, degrees, speed):
    elevation = math.radians(degrees)
    return predict(
        scene, Stroke.from_offsets(a=0, b=0, elevation=elevation, azimuth=0, speed=speed)
    )


def rise(played):
    """Upward speed when the cue has left the ball for good [m/s]."""
    rows = played.trajectory.rows
    last = np.flatnonzero(np.isin(rows['cause'], (Cause.START, Cause.CUE, Cause.RELEASE)))[-1]
    return rows['velocity'][last, 2]


@pytest.mark.parametrize(('mass', 'restitution'), [(0.54, 0.75), (0.25, 0.87)])
@pytest.mark.parametrize('speed', [3.0, 6.0])
def test_jump_shots_agree_with_an_integration_of_the_true_geometry(mass, restitution, speed):
    scene = without_friction(mass, restitution)
    for degrees in (35, 40, 45, 50, 55, 60):
        found = rise(jump(scene, degrees, speed)) / speed
        wanted = rising_speed(math.radians(degrees), speed, mass, restitution) / speed
        assert found == pytest.approx(wanted, abs=0.005)


def test_steeper_jump_shots_without_friction_rise_faster():
    """Up to 50 degrees."""
    scene = without_friction(0.54, 0.75)
    rises = [rise(jump(scene, degrees, 6.0)) for degrees in (35, 40, 45, 50)]
    assert (np.diff(rises) > 0.1).all()


def test_a_strike_with_two_hits_keeps_its_books():
    """Energy before is energy after and losses; the impulses change the momenta."""
    model = model_of(SLOW)._replace(shaft=False)
    rng = np.random.default_rng(1)
    n, ball = 40, model.surface
    elevation, side = rng.uniform(0.7, 1.2, n), rng.uniform(-0.3, 0.3, n)
    axes = np.column_stack([np.cos(elevation), np.zeros(n), -np.sin(elevation)])
    normals = -axes + side[:, np.newaxis] * np.array([0.0, 1.0, 0.0])
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    speed = rng.uniform(1.0, 6.0, n)
    run = strike(model, np.array([[0.0, 0.0, ball.radius]]), axes, normals, speed)
    cues, after = run.cues, run.balls[:, 0]
    assert (cues['hits'] > 1).sum() > 10
    momentum = cues['impulses'][:, 3:] - cues['impulses'][:, :3]
    np.testing.assert_allclose(ball.mass * after['velocity'], momentum, atol=1e-9)
    energy = 0.5 * model.cue_mass * cues['speed'] ** 2
    energy += 0.5 * ball.mass * (after['velocity'] ** 2).sum(axis=1)
    energy += 0.5 * ball.inertia * (after['spin'] ** 2).sum(axis=1)
    given = 0.5 * model.cue_mass * speed**2
    lost = cues['losses'].sum(axis=1)
    assert (energy <= given).all()
    assert (cues['losses'] > -1e-9).all()
    # the rest is with the end of the cue, which swings back
    assert (given - energy - lost > -1e-7 * given).all()
    assert (given - energy - lost < 0.05 * given).all()


def test_a_hit_takes_its_time():
    """Meanwhile the ball moves on; before, it jumped from one velocity to the other."""
    near = shot(0.01)
    path, hit = near.trajectory, near.double_hit
    before, after = path.at(hit - 1e-9).velocity[0], path.at(hit + 3.0 * TIP_DURATION).velocity[0]
    way = path.at(hit + 0.5 * TIP_DURATION).position[0] - path.at(hit).position[0]
    assert before < way / (0.5 * TIP_DURATION) < after
    np.testing.assert_allclose(
        path.at(hit - 1e-9).position, path.at(hit).position, rtol=0, atol=1e-8
    )


def test_a_ball_that_comes_back_from_a_cushion_hits_a_cue_that_recoils():
    """Before, a cue that recoiled was gone."""
    table = Scene.load('pool_table')
    nose = table.table.cushion.height * 2.0 * R - R
    touching = 0.5 * table.table.length - math.sqrt(R**2 - nose**2)
    stroke = Stroke.from_offsets(a=0.1, b=0.0, elevation=0.1, azimuth=0.1, speed=2)
    hits = 0
    for gap in (0.0013, 0.0014, 0.0015):
        scene = dataclasses.replace(
            table, balls={'cue': (touching - gap, 0.2)}, effects=Effects(shaft='off')
        )
        played = predict(scene, stroke)
        assert played.cue_speed < 0.0
        hits += EventKind.CUE in {event.kind for event in played.events}
    assert hits  # at some gaps the ball is slower than the cue


def test_the_paper_keeps_its_law():
    """Law energetic has no piecewise impacts: bodies stay in place, and the tip hits once."""
    scene = Scene.load('paper')
    stroke = Stroke.from_offsets(a=0, b=0, elevation=math.radians(50), azimuth=0, speed=4)
    played = predict(scene, stroke)
    off = predict(dataclasses.replace(scene, effects=Effects(double_hit='off')), stroke)
    np.testing.assert_array_equal(played.velocity, off.velocity)


@pytest.mark.parametrize('b', [-0.5, -0.3, 0.3, 0.5])
def test_the_cue_hits_where_it_is_not_where_it_seems_from_above(b):
    """A cue above or below the middle of a ball reaches it later than one at its height."""
    near = shot(0.05, b, speed=2.0, elevation=0.05)
    hits = [event for event in near.events if event.kind == EventKind.CUE]
    assert hits, 'the ball stops in front of the cue'
    for hit in hits:
        before, after = near.run.at([np.nextafter(hit.time, 0.0), hit.time])['cue'].velocity
        assert np.linalg.norm(after - before) > 0.1


def test_the_cue_hits_no_ball_that_runs_away_from_it():
    scene = dataclasses.replace(POOL, balls={})
    random = np.random.default_rng(3)
    for _ in range(60):
        stroke = Stroke.from_offsets(
            *random.uniform(-0.4, 0.4, 2), random.uniform(0.0, 0.5), 0.0, random.uniform(0.5, 5.0)
        )
        played = predict(scene, stroke)
        for event in played.trajectory.events:
            if event.kind == EventKind.CUE:
                times = [np.nextafter(event.time, 0.0), event.time]
                before, after = played.trajectory.at(times).velocity
                assert np.linalg.norm(after - before) > 1e-3


def test_the_trajectory_tells_of_a_hit_once():
    scene = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [0, 0], '1': [0.0612, 0]}})
    shot = predict(scene, Stroke.from_offsets(0, 0, elevation=0.05, azimuth=0, speed=1.5))
    told = [[e.time for e in events if e.kind is EventKind.CUE] for events in (
        shot.trajectory.events, shot.run.events
    )]  # fmt: skip
    assert told[0] == told[1] == [shot.double_hit]


@pytest.mark.parametrize('setting', ['auto', 'off'])
@pytest.mark.parametrize('others', [{}, {'one': (2 * R + 0.02, 0)}])
def test_a_batch_tells_of_double_hits_as_single_shots_do(setting, others):
    scene = dataclasses.replace(
        SLOW, balls={'cue': (0, 0), **others}, effects=Effects(double_hit=setting)
    )
    draw = np.random.default_rng(3)
    strokes = [
        Stroke.from_offsets(a, b, elevation, azimuth, 2.0)
        for a, b, elevation, azimuth in zip(
            draw.uniform(-0.3, 0.3, 24),
            draw.uniform(-0.4, 0.4, 24),
            draw.uniform(0.1, 1.3, 24),
            draw.uniform(-0.5, 0.5, 24),
            strict=True,
        )
    ]
    batch = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    shots = [predict(scene, stroke) for stroke in strokes]
    assert batch.double_hit.tolist() == [shot.double_hit is not None for shot in shots]
    assert batch.chatter.tolist() == [shot.chatter for shot in shots]
    assert batch.status.tolist() == [shot.status for shot in shots]
    for i, shot in enumerate(shots):
        np.testing.assert_allclose(batch.velocity[i], shot.velocity, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            batch.final_position[i, 0], shot.trajectory.final_position, rtol=0, atol=1e-6
        )
    again = batch.double_hit | batch.chatter
    assert again.any() == (setting == 'auto')
    assert not again.all()
