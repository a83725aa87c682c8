"""What a driver keeps and refuses when it is deactivated, ended, or started again."""

import signal
import time

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import CueState
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import numpy as np
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool
from waiting import PATIENCE, spin_until

from billiard_shot.cue.mechanism import JOINTS
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.node_runner import EVERY_STATE, nanoseconds

SPACE = '/inactive'
DEACTIVATE = Transition.TRANSITION_DEACTIVATE
CLEANUP = Transition.TRANSITION_CLEANUP
SHUTDOWN = Transition.TRANSITION_ACTIVE_SHUTDOWN
QUEUED = 0.15
"""Time for which the driver is stopped, so that all requests wait for its executor [s]."""


def positions(cell, seconds):
    """Joints (n, 6) that the mechanism measures for some time [m, rad]."""
    cell.joints.clear()
    begin = nanoseconds(cell.player.get_clock().now().to_msg())  # older messages may wait
    cell.player.until(lambda: False, seconds)
    rows = [
        dict(zip(each.name, each.position, strict=True))
        for each in cell.joints
        if nanoseconds(each.header.stamp) > begin
    ]
    return np.array([[row[name] for name in JOINTS] for row in rows if JOINTS[0] in row])


@pytest.mark.parametrize(
    ('transitions', 'again'),
    [
        ([DEACTIVATE, CLEANUP], [Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE]),
        ([SHUTDOWN], []),
    ],
)
def test_requests_that_wait_with_a_transition_move_nothing(cell, transitions, again):
    """Before, the node was deactivated, and then the goal that had been accepted executed."""
    caller = cell.services['cue_driver/change_state']
    goal, driver = cell.goal(), cell.processes['cue_driver']
    driver.send_signal(signal.SIGSTOP)
    sent = cell.player.execute_shot.send_goal_async(goal)
    changes = [
        caller.client.call_async(ChangeState.Request(transition=Transition(id=each)))
        for each in transitions
    ]
    clear = cell.services['cue_driver/clear_fault']
    clear.client.call_async(clear.client.srv_type.Request())
    time.sleep(QUEUED)
    driver.send_signal(signal.SIGCONT)
    assert cell.player.until(lambda: all(each.done() for each in (sent, *changes)), PATIENCE)
    assert all(each.result().success for each in changes)
    ended = sent.result().get_result_async()
    assert cell.player.until(ended.done, PATIENCE), 'the goal has no result'
    assert ended.result().result.outcome in (GoalOutcome.DISARMED, GoalOutcome.NOT_READY)
    positions(cell, 0.5)  # a motion that began before the transition is braked
    travelled = positions(cell, 1.0)
    assert len(travelled) > 1
    assert np.ptp(travelled, axis=0).max() < 1e-4
    assert all(map(cell.transition, again))
    if not again:
        driver.send_signal(signal.SIGINT)
        assert driver.wait(PATIENCE) == 0  # the next test starts it again


@pytest.fixture
def driver(node, launch_once, tmp_path):
    """Start drivers with a file for their state; their states arrive in `states`."""

    class Drivers:
        space, path, states = '/kept', tmp_path / 'ros' / 'cue_driver.state', []

        def start(self, *arguments):
            self.states.clear()
            words = ('-p', 'autostart:=true', '-p', f'state_file:={self.path}', *arguments)
            return launch_once('cue_driver', '-r', f'__ns:={self.space}', *words)

        def reach(self, state):
            reached = spin_until(
                node, lambda: self.states and self.states[-1].state == state, PATIENCE
            )
            assert reached, self.states

    drivers = Drivers()
    node.create_subscription(
        CueState, f'{drivers.space}/cue_driver/state', drivers.states.append, EVERY_STATE
    )
    return drivers


def test_a_pressed_emergency_stop_outlasts_the_driver(node, driver):
    """Before, a driver that the launch started again was DISARMED, and the next goal aimed."""
    button = node.create_publisher(Bool, f'{driver.space}/estop', QoSProfile(depth=10))
    first = driver.start()
    driver.reach(SafetyState.DISARMED)
    assert not driver.path.exists()
    assert spin_until(node, lambda: button.get_subscription_count(), PATIENCE)
    button.publish(Bool(data=True))
    driver.reach(SafetyState.ESTOP)
    first.kill()
    first.wait(PATIENCE)
    assert driver.path.read_text() == 'ESTOP estop: pressed\n'
    driver.start()
    driver.reach(SafetyState.ESTOP)
    assert driver.states[-1].reason == 'before this start: estop: pressed'


def test_a_file_that_is_damaged_or_cannot_be_written_is_named(driver):
    driver.path.parent.mkdir()
    driver.path.write_text('DISARMED')
    process = driver.start()
    driver.reach(SafetyState.FAULT)
    assert 'state unknown: clear_fault' in driver.states[-1].reason
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE)
    process = driver.start('-p', f'state_file:={driver.path}/below')
    line = next(line for line in process.stdout if 'configure failed' in line)
    assert f'{driver.path}' in line


def test_a_second_driver_of_the_same_name_does_not_become_active(driver):
    first = driver.start()
    assert any('ready: action' in line for line in first.stdout)
    for _ in range(3):  # on a busy machine the middleware may tell of the first one late
        second = driver.start('-p', "state_file:=''")
        line = next(line for line in second.stdout if 'activate failed' in line or 'ready' in line)
        if 'ready' not in line:
            break
        second.send_signal(signal.SIGINT)
        second.wait(PATIENCE)
    assert f'activate failed: another node is named {driver.space}/cue_driver' in line
    first.send_signal(signal.SIGINT)
    assert any('ready: action' in line for line in second.stdout), 'it becomes active later'
