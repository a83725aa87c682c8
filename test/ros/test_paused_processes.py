"""
Processes that do not run for a while, as on a starved machine or a paused virtual one.

Whatever is being done, and whatever waits to be delivered: a driver that paused does not fire, and
clears no latch, until it has heard everything anew. ROUNDS=25 pauses the driver 200 times.
"""

import os
import re
import signal
from time import monotonic, sleep

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.srv import Arm
from builtin_interfaces.msg import Duration
from cell import PATIENT
import numpy as np
from rclpy.time import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from waiting import PATIENCE, spin_until

from billiard_shot.cue.mechanism import JOINTS, STROKE
from billiard_shot.cue.safety import BEFORE_STROKE, MOVING, SafetyState
from billiard_shot.ros.node_runner import JOINT_STATES

pytestmark = pytest.mark.pauses_processes

ROUNDS = int(os.environ.get('ROUNDS', '1'))
ONCE = SafetyState.ARMED, SafetyState.ESTOP
STATES = SafetyState if ROUNDS > 1 else ONCE  # without nodes, all are tested

SHORT = (
    'estop_timeout:=0.6',
    'interlock_timeout:=0.6',
    'joint_states_timeout:=0.6',
    'settle_time:=1.0',
    'autostart:=true',
)
NODES = {
    **PATIENT,
    'cue_driver': tuple(word for each in SHORT for word in ('-p', each)),
    'cue_sim': ('-p', 'command_timeout:=0.8', '-p', 'rate:=100.0'),
}

SPACE = '/paused'

PAUSE = 1.0
"""Seconds: longer than all time-outs."""

DRAWN_BACK = 0.005
"""Metres that the stroke's joint moves when nothing is struck, at most."""


@pytest.fixture
def cell(whole_cell):
    whole_cell.prepare()
    yield whole_cell
    for process in whole_cell.processes.values():
        process.send_signal(signal.SIGCONT)


def bring_to(cell, state):
    """Bring the driver to a state; what ends early on a starved machine is tried again."""
    for _ in range(10):
        cell.prepare()
        if state is SafetyState.DISARMED or lead_to(cell, state):
            return
    raise AssertionError(f'{state.name} is not reached')


def lead_to(cell, state):
    """Do something that leads from DISARMED to a state; whether it did."""
    player = cell.player

    def reached(*states):
        return player.until(lambda: player.states[1:] and cell.state in states, 30.0)

    if state is SafetyState.ESTOP:
        player.safety_inputs_on = False
        cell.estop.publish(Bool(data=True))
        there = reached(state)
        player.safety_inputs_on = True
        return there
    if state is SafetyState.FAULT:
        rival = player.create_publisher(JointTrajectory, f'{cell.space}/cue_driver/actuation', 1)
        there = reached(state)
        player.destroy_publisher(rival)
        return there and player.until(lambda: cell.health()['commands'] == 'ok', PATIENCE)
    cell.begin(cell.goal(f'{state.name} {monotonic()}'))
    if state is SafetyState.AIMING:
        return reached(state)
    reached(SafetyState.AIMED, SafetyState.DISARMED, SafetyState.ESTOP, SafetyState.FAULT)
    return state is cell.state or (cell.arm().success and reached(state))


def wait(cell, seconds):
    cell.player.until(lambda: False, seconds)


@pytest.mark.parametrize('state', STATES, ids=lambda state: state.name)
def test_a_paused_driver_neither_fires_nor_clears(cell, state):
    """The publishers of its inputs go on meanwhile, or fall silent, in turns."""
    for number in range(ROUNDS):
        stop_the_driver_in(cell, state)
        pause_the_driver(cell, state, silent=(state + number) % 2 == 1)


def stop_the_driver_in(cell, state):
    """Bring the driver to a state and stop it there; messages from then on wait in its queues."""
    for _ in range(10):
        bring_to(cell, state)
        cell.processes['cue_driver'].send_signal(signal.SIGSTOP)
        wait(cell, 0.2)
        if cell.state is state:
            return
        # This process was starved, and the driver went on meanwhile.
        cell.processes['cue_driver'].send_signal(signal.SIGCONT)
    raise AssertionError(f'the driver is not stopped in {state.name}')


def pause_the_driver(cell, state, silent):
    fired = cell.state is SafetyState.FIRING
    cell.player.safety_inputs_on = not silent
    arm = Arm.Request(shot_id=cell.player.states[-1].shot_id)
    requests = [
        cell.services[f'cue_driver/{name}'].client.call_async(request)
        for name, request in (('arm', arm), ('clear_fault', Trigger.Request()), ('arm', arm))
    ]
    wait(cell, PAUSE)
    cell.joints.clear()
    del cell.player.states[:-1]
    cell.processes['cue_driver'].send_signal(signal.SIGCONT)
    assert cell.player.until(lambda: all(each.done() for each in requests), PATIENCE)
    wait(cell, 1.2)  # the settling time of a stroke, and more

    def moved():
        return [
            dict(zip(each.name, each.position, strict=True))[JOINTS[STROKE]]
            for each in cell.joints
            if len(each.name) == len(JOINTS)
        ]

    for each in requests:
        assert not each.result().success, each.result().message
    assert not any(each.state == SafetyState.FIRING for each in cell.player.states[1:])
    if state in BEFORE_STROKE:
        assert cell.player.states[1].state == SafetyState.DISARMED
        assert 'did not run for' in cell.player.states[1].reason
    if not fired and state is not SafetyState.RETRACTING:
        assert cell.player.until(moved, PATIENCE)
        assert max(moved()) < DRAWN_BACK


