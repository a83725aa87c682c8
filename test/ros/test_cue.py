"""The mechanical cue as real processes: driver, simulated mechanism and simulated table."""

import math
import os
from pathlib import Path
import signal

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.msg import BallState, TableState
from billiard_shot_msgs.srv import PredictShot
from builtin_interfaces.msg import Time
from cell import PATIENT
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point
from lifecycle_msgs.msg import Transition
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Header
from waiting import PATIENCE, spin_until

from billiard_shot.cue.mechanism import JOINTS
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import MOVING, SafetyState
from billiard_shot.ros import conversions
from billiard_shot.ros.client import NotReadyError, RobotClient, TableUnknownError
from billiard_shot.ros.conversions import is_stop
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.ros.robot import SIMULATION
from billiard_shot.shot.replay import from_json

SPACE = '/cell'
NODES = {**PATIENT, 'cue_sim': SIMULATION}
"""Joint states come at the default rate."""
WAY = [*MOVING, SafetyState.DISARMED]


def test_the_outcome_is_not_read_from_a_table_state_older_than_the_strike(node):
    player, strike = RobotClient('player', '/nobody'), Time(sec=100)

    def seen(seconds, x):
        ball = BallState(id='cue', position=Point(x=x))
        return TableState(header=Header(stamp=Time(sec=seconds)), balls=[ball])

    player.table = seen(99, 0.1)
    with pytest.raises(NotReadyError, match='the picture is from before the strike after 1 s'):
        player.wait_for_rest(strike, seconds=1.0)
    player.table = seen(101, 0.1)  # a later picture, in which the ball is hidden
    player.table.balls[0].last_seen = Time(sec=99)
    with pytest.raises(NotReadyError, match="ball 'cue' is from before the strike after 1 s"):
        player.wait_for_rest(strike, seconds=1.0)
    for seconds in (101, 0):  # later; of unknown time
        player.table = seen(seconds, 0.3)
        assert player.wait_for_rest(strike)['cue'].position == (0.3, 0.0)
    player.destroy_node()


@pytest.mark.parametrize(
    ('ball', 'words'),
    [
        (BallState(id='8', state=BallState.UNKNOWN), "ball '8' is not seen"),
        (BallState(id='8', moving=True), "ball '8' moves on"),
    ],
)
def test_the_table_is_known_only_if_every_ball_is_seen_at_rest(node, ball, words):
    player = RobotClient('player', '/nobody')
    player.table = TableState(balls=[BallState(id='cue', position=Point(x=0.3)), ball])
    with pytest.raises(TableUnknownError, match=words):
        player.wait_for_rest(seconds=1.0)
    player.destroy_node()


@pytest.mark.parametrize(
    ('balls', 'code', 'words'),
    [
        (
            [BallState(id='8'), BallState(id='cue', state=BallState.POCKETED)],
            1,
            "no ball 'cue' on the table",
        ),
        ([BallState(id='8'), BallState(id='8')], 3, "table_state: balls: '8' occurs twice"),
    ],
)
def test_the_player_says_that_a_table_cannot_be_played(cell, launch_once, balls, code, words):
    publisher = cell.player.create_publisher(TableState, 'unplayable', LATCHED)
    publisher.publish(TableState(balls=balls))
    space = ('-r', f'__ns:={SPACE}', '-r', 'table_state:=unplayable')
    process = launch_once('player', *space, '--', '--speed', '0.5')
    assert cell.player.until(lambda: process.poll() is not None, PATIENCE)
    said = process.stdout.read()
    assert process.returncode == code, said
    assert words in said
    assert 'Traceback' not in said
    cell.player.destroy_publisher(publisher)


def test_the_loop_is_closed(cell):
    """The ball comes to rest where it was predicted to."""
    goal = cell.goal('loop')
    answer = cell.player.predict(
        PredictShot.Request(
            cue_pose=goal.plan.cue_pose, speed=goal.plan.speed, use_table_state=True
        )
    )
    expected = conversions.vectors(answer.trajectory.positions)[-1][:2]
    response = cell.player.execute(goal)
    result = response.result
    assert response.status == GoalStatus.STATUS_SUCCEEDED
    assert result.outcome == GoalOutcome.OK
    assert result.struck
    assert result.strike.shot_id == goal.plan.shot_id
    assert result.strike.speed == pytest.approx(0.8, rel=5e-3)
    assert result.elevation == pytest.approx(0.2, abs=math.radians(0.02))
    assert cell.player.until(lambda: cell.strikes, PATIENCE)
    assert result.strike == cell.strikes[-1]  # with the stamp of the strike, not of the end
    np.testing.assert_allclose(
        cell.player.wait_for_rest(result.strike.header.stamp)['cue'].position, expected, atol=0.01
    )
    played = from_json(cell.shots[-1].data)
    assert played.stroke.speed == pytest.approx(result.strike.speed, rel=1e-12)
    np.testing.assert_allclose(
        played.trajectory.final_position[:2],
        cell.player.wait_for_rest()['cue'].position,
        atol=1e-9,
    )
    cell.reach(SafetyState.DISARMED)
    assert [SafetyState(state.state) for state in cell.player.states[1:]] == WAY
    assert all(state.reason for state in cell.player.states)


