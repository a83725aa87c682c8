"""The shaft of a cue: squirt, several hits in miscues, and the limit of a free end."""

from dataclasses import replace
import math

from moving_strike import strike
import numpy as np
import pytest

from billiard_shot import predict_batch, Scene, Status
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import model_of

CLOTH = {'restitution': 0.5, 'friction': 0.2, 'duration': 0.7e-3}


def pool(friction=0.6, **changes):
    tip = {'restitution': 0.75, 'friction': friction, 'duration': 1.3e-3}
    contacts = {'cue_ball': tip, 'ball_table': CLOTH}
    return Scene.from_dict({'like': 'pool', 'contacts': contacts, **changes})


POOL = pool()


def strokes(a, speed, b=0.0, elevation=0.0):
    columns = np.broadcast_arrays(a, b, elevation, 0.0, speed)
    return np.column_stack([column.ravel() for column in columns]).astype(float)


def squirt(scene, a, speed):
    """Angles of the ball from level strokes [degrees]."""
    velocity = predict_batch(scene, offsets=strokes(a, speed)).velocity
    return np.degrees(np.arctan2(velocity[:, 1], velocity[:, 0]))


def random_strokes(least, most, elevation, count=200):
    rng = np.random.default_rng(1)
    radius, angle = (
        np.sqrt(rng.uniform(least**2, most**2, count)),
        rng.uniform(0, 2 * math.pi, count),
    )
    down = rng.uniform(0.0, math.radians(elevation), count)
    speed = rng.uniform(1.0, 3.0, count)
    return strokes(radius * np.cos(angle), speed, radius * np.sin(angle), down)


def hit_twice(scene, offsets):
    """Share of the strokes that can be played whose tip meets the ball again, however soon."""
    batch = predict_batch(scene, offsets=offsets)
    return (batch.double_hit | batch.chatter)[~batch.refused].mean()


def test_squirt_is_that_of_measured_cues():
    """Alciatore measures 0.4 and 1.9 degrees at 0.1 and 0.5 radii."""
    found = squirt(POOL, [0.1, 0.3, 0.5], 2.0)
    assert (np.array([0.35, 0.75, 1.6]) < found).all()
    assert (found < np.array([0.55, 1.6, 2.6])).all()


def test_squirt_hardly_depends_on_the_speed():
    """The faster a stroke, the farther the tip goes with the ball while they turn."""
    found = squirt(POOL, 0.3, np.array([0.3, 1.0, 2.0, 4.0, 8.0]))
    assert (np.diff(found) > 0.0).all()
    assert found[1:4] == pytest.approx(np.full(3, found[2]), rel=0.05)
    assert found == pytest.approx(np.full(5, found[2]), rel=0.2)


def test_a_tip_without_chalk_squirts_three_times_as_much():
    """Because it slides off the ball."""
    assert squirt(pool(friction=0.2), 0.3, 2.0) > 3.0 * squirt(POOL, 0.3, 2.0)


def test_miscues_hit_the_ball_several_times():
    """High-speed films show it (Alciatore); other level strokes hit it once."""
    assert hit_twice(POOL, random_strokes(0.6, 0.8, 3.0)) > 0.5
    assert hit_twice(POOL, random_strokes(0.0, 0.47, 8.0)) == 0.0
    free = replace(POOL, effects=Effects(shaft='off'))
    assert hit_twice(free, random_strokes(0.6, 0.8, 3.0)) < 0.1


def test_the_spring_of_the_shaft_decides_how_often_masses_hit_twice():
    elevation = random_strokes(0.3, 0.5, 15.0)
    elevation[:, 2] += math.radians(30.0)
    soft, firm = (pool(cue={'mass': 0.54, 'end_stiffness': k}) for k in (0.0, 1e4))
    assert hit_twice(soft, elevation) < hit_twice(firm, elevation) - 0.1


@pytest.mark.parametrize('elevation', [0.0, 0.4])
def test_without_spring_and_dashpot_the_end_is_free(elevation):
    """
    In strikes with one hit, after which the ball does not come down to the cloth again.

    A spring of 1e-6 N/m has no effect but that the solver treats the shaft.
    """
    model = model_of(POOL)
    rng, ball, n = np.random.default_rng(3), model.surface, 60
    axes = np.tile([math.cos(elevation), 0.0, -math.sin(elevation)], (n, 1))
    normals = rng.uniform(-0.35, 0.35, (n, 3)) - axes
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    place, speed = np.array([[0.0, 0.0, ball.radius]]), np.full(n, 2.0)
    none = {'across': model.inverse_end_mass, 'end_damping': 0.0}
    free = strike(model, place, axes, normals, speed, **none, end_stiffness=0.0)
    held = strike(model, place, axes, normals, speed, **none, end_stiffness=1e-6)
    once = (free.cues['hits'] == 1) & (held.cues['hits'] == 1)
    once &= free.balls['velocity'][:, 0, 2] >= 0.0
    assert once.sum() > 20
    for motion in ('velocity', 'spin'):
        unit = 2.0 if motion == 'velocity' else 2.0 / ball.radius
        error = np.abs(free.balls[motion] - held.balls[motion])[once].max() / unit
        assert error < 1e-6


def test_the_shaft_takes_energy_and_gives_none():
    rows = random_strokes(0.0, 0.8, 80.0, 400)
    batch = predict_batch(POOL, offsets=rows)
    played = ~batch.refused
    assert np.isin(batch.status[played], (Status.OK, Status.TOLERANCE_NOT_REACHED)).all()
    ball = POOL.ball
    energy = 0.5 * ball.mass * (batch.velocity**2).sum(axis=1)
    energy += 0.5 * ball.inertia * (batch.spin**2).sum(axis=1)
    energy += 0.5 * POOL.cue.mass * batch.cue_speed**2
    left = 0.5 * POOL.cue.mass * rows[:, 4] ** 2 - energy - batch.dissipated.sum(axis=(1, 2))
    assert (left[played] > -1e-7 * rows[played, 4] ** 2).all()
