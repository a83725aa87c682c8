"""Cue, balls, cushions and cloth that move while they meet, against an independent integration."""

from dataclasses import replace
import math

from moving_strike import strike
import numpy as np
import pytest
from strike_reference import BALL, CLOTH, EDGE, integrate, Springs

from billiard_shot import predict, predict_batch, Scene, Status, Stroke
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import cue_params, model_of
from billiard_shot.table.model.cue import CLOTH_CONTACT, LONGEST_SWING, MAX_HITS, TIP_CONTACT
from billiard_shot.table.model.geometry import stiffness_of
from billiard_shot.table.run.effects import table_on

POOL = {'like': 'pool_table'}
CUES = {
    'shaft': POOL,
    'free end': {**POOL, 'effects': {'shaft': 'off'}},
    'guided': {**POOL, 'cue': {'mass': 0.5, 'guided': True}},
}
KINDS = 'alone', 'ball', 'cushion', 'ball and cushion'
ALONE = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [0.0, 0.0]}})
R = ALONE.ball.radius
FURNITURE = ALONE.table
TOUCHING = 0.5 * FURNITURE.length - math.sqrt(R**2 - (FURNITURE.cushion.height * 2.0 * R - R) ** 2)
STEP = 4e-7  # s; half of it changes the reference by less than 0.001 of the cue's speed


def springs_of(scene, params):
    """State tip, cloth, balls and the nose at the foot in the terms of the reference."""
    nowhere, model = np.zeros(3), model_of(scene)
    places = np.array([[*place, R] for place in scene.balls.values()])
    cloth = (
        model.restitution[CLOTH_CONTACT], 0.0, 0.0, params.cloth_stiffness, params.cloth_exponent,
    )  # fmt: skip
    tip = model.restitution[TIP_CONTACT], 0.0, 0.0, params.stiffness, params.exponent
    rows = [
        (CLOTH, 0, -1, nowhere, nowhere, 0.0, model.friction[TIP_CONTACT], 0.0, 0.0, *tip),
        (CLOTH, 0, -1, nowhere, nowhere, 0.0, model.friction[CLOTH_CONTACT], 0.0, 0.0, *cloth),
    ]
    nose, balls = scene.table.cushion, scene.contacts.ball_ball
    if len(places) > 1:
        friction = balls.friction_fast + balls.friction_slow
        fading = balls.friction_slow, balls.friction_decay
        law = balls.restitution, 0.0, 0.0, params.ball_stiffness, model.surface.exponent
        rows.append((BALL, 0, 1, nowhere, nowhere, 0.0, friction, *fading, *law))
    for ball, place in enumerate(places):
        if place[0] > 0.5 * scene.table.length - 2.0 * R:
            point = np.array([0.5 * scene.table.length, 0.0, nose.height * 2.0 * R])
            along = np.array([0.0, 1.0, 0.0])
            law = nose.restitution, nose.early_fading, nose.fading
            rows.append((EDGE, ball, -1, point, along, 0.0, nose.friction, 0.0, 0.0, *law,
                         params.nose_stiffness, model.surface.exponent))  # fmt: skip
            if ball > 0:
                rows.append((CLOTH, ball, -1, nowhere, nowhere, 0.0, model.friction[CLOTH_CONTACT],
                             0.0, 0.0, *cloth))  # fmt: skip
    return Springs(*(np.array(column) for column in zip(*rows, strict=True)))


def both(scene, stroke):
    """
    Solve a strike by the library and by the reference.

    Returns velocities, spins times radius and the speed of the cue, relative to the cue's speed
    before; and how often the tip met the ball; each twice.
    """
    model, table = model_of(scene), table_on(scene)
    params, ball = cue_params(model, table), model.surface
    places = np.array([[*place, R] for place in scene.balls.values()])
    velocity, normal = np.array(stroke.velocity), np.array(stroke.normal)
    speed, normal = np.linalg.norm(velocity), normal / np.linalg.norm(normal)
    axis = velocity / speed
    run = strike(model, places, axis[np.newaxis], normal[np.newaxis], np.array([speed]), table)
    cue, after = run.cues[0], run.balls[0]
    assert cue['status'] == Status.OK
    found = np.concatenate([after['velocity'].ravel(), R * after['spin'].ravel(), [cue['speed']]])
    shaft = params.end_stiffness, params.end_damping, LONGEST_SWING
    numbers = np.array([params.response, params.across, *axis, *shaft])
    tip = places[0] + params.reach * normal
    v, w, left, closings, _ = integrate(
        springs_of(scene, params), numbers, ball.mass, ball.inertia, R, params.reach, tip, speed,
        places.copy(), MAX_HITS, STEP, 0.05,
    )  # fmt: skip
    wanted = np.concatenate([v.ravel(), R * w.ravel(), [left]])
    return found / speed, wanted / speed, cue['hits'], closings[TIP_CONTACT]