def test_what_it_publishes(cell):
    cell.joints.clear()
    goal = cell.goal('topics')
    cell.begin(goal)
    cell.reach(SafetyState.AIMED)
    cell.commands.clear()
    assert cell.player.until(lambda: len(cell.commands) > 3, PATIENCE), 'repeated while it holds'
    command = cell.commands[-1]
    assert command.joint_names == list(JOINTS)
    assert all(len(point.velocities) == len(JOINTS) for point in command.points)
    assert cell.player.until(lambda: cell.angles, PATIENCE)
    assert cell.angles[-1].data == pytest.approx(0.2, abs=1e-9)
    cell.diagnostics.clear()
    assert cell.player.until(lambda: cell.diagnostics, PATIENCE)
    (status,) = cell.diagnostics[-1].status
    assert status.name == '/cell/cue_driver'
    assert status.message == 'AIMED: waiting to be armed'
    assert {each.key: each.value for each in status.values} == {
        'shot_id': goal.plan.shot_id,
        'node': 'ok',
        'estop': 'ok',
        'interlock': 'ok',
        'mechanism': 'ok',
        'table': 'ok',
        'clock': 'ok',
        'commands': 'ok',
        'alignment': 'exact',
    }

    def measured_angles():
        return [each for each in cell.joints if each.name == ['incline_angle']]

    cell.joints.clear()
    assert cell.player.until(measured_angles, PATIENCE)
    measured = measured_angles()
    assert measured[-1].position[0] == pytest.approx(0.2, abs=math.radians(0.02))
    cell.call('cue_driver/disarm')
    assert cell.result().outcome == GoalOutcome.DISARMED


def test_busy_and_cancel(cell):
    ended = cell.begin(cell.goal('first'))
    first = cell.handle
    cell.begin(cell.goal('second'))
    assert cell.result().outcome == GoalOutcome.BUSY
    cell.reach(SafetyState.AIMED)
    canceled = first.cancel_goal_async()
    assert cell.player.until(lambda: canceled.done() and ended.done(), PATIENCE)
    assert ended.result().status == GoalStatus.STATUS_CANCELED
    assert ended.result().result.outcome == GoalOutcome.CANCELED
    cell.reach(SafetyState.DISARMED)
    assert cell.arm().message == 'arm: not possible in state DISARMED, only in AIMED'


def test_estop_stops_latches_and_clears(cell):
    """One slow publisher of true counts among quick ones of false, until it ends."""
    cell.begin(cell.goal('estop'))
    cell.reach(SafetyState.AIMING)
    assert cell.player.until(cell.moving, PATIENCE)
    slow = cell.player.create_publisher(Bool, 'estop', 10)
    assert cell.player.until(slow.get_subscription_count, PATIENCE)
    slow.publish(Bool(data=True))
    assert cell.player.until(lambda: cell.commands and is_stop(cell.commands[-1]), PATIENCE)
    cell.reach(SafetyState.ESTOP)
    assert cell.result().outcome == GoalOutcome.ESTOP
    cell.stands_still()
    for _ in range(5):
        assert 'estop: ' in cell.call('cue_driver/clear_fault').message
    cell.player.destroy_publisher(slow)
    assert cell.clear()


def test_deactivate_disarms(cell):
    cell.begin(cell.goal('deactivate'))
    cell.reach(SafetyState.AIMING)
    assert cell.player.until(cell.moving, PATIENCE)  # else the mechanism has nothing to stop
    assert cell.transition(Transition.TRANSITION_DEACTIVATE)
    assert cell.result().outcome == GoalOutcome.DISARMED
    cell.stands_still()
    cell.begin(cell.goal('inactive'))
    assert cell.result().outcome == GoalOutcome.NOT_READY
    assert 'not active' in cell.result().message
    assert 'not active' in cell.arm().message
    assert cell.transition(Transition.TRANSITION_CLEANUP)
    assert cell.transition(Transition.TRANSITION_CONFIGURE)
    assert cell.transition(Transition.TRANSITION_ACTIVATE)
    cell.reach(SafetyState.DISARMED)
    # The commands are numbered anew; the mechanism follows them.
    cell.player.wait_for_all()
    assert cell.player.execute(cell.goal('anew')).result.outcome == GoalOutcome.OK


