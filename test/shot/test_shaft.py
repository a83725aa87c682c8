"""The shaft of a cue: squirt, several hits in miscues, and the limit of a free end."""

from dataclasses import replace
import math

from moving_strike import strike
import numpy as np
import pytest
from setups import SLOW_CLOTH, UP

from billiard_shot import effects_of, EventKind, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.game.state import outcome_of
from billiard_shot.impact import Body, collide, Contact
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import model_of, springs

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


# --- how long tip and cloth touch the ball decides how it jumps, and whether it is hit twice -----

PLAYING, JUMPING = Scene.load('pool'), Scene.load('jump_cue')


FREE_END = {'shaft': 'off'}


def with_cloth(milliseconds):
    """Scene `pool` with a cloth of another duration."""
    return PLAYING.with_parameters(['contacts.ball_table.duration'], [1e-3 * milliseconds])


def measured(spring, restitution, mass, other, exponent):
    """Time from touch to parting of two bodies that meet at 2 m/s [s]."""
    bodies = [Body(mass, velocity=(0.0, 0.0, -2.0)), Body(other) if other else Body.fixed()]
    contact = Contact(
        0, 1, (0.0, 0.0, 0.0), UP, restitution=restitution, friction=0.0, stiffness=spring
    )
    return collide(bodies, [contact], exponent=exponent, tolerance=1e-9).duration


@pytest.mark.parametrize('exponent', [1.0, 1.5])
@pytest.mark.parametrize('name', ['pool', 'jump_cue', 'robot_table', 'carom'])
def test_contacts_last_as_long_as_the_scene_says(name, exponent):
    scene = Scene.from_dict({'like': name, 'exponent': exponent})
    (of_tip, of_cloth), _ = springs(scene)
    tip, cloth = scene.contacts.cue_ball, scene.contacts.ball_table
    ball, cue = scene.ball.mass, scene.cue.mass
    found = measured(of_cloth, cloth.restitution, ball, None, exponent)
    assert found == pytest.approx(cloth.duration, rel=1e-3)
    found = measured(of_tip, tip.restitution, cue, ball, exponent)
    assert found == pytest.approx(tip.duration, rel=1e-3)


def test_scenes_that_state_a_ratio_keep_their_physics():
    """A change of the solver shows here; the true geometry is tested in test_moving_bodies."""
    scene = Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH, 'effects': FREE_END})
    shot = predict(scene, Stroke.from_offsets(0.2, -0.1, math.radians(20), 0.0, 3.0))
    assert shot.velocity == pytest.approx([3.1298164, -0.0011309, 0.5783844], abs=1e-6)
    steep = predict(scene, Stroke.from_offsets(0.2, -0.1, math.radians(50), 0.0, 3.0))
    assert steep.velocity == pytest.approx([2.8512813, -0.2396727, 0.0116889], abs=1e-6)
    assert steep.chatter


@pytest.mark.parametrize(('cloth', 'hop'), [(0.5, 4.3), (0.7, 78.0), (1.0, 117.1), (1.57, 131.5)])
def test_the_time_of_a_hop_tells_how_long_the_ball_pressed_the_cloth(cloth, hop):
    """At 20 degrees and 3 m/s [ms]; the page about scenes has these numbers."""
    shot = predict(with_cloth(cloth), Stroke.from_offsets(0.0, 0.0, math.radians(20), 0.0, 3.0))
    landed = next(event for event in shot.events if event.kind == EventKind.BOUNCE)
    assert 1e3 * landed.time == pytest.approx(hop, abs=0.1)


def rising(scene, elevation, speed):
    """Upward speed of a ball that is hit once in its middle, relative to the speed of the cue."""
    shot = predict(scene, Stroke.from_offsets(0.0, 0.0, math.radians(elevation), 0.0, speed))
    assert shot.double_hit is None
    assert not shot.chatter
    return shot.velocity[2] / speed


@pytest.mark.parametrize('speed', [2.0, 4.0])
def test_a_jump_cue_lifts_the_ball_in_one_hit_and_a_playing_cue_hardly_does(speed):
    for elevation in (30, 40, 50):
        assert rising(JUMPING, elevation, speed) >= 0.23
    assert rising(PLAYING, 55, speed) < 0.15


def around_the_middle(draw, count, nearest, farthest):
    """Strokes at 20 to 80 degrees and 1 to 3 m/s whose offsets [radii] lie in a ring."""
    away, angle = draw.uniform(nearest, farthest, count), draw.uniform(0.0, 2.0 * math.pi, count)
    elevation, speed = np.radians(draw.uniform(20, 80, count)), draw.uniform(1, 3, count)
    return np.column_stack(
        [away * np.cos(angle), away * np.sin(angle), elevation, np.zeros(count), speed]
    )


