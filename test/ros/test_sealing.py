"""Goals that the planner seals: complete, accepted by the driver's checks, refused by name."""

from dataclasses import replace
import math

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import BallState, TableState
from billiard_shot_msgs.srv import SealShot
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
from ros2 import fill
from std_msgs.msg import Header
import yaml

from billiard_shot import plan, Scene, Status, Stroke
from billiard_shot.cue.goals import GoalRegistry
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.plan import prepare
from billiard_shot.ros.cue_conversions import plan_of, shot_goal_of
from billiard_shot.ros.seal_shot import one_line, plain
from billiard_shot.ros.sealing import LastPlan, seal, sealed_goal

SCENE = replace(Scene.load('paper'), balls={'cue': (0.1, -0.2), '08': (1.0, 0.5)})
HEADER = Header(frame_id='table', stamp=Time(sec=1000, nanosec=500))
TABLE = TableState(
    balls=[
        BallState(id='cue', position=Point(x=0.3, y=0.1)),
        BallState(id='it\'s "3": $x', position=Point(x=-0.5, y=1 / 3)),
        BallState(id='9', pocketed=True),
    ]
)
LIMITS = {'speed_min': 0.2, 'speed_max': 2.0, 'elevation_max_deg': 57.0, 'offset_max': 0.35}


@pytest.fixture(scope='module')
def last():
    return LastPlan(plan(SCENE, {'rest': (0.6, -0.4)}, budget=1000, constraints=LIMITS).ranking)


def goal_of(answer):
    assert answer.status == Status.OK, answer.message
    return ExecuteShot.Goal(plan=answer.plan, nonce=answer.nonce, expiry=answer.expiry)


def given(**fields):
    return SealShot.Request(
        use_stroke=True, speed=0.7, cue_pose=Pose(position=Point(x=0.1, y=0.1, z=0.03)), **fields
    )


def test_the_best_stroke_of_the_last_plan_is_sealed_by_default(last):
    answer = seal(SealShot.Request(), last, SCENE, None, HEADER)
    shot_goal = shot_goal_of(goal_of(answer), HEADER.stamp, 'table')
    GoalRegistry(600.0).register(shot_goal)
    best = last.ranking[0]
    assert shot_goal.remaining == pytest.approx(60.0)
    assert shot_goal.plan.balls == SCENE.balls
    assert shot_goal.plan.shot_id == f'{best.kind} {last.plan_id}-1'
    assert 'rank 1' in answer.message
    prepared = prepare(Mechanism(), SCENE, shot_goal.plan)
    assert prepared.shot.stroke.offsets == pytest.approx(best.stroke.offsets, abs=1e-9)


def test_a_rank_a_name_and_a_time_can_be_asked_for(last):
    rank = len(last.ranking)
    answer = seal(
        SealShot.Request(plan_id=last.plan_id, rank=rank, shot_id='mine', valid_for=5.0),
        last,
        SCENE,
        None,
        HEADER,
    )
    shot_goal = shot_goal_of(goal_of(answer), HEADER.stamp, 'table')
    assert shot_goal.plan.shot_id == 'mine'
    assert shot_goal.remaining == pytest.approx(5.0)
    assert shot_goal.plan.speed == last.ranking[rank - 1].stroke.speed


def test_each_seal_is_a_goal_of_its_own_for_the_same_shot(last):
    one, other = (seal(SealShot.Request(), last, SCENE, None, HEADER) for _ in range(2))
    assert one.nonce != other.nonce
    assert one.plan == other.plan
    book = GoalRegistry(600.0)
    for answer in (one, other):
        book.register(shot_goal_of(goal_of(answer), HEADER.stamp, 'table'))


def test_a_given_stroke_is_sealed_as_it_is_with_the_balls_of_the_table():
    request = given()
    answer = seal(request, None, SCENE, TABLE, HEADER)
    shot_goal = shot_goal_of(goal_of(answer), HEADER.stamp, 'table')
    GoalRegistry(600.0).register(shot_goal)
    assert answer.plan.cue_pose == request.cue_pose
    assert (shot_goal.plan.speed, shot_goal.plan.elevation) == (0.7, 0.0)
    assert set(shot_goal.plan.balls) == {'cue', TABLE.balls[1].id}
    assert prepare(Mechanism(), SCENE, shot_goal.plan).shot.stroke.offsets[1] > 0.0


