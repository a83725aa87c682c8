"""The driver commands a controller of ros2_control, and nothing goes on when the driver dies."""

import math
from pathlib import Path
import signal
import subprocess
import sys

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('control_msgs', reason='needs control_msgs')

from cell import LONG_RUN, PATIENT
import numpy as np
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from waiting import PATIENCE, PatientCaller

from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.commands import COMMAND_HORIZON
from billiard_shot.ros.conversions import seconds

SPACE = '/controlled'
NODES = {
    'cue_driver': (*PATIENT['cue_driver'], *LONG_RUN, '-p', 'interface:=follow_joint_trajectory'),
    'table_sim': PATIENT['table_sim'],
    'predictor': PATIENT['predictor'],
}
BRAKE = 1.5 * float(np.max(Mechanism().speeds / Mechanism().accelerations))
"""Longest time of the brake at the end of a goal [s]."""


class Controller:
    """The process of a controller, which can be started again."""

    def __init__(self):
        file = Path(__file__).with_name('fake_controller.py')
        self.process = subprocess.Popen(
            [sys.executable, file, '--ros-args', '-r', f'__ns:={SPACE}']
        )

    def close(self):
        self.process.kill()
        self.process.wait()


@pytest.fixture(scope='module')
def controller(domain):
    controller = Controller()
    yield controller
    controller.close()


@pytest.fixture
def cell(controller, whole_cell):
    whole_cell.prepare()
    return whole_cell


def bring_to_motion(cell, name):
    """Begin a shot; return when joints move."""
    cell.begin(cell.goal(name))
    cell.reach(SafetyState.AIMING)
    assert cell.player.until(cell.moving, PATIENCE)


def test_a_shot_is_played(cell):
    result = cell.player.execute(cell.goal('controlled')).result
    assert result.outcome == GoalOutcome.OK, result.message
    assert result.strike.speed == pytest.approx(0.8, rel=5e-3)
    assert result.elevation == pytest.approx(0.2, abs=math.radians(0.02))
    assert cell.player.until(lambda: cell.angles, PATIENCE)
    assert cell.angles[-1].data == pytest.approx(0.2, abs=1e-9)
    assert not cell.commands, 'nothing on the topic'


def test_the_emergency_stop_brakes(cell):
    bring_to_motion(cell, 'stopped')
    cell.player.safety_inputs_on = False
    cell.estop.publish(Bool(data=True))
    cell.reach(SafetyState.ESTOP)
    assert cell.player.until(lambda: not cell.moving(), PATIENCE)
    cell.player.safety_inputs_on = True
    assert cell.clear()
    assert cell.player.execute(cell.goal('afterwards')).result.outcome == GoalOutcome.OK


def test_a_killed_driver_leaves_the_mechanism_stopped(cell):
    """The last goal ends within its horizon, with a brake, before the aim is reached."""
    bring_to_motion(cell, 'killed')
    cell.processes['cue_driver'].kill()
    cell.processes['cue_driver'].wait()
    end = seconds(cell.player.get_clock().now().to_msg()) + COMMAND_HORIZON + BRAKE

    def speeds():
        return [
            max(map(abs, each.velocity))
            for each in cell.joints
            if len(each.name) == len(JOINTS) and seconds(each.header.stamp) > end
        ]

    assert cell.player.until(lambda: len(speeds()) >= 20, PATIENCE)
    assert max(speeds()) < 1e-6, 'at rest'
    cell.restart_driver()
    cell.prepare()
    assert cell.player.execute(cell.goal('a new driver')).result.outcome == GoalOutcome.OK


def test_a_controller_that_does_not_follow_is_a_fault(cell):
    client = PatientCaller(cell.player, Trigger, f'{SPACE}/joint_trajectory_controller/violate')
    assert client.wait_for_service()
    bring_to_motion(cell, 'violate')
    client.call(Trigger.Request())
    cell.reach(SafetyState.FAULT)
    words = 'controller: PATH_TOLERANCE_VIOLATED: base_x is 0.1 m off'
    assert words in cell.player.states[-1].reason
    assert cell.clear()
    assert cell.player.until(lambda: not cell.moving(), PATIENCE)


def test_a_controller_that_is_started_again_is_used_again(cell, controller):
    bring_to_motion(cell, 'frozen')
    controller.process.send_signal(signal.SIGSTOP)
    cell.reach(SafetyState.FAULT)
    assert 'controller: no answer to a goal' in cell.player.states[-1].reason
    controller.close()
    controller.__init__()
    assert cell.clear()
    assert cell.player.execute(cell.goal('again')).result.outcome == GoalOutcome.OK


def test_a_driver_without_its_controller_says_so(cell, launch_once):
    words = ('-p', 'autostart:=true', '-p', 'interface:=follow_joint_trajectory')
    launch_once('cue_driver', '-r', '__ns:=/uncontrolled', *words)
    action = '/uncontrolled/joint_trajectory_controller/follow_joint_trajectory'
    assert cell.player.until(
        lambda: any(
            f'controller: there is no action server {action}' in each.msg
            for each in cell.log
            if each.name == 'uncontrolled.cue_driver'
        ),
        PATIENCE,
    )
