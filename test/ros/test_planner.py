"""The planner as a real process: goals, cancel, preemption, refusals, what it shows."""

from dataclasses import asdict, replace
from functools import partial
import math
import re
from types import SimpleNamespace

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import (
    BallState,
    RankedPlan,
    StrokeLimits,
    StrokeNoise,
    TableState,
    Target,
)
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Vector3
import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray
from waiting import PATIENCE, spin_until

from billiard_shot import plan, predict, Scene, Status, Stroke
from billiard_shot.planning.targets import read_target
from billiard_shot.ros import conversions, plan_conversions, planner
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.ros.plan_conversions import PlanRequest
from billiard_shot.ros.planner import Planner
from billiard_shot.scene.player import NOISES

SCENE = Scene.load('blocked')
DEFAULT = PlanRequest(SCENE, {'pot': '8'}, SCENE.noise, {}, 2000, 1)
POT = Target(kind=Target.POT, balls=['8'])
HOPELESS = 3_000_000
"""A budget that is never spent in a test."""


def balls(**places):
    return [
        BallState(id=name.removeprefix('b'), position=Point(x=x, y=y))
        for name, (x, y) in places.items()
    ]


OPEN = balls(cue=(-0.4, 0.0), b8=(0.5, 0.2))
# The 9 in a ring of others: low cues do not get to it, and the search goes on until it is stopped.
RING = balls(
    cue=(-0.5, 0.0),
    b9=(0.5, 0.0),
    **{
        f'b{i}': (0.5 + 0.0572 * math.cos(i * math.pi / 3), 0.0572 * math.sin(i * math.pi / 3))
        for i in range(1, 7)
    },
)
LOW = {
    'speed_min': 0.1,
    'speed_max': 4.5,
    'elevation_max': 0.09,
    'azimuth_half_range': math.pi,
    'offset_max': 0.5,
}


def limited(**changes):
    """Limits of low cues, in a goal."""
    return {'limits': [StrokeLimits(**{**LOW, **changes})]}


class Asking:
    """A client of the action, and what it hears."""

    def __init__(self, node):
        self.node = node
        self.client = ActionClient(node, PlanShot, 'plan_shot')
        self.feedback = []
        assert self.client.wait_for_server(timeout_sec=PATIENCE), 'the planner did not come up'

    def begin(self, **goal):
        for _ in range(4):  # the first answer of a new server may be lost
            sent = self.client.send_goal_async(
                PlanShot.Goal(**goal), lambda message: self.feedback.append(message.feedback)
            )
            rclpy.spin_until_future_complete(self.node, sent, timeout_sec=PATIENCE / 4)
            if sent.done():
                return sent.result(), sent.result().get_result_async()
        raise TimeoutError('the planner answers no goal')

    def end(self, future):
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=PATIENCE)
        assert future.done(), 'no result'
        return future.result().status, future.result().result

    def ask(self, **goal):
        return self.end(self.begin(**goal)[1])

    def until_it_plans(self):
        self.feedback.clear()
        assert spin_until(self.node, lambda: self.feedback), 'no feedback'


@pytest.fixture(scope='module')
def asking(node, launch):
    launch(
        'planner',
        '-p',
        'scene:=blocked',
        '-p',
        'target:="{pot: \'8\', pocket: any}"',
        '-p',
        'budget:=2000',
        '-p',
        'seconds:=0.0',
        '-r',
        'table_state:=seen_by_planner',
    )
    return Asking(node)


def test_a_goal_without_a_target_is_planned_for_the_parameters_and_shown(node, asking):
    seen = {}
    for kind, topic in ((RankedPlan, 'planner/best'), (MarkerArray, 'planner/markers')):
        node.create_subscription(
            kind, topic, lambda message, topic=topic: seen.update({topic: message}), LATCHED
        )
    status, result = asking.ask()
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert spin_until(node, lambda: len(seen) == 2), seen
    best = seen['planner/best']
    assert best.plan == result.plans[0].plan
    assert best.plan.header.frame_id == 'table'
    assert 0.0 < best.success_low <= best.success <= best.success_high
    assert len(seen['planner/markers'].markers) > 3


