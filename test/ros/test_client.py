"""Asking a service that does not answer."""

import threading

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger
from waiting import PATIENCE

from billiard_shot.ros import client
from billiard_shot.ros.client import call


class AskedTooEarly:
    """Client of a service that comes up after the first request has been sent."""

    def __init__(self, node, come_up):
        self.client, self.come_up = node.create_client(Trigger, 'late'), come_up
        self.requests = 0

    def call_async(self, request):
        future = self.client.call_async(request)
        self.requests += 1
        if self.requests == 1:
            self.come_up()
            assert self.client.wait_for_service(timeout_sec=PATIENCE)
        return future

    def __getattr__(self, name):
        return getattr(self.client, name)


class NeverDiscovered:
    """Client whose requests get no answer, because the server never learns of the client."""

    def __init__(self, node):
        self.client = node.create_client(Trigger, 'late')

    def call_async(self, request):
        return rclpy.Future()

    def remove_pending_request(self, future):
        pass

    def __getattr__(self, name):
        return getattr(self.client, name)


@pytest.fixture
def late(node):
    server, executor = rclpy.create_node('late'), SingleThreadedExecutor()
    executor.add_node(server)
    thread = threading.Thread(target=executor.spin)

    def come_up():
        server.create_service(Trigger, 'late', lambda _, answer: answer)
        thread.start()

    yield AskedTooEarly(node, come_up)
    executor.shutdown()
    thread.join()
    server.destroy_node()


def test_a_lost_request_is_sent_again_if_it_is_repeatable(node, late):
    answer = call(node, late, Trigger.Request(), timeout=PATIENCE, repeatable=True)
    assert isinstance(answer, Trigger.Response)
    assert late.requests > 1


def test_other_requests_are_sent_once(node, late):
    with pytest.raises(TimeoutError, match='no answer from /late'):
        call(node, late, Trigger.Request(), timeout=1.0)
    assert late.requests == 1


def test_a_new_client_asks_if_the_server_never_discovers_the_first_one(node, late, monkeypatch):
    monkeypatch.setattr(client, 'RETRY_PERIOD', 0.5)
    monkeypatch.setattr(client, 'RENEWAL_PERIOD', 2.0)
    late.come_up()
    clients = len(list(node.clients))
    unheard = NeverDiscovered(node)
    answer = call(node, unheard, Trigger.Request(), timeout=PATIENCE, repeatable=True)
    assert isinstance(answer, Trigger.Response)
    assert len(list(node.clients)) == clients + 1  # the one that was never discovered
    node.destroy_client(unheard.client)
