"""The planner as a real process: goals, cancel, preemption, refusals, what it shows."""
import math

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import BallState, RankedPlan, TableState, Target
from geometry_msgs.msg import Point, Vector3
import rclpy
from rclpy.action import ActionClient
from visualization_msgs.msg import MarkerArray

from billiard_shot import plan, predict, Scene, Status, Stroke
from billiard_shot.planning.plan import NOISES
from billiard_shot.ros import plan_conversions
from billiard_shot.ros.conversions import vectors
from billiard_shot.ros.plan_conversions import Task
from billiard_shot.ros.running import LATCHED

SCENE = Scene.load('blocked')
DEFAULT = Task(SCENE, {'pot': '8'}, SCENE.noise, {}, 2000, 1)
POT = Target(kind=Target.POT, ball='8')
HOPELESS = 3_000_000
"""A budget that is never spent in a test."""


def balls(**places):
    return [BallState(id=name.removeprefix('b'), position=Point(x=x, y=y))
            for name, (x, y) in places.items()]


OPEN = balls(cue=(-.4, 0.), b8=(.5, .2))
# The 9 in a ring of others: low cues do not get to it, and the search goes on until it is stopped.
RING = balls(cue=(-.5, 0.), b9=(.5, 0.), **{
    f'b{i}': (.5 + .0572 * math.cos(i * math.pi / 3), .0572 * math.sin(i * math.pi / 3))
    for i in range(1, 7)})
LOW = {'use_limits': True, 'speed_min': .1, 'speed_max': 4.5, 'elevation_max': .09,
       'azimuth_range': math.pi, 'offset_max': .5}


class Asking:
    """A client of the action, and what it hears."""

    def __init__(self, node):
        self.node = node
        self.client = ActionClient(node, PlanShot, 'plan_shot')
        self.feedback = []
        assert self.client.wait_for_server(timeout_sec=120.0), 'the planner did not come up'

    def begin(self, **goal):
        sent = self.client.send_goal_async(
            PlanShot.Goal(**goal), lambda message: self.feedback.append(message.feedback))
        rclpy.spin_until_future_complete(self.node, sent, timeout_sec=20.0)
        return sent.result(), sent.result().get_result_async()

    def end(self, future):
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=60.0)
        assert future.done(), 'no result'
        return future.result().status, future.result().result

    def ask(self, **goal):
        return self.end(self.begin(**goal)[1])

    def until_it_plans(self):
        self.feedback.clear()
        for _ in range(2000):
            rclpy.spin_once(self.node, timeout_sec=0.01)
            if self.feedback:
                return
        raise AssertionError('no feedback')


@pytest.fixture(scope='module')
def asking(node, launch):
    launch('planner', '-p', 'budget:=2000', '-r', 'table_state:=seen_by_planner')
    return Asking(node)


def test_it_plans_for_its_parameters_as_it_starts(node, asking):
    seen = {}
    for kind, topic in ((RankedPlan, 'planner/best'), (MarkerArray, 'planner/markers')):
        node.create_subscription(
            kind, topic, lambda message, topic=topic: seen.update({topic: message}), LATCHED)
    for _ in range(1000):
        rclpy.spin_once(node, timeout_sec=0.02)
        if len(seen) == 2:
            break
    best = seen['planner/best']
    assert best.header.frame_id == 'table'
    assert 0.0 < best.success_low <= best.success <= best.success_high
    assert len(seen['planner/markers'].markers) > 3


def test_a_goal_succeeds_with_plans_that_the_library_confirms(asking):
    asking.feedback.clear()
    status, result = asking.ask(target=POT, balls=OPEN, budget=3000, seed=4)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert result.status == Status.OK
    scene = plan_conversions.with_balls(SCENE, OPEN)
    alone = plan(scene, {'pot': '8'}, NOISES['tournament'], budget=3000, seed=4)
    assert [each.success for each in result.plans] == [each.success for each in alone.ranking]
    assert result.simulations == alone.simulations
    best = result.plans[0]
    pose = best.cue_pose
    stroke = Stroke.from_pose(
        (pose.position.x, pose.position.y, pose.position.z),
        (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w),
        best.speed, scene.cue_ball)
    assert stroke.offsets == pytest.approx(alone.best.stroke.offsets, abs=1e-6)
    assert (best.a, best.b, best.elevation, best.azimuth, best.speed) == pytest.approx(
        alone.best.stroke.offsets)
    shot = predict(scene, stroke)
    assert '8' in shot.table.pocketed
    assert vectors(best.trajectory.positions)[-1] == pytest.approx(
        shot.trajectory.rest, abs=1e-3)
    assert {ball.id for ball in result.balls} == {'cue', '8'}


def test_cancel_while_it_plans(asking):
    handle, ended = asking.begin(target=Target(kind=Target.HIT, ball='9'), balls=RING, **LOW,
                                 budget=HOPELESS)
    asking.until_it_plans()
    handle.cancel_goal_async()
    status, result = asking.end(ended)
    assert status == GoalStatus.STATUS_CANCELED
    assert result.status == Status.CANCELLED
    assert 0 < result.simulations < HOPELESS
    feedback = asking.feedback[-1]
    assert feedback.budget == HOPELESS
    assert 0 < feedback.simulations <= result.simulations


