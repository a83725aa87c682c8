"""Client of a service that waits for the answers."""

import rclpy

from billiard_shot.ros.node_runner import BURST


class Caller:
    """
    Client of a service, as an attribute, that waits for the answers.

    An answer is lost if the server has not yet discovered the client: a request that may be
    executed twice is sent again and again.
    """

    def __init__(self, node, kind, name):
        self._node = node
        self.client = node.create_client(kind, name, qos_profile=BURST)

    def call(self, request, repeatable=False):
        """Call the service, and return its answer; TimeoutError after 10 s."""
        for _ in range(5 if repeatable else 1):
            future = self.client.call_async(request)
            rclpy.spin_until_future_complete(
                self._node, future, timeout_sec=2.0 if repeatable else 10.0
            )
            if future.done():
                return future.result()
            self.client.remove_pending_request(future)
        raise TimeoutError(self.client.service_name)