def test_a_goal_succeeds_with_plans_that_the_library_confirms(asking):
    asking.feedback.clear()
    status, result = asking.ask(target=POT, balls=OPEN, budget=6000, seed=4)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert result.status == Status.OK
    scene, _ = conversions.requested_scene(SCENE, OPEN)
    alone = plan(scene, {'pot': '8'}, NOISES['tournament'], budget=6000, seed=4)
    assert [each.success for each in result.plans] == [alone.best.success], 'a short result'
    assert result.found == len(alone.ranking) > 1
    assert len(result.plans[0].trajectory.times) <= conversions.MAX_KEY_TIMES
    _, longer = asking.ask(
        target=POT, balls=OPEN, budget=6000, seed=4, plan_count=100, sample_count=50
    )
    assert [each.success for each in longer.plans] == [each.success for each in alone.ranking]
    assert all(len(each.trajectory.times) == 50 for each in longer.plans)
    names = [each.plan.shot_id for each in longer.plans]
    assert len({*names, result.plans[0].plan.shot_id}) == len(names) + 1
    assert result.simulations == alone.simulations
    best = result.plans[0]
    pose = best.plan.cue_pose
    stroke = Stroke.from_pose(
        (pose.position.x, pose.position.y, pose.position.z),
        (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w),
        best.plan.speed,
        scene.cue_ball,
    )
    assert stroke.offsets == pytest.approx(alone.best.stroke.offsets, abs=1e-6)
    assert (best.a, best.b, best.plan.elevation, best.azimuth, best.plan.speed) == pytest.approx(
        alone.best.stroke.offsets
    )
    shot = predict(scene, stroke)
    assert '8' in shot.run.pocketed
    assert conversions.vectors(best.trajectory.positions)[-1] == pytest.approx(
        shot.trajectory.final_position, abs=1e-3
    )
    assert {ball.id for ball in best.plan.balls} == {'cue', '8'}


def test_cancel_while_it_plans(asking):
    handle, ended = asking.begin(
        target=Target(kind=Target.HIT, balls=['9']), balls=RING, **limited(), budget=HOPELESS
    )
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
    _, first = asking.begin(
        target=Target(kind=Target.HIT, balls=['9']), balls=RING, **limited(), budget=HOPELESS
    )
    asking.until_it_plans()
    _, second = asking.begin(target=POT, balls=OPEN, budget=1500)
    status, result = asking.end(second)
    assert (status, result.status) == (GoalStatus.STATUS_SUCCEEDED, Status.OK)
    status, result = asking.end(first)
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.CANCELLED)
    assert 'preempted' in result.message


def test_a_plan_that_fails_aborts_with_its_reason(asking):
    status, result = asking.ask(
        target=Target(kind=Target.HIT, balls=['9']), balls=RING, **limited(), budget=1000
    )
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.NO_PLAN)
    assert not result.plans
    assert 'no stroke' in result.message


