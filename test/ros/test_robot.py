"""The command `robot`, which starts the nodes without the `ros2` command."""

import contextlib
import os
from pathlib import Path
import signal
import subprocess
import sys
from threading import Thread
from types import SimpleNamespace

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import GameState
from billiard_shot_msgs.srv import PredictShot
from cell import LONG_RUN, STARVED
from rclpy.action import ActionClient
from std_srvs.srv import Trigger
from waiting import PATIENCE, PatientCaller, spin_until

from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros import robot
from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.robot import SIMULATION

EXAMPLES = Path(__file__).resolve().parents[2] / 'docs' / 'examples'
NOT_SEEN = 'the cue has not met the ball'
"""The driver says so if the controller sends no joint_states during the contact."""
NODES = ('predictor', 'planner', 'cue_driver', 'cue_sim', 'table_sim')


@pytest.fixture
def begin(domain, monkeypatch, tmp_path):
    """Start `robot` in a process group of its own, in which nothing is left at the end."""
    monkeypatch.setenv('ROS_HOME', str(tmp_path))  # no driver finds the state of an earlier one
    begun = []

    def begin(space, *arguments):
        robot = [sys.executable, '-m', 'billiard_shot.ros', 'robot', *arguments]
        process = subprocess.Popen(
            [*robot, '--ros-args', '-r', f'__ns:=/{space}'],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            process_group=0,
        )
        begun.append(process)
        return process

    yield begin
    for process in begun:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def wait_for_nodes(node, space):
    wanted = {(name, f'/{space}') for name in NODES}
    assert spin_until(node, lambda: wanted <= set(node.get_node_names_and_namespaces()))


def test_it_starts_the_nodes_and_ends_them(begin, node):
    process = begin('robot', '--simulate', '--scene', 'robot_table')
    wait_for_nodes(node, 'robot')
    caller = PatientCaller(node, PredictShot, '/robot/predict_shot')
    request = PredictShot.Request(speed=1.0)
    request.cue_pose.position.x, request.cue_pose.position.z = -0.2, 0.0286
    assert caller.wait_for_service()
    assert caller.call(request, repeatable=True).status == 0
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said
    with pytest.raises(ProcessLookupError):  # no node is left
        os.killpg(process.pid, 0)


def test_it_ends_if_a_node_ends(begin, node):
    process = begin('broken', '-h')
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert '--simulate' in said
    process = begin('broken', '--scene', 'no_such_scene')
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1, said
    assert 'no_such_scene' in said
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)


@pytest.mark.parametrize(
    ('ros', 'folder'), [((), ''), (('-r', '__ns:=/a'), 'a/'), (('-r', '__ns:=/a/b'), 'a/b/')]
)
def test_each_namespace_keeps_the_state_of_its_driver(ros, folder, monkeypatch):
    monkeypatch.setenv('ROS_HOME', '/ros')
    for simulate, path in ((True, ''), (False, f'/ros/billiard_shot/{folder}cue_driver.state')):
        nodes = robot.nodes_of(ros, robot.OfRobot(simulate=simulate))
        assert f"state_file:='{path}'" in nodes['cue_driver']


@pytest.mark.parametrize(
    'arguments',
    [
        ['--scene', 'robot_table', '--ros-args', '-r', '__ns:=/a'],
        ['--ros-args', '-r', '__ns:=/a', '--', '--scene', 'robot_table'],
    ],
)
def test_it_names_only_the_node_that_ended_by_itself(arguments, monkeypatch):
    """Before, it named all nodes, because they had all ended by then."""
    ended, running = SimpleNamespace(poll=lambda: 0), SimpleNamespace(poll=lambda: None)

    @contextlib.contextmanager
    def start(nodes, _):
        assert nodes['predictor'] == ('-p', 'scene:=robot_table', '-r', '__ns:=/a')
        yield {'planner': ended, 'predictor': running}
        running.poll = ended.poll

    monkeypatch.setattr(robot, 'running', start)
    monkeypatch.setattr(signal, 'signal', lambda *_: None)
    with pytest.raises(SystemExit, match=r'a node has ended: planner$'):
        robot.main(arguments)


@pytest.fixture
def example(domain):
    """Start programs of the pages."""
    with contextlib.ExitStack() as begun:

        def example(name, space):
            words = ['--ros-args', '-r', f'__ns:=/{space}']
            process = subprocess.Popen([sys.executable, EXAMPLES / name, *words])
            begun.callback(process.wait)
            begun.callback(process.kill)

        yield example


def test_detections_come_from_pictures_instead_of_the_simulated_table():
    nodes = robot.nodes_of([], robot.OfRobot(simulate=True, camera=True, pictures=True))
    assert {'table_camera', 'table_tracker'} <= nodes.keys()
    assert {'camera:=False', 'table_state:=simulated_table'} <= set(nodes['table_sim'])


@pytest.mark.slow
def test_a_turn_is_played_with_the_camera_and_the_controller_of_the_pages(
    begin, example, launch_once, node, tmp_path
):
    """The 8 lies near a pocket."""
    for needed in ('control_msgs', 'tf2_msgs', 'vision_msgs'):
        pytest.importorskip(needed, reason=f'needs {needed}')
    scene = tmp_path / 'scene.yaml'
    scene.write_text("{like: robot_table, balls: {cue: [0.6, 0.1], '8': [1.0, 0.4]}}")
    parts = ('--camera', '--player', '--interface', 'follow_joint_trajectory')
    settings = ('--ros-args', *SIMULATION, *LONG_RUN)
    robot = begin('own', *parts, '--scene', str(scene), *settings)
    Thread(target=robot.stdout.read, daemon=True).start()
    example('trajectory_server.py', 'own')
    example('camera.py', 'own')
    here = ('-r', '__ns:=/own', '-r', 'table_state:=simulated_table')
    launch_once('table_sim', *here, '-p', f'scene:={scene}')
    client = RobotClient('operator', '/own', simulate_safety_inputs=True, timeout=PATIENCE)
    action = ActionClient(client, PlayTurn, '/own/play_turn')

    def result_of(goal, patience=PATIENCE):
        """None if the server does not know this client yet, so that the answer is lost."""
        sent = action.send_goal_async(goal)
        if not client.until(sent.done, patience):
            return None
        ended = sent.result().get_result_async()
        assert client.until(ended.done, PATIENCE)
        return ended.result().result

    assert client.until(action.server_is_ready, PATIENCE)
    cricket = PlayTurn.Goal(state=GameState(game='cricket'))
    assert client.until(lambda: result_of(cricket, 5.0), PATIENCE)
    assert client.until(lambda: client.table and len(client.balls()) == 2, PATIENCE), (
        'no ball is seen'
    )
    goal = PlayTurn.Goal(state=GameState(game='practice', phase='play'), agent='greedy', arm=True)
    clear = PatientCaller(client, Trigger, '/own/cue_driver/clear_fault')
    for _ in range(5):
        result = result_of(goal)
        if not (STARVED.search(result.message) or NOT_SEEN in result.message):
            break
        # A process starved, and the driver ended the shot, as it should.
        assert client.until(
            lambda: (
                client.states[-1].state == SafetyState.DISARMED
                or clear.call(Trigger.Request(), repeatable=True).success
            ),
            PATIENCE,
        )
    assert result.outcome == PlayTurn.Result.OVER, result.message
    assert [list(shot.gone) for shot in result.shots] == [['8']]
    client.destroy_node()
