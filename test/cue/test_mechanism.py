import math
from pathlib import Path

from hypothesis import assume, given
from hypothesis import strategies as st
import numpy as np
from plans import contact_of, HOME, MECHANISM, SHOTS, sightings
import pytest

from billiard_shot import plan, Scene, Status
from billiard_shot.cue.joint_trajectory import ramp_times, stroke_profile, stroke_trajectory
from billiard_shot.cue.mechanism import (
    Axis,
    BASE_Z,
    Incline,
    JOINTS,
    LimitError,
    Mechanism,
    STROKE,
)
from billiard_shot.cue.model import (
    forward_kinematics,
    inverse_kinematics,
    TipPose,
    travel_pivot_height,
)
from billiard_shot.cue.plan import aim_trajectory, prepare_shot, ShotPlan, tip_at
from billiard_shot.shot.stroke import Stroke

ROOT = Path(__file__).resolve().parents[2]


@given(SHOTS, st.floats(-1.2, 1.2), st.floats(-0.6, 0.6), st.floats(0.0, 0.4))
def test_placed_joints_put_the_tip_where_it_was_wanted(shot, x, y, stroke):
    wanted = contact_of(shot, (x, y))
    try:
        joints = inverse_kinematics(MECHANISM, wanted, stroke)
    except LimitError:
        assume(False)
    tip = forward_kinematics(MECHANISM, joints)
    np.testing.assert_allclose(tip.position, wanted.position, atol=1e-12)
    assert tip.elevation == pytest.approx(wanted.elevation, abs=1e-12)
    assert tip.azimuth == pytest.approx(wanted.azimuth, abs=1e-12)
    # and moving the stroke alone moves the tip along its axis
    joints[STROKE] -= 0.1
    np.testing.assert_allclose(
        forward_kinematics(MECHANISM, joints).position,
        wanted.position - 0.1 * wanted.along,
        atol=1e-12,
    )


@given(SHOTS)
def test_quaternion_points_along_the_stroke(shot):
    tip = contact_of(shot)
    stroke = Stroke.from_pose(
        tip.position - 0.1 * tip.along, tip.quaternion, 1.0, (0.0, 0.0, 0.0286)
    )
    np.testing.assert_allclose(np.array(stroke.velocity), tip.along, atol=1e-12)


def test_out_of_reach_names_every_joint():
    with pytest.raises(LimitError) as caught:
        inverse_kinematics(MECHANISM, TipPose(np.array([9.0, -9.0, 0.03]), 0.0, 0.0), 0.1)
    assert [violation.limit for violation in caught.value.violations] == ['base_x', 'base_y']
    with pytest.raises(LimitError, match=r'elevation: 1\.205 rad is 0\.005 rad above'):
        inverse_kinematics(MECHANISM, TipPose(np.zeros(3), 0.0, 1.205), 0.1)
    with pytest.raises(LimitError, match=r'elevation: -0\.01 rad is 0\.01 rad below'):
        inverse_kinematics(MECHANISM, TipPose(np.array([0, 0, 0.03]), 0.0, -0.01), 0.1)


@given(SHOTS, SHOTS)
def test_the_tip_travels_above_the_balls(first, second):
    try:
        start, target = (
            inverse_kinematics(MECHANISM, contact_of(shot), 0.2) for shot in (first, second)
        )
    except LimitError:
        assume(False)
    target[STROKE] = 0.0
    trajectory = aim_trajectory(MECHANISM, start, target)
    np.testing.assert_array_equal(trajectory.positions[-1], target)
    height = travel_pivot_height(MECHANISM, start[2], target[2])
    for time in np.linspace(0.0, trajectory.duration, 200):
        position, velocity, acceleration = trajectory.at(time)
        assert (np.abs(velocity) <= MECHANISM.speeds * (1 + 1e-9)).all()
        assert (np.abs(acceleration) <= MECHANISM.accelerations * (1 + 1e-9)).all()
        aside = position[[0, 1, 3, 4]]
        if (aside != start[[0, 1, 3, 4]]).any() and (aside != target[[0, 1, 3, 4]]).any():
            assert position[2] == pytest.approx(height, abs=1e-12)
            assert (
                forward_kinematics(MECHANISM, position).position[2]
                >= MECHANISM.travel_height - 1e-12
            )


