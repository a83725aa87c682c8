"""Whole plans: what is accepted is safe, by a check of its own; what is not is refused by name."""

from dataclasses import replace
import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from plans import contact_of, MECHANISM, plan_of, RADIUS, random_shot, SCENE, SHOTS, sightings
import pytest

from billiard_shot import Stroke
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.model import forward_kinematics
from billiard_shot.cue.plan import (
    first_touch,
    gap,
    GoalOutcome,
    prepare_shot,
    RefusedError,
    SETBACK,
    Shape,
    ShotPlan,
    tip_at,
)
from billiard_shot.records import ROWS
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
