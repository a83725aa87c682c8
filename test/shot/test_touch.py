"""How tip and ball touch in a strike: whether the tip slides, how long it touches, how often."""

import json
import math

import numpy as np
import pytest
from setups import SLOW_CLOTH

from billiard_shot import effects_of, predict, predict_batch, Scene, Stroke
from billiard_shot.game.state import outcome_of
from billiard_shot.shot.replay import from_json, to_json

POOL = Scene.load('pool')
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
    miscue = predict_batch(POOL, offsets=rows).miscue
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
    assert not predict_batch(POOL, offsets=rows).miscue.any()


def test_a_shot_says_how_long_tip_and_cloth_touched_the_ball():
    level = predict(POOL, Stroke.from_offsets(speed=2.0))
    assert level.tip_time == pytest.approx(POOL.contacts.cue_ball.duration, rel=1e-6)
    assert level.cloth_time == 0.0
    assert '  touch           tip 1.3 ms, cloth 0 ms\n' in str(level)
    steep = predict(POOL, Stroke.from_offsets(elevation_deg=30, speed=2.0))
    assert POOL.contacts.ball_table.duration < steep.cloth_time < 2.0 * steep.tip_time


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
    assert not predict(POOL, CHATTERING).chatter


@pytest.mark.parametrize('gap', [1e-4, 2e-3, 4e-3])
def test_a_second_hit_near_another_ball_is_a_double_hit_however_soon(gap):
    """The motion of the balls tells it."""
    away = 2.0 * POOL.ball.radius + gap
    scene = Scene.from_dict({'like': 'pool', 'balls': {'1': [away, 0.0]}})
    shots = [predict(scene, Stroke.from_offsets(0.0, b, 0.1, 0.0, 3.0)) for b in (-0.3, 0.0, 0.3)]
    assert not any(shot.chatter for shot in shots)
    soon = [shot for shot in shots if shot.double_hit is not None and shot.double_hit < 5e-3]
    assert soon or gap == 1e-4
    assert all(outcome_of(shot).double_hit for shot in soon)


@pytest.mark.parametrize('scene', [POOL, SLOW])
def test_shots_of_files_without_the_times_of_touch_are_read(scene):
    """A second hit in the strike was always a double hit then."""
    shot = predict(scene, CHATTERING)
    data = json.loads(to_json(shot))
    for name in ('chatter', 'double_hit', 'tip_time', 'cloth_time'):
        del data['strike'][name]
    read = from_json(json.dumps(data))
    assert read.double_hit == (0.0 if shot.chatter else None)
    assert (read.chatter, read.tip_time) == (False, 0.0)
    assert 'touch' not in str(read)
    assert (read.velocity == shot.velocity).all()