def test_a_new_goal_preempts_the_old_one(asking):
    _, first = asking.begin(target=Target(kind=Target.HIT, ball='9'), balls=RING, **LOW,
                            budget=HOPELESS)
    asking.until_it_plans()
    _, second = asking.begin(target=POT, balls=OPEN, budget=1500)
    status, result = asking.end(second)
    assert (status, result.status) == (GoalStatus.STATUS_SUCCEEDED, Status.OK)
    status, result = asking.end(first)
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.CANCELLED)
    assert 'preempted' in result.message


def test_a_plan_that_fails_aborts_with_its_reason(asking):
    status, result = asking.ask(target=Target(kind=Target.HIT, ball='9'), balls=RING, **LOW,
                                budget=1000)
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.NO_PLAN)
    assert not result.plans
    assert 'no stroke' in result.message


@pytest.mark.parametrize(('goal', 'named'), [
    ({'target': Target(kind=Target.POT, ball='7')}, "there is no ball '7'"),
    ({'target': Target(kind=99)}, 'target.kind is 99'),
    ({'target': Target(kind=Target.REST, point=Point(x=9.0))}, 'rest'),
    ({'target': Target(kind=Target.REST, point=Point(x=math.nan))}, 'rest'),
    ({'target': POT, 'balls': balls(b8=(0., 0.))}, 'the cue ball'),
    ({'target': POT, 'balls': balls(cue=(0., 0.), b8=(0.01, 0.))}, 'overlap'),
    ({'target': POT, 'use_limits': True}, 'speed_m'),
    ({'target': POT, 'use_noise': True, 'sigma_a': -1.0}, 'a: -1'),
    ({'target': POT, 'first_contact': '5'}, "there is no ball '5'"),
    ({'target': Target(kind=Target.POT, ball='8', radius=-1.0)}, 'radius'),
])
def test_what_makes_no_sense_is_refused_by_name(asking, goal, named):
    status, result = asking.ask(**{'balls': OPEN, **goal})
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.INVALID_REQUEST)
    assert named in result.message
    assert not result.plans


def test_frames_are_checked(asking):
    goal = PlanShot.Goal(target=POT)
    goal.header.frame_id = 'map'
    status, result = asking.ask(header=goal.header, target=POT)
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.INVALID_REQUEST)
    assert "'map'" in result.message


def test_the_table_comes_from_table_state(node, asking):
    publisher = node.create_publisher(TableState, 'seen_by_planner', LATCHED)  # by no one else
    publisher.publish(TableState(snapshot_id=1, balls=balls(cue=(-.4, .1), b3=(.5, -.2))))
    for _ in range(200):
        _, result = asking.ask(target=Target(kind=Target.HIT, ball='3'), budget=300)
        if result.status == Status.OK:
            break
        rclpy.spin_once(node, timeout_sec=0.05)
    assert {ball.id for ball in result.balls} == {'cue', '3'}


@pytest.mark.parametrize(('target', 'wanted'), [
    (Target(), None),
    (Target(kind=Target.REST, point=Point(x=.1, y=.2)), {'rest': (.1, .2)}),
    (Target(kind=Target.PASS, point=Point(x=.1, y=.2), radius=.3),
     {'pass': (.1, .2), 'radius': .3}),
    (Target(kind=Target.GATE, point=Point(x=.1), other_point=Point(x=.2)),
     {'gate': ((.1, .0), (.2, .0))}),
    (Target(kind=Target.HIT, ball='3', direction=Vector3(x=1.0), use_direction=True,
            within=math.pi / 18), {'hit': '3', 'direction': (1., 0.), 'within_deg': 10.0}),
    (Target(kind=Target.HIT, ball='3', point=Point(x=.1), use_point=True),
     {'hit': '3', 'at': (.1, 0.)}),
    (Target(kind=Target.POT, ball='8', pockets=['side_left'], point=Point(x=.1), use_point=True,
            radius=.2), {'pot': '8', 'pocket': ['side_left'], 'leave': (.1, 0.), 'radius': .2}),
    (POT, {'pot': '8', 'pocket': 'any'}),
])
def test_targets_of_messages(target, wanted):
    found = plan_conversions.target_of(target)
    if wanted and 'within_deg' in wanted:
        assert found.pop('within_deg') == pytest.approx(wanted.pop('within_deg'))
    assert found == wanted


def test_limits_and_noise_of_messages():
    goal = PlanShot.Goal(
        **LOW, use_noise=True, sigma_a=.001, sigma_azimuth=math.pi / 180, first_contact='1')
    task = plan_conversions.task_of(goal, DEFAULT, None)
    assert task.constraints['elevation_max_deg'] == pytest.approx(math.degrees(.09))
    assert task.constraints['azimuth_range_deg'] == pytest.approx(180.0)
    assert task.constraints['first_contact'] == '1'
    assert task.noise.azimuth_deg == pytest.approx(1.0)
    assert (task.noise.a, task.noise.b) == (.001, 0.0)
    assert (task.budget, task.seed, task.scene) == (2000, 1, SCENE)
