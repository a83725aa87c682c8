"""How every node of the package runs: until it is told to end, with an exit code that says how."""
from collections.abc import Callable, Sequence
from dataclasses import replace
import gc
import os
import signal
import sys

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from billiard_shot import predict, Scene, Stroke

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes later gets the last message too."""

EVERY_STATE = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""The same for states of which a slow listener must not miss any."""

AWAKE = 1.0
"""Seconds after which a node looks up from waiting, for a signal may come just before it waits."""


def warm_up(scene: Scene, other_balls: bool = False) -> None:
    """
    Predict once, so that compiling or loading the library does not fall to a request.

    `other_balls`: requests may have some, where the scene has none.
    """
    stroke = Stroke.from_offsets(a=0.2, b=0.1, elevation=0.1, azimuth=0.0, speed=1.0)
    predict(scene, stroke).trajectory.at(0.0)
    if other_balls and not scene.balls:
        predict(replace(scene, balls={'another': (1.0, 0.0)}), stroke)


def be_urgent(node: Node, niceness: int) -> None:
    """Run all threads of this process at a niceness; where that is not allowed, say so."""
    try:
        for thread in os.listdir('/proc/self/task'):
            os.setpriority(os.PRIO_PROCESS, int(thread), niceness)
    except OSError:
        node.get_logger().info(
            f'may not run at niceness {niceness}: other processes may delay a stop')


def run(make: Callable[[], Node], name: str, args: Sequence[str] | None) -> None:
    """
    Make a node and run it until SIGINT or SIGTERM; exit code 0 then.

    A bad parameter is one clear line and exit code 1.
    """
    told: list[int] = []
    starting = True

    def end(number: int, _: object) -> None:
        told.append(number)
        if starting:
            # Compiled code is being loaded, by callbacks from C that no exception gets through
            # alive; and nothing has begun that would have to be ended.
            os._exit(0)
        # Not KeyboardInterrupt: where that passes through code that was made by exec, as much of
        # NumPy's and numba's is, Python ends as if nobody had caught it.
        sys.exit(0)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    try:
        with rclpy.init(args=args):
            try:
                executor = SingleThreadedExecutor()
                executor.add_node(make())
                # What is there by now stays: to look through all of numba for garbage would stop
                # the node for a third of a second every now and then.
                gc.collect()
                gc.freeze()
                starting = False
                while rclpy.ok():
                    executor.spin_once(timeout_sec=AWAKE)
            except ExternalShutdownException:
                pass
            except Exception:
                # A signal may end in whatever is being done, as another error.
                if rclpy.ok() and not told:
                    raise
    except ParameterException as error:
        sys.exit(f'{name}: {error}')
