"""Whole plans: what is accepted is safe, by a check of its own; what is not is refused by name."""

from dataclasses import replace
import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from plans import contact_of, MECHANISM, plan_of, RADIUS, random_shot, SCENE, SHOTS, sightings
import pytest

from billiard_shot import lowest_elevation, Scene, Stroke
from billiard_shot.cue.controller import StrikeDetector
from billiard_shot.cue.mechanism import Alignment, INCLINE, STROKE
from billiard_shot.cue.model import forward_kinematics, home
from billiard_shot.cue.plan import (
    first_touch,
    gap,
    GoalOutcome,
    prepare_shot,
    RefusedError,
    SETBACK,
    Shape,
    ShotPlan,
    stroke_on_table,
    tip_at,
)
from billiard_shot.records import ROWS
from billiard_shot.scene import Robot
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.predict import predict
from billiard_shot.table.model.motion import Motion, SegmentRecord
from billiard_shot.table.run.results import Trajectory

POINT = Shape(RADIUS, 0.0, 0.0)


def strokes(trajectory, times):
    """Positions [m] of the joint that strokes: the accelerations between the knots are linear."""
    t, a = trajectory.times, trajectory.accelerations[:, STROKE]
    jerk = np.diff(a) / np.diff(t)
    i = np.clip(np.searchsorted(t, times, side='right') - 1, 0, len(jerk) - 1)
    dt = np.minimum(times, trajectory.duration) - t[i]
    return trajectory.positions[i, STROKE] + dt * (
        trajectory.velocities[i, STROKE] + dt * (a[i] / 2 + dt * jerk[i] / 6)
    )


def distances(prepared, times):
    """Distance of the ball's centre to the cue (a half-line) at times [s] after the strike."""
    tip, along = prepared.contact.position, prepared.contact.along
    stroke = prepared.stroke
    moved = strokes(stroke.trajectory, stroke.leave + times) - strokes(
        stroke.trajectory, stroke.leave
    )
    away = prepared.shot.trajectory.at(times).position - tip - moved[:, np.newaxis] * along
    ahead = away @ along
    off = away - np.minimum(ahead, 0.0)[:, np.newaxis] * along
    return np.linalg.norm(off, axis=1)


def check_brake(count, seed):
    random = np.random.default_rng(seed)
    outcomes = {}
    for _ in range(count):
        ball = random.uniform(-0.5, 0.5, 2).tolist()
        plan = plan_of(random_shot(random), ball)
        try:
            prepared = prepare_shot(MECHANISM, SCENE, plan, allow_miscue=True)
        except RefusedError as error:
            outcomes[error.outcome] = outcomes.get(error.outcome, 0) + 1
            continue
        outcomes[GoalOutcome.OK] = outcomes.get(GoalOutcome.OK, 0) + 1
        stroke = prepared.stroke
        braked, gone = stroke.stop - stroke.leave, stroke.trajectory.duration - stroke.leave
        times = np.concatenate(
            (np.geomspace(1e-5, max(braked, 2e-5), 30), np.linspace(braked, gone, 30)[1:])
        )
        assert (distances(prepared, times) > RADIUS - 1e-12).all(), plan
        assert abs(stroke.trajectory.at(stroke.stop)[1][STROKE]) < 1e-9
        # nor has the tip gone through the cloth
        lowest = forward_kinematics(MECHANISM, stroke.trajectory.at(stroke.stop)[0]).position[2]
        assert lowest >= 0.0
    return outcomes


def test_brake_is_over_before_the_cue_touches_the_ball_again():
    outcomes = check_brake(500, 1)
    assert outcomes[GoalOutcome.OK] > 300
    assert set(outcomes) <= {
        GoalOutcome.OK,
        GoalOutcome.STROKE_OUT_OF_LIMITS,
        GoalOutcome.TOUCHES_AGAIN,
    }


@pytest.mark.nightly
def test_brake_is_over_in_10000_random_plans():
    outcomes = check_brake(10_000, 2)
    assert sum(outcomes.values()) == 10_000
    assert outcomes[GoalOutcome.OK] > 6_000
    assert outcomes[GoalOutcome.TOUCHES_AGAIN] > 0


@given(SHOTS)
def test_aimed_joints_and_run_up_bring_the_tip_to_the_ball(shot):
    try:
        prepared = prepare_shot(MECHANISM, SCENE, plan_of(shot), allow_miscue=True)
    except RefusedError:
        return
    joints, velocity, _ = prepared.stroke.trajectory.at(prepared.stroke.contact)
    tip = forward_kinematics(MECHANISM, joints)
    np.testing.assert_allclose(tip.position, contact_of(shot).position, atol=1e-9)
    assert velocity[STROKE] == pytest.approx(shot[4], rel=1e-9)