def steep(rng, azimuth):
    a, b = rng.uniform(-0.4, 0.4, 2)
    elevation = math.radians(rng.uniform(20.0, 75.0))
    return Stroke.from_offsets(a, b, elevation, azimuth, rng.uniform(0.5, 7.0))


def places(kind, rng):
    gap, angle = rng.uniform(0.0, 2e-3), rng.uniform(-0.8, 0.8)
    if kind == 'alone':
        return {'cue': [0.0, 0.0]}
    if kind == 'ball':
        away = 2.0 * R + gap
        return {'cue': [0.0, 0.0], '1': [away * math.cos(angle), away * math.sin(angle)]}
    if kind == 'cushion':
        return {'cue': [TOUCHING - gap, 0.1]}
    return {'cue': [TOUCHING - gap, 0.1], '1': [TOUCHING - gap, 0.1 + 2.0 * R + 1e-4]}


@pytest.mark.parametrize(
    ('kind', 'cue'),
    # Not of ball and cushion with a shaft: while that swings, the reference goes on with balls
    # that have left the strike.
    [(kind, cue) for kind in KINDS for cue in CUES if (kind, cue) != (KINDS[-1], 'shaft')],
)
def test_strikes_agree_with_an_integration_of_the_true_geometry(kind, cue):
    rng, errors = np.random.default_rng(11), []
    for _ in range(4):
        scene = Scene.from_dict({**CUES[cue], 'balls': places(kind, rng)})
        if kind == 'cushion':
            scene = scene.with_parameters(['table.cushion.early_fading'], [0.2])
        ahead = 1.0 if kind == 'ball and cushion' else 0.0
        found, wanted, hits, closings = both(scene, steep(rng, ahead + rng.uniform(-0.8, 0.8)))
        assert hits == closings
        errors.append(np.abs(found - wanted).max())
    assert np.median(errors) < 0.002
    assert max(errors) < 0.02


@pytest.mark.parametrize('elevation', [0.05, 0.2, 0.6, 0.62])
@pytest.mark.parametrize('effects', [Effects(), Effects(double_hit='off')], ids=['', 'no hit'])
def test_normals_move_in_strikes_with_one_hit(elevation, effects):
    """Also if the cue is gone after its hit."""
    scene = replace(ALONE, effects=effects)
    for a, b, speed in ((0.3, -0.2, 6.0), (-0.1, -0.3, 4.0)):
        stroke = Stroke.from_offsets(a, b, elevation, 0.3, speed)
        shot = predict(scene, stroke)
        _, wanted, hits, closings = both(ALONE, stroke)
        assert hits == closings == 1
        assert shot.double_hit is None
        assert np.abs(shot.velocity / speed - wanted[:3]).max() < 2e-4


