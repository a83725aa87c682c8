"""Messages to the library and back, without any middleware."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallState, GameState
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
from paper import PAPER_SHOTS
from std_msgs.msg import Header

from billiard_shot import predict, predict_batch, Scene, Status, Stroke
from billiard_shot.perception.sightings import Sighting
from billiard_shot.ros import conversions, table_display
from billiard_shot.ros.predict_shot import request_of
from billiard_shot.ros.turn import state_of
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import GATES

SCENE = Scene.load('paper')
RADIUS = SCENE.ball.radius
unit = st.floats(-1.0, 1.0)


@given(
    azimuth=st.floats(-3.0, 3.0),
    elevation=st.floats(0.1, 1.5),
    a=st.floats(-0.4, 0.4),
    x=unit,
    y=unit,
    speed=st.floats(0.05, 10.0),
)
def test_stroke_survives_the_round_trip(azimuth, elevation, a, x, y, speed):
    """Normal and velocity -> cue pose in a message -> the same normal and velocity."""
    first = Stroke.from_offsets(a=a, b=0.1, elevation=elevation, azimuth=azimuth, speed=speed)
    request = request_of(first, SCENE, (x, y))
    second = conversions.stroke_of(request.cue_pose, request.speed, (x, y, RADIUS))
    np.testing.assert_allclose(second.normal, first.normal, atol=1e-9)
    np.testing.assert_allclose(second.velocity, first.velocity, rtol=1e-9, atol=1e-9)


def test_only_a_ball_on_the_table_was_seen_at_the_stamp_of_its_message():
    """Before, a ball that is not detected looked new in every message, and never grew old."""
    balls = [BallState(id='cue'), BallState(id='8', state=BallState.UNKNOWN)]
    seen = conversions.sightings_of(balls, Time(sec=7))
    assert {name: ball.time for name, ball in seen.items()} == {'cue': 7.0, '8': 0.0}


def test_the_systematic_error_of_a_ball_survives_the_round_trip_and_passes_the_gate():
    sightings_of, ball_message = conversions.sightings_of, conversions.ball_message
    ball = Sighting((0.1, 0.2), systematic_error=4e-4, time=3.5)
    assert sightings_of([ball_message('8', ball)]) == {'8': ball}
    for bad in (-1e-9, 0.006, math.nan, math.inf):
        message = ball_message('8', ball)
        message.systematic_error = bad
        with pytest.raises(
            ValueError, match=r"ball '8': systematic_error must be from 0 to 0\.005"
        ):
            sightings_of([message])


def test_trajectory_survives_the_round_trip():
    shot = predict(SCENE, PAPER_SHOTS['massé'])
    message = conversions.response_of(shot, 33).trajectory
    state = shot.trajectory.at(np.asarray(message.times))
    np.testing.assert_array_equal(conversions.vectors(message.positions), state.position)
    np.testing.assert_array_equal(conversions.vectors(message.velocities), state.velocity)
    np.testing.assert_array_equal(conversions.vectors(message.spins), state.spin)
    np.testing.assert_array_equal(message.motion, state.motion)
    assert message.times[0] == 0.0
    assert message.times[-1] == shot.trajectory.duration


def test_numbers_that_are_not_finite_never_leave():
    shot = predict(SCENE, Stroke(normal=(-1, 0, 0), velocity=(1, 0, 0)))
    broken = SimpleNamespace(
        **{
            name: getattr(shot, name)
            for name in (
                'status',
                'miscue',
                'message',
                'spin',
                'cue_speed',
                'trajectory',
                'run',
                'effect_context',
                'error_estimate',
                'wall_time',
            )
        },
        velocity=np.array([np.nan, 0.0, 0.0]),
    )
    answer = conversions.response_of(broken, 5)
    assert answer.status == Status.INVALID_REQUEST
    assert answer.velocity.x == 0.0


def test_answers_tell_miscues():
    wide = Stroke.from_offsets(0.8, 0.0, 0.02, 0.0, 2.0)
    shot = predict('pool', wide)
    answer = conversions.response_of(shot, 2)
    assert (answer.status, answer.miscue) == (Status.OK, True)
    batch = conversions.Batch(
        np.array([wide.normal] * 2),
        np.array([wide.velocity] * 2),
        np.array([Status.OK, Status.INVALID_STROKE], np.uint16),
    )
    result = predict_batch('pool', batch.normals, batch.velocities)
    assert conversions.batch_response(batch, result, 0.0).miscues == [True, False]


def test_path_stamps_carry_over_seconds():
    shot = predict(SCENE, Stroke(normal=(-1, 0, 0), velocity=(1, 0, 0)))
    message = conversions.response_of(shot, 5).trajectory
    message.times[-2] = 1e300
    path = table_display.path_of(message, Header(stamp=Time(sec=7, nanosec=999_999_999)))
    assert path.poses[0].header.stamp == Time(sec=7, nanosec=999_999_999)
    last = path.poses[-1].header.stamp
    assert last.sec + last.nanosec * 1e-9 == pytest.approx(8.0 + message.times[-1], abs=1e-6)


def test_the_answer_lists_every_effect_and_why():
    scene = dataclasses.replace(SCENE, effects=Effects(flight='off'))
    effects = {
        effect.name: effect
        for effect in conversions.response_of(predict(scene, PAPER_SHOTS['massé']), 2).effects
    }
    assert list(effects) == [gate.name for gate in GATES]
    assert effects['table_contact'].simulated
    assert effects['end_mass'].reason == 'the cue is guided: its tip cannot move sideways'
    assert not effects['flight'].simulated
    assert effects['flight'].reason.startswith('the scene turns it off; it would be simulated: ')


@pytest.mark.parametrize(
    ('game', 'balls', 'fields', 'words'),
    [
        ('practice', 'cue 1', {'winner': 0}, 'winner must be -1 while the rack is not over'),
        ('nine_ball', 'cue 8', {}, "balls must be with '9' while the rack is not over"),
        ('eight_ball', 'cue 1 2', {}, "balls must be with '8' while the rack is not over"),
        ('nine_ball', 'cue 8', {'over': True, 'winner': 1}, ''),
        ('nine_ball', 'cue 9', {}, ''),
    ],
)
def test_states_that_no_rack_can_have_are_refused(game, balls, fields, words):
    scene = Scene.load('robot_table')
    places = {name: (0.1 * i, 0.2) for i, name in enumerate(balls.split())}
    message = GameState(game=game, **fields)
    if words:
        with pytest.raises(ValueError, match=words):
            state_of(message, places, scene)
    else:
        assert state_of(message, places, scene).over is message.over