def test_a_goal_that_waited_is_refused(cell):
    cell.processes['cue_driver'].send_signal(signal.SIGSTOP)
    sent = cell.player.execute_shot.send_goal_async(cell.goal('waited'))
    wait(cell, PAUSE)
    cell.processes['cue_driver'].send_signal(signal.SIGCONT)
    assert cell.player.until(sent.done, PATIENCE)
    ended = sent.result().get_result_async()
    assert cell.player.until(ended.done, PATIENCE)
    assert 'because this process paused' in ended.result().result.message


def test_a_paused_mechanism_is_a_fault(cell):
    for _ in range(10):
        bring_to(cell, SafetyState.ARMED)
        cell.processes['cue_sim'].send_signal(signal.SIGSTOP)
        assert cell.player.until(lambda: cell.state not in MOVING, PATIENCE)
        if cell.state is SafetyState.FAULT:
            break
        # This process or the driver was starved, too.
        assert cell.starved(cell.player.states[-1]), cell.player.states[-1]
        cell.processes['cue_sim'].send_signal(signal.SIGCONT)
    assert cell.state is SafetyState.FAULT
    wait(cell, PAUSE)
    refused = cell.call('cue_driver/clear_fault')
    assert not refused.success
    assert re.search('joint_states: (no message|not trusted)', refused.message)
    cell.processes['cue_sim'].send_signal(signal.SIGCONT)
    assert cell.clear()
    assert cell.player.until(lambda: not cell.moving(), PATIENCE)


def test_a_mechanism_that_paused_with_its_driver_stops_by_itself(cell):
    """The command that waited for it meanwhile is too old."""
    for _ in range(10):
        bring_to(cell, SafetyState.AIMING)
        assert cell.player.until(cell.moving, PATIENCE)
        cell.processes['cue_sim'].send_signal(signal.SIGSTOP)
        sleep(0.2)
        cell.processes['cue_driver'].send_signal(signal.SIGSTOP)
        wait(cell, PAUSE)
        if cell.state is SafetyState.AIMING:
            break
        # On a starved machine the driver misses the mechanism before, and tells it to stop.
        for process in cell.processes.values():
            process.send_signal(signal.SIGCONT)
    cell.processes['cue_sim'].send_signal(signal.SIGCONT)
    assert cell.stands_still().silence is not None
    wait(cell, 1.0)
    assert not cell.moving()
    cell.processes['cue_driver'].send_signal(signal.SIGCONT)
    cell.reach(SafetyState.DISARMED)


def test_stamps_of_a_mechanism_that_pauses_again_and_again_never_decrease(node, launch_once):
    """The driver ignores messages with earlier stamps; it then missed the strike."""
    mechanism = launch_once(
        'cue_sim', '-r', '__ns:=/stamps', '-p', 'rate:=1000.0', '-p', 'command_timeout:=2.0'
    )
    heard = []
    listener = node.create_subscription(
        JointState, '/stamps/joint_states', heard.append, JOINT_STATES
    )
    commands = node.create_publisher(JointTrajectory, '/stamps/cue_driver/actuation', 1)
    assert spin_until(node, lambda: heard and commands.get_subscription_count())
    for _ in range(20):
        # At rest it publishes less often.
        commands.publish(hold(heard[-1], node.get_clock().now()))
        for pause, run in ((0.2, 0.005), (0.1, 0.2)):  # the second pause is within a burst
            mechanism.send_signal(signal.SIGSTOP)
            sleep(pause)
            mechanism.send_signal(signal.SIGCONT)
            sleep(run)
        count = len(heard)
        assert spin_until(node, lambda count=count: len(heard) > count + 100)
    steps = np.diff([Time.from_msg(each.header.stamp).nanoseconds for each in heard])
    assert np.median(steps) < 2e6
    assert min(steps) >= 0
    node.destroy_subscription(listener)
    node.destroy_publisher(commands)


def hold(joints, now):
    """Make a command that keeps the joints where they are."""
    zeros = [0.0] * len(joints.name)
    return JointTrajectory(
        header=Header(stamp=now.to_msg()),
        joint_names=joints.name,
        points=[
            JointTrajectoryPoint(
                positions=joints.position,
                velocities=zeros,
                accelerations=zeros,
                time_from_start=Duration(sec=second),
            )
            for second in (0, 1)
        ],
    )
