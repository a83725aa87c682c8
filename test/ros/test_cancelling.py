"""A client that is cancelled leaves no goal behind."""

import threading
import time

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from action_msgs.msg import GoalStatusArray
from billiard_shot_msgs.action import ExecuteShot
import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from waiting import PATIENCE

from billiard_shot.ros.client import CanceledError, NotReadyError, RobotClient


def test_a_goal_is_cancelled_that_is_not_answered_yet(node):
    """Before, the driver aimed such a shot, and refused the next one."""
    driver = rclpy.create_node('cue_driver', namespace='/hasty')
    asked, cancelled = threading.Event(), threading.Event()

    def accept(_):
        asked.set()
        time.sleep(1.0)
        return GoalResponse.ACCEPT

    def play(goal):
        while not goal.is_cancel_requested:
            time.sleep(0.01)
        goal.canceled()
        cancelled.set()
        return ExecuteShot.Result()

    server = ActionServer(
        driver,
        ExecuteShot,
        'execute_shot',
        play,
        callback_group=ReentrantCallbackGroup(),
        goal_callback=accept,
        cancel_callback=lambda _: CancelResponse.ACCEPT,
    )
    executor = MultiThreadedExecutor(3)
    executor.add_node(driver)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    client = RobotClient('player', '/hasty')
    assert client.execute_shot.wait_for_server(PATIENCE)

    def cancel():
        asked.wait(PATIENCE)
        client.is_canceled = True

    threading.Thread(target=cancel, daemon=True).start()
    with pytest.raises(CanceledError):
        client.execute(ExecuteShot.Goal())
    assert cancelled.wait(PATIENCE)
    executor.shutdown()
    spinning.join(PATIENCE)
    server.destroy()
    driver.destroy_node()
    client.destroy_node()


def test_a_client_whose_driver_ends_is_told(node):
    """Not if a driver that was killed before is no longer listed."""
    killed = node.create_publisher(GoalStatusArray, '/mortal/execute_shot/_action/status', 10)
    driver = rclpy.create_node('cue_driver', namespace='/mortal')
    executor = MultiThreadedExecutor(3)
    aimed, alone, ending = (threading.Event() for _ in range(3))

    def play(goal):
        aimed.set()
        ending.wait(PATIENCE)
        return ExecuteShot.Result()

    server = ActionServer(
        driver, ExecuteShot, 'execute_shot', play, callback_group=ReentrantCallbackGroup()
    )
    executor.add_node(driver)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    client = RobotClient('player', '/mortal')
    assert client.execute_shot.wait_for_server(PATIENCE)

    def end():
        aimed.wait(PATIENCE)
        time.sleep(1.0)
        node.destroy_publisher(killed)
        time.sleep(1.0)
        alone.set()
        server.destroy()
        driver.destroy_node()
        ending.set()

    threading.Thread(target=end, daemon=True).start()
    with pytest.raises(NotReadyError, match='action execute_shot: its node has ended'):
        client.execute(ExecuteShot.Goal())
    assert alone.is_set()
    executor.shutdown()
    spinning.join(PATIENCE)
    client.destroy_node()
