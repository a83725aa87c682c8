"""Waiting for other processes, for as long as they may take on a starved machine."""

from functools import partial
import time
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.node import Node

from billiard_shot.ros.node_runner import BURST

PATIENCE = 120.0
"""Seconds after which a test gives up: only a process that hangs takes that long."""

RETRY_PERIOD = 2.0
"""Time without an answer after which a repeatable request is sent again [s]."""

RENEWAL_PERIOD = 20.0
"""
Time without an answer after which a new client replaces the one that asked [s].

On busy machines with Fast DDS 3.2, a server sometimes never discovers a client. A new client is
announced again.
"""


class PatientCaller:
    """
    Client of a service of a process that may be starved; it waits for the answers.

    Attributes
    ----------
    client : Client
        Client in use; another one may replace it during a call.

    """

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        self._node = node
        self._make = partial(node.create_client, kind, name, qos_profile=BURST)
        self.client: Client[Any, Any] = self._make()

    def wait_for_service(self, timeout: float = PATIENCE) -> bool:
        return self.client.wait_for_service(timeout)

    def call(self, request: Any, timeout: float = PATIENCE, repeatable: bool = False) -> Any:
        """
        Call the service, and return its answer.

        Parameters
        ----------
        request
            Request message.
        timeout : float
            Time to wait for an answer [s].
        repeatable : bool
            Whether the request may be executed twice. It is then sent again if there is no answer.
            The answer is lost if the server has not yet discovered the client, even if the client
            has discovered the server (github.com/ros2/rmw_fastrtps/issues/842). If the server
            does not discover the client at all, a new client replaces it.

        Raises
        ------
        TimeoutError
            If there is no answer within `timeout`.

        """
        begin = since = time.monotonic()
        while (left := begin + timeout - time.monotonic()) > 0.0:
            future = self.client.call_async(request)
            rclpy.spin_until_future_complete(
                self._node, future, timeout_sec=min(left, RETRY_PERIOD) if repeatable else left
            )
            if future.done():
                return future.result()
            self.client.remove_pending_request(future)
            if time.monotonic() - since >= RENEWAL_PERIOD:
                since = time.monotonic()
                self._node.destroy_client(self.client)
                self.client = self._make()
        raise TimeoutError(f'no answer from {self.client.service_name} within {timeout} s')


def spin_until(node, condition, seconds=PATIENCE):
    """Spin until a condition is true; False if that takes too long."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        rclpy.spin_once(node, timeout_sec=0.05)
    return True
