"""The command `robot`, which starts the nodes without the `ros2` command."""

import contextlib
import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.srv import PredictShot
from waiting import PATIENCE, PatientCaller, spin_until

NODES = ('predictor', 'planner', 'cue_driver', 'cue_sim', 'table_sim')


@pytest.fixture
def begin(domain):
    """Start `robot` in a process group of its own, in which nothing is left at the end."""
    begun = []

    def begin(space, *arguments):
        robot = [sys.executable, '-m', 'billiard_shot.ros.robot', *arguments]
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
