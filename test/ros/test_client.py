"""Asking a service that does not answer."""
import threading

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

from billiard_shot.ros.client import call


@pytest.fixture
def late(node):
    """Return a client of a service that comes up a second after it is asked for."""
    server, executor = rclpy.create_node('late'), SingleThreadedExecutor()

    def come_up():
        server.create_service(Trigger, 'late', lambda _, answer: answer)
        executor.add_node(server)
        executor.spin()

    timer = threading.Timer(1.0, come_up)
    timer.start()
    yield node.create_client(Trigger, 'late')
    executor.shutdown()
    timer.join()
    server.destroy_node()


def test_a_request_that_gets_lost_is_sent_anew_where_that_is_harmless(node, late):
    assert isinstance(call(node, late, Trigger.Request(), repeatable=True), Trigger.Response)


def test_a_request_is_sent_once_where_it_may_do_harm(node, late):
    with pytest.raises(TimeoutError, match='no answer from /late'):
        call(node, late, Trigger.Request(), timeout=3.0)
