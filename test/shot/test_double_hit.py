"""The cue that catches the ball again."""

import dataclasses
import math

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.scene import Effects
from billiard_shot.shot.double_hit import first_double_hit

POOL = dataclasses.replace(Scene.load('pool_table'), table=None)
R = POOL.ball.radius


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


def test_a_ball_far_in_front_does_not():
    far = shot(0.6)
    assert far.double_hit is None
    assert 'double hit' not in far.message


def test_a_free_ball_runs_away_from_the_cue():
    for b in (-0.4, 0.0, 0.4):
        for elevation in (0.05, 0.5):
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
        return next(each for each in shot.effects if each.name == 'double_hit')

    assert effect(shot(0.01)).simulated
    assert not effect(shot(0.6)).simulated
    near = shot(0.01)
    off = predict(dataclasses.replace(near.scene, effects=Effects(double_hit='off')), near.stroke)
    assert off.double_hit is None
    assert 'double hit' not in off.message
    assert (effect(off).simulated, effect(off).called_for) == (False, True)
    assert effect(off).reason.startswith('the scene turns it off; it would be simulated: the cue')


def test_a_cue_that_hardly_moves_is_not_followed_for_ever():
    there = shot(2.0).trajectory
    assert first_double_hit(there, R, there.at(0.0).position, np.array([1.0, 0, 0]), 1e-9) is None
