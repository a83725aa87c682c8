"""How a client waits for nodes and answers."""

import threading

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger
from waiting import PATIENCE

from billiard_shot.ros.client import NotReadyError, RobotClient


class AskedTooEarly:
    """Client of a service that comes up after the first request has been sent."""

    def __init__(self, come_up, real):
        self.come_up, self.real, self.requests = come_up, real, 0

    def call_async(self, request):
        future = self.real.call_async(request)
        self.requests += 1
        if self.requests == 1:
            self.come_up()
            assert self.real.wait_for_service(timeout_sec=PATIENCE)
        return future

    def __getattr__(self, name):
        return getattr(self.real, name)


@pytest.fixture
def come_up():
    """Function that starts the server of `late`."""
    server, executor = rclpy.create_node('late'), SingleThreadedExecutor()
    executor.add_node(server)
    thread = threading.Thread(target=executor.spin)

    def start():
        server.create_service(Trigger, 'late', lambda _, answer: answer)
        thread.start()

    yield start
    executor.shutdown()
    thread.join()
    server.destroy_node()


def test_a_request_of_a_client_that_may_be_repeated_is_sent_again(node, come_up):
    client = RobotClient('asking', '/early')
    late = AskedTooEarly(come_up, client.create_client(Trigger, '/late'))
    assert isinstance(client.call(late, Trigger.Request(), attempts=15), Trigger.Response)
    assert late.requests > 1
    client.destroy_node()


def test_a_wait_tells_a_node_that_is_missing_from_one_that_is_starting(node):
    client = RobotClient('waiting', '/slow', timeout=0.5)
    with pytest.raises(NotReadyError, match='/slow/planner: no such node is known so far; waited'):
        client.wait_for_planner()
    planner = rclpy.create_node('planner', namespace='/slow')
    with pytest.raises(NotReadyError, match='/slow/planner: the node is starting; waited for'):
        client.wait_for_planner()
    client.destroy_node()
    planner.destroy_node()


def test_a_waiting_callback_does_not_keep_a_client_busy(node):
    """As the callback of the goal of a turn, which waits for the result of the turn."""
    client, ended, looks = RobotClient('waits'), rclpy.Future(), []

    async def execute():
        await ended

    client.until(client.get_name, 0.0)
    task = client.executor.create_task(execute)
    try:
        client.until(lambda: looks.append(task.done()), 0.5)
        assert not any(looks)
        assert len(looks) < 100, 'a look each 50 ms'
    finally:
        ended.set_result(None)
        client.until(task.done, PATIENCE)
        client.destroy_node()
