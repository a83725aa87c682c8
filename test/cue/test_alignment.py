"""A mechanism whose tip is not where its encoders say, and the correction of its shots."""

from dataclasses import replace
import math

import numpy as np
from plans import contact_of, MECHANISM, plan_of, random_shot, SCENE, sightings
import pytest

from billiard_shot import lowest_elevation, Scene, Stroke
from billiard_shot.cue.controller import StrikeDetector
from billiard_shot.cue.mechanism import Alignment, INCLINE, STROKE
from billiard_shot.cue.model import forward_kinematics, home
from billiard_shot.cue.plan import (
    GoalOutcome,
    prepare_shot,
    RefusedError,
    ShotPlan,
    stroke_on_table,
    tip_at,
)
from billiard_shot.scene import Robot
from billiard_shot.scene.placement import CUE_BALL

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
    """Below the alignment, an exact machine goes where the encoders have to be for that."""
    draw = np.random.default_rng(2)
    for _ in range(10):
        a, b, _, azimuth, _ = random_shot(draw)
        planned = 0.3 * a, 0.3 * b, 0.2, azimuth, 1.5
        shot = prepare_shot(SKEWED, SCENE, plan_of(planned))
        joints = shot.aimed.copy()
        joints[STROKE] = shot.profile.contact_at
        tip = forward_kinematics(SKEWED, joints)
        assert tip.position == pytest.approx(contact_of(planned).position, abs=1e-12)
        turned = math.remainder(tip.azimuth - azimuth, math.tau)
        assert (turned, tip.elevation) == pytest.approx((0.0, 0.2), abs=1e-12)
        assert SKEW.speed(shot.profile.speed) == pytest.approx(1.5)
        bare = forward_kinematics(MECHANISM, joints)
        there, *_ = SKEW.on_table(bare.position, bare.azimuth, bare.elevation)
        assert there == pytest.approx(tip.position, abs=1e-12)


def test_a_perfect_stroke_is_measured_as_planned():
    """Before, its speed was reported as 4 % off, and its elevation as that of the encoder."""
    planned = 0.1, 0.05, 0.2, 0.7, 1.5
    shot = prepare_shot(SKEWED, SCENE, plan_of(planned))
    detector, trajectory = StrikeDetector(shot.profile), shot.stroke.trajectory
    for time in np.linspace(0.0, shot.stroke.leave, 400):
        position, velocity, _ = trajectory.at(time)
        detector.update(position, velocity)
    assert detector.strike.speed == pytest.approx(1.5)
    assert detector.strike.tip.elevation == pytest.approx(0.2)
    assert detector.strike.tip.position == pytest.approx(contact_of(planned).position, abs=1e-9)


def test_a_stroke_measured_with_an_alignment_is_the_one_of_the_encoders_below_it():
    """So strikes of an aligned driver give the whole alignment, not what is left of it."""
    encoders = Stroke.from_offsets(0.1, -0.1, 0.3, 1.0, 2.0)
    aligned = Stroke.from_offsets(*stroke_on_table(SKEW, encoders, (0.2, 0.1), SCENE).tolist())
    other = Alignment(machine_x=0.01, speed_scale=1.05)
    for_encoders = stroke_on_table(other, encoders, (0.2, 0.1), SCENE)
    for_aligned = stroke_on_table(other, aligned, (0.2, 0.1), SCENE, SKEW)
    # the tips meet the ball some mm earlier or later along cues that are inclined
    assert for_aligned == pytest.approx(for_encoders, abs=2e-3)


@pytest.mark.parametrize('curvature', [0.0, 0.01])
def test_an_exact_mechanism_plays_what_its_encoders_say_with_any_tip(curvature):
    scene = replace(SCENE, cue=replace(SCENE.cue, tip_curvature_radius=curvature))
    for axis in (False, True):
        stroke = Stroke.from_offsets(0.1, -0.2, 0.3, 1.0, 2.0, axis=axis)
        touching = stroke.touching(curvature / scene.ball.radius)
        played = stroke_on_table(Alignment(), stroke, (0.2, 0.1), scene)
        assert played == pytest.approx(touching.offsets)


def test_limits_are_those_of_the_cue_not_of_its_encoder():
    """Before, level strokes were refused: the encoder of a level cue was below 0."""
    level = plan_of((0.0, 0.0, 0.0, 0.0, 1.5))
    assert prepare_shot(SKEWED, SCENE, level).contact.elevation == 0.0
    with pytest.raises(RefusedError) as refusal:
        prepare_shot(SKEWED, SCENE, plan_of((0.0, 0.0, 1.201, 0.0, 1.5)))
    assert refusal.value.outcome is GoalOutcome.ELEVATION_OUT_OF_LIMITS