@pytest.mark.parametrize('effects', [{}, {'shaft': 'off'}], ids=['shaft', 'free end'])
def test_no_elevation_changes_a_strike_at_once(effects):
    """Between neighbours with one hit; a quarter of them at 35 degrees."""
    scene = Scene.from_dict({'like': 'pool', 'effects': effects})
    rng, n = np.random.default_rng(3), 400
    rows = np.column_stack([rng.uniform(-0.25, 0.25, (n, 2)), rng.uniform(0.0, 1.4, n),
                            np.zeros(n), rng.uniform(0.5, 6.0, n)])  # fmt: skip
    rows[: n // 4, 2] = math.radians(35.0)
    raised = rows.copy()
    raised[:, 2] += 1e-6
    low, high = predict_batch(scene, offsets=rows), predict_batch(scene, offsets=raised)
    alike = ~(low.double_hit | low.chatter | high.double_hit | high.chatter)
    step = np.abs(low.velocity - high.velocity).max(axis=1) / rows[:, 4]
    assert alike.mean() > 0.5
    assert step[alike].max() < 1e-3


def test_the_steepest_strikes_with_one_hit_agree_with_the_true_geometry():
    rng, checked = np.random.default_rng(2), 0
    while checked < 6:
        a, b = rng.uniform(-0.4, 0.4, 2)
        stroke = Stroke.from_offsets(
            a, b, math.radians(rng.uniform(45.0, 80.0)), 0.0, rng.uniform(0.5, 7.0)
        )
        shot = predict(ALONE, stroke)
        if shot.double_hit is not None or shot.miscue:
            continue
        found = np.concatenate([shot.velocity, R * shot.spin]) / stroke.speed
        assert found == pytest.approx(both(ALONE, stroke)[1][:6], abs=1e-3)
        checked += 1


def test_strikes_of_any_speed_end_with_a_true_status():
    """A tip that would go through a good part of the ball does not keep its tolerance."""
    rng, n = np.random.default_rng(4), 300
    speeds, around = 10.0 ** rng.uniform(-1.5, 2.0, n), rng.uniform(-0.5, 0.5, (n, 2))
    rows = np.column_stack([around, rng.uniform(0.5, 1.5, n), rng.uniform(-3.0, 3.0, n), speeds])
    batch = predict_batch('pool', offsets=rows)
    played = batch.status < Status.MISS
    assert played.mean() > 0.9
    fast = played & (speeds * ALONE.contacts.cue_ball.duration > R)
    assert (batch.status[fast] == Status.TOLERANCE_NOT_REACHED).all()
    assert (batch.status[played & ~fast] != Status.OK).mean() < 0.05
    ball = model_of(ALONE).surface
    energy = 0.5 * ball.mass * (batch.velocity**2).sum(axis=1)
    energy += 0.5 * ball.inertia * (batch.spin**2).sum(axis=1)
    assert (energy[played] <= 0.5 * ALONE.cue.mass * speeds[played] ** 2).all()  # false for NaN


def directions(rng, count):
    """Directions of the lower half sphere, and normals near the opposite ones, (count, 3) each."""
    axes = rng.normal(size=(count, 3))
    axes[:, 2] = -np.abs(axes[:, 2])
    axes /= np.linalg.norm(axes, axis=1)[:, np.newaxis]
    normals = rng.uniform(-0.5, 0.5, (count, 3)) - axes
    return axes, normals / np.linalg.norm(normals, axis=1)[:, np.newaxis]


@pytest.mark.parametrize('seed', range(8))
def test_no_ratio_of_masses_or_stiffnesses_makes_energy(seed):
    """Cue, end and ball, tip and cloth: with ratios from 0.0001 to 10,000."""
    rng, pool = np.random.default_rng(seed), model_of(Scene.load('pool'))
    ball, (cue, end, stiffness) = pool.surface, 10.0 ** rng.uniform(-4.0, 4.0, 3)
    model = pool._replace(
        cue_mass=ball.mass * cue,
        inverse_end_mass=1.0 / (ball.mass * end) if seed % 2 else 0.0,
        friction=tuple(rng.uniform(0.0, 1.0, 2).tolist()),
        restitution=tuple(rng.uniform(0.05, 1.0, 2).tolist()),
    )
    hit = 2.0 / (1.0 / model.cue_mass + 1.0 / ball.mass)
    tip = stiffness_of(hit, model.tip_duration, model.exponent[TIP_CONTACT])
    model = model._replace(stiffness=(tip, tip / stiffness))
    axes, normals = directions(rng, 40)
    place, speed = np.array([[0.0, 0.0, ball.radius]]), 10.0 ** rng.uniform(-1.0, 1.0, 40)
    run = strike(model, place, axes, normals, speed)
    assert (run.cues['status'] == Status.OK).all()
    energy = 0.5 * model.cue_mass * run.cues['speed'] ** 2
    energy += 0.5 * ball.mass * (run.balls['velocity'] ** 2).sum(axis=(1, 2))
    energy += 0.5 * ball.inertia * (run.balls['spin'] ** 2).sum(axis=(1, 2))
    assert (energy <= 0.5 * model.cue_mass * speed**2 * (1.0 + 1e-9)).all()
