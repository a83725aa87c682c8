"""When a message was written, on the steady clock of the process that receives it."""

import math
import time

from rclpy.clock import Clock
from rclpy.time import Time


def written(info: dict[str, int], now: float) -> float:
    """
    Time at which the publisher wrote a message [s].

    Parameters
    ----------
    info : dict
        What rclpy gives a callback beside the message. Its source timestamp counts from 1970, so
        the clocks of the two machines must be synchronised.
    now : float
        Time of the steady clock [s].

    Returns
    -------
    float
        Time on the steady clock; minus infinity if the middleware does not tell.

    """
    source = info['source_timestamp']
    return now - 1e-9 * (time.time_ns() - source) if source else -math.inf


def stamped(stamp: Time, clock: Clock, now: float) -> float:
    """
    Time on the steady clock that the stamp in a message stands for [s].

    Infinity if there is no stamp: then the stamp does not limit the time of writing.
    """
    if stamp.nanoseconds == 0:
        return math.inf
    return now - 1e-9 * (clock.now().nanoseconds - stamp.nanoseconds)
