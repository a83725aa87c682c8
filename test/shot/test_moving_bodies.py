"""Cue, balls, cushions and cloth that move while they meet, against an independent integration."""

import math

import numpy as np
import pytest
from strike_reference import ARC, BALL, CLOTH, EDGE, integrate, Springs

from billiard_shot import Scene, Status, Stroke
from billiard_shot.shot.cue_contact import MAX_HITS, meet, Meeting
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.model import TIP, tip_reach, tip_stiffness
from billiard_shot.shot.neighbours import FIXED, neighbours_of
from billiard_shot.table.effects import table_on
from billiard_shot.table.geometry import layout_of

POOL = {'like': 'pool_table'}
GUIDED = {'like': 'pool_table', 'cue': {'mass': 0.5, 'guided': True}}
R = Scene.load('pool_table').ball.radius
TABLE = Scene.load('pool_table').table
TOUCHING = 0.5 * TABLE.length - math.sqrt(R**2 - (TABLE.cushion.height * 2.0 * R - R) ** 2)
STEP = 4e-7  # s; half of it changes the reference by less than 0.001 of the cue's speed


def springs_of(model, neighbours):
    """State tip, cloth and neighbours in the terms of the reference."""
    scale = tip_stiffness(model) / model.stiffness[TIP]
    nowhere = np.zeros(3)
    rows = [
        (CLOTH, 0, -1, nowhere, nowhere, 0.0, friction, 0.0, 0.0, restitution, 0.0, scale * k)
        for friction, restitution, k in zip(
            model.friction, model.restitution, model.stiffness, strict=True
        )
    ]
    for each in neighbours:
        kind, point, along, size, nose = BALL, nowhere, nowhere, 0.0, each.nose
        if nose is not None and nose.is_round:
            kind, point, size = ARC, np.array([nose.x, nose.y, nose.height]), -nose.away
        elif nose is not None:
            kind, along = EDGE, np.array([-nose.y, nose.x, 0.0])
            point = np.array([-nose.away * nose.x, -nose.away * nose.y, nose.height])
        elif each.b == FIXED:
            kind = CLOTH
        friction = each.friction, each.fading, each.decay
        law = each.restitution, each.softening, each.stiffness
        rows.append((kind, each.a, each.b, point, along, size, *friction, *law))
    return Springs(*(np.array(column) for column in zip(*rows, strict=True)))


def both(scene, stroke):
    """
    Solve a strike by the library and by the reference.

    Returns velocities, spins times radius and the speed of the cue, relative to the cue's speed
    before; and how often contacts closed; each twice.
    """
    model = model_of(scene)
    balls = scene.balls or {'cue': (0.0, 0.0)}
    places = np.array([[*place, R] for place in balls.values()])
    table = layout_of(model.surface, table_on(scene))
    members, neighbours = neighbours_of(table, model, places)
    places, velocity = places[members], np.array(stroke.velocity)
    speed, normal = np.linalg.norm(velocity), np.array(stroke.normal)
    axis, tip = velocity / speed, places[0] + tip_reach(model) * normal / np.linalg.norm(normal)
    still = np.zeros((1, *places.shape))
    begin = Meeting(places[np.newaxis], still, still, tip[np.newaxis], np.array([speed]))
    met = meet(model, axis[np.newaxis], begin, np.array([1e-9]), neighbours)
    assert met.status[0] == Status.OK
    found = np.concatenate(
        [met.after.velocity.ravel(), R * met.after.spin.ravel(), met.after.speed]
    )
    ball, cue = model.surface, np.array([1.0 / model.cue_mass, model.inverse_end_mass, *axis])
    v, w, left, closings, _ = integrate(
        springs_of(model, neighbours), cue, model.exponent, ball.mass, ball.inertia, R,
        tip_reach(model), tip, speed, places.copy(), MAX_HITS, STEP, 0.05,
    )  # fmt: skip
    wanted = np.concatenate([v.ravel(), R * w.ravel(), [left]])
    return found / speed, wanted / speed, met.closings[0], closings


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


@pytest.mark.parametrize('cue', [POOL, GUIDED], ids=['end mass', 'guided'])
@pytest.mark.parametrize('kind', ['alone', 'ball', 'cushion', 'ball and cushion'])
def test_strikes_agree_with_an_integration_of_the_true_geometry(kind, cue):
    rng, errors = np.random.default_rng(11), []
    for _ in range(6):
        scene = Scene.from_dict({**cue, 'balls': places(kind, rng)})
        ahead = 1.0 if kind == 'ball and cushion' else 0.0
        found, wanted, hits, closings = both(scene, steep(rng, ahead + rng.uniform(-0.8, 0.8)))
        assert hits[TIP] == closings[TIP]
        errors.append(np.abs(found - wanted).max())
    assert np.median(errors) < 0.002
    assert max(errors) < 0.02


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
        stiffness=(stiffness, 1.0),
    )
    axes, normals = directions(rng, 40)
    place = np.tile([0.0, 0.0, ball.radius], (40, 1, 1))
    still, speed = np.zeros((40, 1, 3)), 10.0 ** rng.uniform(-1.0, 1.0, 40)
    begin = Meeting(place, still, still, place[:, 0] + tip_reach(model) * normals, speed)
    met = meet(model, axes, begin, np.full(40, 1e-9))
    assert (met.status == Status.OK).all()
    energy = 0.5 * model.cue_mass * met.after.speed**2
    energy += 0.5 * ball.mass * (met.after.velocity**2).sum(axis=(1, 2))
    energy += 0.5 * ball.inertia * (met.after.spin**2).sum(axis=(1, 2))
    assert (energy <= 0.5 * model.cue_mass * speed**2 * (1.0 + 1e-9)).all()