def begin_to_fire(cell, name):
    cell.begin(cell.goal(name))
    cell.reach(SafetyState.AIMED)
    assert cell.arm().success
    cell.reach(SafetyState.FIRING)


def test_a_killed_driver_leaves_the_mechanism_stopped(cell):
    begin_to_fire(cell, 'killed')
    cell.processes['cue_driver'].kill()
    cell.stands_still()
    cell.player.wait_for_rest()
    cell.restart_driver()


def test_a_driver_that_a_signal_ends_stops_the_mechanism(cell):
    """Before, no stop was sent, and joints moved on until the time-out of the mechanism."""
    begin_to_fire(cell, 'ended')
    driver = cell.processes['cue_driver']
    driver.send_signal(signal.SIGTERM)
    assert driver.wait(timeout=PATIENCE) == 0
    assert cell.stands_still().silence is None, 'commanded'
    cell.player.wait_for_rest()
    cell.restart_driver()


def test_a_killed_mechanism_is_a_fault(cell):
    cell.begin(cell.goal('killed mechanism'))
    cell.reach(SafetyState.AIMING)
    cell.processes['cue_sim'].kill()
    cell.reach(SafetyState.FAULT)
    assert 'joint_states: no message for' in cell.player.states[-1].reason
    assert cell.result().outcome == GoalOutcome.FAULT
    assert not cell.call('cue_driver/clear_fault').success
    cell.start('cue_sim')
    assert cell.clear()
    cell.prepare()  # the new mechanism may not hear the driver yet
    assert cell.player.execute(cell.goal('as before')).result.outcome == GoalOutcome.OK


def test_another_process_killed_does_no_harm(cell):
    cell.begin(cell.goal('killed predictor'))
    cell.reach(SafetyState.AIMED)
    cell.processes['predictor'].kill()
    cell.processes['table_sim'].kill()
    assert cell.arm().success
    assert cell.result().outcome == GoalOutcome.OK


def test_the_mechanism_waits_for_no_clock(launch_once, node):
    """Simulated time is 0 until the first message on /clock."""
    joints = []
    node.create_subscription(JointState, '/no_clock/joint_states', joints.append, 10)
    process = launch_once('cue_sim', '-r', '__ns:=/no_clock', '-p', 'use_sim_time:=true')
    assert spin_until(node, lambda: len(joints) > 20 or process.poll() is not None)
    assert process.poll() is None, process.stdout.read()
    assert joints[-1].header.stamp == Time()


def test_a_driver_that_has_ended_is_no_rival(launch, node, long_lease):
    """
    It says that it ends, so others need not wait until they take it for dead.

    The middleware says so once, by a message that a busy machine may lose: so one of three counts.
    """
    # A node may log before it can be ended in order; its diagnostics come from its executor.
    heard = []
    listener = node.create_subscription(DiagnosticArray, '/diagnostics', heard.append, 100)

    def is_forgotten(space):
        process = launch('cue_driver', '-r', f'__ns:={space}', '-p', 'autostart:=true')
        name = f'{space}/cue_driver'

        def commands():
            return node.count_publishers(f'{name}/actuation')

        assert spin_until(
            node, lambda: any(each.status[0].name == name for each in heard) and commands()
        )
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=PATIENCE) == 0
        return spin_until(node, lambda: not commands(), 20.0)

    assert any(is_forgotten(f'/ended_{attempt}') for attempt in range(3))
    node.destroy_subscription(listener)


@pytest.fixture
def long_lease(domain, monkeypatch, tmp_path):
    """Let others wait for an hour before they take a silent process for dead."""
    profile = Path(os.environ['FASTDDS_DEFAULT_PROFILES_FILE']).read_text()
    begin = '<discovery_config>'
    assert profile.count(begin) == 1
    lease = '<leaseDuration><sec>3600</sec></leaseDuration>'
    (tmp_path / 'fastdds.xml').write_text(profile.replace(begin, begin + lease))
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', str(tmp_path / 'fastdds.xml'))
