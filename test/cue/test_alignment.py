"""A mechanism whose tip is not where its encoders say, and the correction of its shots."""

from dataclasses import replace
import math

import numpy as np
from plans import MECHANISM, plan_of, random_shot, SCENE
import pytest

from billiard_shot import Stroke
from billiard_shot.cue.alignment import Alignment
from billiard_shot.cue.kinematics import forward_kinematics
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.outcome import GoalOutcome, RefusedError
from billiard_shot.cue.plan import prepare_shot, stroke_on_table

SKEW = Alignment(0.003, -0.002, 0.5, 0.002, -0.001, 0.96, 0.02, 1.01, 0.2)
SKEWED = replace(MECHANISM, alignment=SKEW)


def test_encoders_and_tip_are_inverse_to_each_other():
    draw = np.random.default_rng(1)
    for _ in range(20):
        position, angles = draw.uniform(-1.0, 1.0, 3), draw.uniform(0.0, 1.0, 2)
        there, *turned = SKEW.on_table(*SKEW.by_encoders(position, *angles))
        assert there == pytest.approx(position, abs=1e-12)
        assert turned == pytest.approx(angles, abs=1e-12)
        assert SKEW.speed(SKEW.encoder_speed(2.0)) == pytest.approx(2.0)


def test_an_aligned_mechanism_brings_the_tip_to_the_planned_place_at_the_planned_speed():
    draw = np.random.default_rng(2)
    for _ in range(10):
        a, b, _, azimuth, _ = random_shot(draw)
        planned = 0.5 * a, 0.5 * b, 0.2, azimuth, 1.5
        shot = prepare_shot(SKEWED, SCENE, plan_of(planned))
        joints = shot.aimed.copy()
        joints[STROKE] = shot.profile.contact_at
        tip = forward_kinematics(SKEWED, joints)
        played = stroke_on_table(
            SKEW,
            Stroke.from_pose(
                tip.position - 0.05 * tip.along,
                tip.quaternion,
                shot.profile.speed,
                (0.0, 0.0, SCENE.ball.radius),
            ),
            (0.0, 0.0),
            SCENE,
        )
        played[3] = math.remainder(played[3] - azimuth, math.tau) + azimuth
        # the encoders' tip meets the ball some mm earlier or later along a cue that is inclined
        assert played == pytest.approx(planned, abs=1e-3)


@pytest.mark.parametrize('curvature', [0.0, 0.01])
def test_an_exact_mechanism_plays_what_its_encoders_say_with_any_tip(curvature):
    scene = replace(SCENE, cue=replace(SCENE.cue, tip_curvature_radius=curvature))
    for axis in (False, True):
        stroke = Stroke.from_offsets(0.1, -0.2, 0.3, 1.0, 2.0, axis=axis)
        touching = stroke.touching(curvature / scene.ball.radius)
        played = stroke_on_table(Alignment(), stroke, (0.2, 0.1), scene)
        assert played == pytest.approx(touching.offsets)


def test_limits_are_those_of_the_corrected_pose():
    level = plan_of((0.0, 0.0, math.radians(0.1), 0.0, 1.5))
    prepare_shot(MECHANISM, SCENE, level)
    with pytest.raises(RefusedError) as refusal:
        prepare_shot(SKEWED, SCENE, level)
    assert refusal.value.outcome is GoalOutcome.ELEVATION_OUT_OF_LIMITS
