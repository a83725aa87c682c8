"""How a predictor starts and how it ends."""

from dataclasses import fields
from pathlib import Path
import re
import signal
import sys

from programs import ran
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from waiting import PATIENCE, PatientCaller

from billiard_shot.ros.predictor import PredictorParameters


@pytest.mark.parametrize(
    ('name', 'number'), [('predictor', signal.SIGINT), ('table_sim', signal.SIGTERM)]
)
def test_signals_end_a_node_with_exit_code_0(launch, node, name, number):
    space = f'/end_{name}_{number}'
    process = launch(name, '-r', f'__ns:={space}')
    client = PatientCaller(node, ListParameters, f'{space}/{name}/list_parameters')
    assert client.wait_for_service()
    client.call(ListParameters.Request(), repeatable=True)
    process.send_signal(number)
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said
    assert 'Traceback' not in said


def said_by(script, code=0):
    """Run a script until it ends with an exit code; return its output."""
    ended = ran([sys.executable, '-c', script], timeout=PATIENCE)
    assert ended.returncode == code, ended.stderr
    return ended.stdout + ended.stderr


FINALIZED = """
import os, signal
from rclpy.node import Node
from billiard_shot.ros.node_runner import spin_node

class Finalized:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        sum(range(1000))  # the handler runs before this ends

class Short(Node):
    def __init__(self):
        super().__init__('short')
        self.create_timer(0.01, Finalized)

spin_node(Short, 'short', [])
"""


def test_a_signal_during_a_finalizer_ends_a_node():
    """Before, the node went on, and a traceback was printed."""
    said = said_by(FINALIZED)
    assert 'Traceback' not in said


FAILING = """
import os
import signal

from rclpy.node import Node

from billiard_shot.ros.node_runner import spin_node, steady_timer

class Failing(Node):
    count = 0

    def __init__(self):
        super().__init__('failing')
        steady_timer(self, 0.05, self.fail)

    def fail(self):
        self.count += 1
        raise ValueError(f'error {self.count}')

    def survive(self, error):
        print(f'survived {error}', flush=True)
        if self.count == 3:
            os.kill(os.getpid(), signal.SIGINT)

spin_node(Failing, 'failing', [], survive=Failing.survive)
"""


def test_a_node_that_survives_errors_goes_on():
    said = said_by(FAILING)  # the middleware may say something, too
    assert re.findall(r'^survived .*$', said, re.MULTILINE) == [
        f'survived error {i}' for i in (1, 2, 3)
    ]


STUCK = """
import os
import signal

from rclpy.node import Node

from billiard_shot.ros import node_runner

class Stuck(Node):
    def __init__(self):
        super().__init__('stuck')
        self.create_timer(0.01, self.go_on)

    def go_on(self):
        os.kill(os.getpid(), signal.SIGTERM)
        while True:
            pass

node_runner.END_TIME = 0.5
node_runner.spin_node(Stuck, 'stuck', [])
"""


def test_a_signal_ends_a_node_whose_callback_does_not_return():
    assert 'stuck: a callback has not returned 0.5 s after a signal' in said_by(STUCK, code=1)


@pytest.mark.parametrize(
    ('name', 'setting', 'words'),
    [
        ('predictor', 'scene:=no_such_scene', 'no_such_scene'),
        ('cue_driver', 'scene:=pool', 'scene must be one with a guided cue'),
        ('cue_driver', 'settle_time:=9.0', 'settle_time must be below arm_timeout'),
        ('table_tracker', 'window:=many', 'window'),
    ],
)
def test_bad_parameter_is_a_clear_start_up_error(launch, name, setting, words):
    process = launch(name, '-p', setting)
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert words in said
    assert 'Traceback' not in said


@pytest.mark.parametrize(
    ('argument', 'code', 'words'),
    [('--help', 0, 'predicts the shot'), ('--scene=paper', 2, 'unrecognized arguments: --scene')],
)
def test_other_arguments_than_those_of_ros_do_not_start_it(argument, code, words):
    done = ran(
        [sys.executable, '-m', 'billiard_shot.ros', 'predictor', argument], timeout=PATIENCE
    )
    assert done.returncode == code
    assert words in done.stdout + done.stderr


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        (None, 'Error opening YAML file'),
        ('/**: [\n', 'Sequences'),
        ('/**:\n  scene: paper\n', 'before ros__parameters'),
        ('/**:\n  ros__parameters:\n    scene:\n', 'No value at line'),
        ('/**:\n  ros__parameters:\n    scene: []\n', 'scene must have a value'),
        ('/**:\n  ros__parameters:\n    scene: *a\n', 'alias'),
    ],
)
def test_a_bad_file_of_parameters_is_refused_in_a_line(start, tmp_path, text, words):
    file = tmp_path / 'parameters.yaml'
    if text:
        file.write_text(text)
    process = start('--params-file', str(file))
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1, said
    own = [line for line in said.splitlines() if '[rcl]' not in line]  # rcl logs a line itself
    assert len(own) == 1, said
    assert words in own[0]


def test_parameters_are_described_and_checked_when_set(ask, node):
    describe = PatientCaller(node, DescribeParameters, '/predictor/describe_parameters')
    set_them = PatientCaller(node, SetParameters, '/predictor/set_parameters')
    assert describe.wait_for_service()
    assert set_them.wait_for_service()
    names = [each.name for each in fields(PredictorParameters)]
    request = DescribeParameters.Request(names=names)
    for descriptor in describe.call(request, repeatable=True).descriptors:
        assert descriptor.description.endswith('.')

    def put(name, kind, **value):
        parameter = ParameterMessage(name=name, value=ParameterValue(type=kind, **value))
        request = SetParameters.Request(parameters=[parameter])
        return set_them.call(request, repeatable=True).results[0]

    integer, double, string = 2, 3, 4
    assert not put('scene', string, string_value='no_such_scene').successful
    assert 'no_such_scene' in put('scene', string, string_value='no_such_scene').reason
    assert not put('tolerance', double, double_value=-1.0).successful
    assert not put('tolerance', double, double_value=float('nan')).successful
    assert not put('sample_count', integer, integer_value=10**9).successful
    assert put('sample_count', integer, integer_value=77).successful
    from paper import request_for

    request = request_for('horizontal')
    assert len(ask(request).trajectory.times) == 77
    assert put('sample_count', integer, integer_value=0).successful


@pytest.mark.xdist_group('demo')  # it shares no node with the others
def test_demo_prints_the_four_shots(domain):
    demo = Path(__file__).parents[2] / 'config' / 'demo.py'
    done = ran([sys.executable, str(demo)], timeout=240)
    assert done.returncode == 0, done.stderr
    for name in ('vertical', 'horizontal', 'jump', 'massé'):
        assert f'{name}: Stroke(' in done.stdout
    assert done.stdout.count('ball velocity') == 4
    # two strokes that are given, one that is planned
    assert done.stdout.count('executed    OK') == 3
    assert done.stdout.count('from the prediction') == 3
    assert done.stdout.count('target      reached: ') == 1
    assert 'turn        player 0 wins' in done.stdout, 'three balls are cleared'
