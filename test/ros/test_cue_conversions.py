"""The mechanical cue's messages to the library and back, without any middleware."""

from dataclasses import replace
import math
from unittest.mock import MagicMock

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import BallState, CueState
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from rclpy.time import Time as RosTime
from std_msgs.msg import Header
from unique_identifier_msgs.msg import UUID

from billiard_shot import Scene, Stroke
from billiard_shot.cue.controller import MeasuredStrike, Result
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.model import TipPose
from billiard_shot.cue.plan import GoalOutcome, prepare_shot, RefusedError
from billiard_shot.cue.safety import SafetyState
from billiard_shot.perception.sightings import Sighting
from billiard_shot.ros import conversions
from billiard_shot.ros.cue_driver import CueDriver

SCENE = Scene.load('paper')
RADIUS = SCENE.ball.radius
BALLS = {'cue': Sighting((0.1, -0.2), (1e-8, 2e-9, 3e-8), time=4.25), '8': Sighting((0.5, 0.25))}


def plan(a=0.1, b=0.2, elevation=0.3, azimuth=1.0, speed=2.0):
    stroke = Stroke.from_offsets(a, b, elevation, azimuth, speed)
    return replace(conversions.plan_of(stroke, BALLS, SCENE, 'shot'), made=5.0)


def message_of(plan):
    return conversions.plan_message(plan, Header(frame_id='table', stamp=Time(sec=5)))


@given(
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 1.2),
    st.floats(-3.1, 3.1),
    st.floats(0.1, 6.0),
)
def test_a_plan_survives_the_round_trip(a, b, elevation, azimuth, speed):
    sent = plan(a, b, elevation, azimuth, speed)
    assert conversions.shot_plan_of(message_of(sent), 'table') == sent


def test_plans_that_make_no_sense():
    message = message_of(plan())
    message.header.frame_id = 'map'
    with pytest.raises(RefusedError, match=r"plan\.header\.frame_id must be 'table' or empty"):
        conversions.shot_plan_of(message, 'table')
    message = message_of(plan())
    message.balls.append(BallState(id='cue'))
    with pytest.raises(RefusedError, match="'cue' occurs twice"):
        conversions.shot_plan_of(message, 'table')
    message.balls[-1].id = 'pocketed'
    message.balls[-1].state = BallState.POCKETED
    assert conversions.shot_plan_of(message, 'table') == plan()


def test_a_trajectory_survives_the_round_trip():
    trajectory = prepare_shot(Mechanism(), SCENE, plan()).stroke.trajectory
    message = conversions.joint_trajectory_message(trajectory, JOINTS, Header(stamp=Time(sec=3)))
    assert all(point.velocities for point in message.points)
    order = [3, 1, 0, 2, 5, 4]
    message.joint_names = [message.joint_names[i] for i in order]
    for point in message.points:
        for values in (point.positions, point.velocities, point.accelerations):
            values[:] = type(values)('d', [values[i] for i in order])
    back = conversions.trajectory_of(message, JOINTS)
    np.testing.assert_allclose(back.times, trajectory.times, atol=1e-9)
    for field in ('positions', 'velocities', 'accelerations'):
        np.testing.assert_array_equal(getattr(back, field), getattr(trajectory, field))


def test_invalid_trajectories_are_refused():
    trajectory = prepare_shot(Mechanism(), SCENE, plan()).stroke.trajectory

    def refused(change):
        message = conversions.joint_trajectory_message(
            trajectory, JOINTS, Header(stamp=Time(sec=3))
        )
        change(message)
        with pytest.raises(ValueError, match=r'joint_names|points') as caught:
            conversions.trajectory_of(message, JOINTS)
        return str(caught.value)

    assert 'joint_names' in refused(lambda m: m.joint_names.pop())
    assert 'velocities' in refused(lambda m: setattr(m.points[3], 'velocities', []))
    assert 'ascend' in refused(
        lambda m: setattr(m.points[1], 'time_from_start', m.points[4].time_from_start)
    )
    assert 'finite' in refused(lambda m: setattr(m.points[1], 'positions', [math.nan] * 6))
    assert 'points' in refused(lambda m: m.points.clear())