def test_steep_strokes_hit_once():
    """Also massés of a free end. With the ratio of the paper nearly half of them hit twice."""
    draw = np.random.default_rng(6)
    rows = np.concatenate(
        [around_the_middle(draw, 240, 0.0, 0.3), around_the_middle(draw, 240, 0.3, 0.5)]
    )
    slow = Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH, 'effects': FREE_END})
    assert predict_batch(slow, offsets=rows).chatter.mean() > 0.4
    found = predict_batch(Scene.from_dict({'like': 'pool', 'effects': FREE_END}), offsets=rows)
    twice = found.double_hit | found.chatter
    near = np.hypot(rows[:, 0], rows[:, 1]) < 0.3
    assert not twice[near & (rows[:, 2] < math.radians(60))].any()
    assert not found.double_hit.any()
    assert twice.mean() < 0.04


# --- how tip and ball touch in a strike: whether the tip slides, how long it touches, how often

SLOW = Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH})
CHATTERING = Stroke.from_offsets(0.2, -0.1, math.radians(50), 0.0, 3.0)


@pytest.mark.parametrize('speed', [0.3, 2.0, 8.0])
@pytest.mark.parametrize('elevation', [0.02, 0.5, 1.0])
@pytest.mark.parametrize('side', [0.0, 0.9, 1.6, 3.1, 4.7])
def test_tips_slide_from_half_a_radius_on(speed, elevation, side):
    """
    Players miscue from 0.5 to 0.55 radii on (Alciatore); friction 0.6.

    In the fastest steep strokes the shaft holds the tip back, which slides sooner.
    """
    away = np.arange(0.3, 0.75, 0.01)
    rows = np.tile([0.0, 0.0, elevation, 0.0, speed], (len(away), 1))
    rows[:, 0], rows[:, 1] = away * math.cos(side), away * math.sin(side)
    miscue = predict_batch(PLAYING, offsets=rows).miscue
    held = away[~miscue].max()
    assert 0.47 <= held <= 0.6
    assert not miscue[away < (0.44 if elevation * speed >= 8.0 else held)].any()


def test_a_tip_that_slides_only_as_it_leaves_makes_no_miscue():
    """The cloth still pushes a ball from which the tip parts."""
    draw = np.random.default_rng(2)
    away, angle = draw.uniform(0.0, 0.45, 300), draw.uniform(0.0, 2.0 * math.pi, 300)
    rows = np.column_stack(
        [
            away * np.cos(angle),
            away * np.sin(angle),
            np.radians(draw.uniform(20, 60, 300)),
            np.zeros(300),
            draw.uniform(1.0, 3.0, 300),
        ]
    )
    assert not predict_batch(PLAYING, offsets=rows).miscue.any()


def test_a_shot_says_how_long_tip_and_cloth_touched_the_ball():
    level = predict(PLAYING, Stroke.from_offsets(speed=2.0))
    assert level.tip_time == pytest.approx(PLAYING.contacts.cue_ball.duration, rel=1e-6)
    assert level.cloth_time == 0.0
    assert '  touch           tip 1.3 ms, cloth 0 ms\n' in str(level)
    steep = predict(PLAYING, Stroke.from_offsets(elevation_deg=30, speed=2.0))
    assert PLAYING.contacts.ball_table.duration < steep.cloth_time < 2.0 * steep.tip_time


def test_a_tip_that_touches_the_ball_again_at_once_chatters():
    """Nobody could call it; `effects_of` and the shot tell it."""
    shot = predict(SLOW, CHATTERING)
    assert shot.chatter
    assert shot.double_hit is None
    assert not outcome_of(shot).double_hit
    assert '(it chatters)' in str(shot)
    effect = next(each for each in effects_of(shot) if each.name == 'double_hit')
    assert effect.called_for
    assert 'chatters' in effect.reason
    assert not predict(PLAYING, CHATTERING).chatter


@pytest.mark.parametrize('gap', [1e-4, 2e-3, 4e-3])
def test_a_second_hit_near_another_ball_is_a_double_hit_however_soon(gap):
    """The motion of the balls tells it."""
    away = 2.0 * PLAYING.ball.radius + gap
    scene = Scene.from_dict({'like': 'pool', 'balls': {'1': [away, 0.0]}})
    shots = [predict(scene, Stroke.from_offsets(0.0, b, 0.1, 0.0, 3.0)) for b in (-0.3, 0.0, 0.3)]
    assert not any(shot.chatter for shot in shots)
    soon = [shot for shot in shots if shot.double_hit is not None and shot.double_hit < 5e-3]
    assert soon or gap == 1e-4
    assert all(outcome_of(shot).double_hit for shot in soon)