def test_touch_is_found_when_it_happens():
    """A cue that goes on at a constant speed catches a slower ball where their ways meet."""
    shot = (0.0, 0.0, 0.0, 0.0, 2.0)
    ball = predict(SCENE, Stroke.from_offsets(*shot)).trajectory
    speed = 1.5
    tip = contact_of(shot)

    def touch(cue):
        return first_touch(ball, cue, tip.position, tip.along, POINT, 1.0, 60.0)

    found = touch(lambda t: (speed * t, speed))
    assert ball.at(found).position[0] == pytest.approx(speed * found, abs=2e-5)
    times = np.linspace(0.01, found - 1e-3, 100)
    assert (ball.at(times).position[:, 0] > speed * times).all()
    assert touch(lambda t: (0.0, 0.0)) == math.inf


def test_a_ball_that_comes_back_meets_a_cue_that_stays():
    """There and back again, x = t - t^2, without end."""
    rows = ROWS.records(SegmentRecord, 1)
    rows['motion'] = Motion.SLIDE
    rows['position'], rows['velocity'] = (0.0, 0.0, RADIUS), (1.0, 0.0, 0.0)
    rows['acceleration'] = (-2.0, 0.0, 0.0)
    ball = Trajectory(rows)
    tip, along = np.array([-RADIUS, 0.0, RADIUS]), np.array([1.0, 0.0, 0.0])

    def touch_of(cue, until=5.0):
        return first_touch(ball, cue, tip, along, Shape(RADIUS, 0.0, 0.0065), 10.0, until)

    assert touch_of(lambda t: (0.0, 0.0)) == pytest.approx(1.0, abs=1e-4)
    assert touch_of(lambda t: (0.0, 0.0), until=0.99) == math.inf
    # drawn back it gains time: the root of t - t^2 = -t / 2
    assert touch_of(lambda t: (-0.5 * t, -0.5)) == pytest.approx(1.5, abs=1e-4)


def test_gap_to_a_half_line():
    along, still = np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.5, 0.0])
    assert gap(np.array([0.3, 0.4, 0.0]), still, along, 0.0) == pytest.approx((0.5, -0.2))
    assert gap(np.array([-0.3, 0.4, 0.0]), still, along, 0.0) == pytest.approx((0.4, 0.5))
    assert gap(np.array([0.1, 0.4, 0.0]), still, along, 0.2) == pytest.approx((0.5, -0.2))
    assert gap(np.array([-0.3, 0.4, 0.0]), still, along, 0.2) == pytest.approx((0.4, 0.5))


@given(st.floats(0.0, 0.9))
def test_the_round_shaft_is_clear_of_a_ball_hit_off_centre(offset):
    normal = np.array([-math.sqrt(1.0 - offset * offset), offset, 0.0])
    distance, _ = gap(-RADIUS * normal, np.zeros(3), np.array([1.0, 0, 0]), SETBACK * 0.0065)
    assert distance > RADIUS + 0.0065


def test_other_balls_count():
    """One behind the tip is in the way; one in front of the ball sends it back to the cue."""
    shot = (0.0, 0.0, 0.05, 0.0, 1.0)
    prepare_shot(MECHANISM, SCENE, plan_of(shot, others={'8': (0.5, 0.0)}))
    with pytest.raises(RefusedError, match="ball '8' is in the way of the cue") as caught:
        prepare_shot(MECHANISM, SCENE, plan_of(shot, others={'8': (-0.3, 0.01)}))
    assert caught.value.outcome is GoalOutcome.TOUCHES_AGAIN
    with pytest.raises(
        RefusedError, match=r"from ball 'cue', which it overlaps by 47\.2 mm"
    ) as caught:
        prepare_shot(MECHANISM, SCENE, plan_of(shot, others={'8': (0.01, 0.0)}))
    assert caught.value.outcome is GoalOutcome.INVALID_PLAN
    with pytest.raises(RefusedError, match="touch ball 'cue' again"):
        prepare_shot(MECHANISM, SCENE, plan_of(shot, others={'8': (2 * RADIUS + 1e-3, 0.0)}))


def test_a_rounded_tip_meets_the_ball_where_its_sphere_does():
    dome = 0.01
    scene = replace(SCENE, cue=replace(SCENE.cue, tip_curvature_radius=dome))
    stroke = Stroke.from_offsets(0.2, 0.2, 0.1, 0.0, 1.0)
    tip = tip_at(stroke, (0.0, 0.0), scene)
    centre = tip.position - dome * tip.along
    assert np.linalg.norm(centre - (0.0, 0.0, RADIUS)) == pytest.approx(RADIUS + dome)
    position = tuple((tip.position - 0.05 * tip.along).tolist())
    prepared = prepare_shot(
        MECHANISM,
        scene,
        ShotPlan(
            'shot', position, tip.quaternion, 1.0, tip.elevation, sightings({'cue': (0.0, 0.0)})
        ),
    )
    np.testing.assert_allclose(prepared.contact.position, tip.position, atol=1e-12)