def test_a_move_over_nothing_takes_no_time():
    """Nor knots so near each other that a message could not tell their times apart."""
    start = inverse_kinematics(MECHANISM, contact_of((0, 0, 0, 0, 1)), 0.0)
    near = start.copy()
    near[STROKE] = -7e-62
    trajectory = aim_trajectory(MECHANISM, near, start)
    assert np.diff(trajectory.times).min(initial=1.0) > 1e-7
    np.testing.assert_array_equal(trajectory.positions[-1], start)


def test_paths_are_joined_without_jumps():
    trajectory = aim_trajectory(
        MECHANISM,
        inverse_kinematics(MECHANISM, contact_of((0, 0, 0, 0, 1)), 0.2),
        inverse_kinematics(MECHANISM, contact_of((0.1, 0.2, 0.5, 2, 1)), 0.0),
    )
    for i, knot in enumerate(trajectory.times[:-1]):
        before = trajectory.at(knot - 1e-9)
        np.testing.assert_allclose(before[0], trajectory.positions[i], atol=1e-7)
        np.testing.assert_allclose(before[1], trajectory.velocities[i], atol=1e-6)
        jerk = np.diff(trajectory.accelerations, axis=0)[i] / np.diff(trajectory.times)[i]
        assert (np.abs(jerk) <= MECHANISM.jerks * (1 + 1e-9)).all()


def test_settings_are_checked(tmp_path):
    with pytest.raises(ValueError, match='min must be below max, 0, got 1'):
        Axis(1.0, 0.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match='max_force must be a finite number above 0, got 0'):
        Mechanism(max_force=0)
    with pytest.raises(ValueError, match=r'max_elevation must .* within -0\.07.*, got 1\.3'):
        Mechanism(max_elevation=1.3)
    with pytest.raises(ValueError, match=r'incline must be between 0\.2 and 0\.8, .* got 0\.1'):
        Mechanism(incline=Axis(0.1, 0.7, 1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match=r'base_z\.max must be at least 0\.4105.*, got 0\.4'):
        Mechanism(base_z=Axis(0.0, 0.4, 0.5, 2.0, 20.0))
    path = tmp_path / 'mine.yaml'
    path.write_text('max_force: 80\nspeed: 3\nstroke: {min: 0, max: -1}')
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (looked at below)
        Mechanism.load(path)
    for words in (
        'mine.yaml: 5 mistakes',
        'line 2: speed is unknown',
        'line 3: stroke.speed is missing',
    ):
        assert words in str(caught.value)
    path.write_text('max_force: 80\n')
    assert Mechanism.load(str(path)) == Mechanism(max_force=80)
    assert Mechanism.load('') == Mechanism()
    assert Mechanism.load(ROOT / 'config' / 'mechanism.yaml') == Mechanism()
    assert len(Mechanism().axes) == len(JOINTS)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('incline_geometry: {base: 0}', r'line 1: incline_geometry\.base must be'),
        ('min_speed: [1', r'line 1, column 14: while parsing a flow sequence: expected'),
        ('min_speed: *a', r"line 1, column 12: found undefined alias 'a'"),
        ('min_speed: "\0"', 'unacceptable character'),
    ],
)
def test_a_mistake_in_a_file_is_told_in_a_line(tmp_path, text, words):
    file = tmp_path / 'mechanism.yaml'
    file.write_text(text)
    with pytest.raises(ValueError, match=words) as caught:
        Mechanism.load(file)
    assert len(str(caught.value).splitlines()) == 1
    assert str(file) in str(caught.value)


DEFAULT = Incline()


@st.composite
def inclines(draw):
    """An incline, and two lengths of its actuator."""
    base, arm = draw(st.floats(0.05, 2.0)), draw(st.floats(0.05, 2.0))
    least, most = abs(base - arm), base + arm
    low, high = sorted((draw(st.floats(0.01, 0.99)), draw(st.floats(0.01, 0.99))))
    assume(high - low > 0.01)
    incline = Incline(base, arm, draw(st.floats(0.1, 2.0)))
    return incline, least + low * (most - least), least + high * (most - least)