def test_plans_know_the_limits_of_the_aligned_mechanism():
    steep = replace(MECHANISM, alignment=Alignment(elevation_bias_deg=-1.0, speed_scale=0.7))
    limits = steep.within(Robot(speed_max=5.0, elevation_max_deg=85.0, offset_max=0.4))
    low, high = (steep.elevation(length) for length in (steep.incline.min, steep.incline.max))
    assert low < 0.0 < high < MECHANISM.max_elevation
    assert limits.elevation_max_deg == pytest.approx(math.degrees(high))
    assert (limits.speed_max, limits.offset_max) == (pytest.approx(4.2), 0.4)
    shot = 0.0, 0.0, math.radians(limits.elevation_max_deg) - 1e-9, 0.0, 0.3
    prepare_shot(steep, SCENE, plan_of(shot), allow_miscue=True)
    with pytest.raises(ValueError, match='speed_max'):
        steep.within(Robot(speed_min=4.3))


@pytest.mark.parametrize(
    ('tip_up', 'words'), [(0.05, r'cloth: -0\.01.* by the encoders'), (0.02, None)]
)
def test_the_tip_stays_above_the_cloth_without_the_alignment_too(tip_up, words):
    """A wrong alignment would otherwise press the cue into the table."""
    mechanism = replace(MECHANISM, alignment=Alignment(tip_up=tip_up))
    plan = plan_of((0.0, 0.0, 0.05, 0.0, 1.0))
    if words is None:
        prepare_shot(mechanism, SCENE, plan)
        return
    with pytest.raises(RefusedError, match=words) as refusal:
        prepare_shot(mechanism, SCENE, plan)
    assert refusal.value.outcome is GoalOutcome.STROKE_OUT_OF_LIMITS


def test_the_cue_stays_above_the_cushions_without_the_alignment_too():
    """A cue that is 15 mm higher than its encoders say may be a cue that is not."""
    table = Scene.load('robot_table')
    scene = replace(table, balls={}, cue=replace(table.cue, length=1.0))
    ball = 0.5 * scene.table.length - 0.06, 0.0
    level = np.array([[0.0, 0.0, 0.0, math.pi, 1.0]])
    lowest = lowest_elevation(replace(scene, balls={CUE_BALL: ball}), level)
    stroke = Stroke.from_offsets(0.0, 0.0, float(lowest[0]) + 1e-3, math.pi, 1.0)
    tip = tip_at(stroke, ball, scene)
    position = tuple((tip.position - 0.02 * tip.along).tolist())
    plan = ShotPlan('s', position, tip.quaternion, 1.0, tip.elevation, sightings({CUE_BALL: ball}))
    prepare_shot(MECHANISM, scene, plan)
    with pytest.raises(RefusedError, match='through a cushion, by the encoders'):
        prepare_shot(replace(MECHANISM, alignment=Alignment(tip_up=0.015)), scene, plan)


def test_a_wrong_length_counts_in_the_way_to_the_cloth():
    """A cue that is faster than its encoder says may also go farther."""
    plan = plan_of((0.0, 0.0, 0.6, 0.0, 1.5))
    shot = prepare_shot(MECHANISM, SCENE, plan)
    way = shot.profile.worst_case_stop - shot.profile.contact_at
    long = replace(MECHANISM, alignment=Alignment(speed_scale=2.0))
    height = shot.contact.position[2] - SCENE.cue.ferrule_radius * math.cos(0.6)
    aligned = prepare_shot(long, SCENE, plan).profile
    assert 2.0 * (aligned.worst_case_stop - aligned.contact_at) <= height / math.sin(0.6)
    assert way <= height / math.sin(0.6)


def test_the_carriage_travels_high_enough_with_and_without_the_alignment():
    for tip_up in (-0.1, 0.1):
        mechanism = replace(MECHANISM, alignment=Alignment(tip_up=tip_up))
        joints = home(mechanism)
        for length in np.linspace(mechanism.incline.min, mechanism.incline.max, 20):
            joints[INCLINE] = length
            for each in (mechanism, MECHANISM):
                height = forward_kinematics(each, joints).position[2]
                assert height >= mechanism.travel_height - 1e-12


def test_an_implausible_alignment_is_refused_by_name():
    Alignment(0.05, -0.05, 3.0, 0.05, -0.05, 1.1, 0.1, 0.9, -3.0).check_plausible(1.0)
    wrong = Alignment(machine_x=0.06, speed_scale=0.8)
    with pytest.raises(ValueError, match='widens the ranges') as error:
        wrong.check_plausible(1.0)
    assert 'alignment.machine_x must be from -0.05 to 0.05, got 0.06' in str(error.value)
    assert 'alignment.speed_scale must be from 0.9 to 1.1, got 0.8' in str(error.value)
    wrong.check_plausible(2.0)
    assert str(wrong) == 'machine_x 0.06, speed_scale 0.8'
    assert str(Alignment()) == 'exact'
