"""
Attacks on the robot, TRIALS times each, as `make soak` does; without TRIALS they are skipped.

In no trial may the cue play a stroke that nobody decided for this table, or a node end. After each
trial the cell is in order again. `make test` has a trial of each hole, most of them without nodes.
"""

import math
import os
import signal

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')

from billiard_shot_msgs.msg import BallState, TableState
from billiard_shot_msgs.srv import PlaceBalls, PredictShot
from cell import PATIENT
from geometry_msgs.msg import Point
import numpy as np
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose
from waiting import PATIENCE, PatientCaller

from billiard_shot import Scene, Stroke
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.node_runner import LATCHED

TRIALS = range(int(os.environ.get('TRIALS', '0')))
pytestmark = pytest.mark.parametrize('trial', TRIALS)

SPACE = '/attacked'
SCENE = Scene.load('robot_table')
ON_IT = ('-p', 'scene:=robot_table')
TABLE_TIMEOUT = 1.0
NODES = {
    'cue_driver': (*PATIENT['cue_driver'], *ON_IT, '-p', f'table_timeout:={TABLE_TIMEOUT}'),
    'cue_sim': PATIENT['cue_sim'],
    'table_sim': (*ON_IT, '-p', 'camera:=true', '-p', 'real_time_factor:=100.0'),
    'table_tracker': ON_IT,
    'predictor': ON_IT,
    'planner': ON_IT,
}
STROKE = Stroke.from_offsets(a=0.0, b=0.2, elevation=0.2, azimuth=0.5, speed=0.8)


@pytest.fixture
def draws(trial):
    return np.random.default_rng(trial)


def wait(cell, seconds):
    """Let time pass, and go on saying that all is well."""
    cell.player.until(lambda: False, seconds)


def goal_for(cell, balls):
    return cell.player.goal(STROKE, balls, SCENE, 'attack')


def aim(cell):
    """Aim a stroke for the balls as they lie."""
    cell.begin(goal_for(cell, cell.player.wait_for_rest()))
    cell.reach(SafetyState.AIMED)


def place(cell, places):
    """Put the balls of the simulated table elsewhere."""
    service = PatientCaller(cell.player, PlaceBalls, f'{SPACE}/table_sim/place')
    balls = [BallState(id=name, position=Point(x=x, y=y)) for name, (x, y) in places.items()]
    answer = service.call(PlaceBalls.Request(balls=balls), repeatable=True)
    assert answer.success, answer.message


def assert_nothing_was_played(cell, *outcomes):
    """The goal ends, without a strike, with one of these outcomes, if there are any."""
    result = cell.result()
    assert not result.struck, 'the cue has fired'
    assert not cell.strikes
    assert not outcomes or GoalOutcome(result.outcome) in outcomes, result.message
    assert_all_live(cell)


def assert_all_live(cell):
    ended = [name for name, process in cell.processes.items() if process.poll() is not None]
    assert not ended


@pytest.fixture(autouse=True)
def no_strikes_yet(cell):
    """Forget the strikes so far, and the balls that somebody has added."""
    reset = PatientCaller(cell.player, Trigger, f'{SPACE}/table_tracker/reset')
    assert reset.call(Trigger.Request(), repeatable=True).success
    known = cell.player.until(lambda: cell.player.balls().keys() == {'cue', '8'}, PATIENCE)
    assert known, 'the tracker does not see the cue ball and the 8'
    cell.strikes.clear()