@pytest.mark.parametrize(
    ('goal', 'named'),
    [
        ({'target': Target(kind=Target.POT, balls=['7'])}, 'target.balls must be one of '),
        ({'target': Target(kind=99)}, 'target.kind must be one of its constants, 0 to 5, got 99'),
        ({'target': Target(kind=Target.HIT)}, 'target.balls must be one name, got []'),
        (
            {'target': Target(kind=Target.REST, point=Point(x=9.0))},
            'target.point must be on the table, ',
        ),
        (
            {'target': Target(kind=Target.REST, point=Point(x=math.nan))},
            'target.point must be two finite numbers, (x, y), got (nan, 0.0)',
        ),
        ({'target': POT, 'balls': balls(b8=(0.0, 0.0))}, 'the cue ball'),
        ({'target': POT, 'balls': OPEN * 1000}, 'balls must have at most 64 elements, got 2000'),
        (
            {'target': POT, 'balls': balls(cue=(1e160, 0.0))},
            "balls: ball 'cue': position.x must be from -10 to 10 m, got 1e+160",
        ),
        (
            {'target': POT, 'balls': balls(cue=(0.0, 0.0), b8=(0.01, 0.0))},
            "mm from ball 'cue', which it overlaps by 47.1 mm",
        ),
        (
            {'target': POT, 'limits': [StrokeLimits()]},
            'limits.speed_min must be a finite number above 0, got 0.0',
        ),
        ({'target': POT, **limited(elevation_max=-math.pi / 2)}, 'limits.elevation_max must be '),
        (
            {'target': POT, 'noise': [StrokeNoise(a=-1.0)]},
            'noise.a must be a finite number at least 0 and at most 0.1, got -1',
        ),
        ({'target': POT, 'first_contact': ['5']}, 'first_contact must be one of '),
        (
            {'target': Target(kind=Target.POT, balls=['8'], radius=-1.0)},
            'target.radius must be a finite number above 0, got -1.0',
        ),
        ({'target': POT, 'sample_count': 20_000}, 'sample_count must be at most 10000, got 20000'),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(asking, goal, named):
    status, result = asking.ask(**{'balls': OPEN, **goal})
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.INVALID_REQUEST)
    assert named in result.message
    assert not result.plans


def test_a_ball_that_overlaps_is_named_once():
    where = r"^table_state\.balls\.8 must be at least 57\.15 mm from ball 'cue', "
    with pytest.raises(ValueError, match=where):
        conversions.requested_scene(
            SCENE, balls(cue=(0.0, 0.0), b8=(0.01, 0.0)), field='table_state.balls'
        )


def test_every_mistake_of_a_goal_has_a_line_with_its_field():
    goal = PlanShot.Goal(
        target=Target(kind=Target.HIT, balls=['8'], use_direction=True, within=9.0),
        noise=[StrokeNoise(b=math.nan, elevation=-math.pi)],
    )
    with pytest.raises(ValueError, match='2 mistakes') as refused:
        plan_conversions.plan_request_of(goal, DEFAULT, None, 'table')
    assert re.findall(r'^  ([\w.]+) must be .*, got (\S+)', str(refused.value), re.MULTILINE) == [
        ('noise.b', 'nan'),
        ('noise.elevation', '-180.0'),
    ]
    goal.noise = []
    task = plan_conversions.plan_request_of(goal, DEFAULT, None, 'table')
    with pytest.raises(ValueError, match='2 mistakes') as refused:
        plan(SCENE, task.target)
    message = plan_conversions.in_fields(str(refused.value), goal)
    assert re.findall(r'^  ([\w.]+) must ', message, re.MULTILINE) == [
        'target.within',
        'target.direction',
    ]
    own = 'constraints: speed_max must be a finite number above 0, got 0.0'
    assert plan_conversions.in_fields(own, goal) == own.removeprefix('constraints: ')
    assert (
        plan_conversions.in_fields('target: pot must be any', PlanShot.Goal())
        == 'target: pot must be any'
    )


def test_frames_are_checked(asking):
    goal = PlanShot.Goal(target=POT)
    goal.header.frame_id = 'map'
    status, result = asking.ask(header=goal.header, target=POT)
    assert (status, result.status) == (GoalStatus.STATUS_ABORTED, Status.INVALID_REQUEST)
    assert "'map'" in result.message


def test_the_table_comes_from_table_state(node, asking):
    publisher = node.create_publisher(TableState, 'seen_by_planner', LATCHED)  # by no one else
    publisher.publish(TableState(snapshot_id=1, balls=balls(cue=(-0.4, 0.1), b3=(0.5, -0.2))))
    results = []

    def is_seen():
        results.append(asking.ask(target=Target(kind=Target.HIT, balls=['3']), budget=300)[1])
        return results[-1].status == Status.OK

    assert spin_until(node, is_seen), results[-1].message
    assert {ball.id for ball in results[-1].plans[0].plan.balls} == {'cue', '3'}


@pytest.mark.parametrize(
    ('target', 'wanted'),
    [
        (Target(), None),
        (Target(kind=Target.REST, point=Point(x=0.1, y=0.2)), {'rest': (0.1, 0.2)}),
        (
            Target(kind=Target.PASS, point=Point(x=0.1, y=0.2), radius=0.3),
            {'pass': (0.1, 0.2), 'radius': 0.3},
        ),
        (
            Target(kind=Target.GATE, point=Point(x=0.1), other_point=Point(x=0.2)),
            {'gate': ((0.1, 0.0), (0.2, 0.0))},
        ),
        (
            Target(
                kind=Target.HIT,
                balls=['3'],
                direction=Vector3(x=1.0),
                use_direction=True,
                within=math.pi / 18,
            ),
            {'hit': '3', 'direction': (1.0, 0.0), 'direction_tolerance_deg': 10.0},
        ),
        (
            Target(kind=Target.HIT, balls=['3'], point=Point(x=0.1), use_point=True),
            {'hit': '3', 'at': (0.1, 0.0)},
        ),
        (
            Target(
                kind=Target.POT,
                balls=['8'],
                pockets=['side_left'],
                point=Point(x=0.1),
                use_point=True,
                radius=0.2,
            ),
            {'pot': ['8'], 'pocket': ['side_left'], 'leave': (0.1, 0.0), 'radius': 0.2},
        ),
        (POT, {'pot': ['8'], 'pocket': 'any'}),
        (Target(kind=Target.POT), {'pot': 'any', 'pocket': 'any'}),
    ],
)
def test_targets_of_messages(target, wanted):
    found = plan_conversions.requested_target(target)
    if wanted:
        there_and_back = plan_conversions.requested_target(plan_conversions.target_message(wanted))
        assert asdict(read_target(there_and_back)) == pytest.approx(asdict(read_target(wanted)))
    if wanted and 'direction_tolerance_deg' in wanted:
        assert found.pop('direction_tolerance_deg') == pytest.approx(
            wanted.pop('direction_tolerance_deg')
        )
    assert found == wanted


def test_limits_and_noise_of_messages():
    goal = PlanShot.Goal(
        **limited(), noise=[StrokeNoise(a=0.001, azimuth=math.pi / 180)], first_contact=['1']
    )
    task = plan_conversions.plan_request_of(goal, DEFAULT, None, 'table')
    assert task.constraints['elevation_max_deg'] == pytest.approx(math.degrees(0.09))
    assert task.constraints['azimuth_half_range_deg'] == pytest.approx(180.0)
    assert task.constraints['first_contact'] == ['1']
    assert task.noise.azimuth_deg == pytest.approx(1.0)
    assert (task.noise.a, task.noise.b) == (0.001, 0.0)
    assert (task.budget, task.seed, task.scene) == (2000, 1, SCENE)


def test_balls_to_keep_and_times_of_messages():
    own = replace(DEFAULT, seconds=9.0)
    task = plan_conversions.plan_request_of(PlanShot.Goal(keep=['1', '8']), own, None, 'table')
    assert (task.constraints['keep'], task.seconds) == (['1', '8'], 9.0)
    task = plan_conversions.plan_request_of(PlanShot.Goal(seconds=0.5), own, None, 'table')
    assert ('keep' in task.constraints, task.seconds) == (False, 0.5)
    task = plan_conversions.plan_request_of(PlanShot.Goal(budget=100), own, None, 'table')
    assert (task.budget, task.seconds) == (100, None)


def test_the_plan_has_the_balls_as_they_were_seen():
    seen = [
        BallState(id='cue', position_covariance=[1e-8, 0.0, 0.0, 0.0, 4e-8, 0.0, 0.0, 0.0, 0.0]),
        BallState(id='8', position=Point(x=0.5), last_seen=Time(sec=3)),
    ]
    task = plan_conversions.plan_request_of(PlanShot.Goal(balls=seen), DEFAULT, None, 'table')
    result = plan(task.scene, {'pot': '8'}, budget=300)
    message = plan_conversions.ranked_message(result.best, task, 'x', Header(), 2)
    assert message.plan.balls == seen


def test_a_warning_is_part_of_the_message():
    result = plan(SCENE, {'pot': '8'}, budget=500)

    def warning(best):
        return plan_conversions.ranked_message(best, DEFAULT, 'x', Header(), 2).warning

    assert warning(result.best) == result.best.warning
    azimuth = result.best.stroke.offsets[3] + 0.5
    other_way = Stroke.from_offsets(azimuth=azimuth, elevation=0.1, speed=1.0)
    assert warning(replace(result.best, stroke=other_way)) == 'without errors the target is missed'


@pytest.mark.parametrize('place', [(planner, 'plan'), (plan_conversions, 'plan_request_of')])
def test_an_error_of_the_planner_is_a_result(node, monkeypatch, place):
    """Else the status would be OK, and the goals that come later would wait for ever."""

    def broken(*_, **__):
        raise ZeroDivisionError('in the library')

    monkeypatch.setattr(*place, broken)
    log, ends, executor = [], [], SingleThreadedExecutor()
    goal = SimpleNamespace(
        request=PlanShot.Goal(), is_cancel_requested=False, abort=lambda: ends.append('aborted')
    )
    fake = SimpleNamespace(
        executor=executor,
        get_logger=lambda: SimpleNamespace(error=log.append),
        get_parameter=lambda _: SimpleNamespace(value='table'),
        _default=DEFAULT,
        _table=None,
        _search=None,
    )
    fake._planned = partial(Planner._planned, fake)
    answer = executor.create_task(Planner._execute, fake, goal)
    executor.spin_until_future_complete(answer, PATIENCE)
    assert answer.result().status == Status.NO_PLAN
    assert "failed with ZeroDivisionError('in the library')" in answer.result().message
    assert 'in broken' in log[0]
    assert ends == ['aborted']
    assert fake._search is None


def test_the_covariance_of_the_balls_is_noise_of_their_places():
    """The largest standard deviation; one that the goal states itself takes precedence."""
    covariance = [4e-6, 0.0, 0.0, 0.0, 4e-6, 0.0, 0.0, 0.0, 0.0]
    cue = BallState(id='cue', position_covariance=covariance)
    seen = [cue, BallState(id='8', position=Point(x=0.5))]
    task = plan_conversions.plan_request_of(PlanShot.Goal(balls=seen), DEFAULT, None, 'table')
    assert task.noise == replace(DEFAULT.noise, balls=0.002)
    own = [StrokeNoise(balls=0.001)]
    task = plan_conversions.plan_request_of(
        PlanShot.Goal(balls=seen, noise=own), DEFAULT, None, 'table'
    )
    assert task.noise.balls == 0.001
