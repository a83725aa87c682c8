"""A stroke for which the cue has no room is refused, by name."""

import dataclasses
import math

import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, Status, Stroke
from billiard_shot.shot.lowest_elevation import lowest_elevation

POOL = Scene.load('pool_table')
R = POOL.ball.radius


def scene_of(base=POOL, **balls):
    return dataclasses.replace(base, balls=balls)


def stroke(elevation_deg, azimuth=0.0, b=0.0):
    return Stroke.from_offsets(
        a=0, b=b, elevation=math.radians(elevation_deg), azimuth=azimuth, speed=1
    )


def test_a_level_cue_goes_through_the_cushion_behind_it():
    shot = predict(scene_of(cue=(-0.6, 0.0)), stroke(0))
    assert shot.status == Status.CUE_THROUGH_CUSHION
    assert 'the head cushion blocks the cue, by' in shot.message
    assert shot.trajectory.final_position == pytest.approx([-0.6, 0, R])
    assert shot.run.duration == 0.0
    assert predict(scene_of(cue=(-0.6, 0.0)), stroke(4)).status == Status.OK


def test_how_steep_it_has_to_be():
    # tip at the ball's middle height; a cone over the nose, 0.67 m - r behind the tip
    scene = scene_of(cue=(-0.6, 0.0))
    distance = 0.67 - R
    thick = 0.0065 + 0.008 * distance / 1.47
    lift = math.degrees(math.atan((0.635 * 2 * R - R + thick) / distance))
    assert predict(scene, stroke(lift - 0.3)).status == Status.CUE_THROUGH_CUSHION
    assert predict(scene, stroke(lift + 0.3)).status == Status.OK


def test_the_lowest_elevation_is_the_first_with_room():
    scene = scene_of(cue=(-0.6, 0.1), eight=(-0.9, 0.1))
    draw = np.random.default_rng(2)
    offsets = np.zeros((60, 5))
    offsets[:, :2] = draw.uniform(-0.35, 0.35, (60, 2))
    offsets[:, 3], offsets[:, 4] = draw.uniform(-math.pi, math.pi, 60), 1.0
    offsets[0] = 0.0, 0.1, 0.0, 0.0, 1.0
    lowest = lowest_elevation(scene, offsets)
    assert 0.0 < lowest[0] < math.radians(20.0)
    for row, least in zip(offsets, lowest, strict=True):
        a, b, _, azimuth, speed = row
        assert predict(scene, Stroke.from_offsets(a, b, least, azimuth, speed)).status < 100
        if least > math.radians(0.051):
            lower = Stroke.from_offsets(a, b, least - math.radians(0.051), azimuth, speed)
            assert predict(scene, lower).status.refused


def test_offsets_that_no_elevation_helps_have_none():
    scene = scene_of(cue=(-0.6, 0.1))
    rows = [(0.8, 0.8, 0, 0, 1), (0, 0, 0, 0, 0), (math.nan, 0, 0, 0, 1), (0, 0, 7, 0, 1)]
    lowest = lowest_elevation(scene, rows)
    assert np.isinf(lowest).tolist() == [True, True, True, False]
    elsewhere = lowest_elevation(scene, [(0, 0, 0, 0, 1)], position=(-1.2, 0.1, R))
    assert elsewhere[0] > lowest[3] + math.radians(1.0)
    with pytest.raises(ValueError, match=r'offsets must be of shape \(n, 5\), got \(5,\)'):
        lowest_elevation(scene, rows[0])


def test_far_from_all_cushions_level_is_level():
    wide = dataclasses.replace(POOL.table, length=6.0)
    assert predict(dataclasses.replace(POOL, table=wide, balls={}), stroke(0)).status == Status.OK


def test_a_ball_in_the_way_is_named():
    scene = scene_of(dataclasses.replace(POOL, table=None), cue=(0, 0), eight=(-0.3, 0.01))
    shot = predict(scene, stroke(0))
    assert shot.status == Status.CUE_THROUGH_BALL
    assert "ball 'eight' blocks the cue, by" in shot.message
    assert predict(scene, stroke(30)).status == Status.OK
    assert predict(scene, stroke(0, azimuth=0.5)).status == Status.OK
    ahead = scene_of(dataclasses.replace(POOL, table=None), cue=(0, 0), eight=(0.3, 0.0))
    assert predict(ahead, stroke(0)).status == Status.OK


def test_a_batch_refuses_the_same_rows():
    scene = scene_of(cue=(-0.6, 0.0), eight=(-0.6, -0.3))
    strokes = [stroke(e, a) for e in (0, 5, 30) for a in (0, math.pi / 2, math.pi)]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    single = [predict(scene, s).status for s in strokes]
    assert many.status.tolist() == single
    assert {Status.OK, Status.CUE_THROUGH_BALL, Status.CUE_THROUGH_CUSHION} == set(single)


def test_a_cue_of_unknown_shape_is_not_refused():
    paper = Scene.load('paper')
    assert paper.cue.length == 0
    blocked = dataclasses.replace(paper, balls={'cue': (0, 0), 'eight': (-0.2, 0)})
    assert predict(blocked, stroke(0)).status == Status.OK


@pytest.mark.parametrize('curvature', [0.0, 0.0105])
def test_the_elevation_in_the_message_is_allowed(curvature):
    cue = dataclasses.replace(POOL.cue, tip_curvature_radius=curvature)
    scene = dataclasses.replace(scene_of(cue=(-0.6, 0.0)), cue=cue)
    for b in (-0.8, -0.5, 0.0, 0.4):
        refused = predict(scene, stroke(0.0, b=b))
        if refused.status != Status.CUE_THROUGH_CUSHION:
            continue
        free = float(refused.message.split('at least ')[-1].split(',')[0])
        a, b_touching, _, azimuth, _ = refused.stroke.touching(curvature / R).offsets
        at = Stroke.from_offsets(a, b_touching, math.radians(free), azimuth, 1)
        assert not predict(scene, at).status.refused