def test_a_table_that_changes_after_the_decision(cell, draws):
    """Somebody moves a ball by 3 mm to 20 cm, adds one, or takes one away."""
    balls = cell.player.wait_for_rest()
    places = {name: ball.position for name, ball in balls.items()}
    name = draws.choice(sorted(places))
    change = draws.choice(['move', 'add', 'take'])
    if change == 'move':
        way, angle = 0.003 * 66.0 ** draws.random(), draws.uniform(0.0, 2.0 * math.pi)
        x, y = places[name]
        places[name] = x + way * math.cos(angle), y + way * math.sin(angle)
    elif change == 'add':
        places['3'] = (-0.3, 0.3)
    else:
        places = {'cue': places['cue']}
    place(cell, places)
    wait(cell, draws.uniform(0.0, 1.0))
    cell.begin(goal_for(cell, balls))
    cell.player.until(lambda: cell.state is SafetyState.AIMED or cell.ended.done(), PATIENCE)
    if not cell.ended.done():
        wait(cell, 1.0)  # in which the tracker sees what has changed
        cell.arm()
    assert_nothing_was_played(
        cell, GoalOutcome.TABLE_DIFFERS, GoalOutcome.TABLE_MOVED, GoalOutcome.TABLE_STALE
    )


@pytest.mark.parametrize('who', ['table_sim', 'table_tracker'])
def test_a_camera_that_freezes_or_dies_while_the_cue_is_aimed(cell, draws, who):
    aim(cell)
    process = cell.processes[who]
    if draws.random() < 0.5:
        process.kill()
        process.wait()
        cell.processes.pop(who)
    else:
        process.send_signal(signal.SIGSTOP)
    try:
        wait(cell, TABLE_TIMEOUT + draws.uniform(0.5, 7.0))
        cell.arm()
        assert_nothing_was_played(cell, GoalOutcome.TABLE_STALE)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGCONT)
        else:
            cell.start(who)


def test_numbers_of_any_size_end_no_node(cell, draws):
    def number():
        return float(draws.choice([-1.0, 1.0]) * 10.0 ** draws.uniform(-320.0, 308.0))

    def point():
        return Point(x=number(), y=number(), z=number())

    states = cell.player.create_publisher(TableState, f'{SPACE}/table_state', LATCHED)
    camera = cell.player.create_publisher(Detection3DArray, f'{SPACE}/detections', 10)
    service = PatientCaller(cell.player, PlaceBalls, f'{SPACE}/table_sim/place')
    try:
        for _ in range(5):
            stamp = cell.player.get_clock().now().to_msg()
            balls = [BallState(id=name, position=point()) for name in ('cue', '8')]
            for ball in balls:
                ball.position_covariance[:] = [number() for _ in range(9)]
            table = TableState(balls=balls)
            seen = Detection3DArray()
            for name in ('cue', '8'):
                result = ObjectHypothesisWithPose()
                result.hypothesis.class_id, result.hypothesis.score = name, 1.0
                result.pose.pose.position = point()
                result.pose.covariance = [number() for _ in range(36)]
                seen.detections.append(Detection3D(results=[result]))
            for message in (table, seen):
                message.header.stamp, message.header.frame_id = stamp, 'table'
            states.publish(table)
            camera.publish(seen)
            assert not service.call(PlaceBalls.Request(balls=balls), repeatable=True).success
            request = PredictShot.Request(speed=number(), use_table_state=True)
            request.cue_pose.position = point()
            assert cell.player.predict(request).status >= 100
    finally:
        cell.player.destroy_publisher(states)
        cell.player.destroy_publisher(camera)
    assert_all_live(cell)


def test_a_press_at_any_time_is_latched(cell, draws):
    """The cue fires after no press; a press during the stroke stops it."""
    cell.begin(goal_for(cell, cell.player.wait_for_rest()))
    wait(cell, draws.uniform(0.0, 6.0))
    if cell.state is SafetyState.AIMED:
        cell.arm()
        wait(cell, draws.uniform(0.0, 0.3))
    publisher = cell.player.create_publisher(Bool, f'{SPACE}/estop', 10)
    try:
        assert cell.player.until(publisher.get_subscription_count, PATIENCE)
        publisher.publish(Bool(data=True))
        cell.reach(SafetyState.ESTOP)
        before = len(cell.strikes)
        wait(cell, 1.0)
        assert cell.state is SafetyState.ESTOP, 'a press was cleared'
        assert len(cell.strikes) == before, 'the cue has fired'
    finally:
        cell.player.destroy_publisher(publisher)
    assert_all_live(cell)
