"""Waiting for other processes, for as long as they may take on a starved machine."""

from functools import partial
from time import monotonic

import rclpy

from billiard_shot.ros import client

PATIENCE = 120.0
"""Seconds after which a test gives up: only a process that hangs takes that long."""

call = partial(client.call, timeout=PATIENCE)


def spin_until(node, condition, seconds=PATIENCE):
    """Spin until a condition is true; False if that takes too long."""
    deadline = monotonic() + seconds
    while not condition():
        if monotonic() > deadline:
            return False
        rclpy.spin_once(node, timeout_sec=0.05)
    return True
