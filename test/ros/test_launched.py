"""What the launch file starts works, as real processes; launch itself is recorded only."""

import os
import signal
import subprocess
import sys
from time import monotonic

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from recorded_launch import started
from waiting import PATIENCE, PatientCaller, spin_until
import yaml


@pytest.fixture
def launched(domain, launch_file, tmp_path):
    """Processes of all nodes of a robot in a namespace, as launch would start them."""
    nodes = started(
        launch_file,
        simulate='true',
        scene='robot_table',
        namespace='cell5',
        frame='cell5/table',
        log_level='info',
    )
    processes = {}
    for name, node in nodes.items():
        settings = tmp_path / f'{name}.yaml'
        settings.write_text(yaml.safe_dump({'/**': {'ros__parameters': node.settings}}))
        files = [word for file in (*node.files, settings) for word in ('--params-file', str(file))]
        processes[name] = subprocess.Popen(
            [
                *node.prefix.split(),
                sys.executable,
                '-m',
                'billiard_shot.ros',
                name,
                *node.arguments,
                '--ros-args',
                '-r',
                f'__ns:=/{node.namespace}',
                *files,
            ]
        )
    yield processes
    for process in processes.values():
        process.kill()
        process.wait()


def subscribe(node, diagnostics):
    """Collect the diagnostics of all nodes."""
    node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: diagnostics.extend(message.status), 10
    )


def test_a_robot_in_a_namespace_becomes_ready_and_ends(node, launched):
    diagnostics = []
    subscribe(node, diagnostics)
    client = PatientCaller(node, GetState, '/cell5/cue_driver/get_state')
    assert client.wait_for_service()

    def is_active():
        answer = client.call(GetState.Request(), repeatable=True)
        return answer.current_state.id == State.PRIMARY_STATE_ACTIVE

    assert spin_until(node, is_active)
    deadline = monotonic() + PATIENCE

    def is_heard():
        return any(each.name == '/cell5/cue_driver' for each in diagnostics)

    # On a machine without a free core the middleware may fail to connect a subscription for good.
    while not spin_until(node, is_heard, seconds=10):
        assert monotonic() < deadline, 'the driver publishes no diagnostics'
        subscribe(node, diagnostics)
    assert {each.hardware_id for each in diagnostics if each.name == '/cell5/cue_driver'} == {
        '/cell5/mechanical_cue'
    }
    wanted = {(name, '/cell5') for name in launched}

    def ended():
        return [name for name, process in launched.items() if process.poll() is not None]

    assert spin_until(node, lambda: ended() or wanted <= set(node.get_node_names_and_namespaces()))
    assert not ended()
    for process in launched.values():
        os.kill(process.pid, signal.SIGINT)
    assert {process.wait(timeout=PATIENCE) for process in launched.values()} == {0}
