"""What the driver refuses and reports: other drivers, settings, clocks, silence."""

import copy
import re
import signal
import time

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import CueState, TableState
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import numpy as np
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from waiting import PATIENCE, PatientCaller, spin_until

from billiard_shot.cue.mechanism import JOINTS
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.client import NotReadyError, RobotClient
from billiard_shot.ros.node_runner import EVERY_STATE, LATCHED, nanoseconds

SPACE = '/safety'


def setter(cell, node):
    """Return a function that sets a parameter of a node: '' or the reason why not."""
    client = PatientCaller(cell.player, SetParameters, f'{SPACE}/{node}/set_parameters')
    cell.wait_for_services(client)

    def put(name, value):
        kind = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}[type(value)]
        number = {'bool': 1, 'integer': 2, 'double': 3, 'string': 4}[kind]
        parameter = Parameter(
            name=name, value=ParameterValue(type=number, **{f'{kind}_value': value})
        )
        answer = client.call(SetParameters.Request(parameters=[parameter]), repeatable=True)
        (result,) = answer.results
        return '' if result.successful else result.reason

    return put


def test_two_drivers_fault_both_and_name_each_other(cell, launch_once):
    second = launch_once(
        'cue_driver',
        '-r',
        f'__ns:={SPACE}',
        '-r',
        '__node:=second_driver',
        '-p',
        'autostart:=true',
        '-r',
        '~/actuation:=cue_driver/actuation',
    )
    cell.reach(SafetyState.FAULT)
    assert cell.player.states[-1].reason.startswith('another node commands the mechanism: ')
    assert cell.says('second_driver', 'FAULT: another node commands the mechanism: ')
    rival = f'another node commands the mechanism: {SPACE}/second_driver'
    known = cell.player.until(lambda: cell.health()['commands'] == rival, PATIENCE)
    assert known, cell.health()['commands']
    refused = cell.call('cue_driver/clear_fault')
    assert not refused.success
    assert rival in refused.message
    second.terminate()
    assert second.wait(timeout=PATIENCE) == 0
    assert cell.clear()


def test_safety_limits_cannot_be_set_while_the_driver_is_configured(cell):
    put = setter(cell, 'cue_driver')
    wanted = 'estop_timeout: can be set only while the node is unconfigured'
    assert put('estop_timeout', 1.0).startswith(wanted)
    assert put('scene', 'paper').startswith('scene: can be set only')
    assert cell.transition(Transition.TRANSITION_DEACTIVATE)
    assert put('estop_timeout', 1.0).startswith(wanted)
    assert cell.transition(Transition.TRANSITION_CLEANUP)
    assert put('estop_timeout', 1000.0)
    assert 'read-only' in put('period', 0.05)
    assert put('joint_states_timeout', 0.05) == ''
    assert not cell.transition(Transition.TRANSITION_CONFIGURE)
    assert cell.says(
        'cue_driver',
        'configure failed: estop_timeout, interlock_timeout, joint_states_timeout must be at '
        'least four times the period, 0.02, got 0.05 (s)',
    )
    assert put('joint_states_timeout', 2.0) == ''
    assert cell.transition(Transition.TRANSITION_CONFIGURE)
    assert cell.transition(Transition.TRANSITION_ACTIVATE)
    cell.reach(SafetyState.DISARMED)


def test_an_older_table_state_does_not_replace_a_newer_one(cell):
    """Two cameras, or a queue that was held up."""
    cell.wait_for_services()
    older = TableState(
        header=Header(frame_id='table', stamp=cell.player.table.header.stamp), balls=[]
    )
    older.header.stamp.sec -= 3600
    publisher = cell.player.create_publisher(TableState, f'{SPACE}/table_state', LATCHED)
    publisher.publish(older)
    try:
        assert cell.says('cue_driver', 'ignored a table_state 3.6e+03 s older than the last')
    finally:
        cell.player.destroy_publisher(publisher)
        cell.services['table_sim/reset'].call(Trigger.Request())


def restore_table(cell):
    cell.services['table_sim/reset'].call(Trigger.Request())
    assert cell.player.until(lambda: cell.health()['table'] == 'ok', PATIENCE)


def test_a_table_that_is_not_valid_is_not_known_any_more(cell):
    """A shot that waits for its table is given up: the balls may have moved."""
    cell.wait_for_services()
    publisher = cell.player.create_publisher(TableState, f'{SPACE}/table_state', LATCHED)
    bad = copy.deepcopy(cell.player.table)
    bad.balls.append(bad.balls[0])
    cell.begin(cell.goal('two balls of a name'))
    cell.processes['table_sim'].send_signal(signal.SIGSTOP)  # else it corrects the message at once
    try:
        cell.reach(SafetyState.AIMING)
        publisher.publish(bad)
        cell.reach(SafetyState.DISARMED)
        assert cell.health()['table'].startswith('table_state: ')
        assert cell.result().outcome == GoalOutcome.TABLE_STALE
    finally:
        cell.processes['table_sim'].send_signal(signal.SIGCONT)
        cell.player.destroy_publisher(publisher)
        restore_table(cell)