def test_a_goal_in_the_frame_of_the_node():
    answer = seal(given(), None, SCENE, TABLE, Header(frame_id='bed'))
    assert answer.plan.header.frame_id == 'bed'
    shot_goal_of(goal_of(answer), Time(), 'bed')


@pytest.mark.parametrize(
    ('request_', 'words'),
    [
        (SealShot.Request(plan_id='older'), "plan_id is 'older': must be that of the last plan"),
        (SealShot.Request(rank=99), 'rank is 99: must be at most'),
        (SealShot.Request(valid_for=-1.0), 'valid_for is -1.0: must be above 0 s'),
        (SealShot.Request(valid_for=math.nan), 'valid_for is nan'),
        (SealShot.Request(valid_for=math.inf), 'valid_for is inf'),
        (SealShot.Request(header=Header(frame_id='map')), "header.frame_id is 'map'"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(last, request_, words):
    answer = seal(request_, last, SCENE, TABLE, HEADER)
    assert answer.status == Status.INVALID_REQUEST
    assert words in answer.message
    assert answer == SealShot.Response(status=answer.status, message=answer.message)


@pytest.mark.parametrize(
    ('change', 'status', 'words'),
    [
        ({'speed': 0.0}, Status.INVALID_STROKE, 'speed is 0.0'),
        ({'speed': math.nan}, Status.INVALID_STROKE, 'speed is nan'),
        ({'cue_pose': Pose(orientation=Quaternion(w=0.0))}, Status.INVALID_STROKE, 'orientation'),
        (
            {'cue_pose': Pose(position=Point(x=math.inf))},
            Status.INVALID_STROKE,
            'position.x is inf',
        ),
    ],
)
def test_a_stroke_that_makes_no_sense_is_refused_by_name(change, status, words):
    request = given()
    for name, value in change.items():
        setattr(request, name, value)
    answer = seal(request, None, SCENE, TABLE, HEADER)
    assert answer.status == status
    assert words in answer.message


def test_without_plan_table_or_guided_cue_nothing_is_sealed(last):
    pool = Scene.load('pool')
    cases = [
        (SealShot.Request(), None, SCENE, TABLE, 'there is no plan yet'),
        (given(), None, SCENE, None, 'no message has been received on topic table_state'),
        (given(), None, SCENE, TableState(), "no ball 'cue'"),
        (given(), None, SCENE, TableState(balls=[BallState(id='8')] * 2), 'twice'),
        (given(), None, SCENE, TableState(header=Header(frame_id='map')), "'map'"),
        (given(), None, pool, TABLE, 'not guided'),
        (
            SealShot.Request(),
            LastPlan(plan(pool, {'rest': (0.5, 0.0)}, budget=300).ranking),
            SCENE,
            TABLE,
            'not guided',
        ),
    ]
    for request, planned, scene, table, words in cases:
        answer = seal(request, planned, scene, table, HEADER)
        assert answer.status == Status.INVALID_REQUEST
        assert words in answer.message


def test_one_line_of_yaml_is_the_goal_to_the_last_digit():
    stroke = Stroke.from_offsets(a=1e-5, b=0.1, elevation=0.2, azimuth=1e-7, speed=1e-4 + 1 / 3)
    odd = ('08', '1e5', 'no', '~', 'it is "3": $x', "l'8", '8', 'größe', '{a: [')
    balls = {'cue': (1e-5, -2e-17), **dict.fromkeys(odd, (1.0, 0.1))}
    goal = sealed_goal(plan_of(stroke, balls, SCENE, 'shot: "1" #2'), HEADER)
    text = one_line(plain(goal))
    assert '\n' not in text
    again = fill(ExecuteShot.Goal(), yaml.safe_load(text))
    assert again == goal
    GoalRegistry(600.0).register(shot_goal_of(again, HEADER.stamp, 'table'))
    again.plan.balls[3].position.x += 1e-9
    with pytest.raises(RefusedError) as refused:
        GoalRegistry(600.0).register(shot_goal_of(again, HEADER.stamp, 'table'))
    assert refused.value.outcome is Outcome.PLAN_CHANGED
