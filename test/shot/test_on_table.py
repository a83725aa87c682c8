"""Strokes on a table with other balls."""

import dataclasses
import math

import numpy as np
import pytest

from billiard_shot import (
    effects_of,
    predict,
    predict_batch,
    Scene,
    sensitivity_of,
    simulate,
    Status,
    Stroke,
)
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import BallState, EventKind

POOL = Scene.load('pool_table')
R = POOL.ball.radius
LIFT = math.radians(6)


def scene_of(**balls):
    return dataclasses.replace(POOL, balls=balls)


def stroke(azimuth=0.0, speed=2.0, a=0.0, b=0.0, elevation=LIFT):
    return Stroke.from_offsets(a=a, b=b, elevation=elevation, azimuth=azimuth, speed=speed)


def test_a_shot_is_a_strike_and_then_the_table():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    shot = predict(scene, stroke())
    assert shot.status == Status.OK
    run = simulate(
        scene,
        {
            'cue': BallState((-0.6, 0.1, R), shot.velocity, shot.spin),
            'one': BallState((0.2, 0.12, R)),
        },
    )
    assert shot.run.final_position['one'] == pytest.approx(run.final_position['one'], abs=0.05)
    assert shot.trajectory is shot.run.balls['cue']
    assert EventKind.BALL in {event.kind for event in shot.trajectory.events}
    assert shot.run.first_met == {'cue': 'one', 'one': 'cue'}
    effects = {effect.name: effect for effect in effects_of(shot)}
    assert effects['ball_ball'].simulated
    assert shot.message == f'first contact one; at rest after {shot.run.duration:.3g} s'


def test_a_straight_pot():
    place, pocket = np.array([0.6, 0.2]), np.array([1.27, 0.635])
    line = (pocket - place) / np.linalg.norm(pocket - place)
    cue = place - 0.4 * line
    scene = scene_of(cue=tuple(cue), one=tuple(place))
    shot = predict(scene, stroke(math.atan2(line[1], line[0]), 1.5))
    assert shot.run.pocketed['one'] == 'foot_left'
    assert shot.run.at(20.0)['one'].motion == Motion.POCKETED


def test_a_batch_gives_what_single_predictions_give():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12), two=(0.5, -0.3))
    strokes = [stroke(angle, speed) for angle in (-0.3, 0.0, 0.1) for speed in (0.4, 2.0)]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    for i, one in enumerate(strokes):
        shot = predict(scene, one)
        assert many.status[i] == shot.status
        assert many.final_position[i, 0] == pytest.approx(shot.trajectory.final_position, abs=1e-9)
        for k, name in enumerate(many.names):
            assert many.final_position[i, k] == pytest.approx(
                shot.run.final_position[name], abs=1e-9
            )


def test_off_the_table_is_an_outcome():
    scene = scene_of(cue=(0.9, 0.0))
    jump = Stroke.from_offsets(a=0, b=0, elevation=math.radians(30), azimuth=0, speed=8)
    shot = predict(scene, jump)
    assert shot.status == Status.OFF_TABLE
    assert shot.message.startswith('cue ball off the table; ')
    assert shot.run.off_table == ('cue',)


def test_a_refused_stroke_moves_nothing():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    shot = predict(scene, Stroke(normal=(1, 0, 0), velocity=(1, 0, 0)))
    assert shot.status == Status.MISS
    assert shot.run.duration == 0.0
    assert shot.events == ()
    assert shot.trajectory.final_position == pytest.approx([-0.6, 0.1, R])


def test_where_the_cue_ball_cannot_be():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    with pytest.raises(
        ValueError, match=r"position must be .* from ball 'one', which .*, got \(0\.21, 0\.12\)"
    ):
        predict(scene, stroke(), position=(0.21, 0.12))
    room = r'must be between the cushions, x from -1\.242 to 1\.242 and y from .*, got '
    for place, text in (((1.3, 0), r'\(1\.3, 0\)'), ((1.2695, 0.3), r'\(1\.2695, 0\.3\)')):
        with pytest.raises(ValueError, match=f'position {room}{text}'):
            predict(scene, stroke(), position=place)
    with pytest.raises(ValueError, match='must be beside the pockets, not over one, got'):
        predict(scene, stroke(), position=(1.27, 0.635))
    assert predict(scene, stroke(), position=(0.0, -0.638)).status == Status.OK, 'in a mouth'


def test_sensitivity_counts_the_cushions():
    scene = scene_of(cue=(0.0, 0.0))
    shot = predict(scene, stroke(0.4, 1.2))
    assert shot.run.events
    step = 1e-4
    ends = [
        predict(scene, stroke(0.4, 1.2 * (1 + s))).trajectory.final_position[:2]
        for s in (-step, step)
    ]
    slope = (ends[1] - ends[0]) / (2 * step * 1.2)
    assert sensitivity_of(shot)[:, 4] == pytest.approx(slope, rel=0.1, abs=0.02)