@pytest.mark.pauses_processes
def test_a_driver_that_hears_nothing_after_a_pause_ends(cell):
    """The middleware may lose its connections; a launch then starts the driver again."""
    others = [cell.processes[name] for name in ('cue_sim', 'table_sim')]
    driver = cell.processes['cue_driver']
    cell.player.safety_inputs_on = False
    for process in others:
        process.send_signal(signal.SIGSTOP)
    cell.player.until(lambda: False, 0.5)  # the driver reads what has been sent before
    driver.send_signal(signal.SIGSTOP)
    cell.player.until(lambda: False, 2.5)
    driver.send_signal(signal.SIGCONT)
    try:
        assert cell.player.until(lambda: driver.poll() is not None, PATIENCE)
        assert driver.returncode == 1
        words = 'nothing has been received for 2 s since this process paused'
        assert any(words in line for line in cell.logged('cue_driver'))
    finally:
        for process in others:
            process.send_signal(signal.SIGCONT)
    cell.prepare()
    assert cell.player.execute(cell.goal('again')).result.outcome == GoalOutcome.OK


def test_stamps_before_1970_do_not_end_the_driver(cell):
    cell.wait_for_services()
    driver = cell.processes['cue_driver']
    table = cell.player.create_publisher(TableState, f'{SPACE}/table_state', LATCHED)
    joints = cell.player.create_publisher(JointState, f'{SPACE}/joint_states', 10)
    state = copy.deepcopy(cell.player.table)
    state.header.stamp.sec = -1
    rest = [0.0] * len(JOINTS)
    message = JointState(header=state.header, name=JOINTS, position=rest, velocity=rest)
    try:
        for _ in range(20):
            table.publish(state)
            joints.publish(message)
            cell.player.until(lambda: False, 0.1)
    finally:
        cell.player.destroy_publisher(table)
        cell.player.destroy_publisher(joints)
        restore_table(cell)
    assert cell.call('cue_driver/disarm').success
    assert cell.processes['cue_driver'] is driver
    assert driver.poll() is None, 'the driver has ended'


def test_an_unconfigured_driver_says_how_to_go_on(cell, launch_once):
    launch_once('cue_driver', '-r', '__ns:=/idle')
    assert cell.player.until(
        lambda: any(
            'not ready: the node is not active: configure it' in each.msg
            for each in cell.log
            if each.name == 'idle.cue_driver'
        ),
        PATIENCE,
    )
    client = RobotClient('waiting', '/idle', timeout=0.5)
    assert client.until(lambda: 'not active' in client.problems[0], PATIENCE)
    words = '/idle/cue_driver: node: the node is not active: configure it, then activate it'
    with pytest.raises(NotReadyError, match=words):
        client.wait_for_driver()
    client.destroy_node()
    topics = {name for name, _ in cell.player.get_topic_names_and_types()}
    services = {name for name, _ in cell.player.get_service_names_and_types()}
    made = {f'/idle/cue_driver/{name}' for name in ('state', 'actuation', 'arm', 'clear_fault')}
    assert not made & (topics | services), 'they are made when the node is configured'


def test_simulated_time_that_does_not_run_or_jumps_back_is_named(cell, launch_once):
    """A driver of its own, which lives on simulated time."""
    launch_once(
        'cue_driver', '-r', '__ns:=/timeless', '-p', 'autostart:=true', '-p', 'use_sim_time:=true'
    )

    def clock():
        said = [
            value.value
            for message in cell.diagnostics
            for each in message.status
            if each.name == '/timeless/cue_driver'
            for value in each.values
            if value.key == 'clock'
        ]
        return said[-1] if said else ''

    assert cell.player.until(lambda: 'no message received on /clock' in clock(), PATIENCE)
    publisher = cell.player.create_publisher(Clock, '/clock', 1)
    time = 100.0

    def run(seconds, until):
        nonlocal time
        for _ in range(round(seconds / 0.05)):
            time += 0.05
            message = Clock()
            message.clock.sec, message.clock.nanosec = int(time), int(1e9 * (time % 1.0))
            publisher.publish(message)
            if cell.player.until(until, 0.05):
                return True
        return False

    assert run(30.0, lambda: clock() == 'ok')
    time -= 60.0
    assert run(30.0, lambda: clock().startswith('ROS clock: jumped back by '))
    assert run(30.0, lambda: clock() == 'ok')
    assert cell.player.until(
        lambda: clock().startswith('ROS clock: has stood still for'), PATIENCE
    )
    cell.player.destroy_publisher(publisher)


def test_commands_that_a_mechanism_refuses(cell, launch_once):
    """Commands without a number, and old ones; a refusal is logged once, not every time."""
    publisher = cell.player.create_publisher(JointTrajectory, f'{SPACE}/elsewhere', 1)
    process = launch_once(
        'cue_sim',
        '-r',
        f'__ns:={SPACE}',
        '-r',
        '__node:=second_sim',
        '-r',
        'joint_states:=other_joint_states',
        '-r',
        'cue_driver/actuation:=elsewhere',
    )
    assert cell.player.until(publisher.get_subscription_count, PATIENCE)

    def said():
        return [line for line in cell.logged('second_sim') if line.startswith('ignored')]

    def refused():
        publisher.publish(JointTrajectory())  # again: the mechanism may not know the publisher yet
        cell.player.until(lambda: False, 0.05)
        return said()

    assert cell.player.until(refused, PATIENCE)
    for _ in range(5):
        refused()
    (line,) = said()
    assert re.fullmatch(
        r'ignored a command: header\.stamp must be .*at most 0\.5 ago, got .* \(s\)', line
    )
    process.send_signal(signal.SIGSTOP)
    stamp = cell.player.get_clock().now().to_msg()
    publisher.publish(JointTrajectory(header=Header(stamp=stamp)))
    cell.player.until(lambda: False, 3.0)
    process.send_signal(signal.SIGCONT)
    assert cell.player.until(lambda: len(said()) > 1, PATIENCE)
    assert said()[1].startswith('ignored a command: it was written ')


# --- what a driver keeps and refuses when it is deactivated, ended, or started again -------------

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