@given(inclines(), st.floats(0.0, 1.0))
def test_length_to_elevation_and_back(drawn, part):
    incline, shortest, longest = drawn
    length = shortest + part * (longest - shortest)
    elevation = incline.elevation(length)
    slope = incline.base * incline.arm * math.sin(elevation + incline.level_angle) / length
    assert incline.length(elevation) == pytest.approx(length, rel=1e-14, abs=4e-16 * slope + 1e-16)


@given(inclines(), st.floats(0.0, 1.0))
def test_elevation_to_length_and_back(drawn, part):
    incline, shortest, longest = drawn
    low, high = incline.elevation(shortest), incline.elevation(longest)
    elevation = low + (0.001 + 0.998 * part) * (high - low)
    back = incline.elevation(incline.length(elevation))
    # The triangle is nowhere flat, so that an angle is as good as the length it comes from.
    angle = elevation + incline.level_angle
    lever = incline.base * incline.arm * math.sin(angle) / incline.length(elevation)
    assert back == pytest.approx(elevation, abs=1e-15 * (4 + 4 * (incline.base + 1) / lever))


@given(inclines(), st.floats(0.0, 1.0))
def test_it_is_the_law_of_cosines(drawn, part):
    incline, shortest, longest = drawn
    length = shortest + part * (longest - shortest)
    angle = incline.elevation(length) + incline.level_angle
    square = incline.base**2 + incline.arm**2 - 2 * incline.base * incline.arm * math.cos(angle)
    assert math.sqrt(square) == pytest.approx(length, rel=1e-6)


def test_a_longer_actuator_raises_the_cue():
    low, high = DEFAULT.elevation(0.40), DEFAULT.elevation(0.72)
    assert low < 0.0 < 1.2 < high
    assert DEFAULT.elevation(0.5) < DEFAULT.elevation(0.5001)


def test_limits_say_which_and_by_how_much():
    with pytest.raises(LimitError, match=r'0\.9 m is 0\.1 m above the limit of 0\.8 m'):
        DEFAULT.elevation(0.9)
    with pytest.raises(LimitError, match=r'below the limit of 0\.2 m'):
        DEFAULT.elevation(0.1)


MASS, GRAVITY = 0.5018, 9.80665
DRIVE = MECHANISM.stroke


def profile_of(
    speed=3.0, after=0.5, elevation=0.1, touch_time=0.0, clearance=math.inf, mechanism=MECHANISM
):
    return stroke_profile(
        mechanism, MASS, GRAVITY, elevation, speed, after * speed, touch_time, clearance
    )


@given(st.floats(0.05, 6.0), st.floats(-0.2, 1.0), st.floats(0.0, 1.2))
def test_stroke_keeps_every_limit(speed, after, elevation):
    profile = profile_of(speed, after, elevation)
    stroke = stroke_trajectory(profile, HOME, 0.6)
    trajectory = stroke.trajectory
    for time in np.linspace(0.0, trajectory.duration, 300):
        position, velocity, acceleration = (row[STROKE] for row in trajectory.at(time))
        assert -1e-12 <= position <= DRIVE.max
        assert abs(velocity) <= max(speed, DRIVE.speed) * (1 + 1e-9)
        if not stroke.contact <= time <= stroke.leave:  # then the ball does it
            assert abs(acceleration) <= DRIVE.acceleration * (1 + 1e-9)
            force = MASS * (acceleration - GRAVITY * math.sin(elevation))
            assert abs(force) <= MECHANISM.max_force * (1 + 1e-9)
    outside = (trajectory.times[:-1] < stroke.contact) | (trajectory.times[:-1] >= stroke.leave)
    jerk = np.abs(np.diff(trajectory.accelerations[:, STROKE]) / np.diff(trajectory.times))
    assert (jerk[outside] <= DRIVE.jerk * (1 + 1e-9)).all()