def test_zero_command():
    stop = conversions.stop_message(JOINTS, 'table')
    assert conversions.is_stop(stop)
    assert list(stop.points[0].velocities) == [0.0] * 6
    trajectory = prepare_shot(Mechanism(), SCENE, plan()).stroke.trajectory
    assert not conversions.is_stop(
        conversions.joint_trajectory_message(trajectory, JOINTS, Header(stamp=Time(sec=3)))
    )


def test_a_measured_strike_is_the_stroke_that_was_played():
    stroke = Stroke.from_offsets(0.1, 0.2, 0.3, 1.0, 2.0)
    ball = np.array([0.1, -0.2, RADIUS])
    tip = TipPose(ball + RADIUS * np.array(stroke.normal), 1.0, 0.3)
    for off in (-1e-5, 0.0, 1e-5):
        strike = MeasuredStrike(TipPose(tip.position + off * tip.along, 1.0, 0.3), 2.0)
        message = conversions.strike_message('shot', strike, Header())
        back = conversions.measured_stroke(message, tuple(ball))
        np.testing.assert_allclose(back.normal, stroke.normal, atol=1e-12)
        np.testing.assert_allclose(back.velocity, stroke.velocity, atol=1e-12)
    result = conversions.execution_result(Result(GoalOutcome.OK, 'done', True, strike), message)
    assert (result.struck, result.measured) == (True, True)
    assert (result.elevation, result.strike.speed) == (0.3, 2.0)


def test_a_strike_that_was_not_measured_has_its_time():
    """So whoever watches the table knows from when on its balls count."""
    message = conversions.strike_message('shot', None, Header(stamp=Time(sec=7)))
    result = conversions.execution_result(Result(GoalOutcome.OK, 'done', True), message)
    assert (result.struck, result.measured, result.elevation) == (True, False, 0.0)
    assert (result.strike.header.stamp.sec, result.strike.speed) == (7, 0.0)
    result = conversions.execution_result(Result(GoalOutcome.FAULT, 'stopped'), message)
    assert (result.struck, result.strike.header.stamp.sec) == (False, 0)


def constants(interface):
    return {
        name: getattr(interface, name)
        for name in dir(interface)
        if name.isupper() and isinstance(getattr(interface, name), int)
    }


def test_constants_are_the_enumerations():
    assert constants(CueState) == {state.name: state.value for state in SafetyState}
    assert constants(ExecuteShot.Result) == {
        outcome.name: outcome.value for outcome in GoalOutcome
    }


def test_a_goal_is_judged_at_the_time_at_which_it_arrives():
    """Before, a plan that was newer than the last tick by 0.1 s was refused: a busy computer."""
    driver, goal = MagicMock(_ended={}), MagicMock(goal_id=UUID())
    driver._own.frame = 'table'
    driver.get_clock().now.return_value = RosTime(seconds=6)
    driver._controller.execute.side_effect = RefusedError(GoalOutcome.BUSY, 'busy')
    goal.request = ExecuteShot.Goal(plan=message_of(plan()), expiry=Time(sec=60))
    CueDriver._begin(driver, goal)
    (first, (time, _), _), (then, *_) = driver._controller.method_calls
    assert (first, time, then) == ('receive_clock', 6.0, 'execute')


def test_an_error_while_a_goal_is_taken_is_a_fault():
    """If an exception ends an action, rclpy gives it the outcome 0, which is OK."""
    driver, goal = MagicMock(_ended={}), MagicMock(goal_id=UUID(), is_cancel_requested=False)
    driver._controller.reason = 'error of this program'
    driver.get_clock().now().to_msg.side_effect = KeyError('clock')
    CueDriver._begin(driver, goal)
    with pytest.raises(StopIteration) as ended:
        CueDriver._end(driver, goal).send(None)
    assert ended.value.value.outcome == GoalOutcome.FAULT
    assert ended.value.value.message == 'error of this program'
    driver.survive.assert_called_once()
    goal.abort.assert_called_once()
