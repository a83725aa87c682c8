import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from plans import HOME, MECHANISM
import pytest

from billiard_shot.cue.joint_trajectory import ramp_times, stroke_profile, stroke_trajectory
from billiard_shot.cue.mechanism import BASE_Z, LimitError, Mechanism, STROKE

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