@pytest.mark.parametrize(
    ('changes', 'outcome', 'words'),
    [
        ({'speed': 6.1}, GoalOutcome.SPEED_OUT_OF_LIMITS, r'0\.1 m/s above the limit of 6 m/s'),
        ({'speed': -1.0}, GoalOutcome.INVALID_PLAN, r'speed must .*, got -1.0'),
        ({'speed': math.nan}, GoalOutcome.INVALID_PLAN, r'speed must .*, got nan'),
        (
            {'elevation': 0.3},
            GoalOutcome.INVALID_PLAN,
            'elevation must be that of the quaternion, ',
        ),
        ({'elevation': math.nan}, GoalOutcome.INVALID_PLAN, r'elevation must .*, got nan'),
        ({'balls': {}}, GoalOutcome.INVALID_PLAN, "balls must have 'cue', got none"),
        (
            {'balls': sightings({'cue': (0.0, 0.0), '8': (math.inf, 0.0)})},
            GoalOutcome.INVALID_PLAN,
            'balls.8 must be two finite numbers',
        ),
        ({'quaternion': (0.0, 0.0, 0.0, 0.0)}, GoalOutcome.INVALID_PLAN, 'quaternion'),
        ({'position': (-1.0, 1.0, 0.02)}, GoalOutcome.NOT_PREDICTED, 'MISS: position, quaternion'),
    ],
)
def test_refused_by_name(changes, outcome, words):
    with pytest.raises(RefusedError, match=words) as caught:
        prepare_shot(MECHANISM, SCENE, replace(plan_of((0.1, 0.1, 0.1, 0.0, 2.0)), **changes))
    assert caught.value.outcome is outcome


@pytest.mark.parametrize(
    ('shot', 'ball', 'outcome', 'words'),
    [
        (
            (0.0, 0.1, 1.21, 0.0, 2.0),
            (0, 0),
            GoalOutcome.ELEVATION_OUT_OF_LIMITS,
            'elevation: 1.21 rad',
        ),
        ((0.0, 0.0, 0.1, 0.0, 2.0), (3.5, 0), GoalOutcome.OUT_OF_REACH, 'base_x: 3.'),
        ((0.0, 0.0, 0.9, 0.0, 5.0), (0, 0), GoalOutcome.STROKE_OUT_OF_LIMITS, 'cloth: 0.1'),
        (
            (0.02, 0.35, 0.97, 0.0, 1.12),
            (0, 0),
            GoalOutcome.TOUCHES_AGAIN,
            'ms after the strike, as it',
        ),
    ],
)
def test_refused_by_limit(shot, ball, outcome, words):
    with pytest.raises(RefusedError, match=words) as caught:
        prepare_shot(MECHANISM, SCENE, plan_of(shot, ball), allow_miscue=True)
    assert caught.value.outcome is outcome


def test_a_predicted_miscue_is_refused_unless_it_is_allowed():
    """The tip slides on the ball if it hits too far beside the centre for its friction."""
    plan = plan_of((0.55, 0.0, 0.1, 0.0, 2.0))
    with pytest.raises(RefusedError, match='slide on the ball') as caught:
        prepare_shot(MECHANISM, SCENE, plan)
    assert caught.value.outcome is GoalOutcome.MISCUE
    assert prepare_shot(MECHANISM, SCENE, plan, allow_miscue=True).shot.miscue


@given(SHOTS)
def test_the_drive_does_not_brake_while_the_tip_touches_the_ball(shot):
    try:
        prepared = prepare_shot(MECHANISM, SCENE, plan_of(shot), allow_miscue=True)
    except RefusedError:
        return
    released = prepared.stroke.leave - prepared.stroke.contact
    expected = max(MECHANISM.contact_time, prepared.shot.tip_time)
    assert released == pytest.approx(expected, rel=1e-9)


def test_steep_strokes_touch_for_longer_than_the_drive_would_release_the_cue():
    prepared = prepare_shot(MECHANISM, SCENE, plan_of((0.0, 0.1, 1.0, 0.0, 1.0)))
    assert prepared.shot.tip_time > MECHANISM.contact_time


# --- A mechanism whose tip is not where its encoders say, and the correction of its shots --------

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
    """So strikes of an aligned driver give the whole alignment, not a correction to it."""
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
