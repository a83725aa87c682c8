"""A tip that shears: its time on the ball, squirt, and the chain of masses it stands for."""

import math

import chain_reference
from moving_strike import strike
import numpy as np
import pytest

from billiard_shot import effects_of, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.shot.effects import cue_params, model_of, TIP_SHEAR
from billiard_shot.table.run.layout import ENDLESS

TIP = {'restitution': 0.75, 'friction': 0.6, 'duration': 1.3e-3, 'exponent': 1.5}
CLOTH = {'restitution': 0.5, 'friction': 0.2, 'duration': 0.7e-3}


def pool(spring='on', **effects):
    contacts = {'cue_ball': TIP, 'ball_table': CLOTH}
    return Scene.from_dict(
        {'like': 'pool', 'contacts': contacts, 'effects': {'tip_spring': spring, **effects}}
    )


POOL = pool()
BOTH_TIPS = pytest.mark.parametrize(
    'scene', [Scene.load('pool'), POOL], ids=['rigid', 'tip_spring']
)


def level(a, speed):
    """Level strokes at side offsets [radii]."""
    columns = np.broadcast_arrays(a, 0.0, 0.0, 0.0, speed)
    return np.column_stack([column.ravel() for column in columns]).astype(float)


def random_strokes(draw, count, offset, lowest, highest):
    """Strokes at 1 to 3 m/s with offsets within a circle [radii] and elevations [degrees]."""
    away, angle = offset * np.sqrt(draw.random(count)), draw.uniform(0.0, 2.0 * math.pi, count)
    elevation = np.radians(draw.uniform(lowest, highest, count))
    speed = draw.uniform(1.0, 3.0, count)
    return np.column_stack(
        [away * np.cos(angle), away * np.sin(angle), elevation, np.zeros(count), speed]
    )


def vectors(rows):
    """Axes (n, 3) of cues, directions (n, 3) from the ball to the tip, and speeds."""
    strokes = [Stroke.from_offsets(*row) for row in rows]
    speeds = rows[:, 4]
    return (
        np.array([stroke.velocity for stroke in strokes]) / speeds[:, np.newaxis],
        np.array([stroke.normal for stroke in strokes]),
        speeds,
    )


def ours(scene, rows, **changes):
    model = model_of(scene)
    return strike(model, np.array([[0.0, 0.0, model.surface.radius]]), *vectors(rows), **changes)


def touched(a, speed):
    return predict(POOL, Stroke.from_offsets(a, 0.0, 0.0, 0.0, speed)).tip_time


def squirt(a, speed):
    velocity = predict_batch(POOL, offsets=level(a, speed)).velocity
    return np.degrees(np.arctan2(velocity[:, 1], velocity[:, 0]))


def test_slow_and_off_centre_contacts_last_longer():
    """As in high-speed films; a tip that does not shear touches the ball for less off centre."""
    assert 1.9 < touched(0.0, 0.3) / touched(0.0, 8.0) < 2.0
    assert 1.005 < touched(0.4, 2.0) / touched(0.0, 2.0) < 1.1
    stroke = Stroke.from_offsets(0.4, 0.0, 0.0, 0.0, 2.0)
    assert predict(pool('off'), stroke).tip_time < 0.9 * touched(0.0, 2.0)


def test_squirt_is_that_of_measured_cues():
    """At half a radius the tip slips: docs/limits.md."""
    found = squirt([0.1, 0.3, 0.48], 2.0)
    assert (np.array([0.35, 0.75, 1.6]) < found).all()
    assert (found < np.array([0.55, 1.6, 2.6])).all()
    assert squirt(0.5, 2.0)[0] > 2.6


@BOTH_TIPS
def test_a_chalked_tip_slips_from_half_a_radius_on(scene):
    offsets = np.arange(0.4, 0.65, 0.01)
    shots = [predict(scene, Stroke.from_offsets(a, 0.0, 0.0, 0.0, 2.0)) for a in offsets]
    assert 0.48 <= offsets[[shot.miscue for shot in shots].index(True)] <= 0.6


@BOTH_TIPS
def test_a_playing_cue_hits_most_steep_strokes_near_the_middle_once(scene):
    batch = predict_batch(
        scene, offsets=random_strokes(np.random.default_rng(6), 300, 0.3, 20.0, 60.0)
    )
    assert (batch.double_hit | batch.chatter).mean() < 0.15


def test_a_jump_cue_with_a_tip_that_shears_lifts_the_ball_in_one_hit():
    scene = Scene.from_dict(
        {
            'like': 'jump_cue',
            'contacts': {'cue_ball': {'exponent': 1.5}},
            'effects': {'tip_spring': 'on'},
        }
    )
    for elevation in (30, 40, 50):
        shot = predict(scene, Stroke.from_offsets(0.0, 0.0, math.radians(elevation), 0.0, 4.0))
        assert shot.velocity[2] >= 0.23 * 4.0
        assert shot.double_hit is None
        assert not shot.chatter


