"""When a message was written, on the steady clock of the receiving process, and by whom."""

from collections.abc import Mapping
import math
import time
from typing import Any

from builtin_interfaces.msg import Time as TimeMessage
from rclpy.clock import Clock
from rclpy.node import Node

UNKNOWN_NODE = '_NODE_NAME_UNKNOWN_'
"""Name of a node in place of its own: a publisher is discovered earlier than its node's name."""


def written(info: Mapping[str, Any], now: float) -> float:
    """
    Time at which the publisher wrote a message, on the steady clock, which shows `now` [s].

    The source timestamp in the message info counts from 1970, so the clocks of the two machines
    must be synchronised. If the middleware gives no timestamp, the time is minus infinity.
    """
    source = info['source_timestamp']
    return now - 1e-9 * (time.time_ns() - source) if source else -math.inf


def publisher_of(info: Mapping[str, Any]) -> bytes:
    """Id that the middleware gives to the publisher of a message; empty if it gives none."""
    return (info.get('publisher_gid') or {}).get('data', b'')


def publishers_of(node: Node, topic: str) -> dict[bytes, str]:
    """Ids of the publishers of a topic, with the names of their nodes."""
    return {
        bytes(each.endpoint_gid): f'{each.node_namespace.rstrip("/")}/{each.node_name}'
        for each in node.get_publishers_info_by_topic(topic)
    }


def nanoseconds(stamp: TimeMessage) -> int:
    """Time of a stamp [ns]; rclpy.time.Time refuses negative stamps."""
    return 10**9 * stamp.sec + stamp.nanosec


def stamped(stamp: TimeMessage, clock: Clock, now: float) -> float:
    """
    Convert the stamp of a message to the steady clock [s].

    If there is no stamp, the result is infinity, which does not limit the time of writing.
    """
    time = nanoseconds(stamp)
    return now - 1e-9 * (clock.now().nanoseconds - time) if time else math.inf
