"""Strikes on a ball that touches another one, or a cushion."""

import dataclasses
import math

import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, Status, Stroke

POOL = Scene.load('pool_table')
R = POOL.ball.radius
REACH = math.sqrt(R**2 - (POOL.table.cushion.height * 2 * R - R) ** 2)
LEVEL = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0, speed=2)


def scene_of(**balls):
    return dataclasses.replace(POOL, balls=balls)


def energy(scene, shot):
    """Of cue and balls after the strike [J]."""
    first = shot.table.at(0.0)
    balls = sum(
        0.5 * scene.ball.mass * (s.velocity**2).sum()
        + 0.5 * scene.ball.inertia * (s.spin**2).sum()
        for s in first.values()
    )
    return balls + 0.5 * scene.cue.mass * shot.cue_speed**2


def test_two_frozen_balls_leave_together():
    scene = scene_of(cue=(0.0, 0.0), one=(2 * R, 0.0))
    shot = predict(scene, LEVEL)
    alone = predict(scene_of(cue=(0.0, 0.0)), LEVEL)
    first = shot.table.at(0.0)
    assert first['one'].velocity[0] > 1.0
    assert 0 < shot.velocity[0] < first['one'].velocity[0]
    assert shot.velocity[0] < alone.velocity[0]
    assert shot.cue_speed < alone.cue_speed  # it moves two balls
    assert len(shot.impact.dissipated) == 3
    assert energy(scene, shot) < 0.5 * scene.cue.mass * 4
    assert shot.impact.dissipated.sum() == pytest.approx(
        0.5 * scene.cue.mass * 4 - energy(scene, shot), rel=0.05
    )


def test_a_ball_beside_does_not_matter():
    behind = scene_of(cue=(0.0, 0.0), one=(0.0, 1.9 * R * 2))
    free = scene_of(cue=(0.0, 0.0))
    assert predict(behind, LEVEL).velocity == pytest.approx(predict(free, LEVEL).velocity)


def test_in_touch_and_nearly_in_touch():
    # a hair's breadth apart the balls meet after the strike, in touch during it: they differ
    apart = predict(scene_of(cue=(0.0, 0.0), one=(2 * R + 1e-5, 0.0)), LEVEL)
    frozen = predict(scene_of(cue=(0.0, 0.0), one=(2 * R, 0.0)), LEVEL)
    assert apart.velocity[0] > frozen.velocity[0] + 0.3
    speeds = [shot.table.at(1e-3)['one'].velocity[0] for shot in (apart, frozen)]
    assert 2.0 < speeds[1] < speeds[0] < 2.6


def test_along_a_cushion_and_away_from_it():
    y = 0.635 - REACH
    scene = scene_of(cue=(-0.3, y))
    along = predict(scene, LEVEL)
    assert along.status in (Status.OK, Status.MISCUE)
    assert abs(along.trajectory.at(0.0).position[1] - y) < 1e-12
    assert along.velocity[1] <= 1e-6
    into = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0.5, speed=1)
    shot = predict(scene, into)
    assert shot.velocity[1] < 0  # the cushion throws it back
    assert len(shot.impact.dissipated) == 3
    assert energy(scene, shot) < 0.5 * scene.cue.mass


def test_a_batch_gives_what_single_predictions_give():
    scene = scene_of(cue=(0.0, 0.0), one=(2 * R * math.cos(0.4), 2 * R * math.sin(0.4)))
    strokes = [
        Stroke.from_offsets(a=a, b=0.1, elevation=0.1, azimuth=0.1, speed=1.5)
        for a in (-0.2, 0.0, 0.2)
    ]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    for i, stroke in enumerate(strokes):
        shot = predict(scene, stroke)
        assert many.velocity[i] == pytest.approx(shot.velocity, abs=1e-9)
        assert many.final_position[i] == pytest.approx(shot.trajectory.final_position, abs=1e-6)
        assert np.isfinite(many.final_position).all()