def test_strikes_agree_with_a_chain_of_masses():
    """Relative to the speed of the cue; steep strokes only if they hit once."""
    model, draw = model_of(POOL), np.random.default_rng(2)
    q, ball = cue_params(model, ENDLESS), model.surface
    given = chain_reference.Strike(
        ball.mass, ball.inertia, ball.radius, model.cue_mass, 0.0065,
        tip=(q.stiffness, q.exponent, q.restitution, q.friction), shear=TIP_SHEAR,
        cloth=(q.cloth_stiffness, q.cloth_restitution, q.cloth_friction),
    )  # fmt: skip
    rows = np.concatenate(
        [random_strokes(draw, 12, 0.45, 0.0, 8.0), random_strokes(draw, 12, 0.45, 15.0, 70.0)]
    )
    velocity, spin, tip_time, hits = chain_reference.strike(given, *vectors(rows), step=5e-7)
    shots = [predict(POOL, Stroke.from_offsets(*row)) for row in rows]
    errors = [np.array([shot.velocity for shot in shots]) - velocity]
    errors += [ball.radius * (np.array([shot.spin for shot in shots]) - spin)]
    error = np.abs(np.hstack(errors)).max(axis=1) / rows[:, 4]
    found_time = np.array([shot.tip_time for shot in shots])
    once = np.array([shot.double_hit is None and not shot.chatter for shot in shots])
    once &= (hits == 1) & (found_time < 3e-3)
    flat, steep = error[:12], error[12:][once[12:]]
    assert once[:12].all()
    assert len(steep) > 6
    assert np.median(flat) < 0.005
    assert flat.max() < 0.01
    assert np.median(steep) < 0.01
    assert np.quantile(steep, 0.9) < 0.03
    assert found_time[:12] == pytest.approx(tip_time[:12], rel=0.02)


def test_a_tip_that_hardly_shears_is_a_tip_that_does_not():
    rows = random_strokes(np.random.default_rng(3), 40, 0.4, 0.0, 40.0)
    free = {'across': model_of(POOL).inverse_end_mass, 'end_damping': 0.0, 'end_stiffness': 1e-6}
    stiff, rigid = (ours(POOL, rows, **free, shear=shear) for shear in (300.0, 0.0))
    once = (stiff.cues['hits'] == 1) & (rigid.cues['hits'] == 1)
    assert once.sum() > 20
    error = np.abs(stiff.balls['velocity'] - rigid.balls['velocity'])[once].max(axis=(1, 2))
    assert (error / rows[once, 4]).max() < 1e-3


@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_a_tip_that_shears_gives_no_energy_and_needs_few_steps(exponent):
    rows = random_strokes(np.random.default_rng(1), 400, 0.8, 0.0, 80.0)
    contacts = {'cue_ball': {**TIP, 'exponent': exponent}, 'ball_table': CLOTH}
    scene = Scene.from_dict(
        {'like': 'pool', 'contacts': contacts, 'effects': {'tip_spring': 'on'}}
    )
    run = ours(scene, rows)
    assert np.isin(run.cues['status'], (Status.OK, Status.TOLERANCE_NOT_REACHED)).all()
    assert run.cues['steps'].mean() < 500
    ball, cue, after = scene.ball, scene.cue, run.balls[:, 0]
    energy = 0.5 * ball.mass * (after['velocity'] ** 2).sum(axis=1)
    energy += 0.5 * ball.inertia * (after['spin'] ** 2).sum(axis=1)
    energy += 0.5 * cue.mass * run.cues['speed'] ** 2
    left = 0.5 * cue.mass * rows[:, 4] ** 2 - energy - run.cues['losses'].sum(axis=1)
    assert (run.cues['losses'] > -1e-9).all()
    assert (left > -1e-7 * rows[:, 4] ** 2).all()


@pytest.mark.parametrize('spring', ['off', 'on'])
def test_a_curved_spring_closes_no_contact_that_only_touches(spring):
    """Else the ball met the cloth again, by chance of the tolerance, and the normals moved."""
    draw = np.random.default_rng(1)
    rows = random_strokes(draw, 200, 0.45, 0.0, 8.0)
    rows[:, 4] = draw.uniform(0.3, 8.0, 200)
    loose, tight = (
        predict_batch(pool(spring), offsets=rows, tolerance=each).velocity for each in (1e-4, 1e-8)
    )
    assert np.abs(loose - tight).max() < 1e-6


def test_the_effect_is_off_unless_the_scene_turns_it_on():
    def effect(shot):
        return next(each for each in effects_of(shot) if each.name == 'tip_spring')

    stroke = Stroke.from_offsets(0.3, 0.0, 0.1, 0.0, 2.0)
    shot = predict(Scene.load('pool'), stroke)
    assert (effect(shot).simulated, effect(shot).called_for) == (False, True)
    assert effect(predict(POOL, stroke)).simulated
    for scene in (pool(shaft='off'), Scene.from_dict({'like': 'pool', 'cue': {'guided': True}})):
        assert not effect(predict(scene, stroke)).called_for
    smooth = predict(pool(shaft='off'), stroke)
    assert (smooth.velocity == predict(pool('off', shaft='off'), stroke).velocity).all()


def test_no_shot_is_predicted_again_to_say_whether_it_calls_for_the_effect(monkeypatch):
    """The effect is off by default: each answer of the predictor would take twice as long."""
    shot = predict('pool', Stroke.from_offsets(0.3, 0.0, 0.1, 0.0, 2.0))

    def again(*_):
        raise AssertionError('predicted again')

    monkeypatch.setattr('billiard_shot.shot.predict.predict', again)
    assert 'tip_spring' in [each.name for each in effects_of(shot)]