@given(st.floats(0.05, 6.0), st.floats(-0.2, 1.0))
def test_constant_speed_before_the_ball_and_rest_in_the_end(speed, after):
    profile = profile_of(speed, after)
    stroke = stroke_trajectory(profile, HOME, 0.6)
    for time in np.linspace(stroke.contact - MECHANISM.steady_time, stroke.contact, 20):
        _, velocity, acceleration = stroke.trajectory.at(time)
        assert velocity[STROKE] == pytest.approx(speed, rel=1e-12)
        assert acceleration[STROKE] == pytest.approx(0.0, abs=1e-9)
    for time, where, how_fast in (
        (stroke.contact, profile.contact_at, speed),
        (stroke.leave, profile.leave_at, after * speed),
        (stroke.stop, profile.stop_at, 0.0),
        (stroke.home, 0.0, 0.0),
    ):
        position, velocity, _ = stroke.trajectory.at(time)
        assert position[STROKE] == pytest.approx(where, abs=1e-12)
        assert velocity[STROKE] == pytest.approx(how_fast, abs=1e-6)
    np.testing.assert_allclose(stroke.trajectory.positions[-1], [*HOME[:BASE_Z], 0.6, *HOME[3:]])
    assert profile.worst_case_stop >= profile.stop_at


@given(st.floats(1e-3, 10.0), st.floats(1.0, 1e3), st.floats(10.0, 1e5))
def test_ramp_uses_what_it_may(change, acceleration, jerk):
    rise, hold = ramp_times(change, acceleration, jerk)
    assert rise * jerk <= acceleration * (1 + 1e-12)
    assert rise * jerk * (rise + hold) == pytest.approx(change, rel=1e-9)
    if hold > 0.0:
        assert rise * jerk == pytest.approx(acceleration)


@pytest.mark.parametrize(
    ('arguments', 'limit', 'words'),
    [
        ({'speed': 6.5}, 'stroke.speed', r'6\.5 m/s is 0\.5 m/s above the limit of 6 m/s'),
        ({'speed': 0.01}, 'stroke.speed', r'0\.01 m/s is 0\.04 m/s below the limit of 0\.05 m/s'),
        (
            {'clearance': 0.01},
            'cloth',
            r'above the limit of 0\.01 m \(braking from 3 m/s at 150 m/s\^2, limited by '
            r'stroke\.acceleration',
        ),
        ({'mechanism': Mechanism(max_force=20.0), 'speed': 5.0}, 'travel', 'limited by max_force'),
        (
            {'mechanism': Mechanism(max_force=4.0), 'elevation': 1.1},
            'force',
            r'4\.386 N is 0\.386 N',
        ),
        ({'after': -5.0}, 'travel', 'the cue recoils'),
        ({'touch_time': 0.2}, 'travel', 'above the limit of 0.6 m'),
    ],
)
def test_what_it_cannot_do_says_which_limit_and_by_how_much(arguments, limit, words):
    with pytest.raises(LimitError, match=words) as caught:
        profile_of(**arguments)
    assert limit in [violation.limit for violation in caught.value.violations]


# --- the scene `robot_table`: a pool table at which the mechanical cue plays ---------------------

SCENE = Scene.load('robot_table')
RUN_UP = 0.05  # m


def test_the_cue_is_that_of_the_paper_and_the_table_a_pool_table():
    paper, pool = Scene.load('paper'), Scene.load('pool_table')
    assert SCENE.cue == paper.cue
    tip, of_paper = SCENE.contacts.cue_ball, paper.contacts.cue_ball
    assert (tip.restitution, tip.friction) == (of_paper.restitution, of_paper.friction)
    assert (SCENE.table, SCENE.ball, SCENE.cloth) == (pool.table, pool.ball, pool.cloth)
    assert SCENE.contacts.ball_table == pool.contacts.ball_table


def test_the_mechanism_can_play_what_is_planned():
    result = plan(SCENE, {'pot': '8', 'pocket': 'any'}, budget=2000, seed=1)
    assert result.status is Status.OK, result.message
    assert result.best.success > 0.2
    for planned in result.ranking:
        stroke = planned.stroke
        tip = tip_at(stroke, SCENE.balls['cue'], SCENE)
        before = tuple((tip.position - RUN_UP * tip.along).tolist())
        prepare_shot(
            Mechanism(),
            SCENE,
            ShotPlan(  # raises where it cannot
                planned.kind,
                before,
                tip.quaternion,
                stroke.speed,
                tip.elevation,
                sightings(SCENE.balls),
            ),
        )
