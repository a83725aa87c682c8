"""Waiting for other processes, for as long as they may take on a starved machine."""

from time import monotonic

import rclpy

from billiard_shot.ros.service_caller import ServiceCaller

PATIENCE = 120.0
"""Seconds after which a test gives up: only a process that hangs takes that long."""


class PatientCaller(ServiceCaller):
    """Client of a service of a process that may be starved."""

    def wait_for_service(self, timeout=PATIENCE):
        return self.client.wait_for_service(timeout)

    def call(self, request, timeout=PATIENCE, repeatable=False):
        return super().call(request, timeout, repeatable)


def spin_until(node, condition, seconds=PATIENCE):
    """Spin until a condition is true; False if that takes too long."""
    deadline = monotonic() + seconds
    while not condition():
        if monotonic() > deadline:
            return False
        rclpy.spin_once(node, timeout_sec=0.05)
    return True
