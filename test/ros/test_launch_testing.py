"""
The launch file with the real launch: everything becomes ready, and everything ends.

It needs an installed package and launch_testing, of which PyPI has no wheel: run it with
`colcon test` in a workspace.
"""

from contextlib import ExitStack
import os
from pathlib import Path
import time
import unittest

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('launch_testing', reason='needs launch_testing')
pytest.importorskip('launch_ros', reason='needs launch_ros')

from domain_coordinator import domain_id
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, SetEnvironmentVariable
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_testing import post_shutdown_test
from launch_testing.actions import ReadyToTest
from launch_testing.asserts import assertExitCodes
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
import rclpy
from rclpy.executors import SingleThreadedExecutor

FILE = Path(__file__).resolve().parents[2] / 'launch' / 'shot.launch.py'
START_UP = 120.0  # s; the machine may be busy
HELD = ExitStack()  # until the process ends
DOMAIN = HELD.enter_context(domain_id())
NODES = {'predictor', 'planner', 'table_display', 'cue_driver', 'cue_sim', 'table_sim'}


@pytest.mark.launch_test
def generate_test_description():
    return LaunchDescription(
        [
            SetEnvironmentVariable('ROS_DOMAIN_ID', str(DOMAIN)),
            SetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST'),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(FILE)),
                launch_arguments={
                    'simulate': 'true',
                    'namespace': 'cell1',
                    'frame': 'cell1/table',
                }.items(),
            ),
            ReadyToTest(),
        ]
    )


class TestRunning(unittest.TestCase):
    def test_the_driver_becomes_active(self):
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=DOMAIN)
        node = rclpy.create_node('tester', context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        client = node.create_client(GetState, '/cell1/cue_driver/get_state')
        deadline = time.monotonic() + START_UP
        state = None
        while state != State.PRIMARY_STATE_ACTIVE and time.monotonic() < deadline:
            if client.wait_for_service(timeout_sec=1.0):
                future = client.call_async(GetState.Request())
                executor.spin_until_future_complete(future, timeout_sec=5.0)
                state = future.result().current_state.id if future.done() else None
        node.destroy_node()
        rclpy.shutdown(context=context)
        assert state == State.PRIMARY_STATE_ACTIVE


@post_shutdown_test()
class TestEnded(unittest.TestCase):
    def test_every_node_ended_with_exit_code_0(self, proc_info):
        assertExitCodes(proc_info)
        started = {name.rpartition('-')[0] for name in proc_info.process_names()}
        assert started >= NODES

    def test_no_process_is_left(self, proc_info):
        for process in proc_info:
            with pytest.raises(ProcessLookupError):
                os.kill(process.pid, 0)
