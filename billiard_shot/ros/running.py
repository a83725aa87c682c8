"""How every node of the package runs: until it is told to end, with an exit code that says how."""

from collections.abc import Callable, Iterator, Sequence
import contextlib
from dataclasses import replace
import gc
import os
import signal
import sys
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from billiard_shot import machine_code, predict, Scene, Stroke

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes later gets the last message too."""

EVERY_STATE = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""The same for states of which a slow listener must not miss any."""

AWAKE = 1.0
"""Seconds after which a node looks up from waiting, for a signal may come just before it waits."""

PROGRESS = 5.0
"""Seconds between two looks whether the library is compiled."""


@contextlib.contextmanager
def initialized(args: Sequence[str] | None = None, **options: Any) -> Iterator[None]:
    """
    Initialize rclpy with `options`, and shut it down in the end.

    `with rclpy.init()` does the same, but not on Jazzy, where `init` returns None.
    """
    rclpy.init(args=args, **options)
    try:
        yield
    finally:
        rclpy.try_shutdown()


def warm_up(node: Node, scene: Scene, other_balls: bool = False, compiles: bool = True) -> None:
    """
    Load what the first request would wait for.

    If the library is not compiled yet, the node interprets it at first and compiles it in other
    processes, with a low priority.

    Parameters
    ----------
    node : Node
    scene : Scene
    other_balls : bool
        Requests may have other balls, where the scene has none.
    compiles : bool
        Whether it compiles. A node that must never be late leaves that to others.

    """
    log = node.get_logger()
    if machine_code.available() and machine_code.is_complete():
        machine_code.require()
    elif machine_code.available() and compiles:
        machine_code.prepare()
        log.info('compiling the library in the background, once; answers are slower meanwhile')
        node.create_timer(PROGRESS, Said(node), clock=Clock(clock_type=ClockType.STEADY_TIME))
    stroke = Stroke.from_offsets(a=0.2, b=0.1, elevation=0.1, azimuth=0.0, speed=1.0)
    predict(scene, stroke).trajectory.at(0.0)
    if other_balls and not scene.balls:
        predict(replace(scene, balls={'another': (1.0, 0.0)}), stroke)


def wait_for_machine_code(node: Node) -> None:
    """Wait until the library is compiled, and log again and again for how long."""
    said = 0.0

    def report(done: int, total: int, waited: float) -> None:
        nonlocal said
        if waited - said >= PROGRESS:
            said = waited
            node.get_logger().info(
                f'compiling the library, once: {done} of {total} parts after {waited:.0f} s'
            )

    machine_code.require(report)


class Said:
    """Says once that the library is compiled."""

    def __init__(self, node: Node) -> None:
        self.node, self.over = node, False

    def __call__(self) -> None:
        """Look whether it is."""
        if not self.over and machine_code.is_loaded():
            self.over = True
            self.node.get_logger().info('the library is compiled')


def be_urgent(node: Node, niceness: int) -> None:
    """Run all threads of this process at a niceness; where that is not allowed, say so."""
    try:
        for thread in os.listdir('/proc/self/task'):
            os.setpriority(os.PRIO_PROCESS, int(thread), niceness)
    except OSError:
        node.get_logger().info(
            f'may not run at niceness {niceness}: other processes may delay a stop'
        )


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
        with initialized(args):
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
    finally:
        if told:
            # rclpy is shut down. On Jazzy the middleware sometimes crashes as Python ends.
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(0)
