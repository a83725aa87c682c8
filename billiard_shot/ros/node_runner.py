"""Runs a node until a signal ends it; when messages were written, and by whom."""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
import contextlib
import gc
import inspect
import math
import os
import re
import signal
import sys
import threading
import time
from time import sleep
from typing import Any, TypeAlias, TypeVar

from builtin_interfaces.msg import Time as TimeMessage
import rclpy
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.timer import Timer
from rclpy.utilities import remove_ros_args

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


N = TypeVar('N', bound=Node)
GoalHandle: TypeAlias = 'ServerGoalHandle[Any, Any, Any]'

# QoS of latched topics: late subscribers receive the last messages.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
EVERY_STATE = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)

SAFETY_INPUT = QoSProfile(depth=100)
"""
QoS of `estop` and `interlock`.

A short press of a button is not lost if the driver pauses, as long as the publisher keeps the
message: its own depth, 10 by default, counts from the press to the end of the pause. A queued
message does not become fresh: its age counts from the time of writing.
"""

JOINT_STATES = QoSProfile(depth=100)
"""
QoS of `joint_states`: a strike is measured from a series of only a few messages.

At this depth no message is lost if the reader or writer pauses for half a second, at up to 200 Hz.
A deeper queue would delay all messages if more arrive than the driver can read.
"""

BURST = QoSProfile(depth=2000)
"""
QoS of services and actions: of requests that are sent at the same time, none is lost up to this.

The middleware drops requests and answers beyond the depth without a sign. At the server the depth
counts the requests of all clients. At a client it counts the answers to all clients, because Fast
DDS sends every answer to every client of the service, which discards those of the others.
"""

END_TIME = 8.0  # s from a signal to the end of a node, even if a callback does not return


def own_arguments(args: Sequence[str] | None) -> list[str]:
    """
    Return the arguments of a program that are not ROS arguments.

    If the ROS arguments or a file of parameters cannot be read, exit with one line.
    """
    given = sys.argv if args is None else ['', *args]
    try:
        return list(remove_ros_args(given)[1:])
    except RuntimeError as error:  # of rcl, with the places in its source
        reason = ' '.join(re.sub(r', at \S+:\d+', '', str(error)).split())
        sys.exit(f'ROS arguments: {reason}')


def parser_of(
    name: str, docstring: str | None, epilog: str, usage: str | None = None
) -> argparse.ArgumentParser:
    """Make the argument parser of a program that `ros2 run` starts."""
    return argparse.ArgumentParser(
        prog=name,
        usage=usage,
        description=(docstring or '').strip().partition('\n')[0],
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


@contextlib.contextmanager
def initialized(args: Sequence[str] | None = None, **options: Any) -> Iterator[None]:
    """
    Initialize rclpy with `options`, and shut it down at the end.

    `with rclpy.init()` does the same, but not on Jazzy, where `init` returns None.
    """
    rclpy.init(args=None if args is None else list(args), **options)
    try:
        yield
    finally:
        rclpy.try_shutdown()


def steady_timer(
    node: Node, period: float, callback: Callable[[], None], autostart: bool = True
) -> Timer:
    """Make a timer of a node that keeps to the steady clock, whatever sets the ROS clock."""
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    return node.create_timer(period, callback, clock=clock, autostart=autostart)


def in_thread(node: Node, work: Callable[[], Any]) -> Any:
    """
    Do some work in a thread, while the node answers other requests.

    The future is for `await` in a callback of the node; an exception of `work` is raised there.
    """
    executor = node.executor
    assert executor is not None
    ended: Future[Any] = Future(executor=executor)

    def do() -> None:
        try:
            ended.set_result(work())
        except Exception as error:
            ended.set_exception(error)
        executor.wake()  # it looks at waiting callbacks only when something happens

    threading.Thread(target=do, daemon=True).start()
    return ended


class EndError(RuntimeError):
    """Ends the node with exit code 1, so that a launch starts it again; the message says why."""


def set_niceness(node: Node, niceness: int) -> None:
    """Set the niceness of all threads of this process; log if that is not allowed."""
    try:
        for thread in os.listdir('/proc/self/task'):
            os.setpriority(os.PRIO_PROCESS, int(thread), niceness)
    except OSError:
        node.get_logger().info(
            f'niceness {niceness} is not permitted: other processes may delay a stop'
        )


def spin_node(
    make: Callable[[], N],
    name: str,
    args: Sequence[str] | None,
    leave: Callable[[N], object] = lambda node: None,
    survive: Callable[[N, Exception], object] | None = None,
) -> None:
    """
    Make a node and run it until SIGINT or SIGTERM; then call `leave` and exit with code 0.

    The middleware still works while `leave` runs. If a callback raises an exception, call
    `survive` and go on; without `survive`, the node ends. If a callback raises EndError, or after
    a bad parameter, print one line and exit with code 1. `--help` and other arguments that are
    not ROS arguments do not start the node. If a callback does not return within `END_TIME` of a
    signal, exit with code 1.
    """
    parser_of(
        name,
        inspect.getdoc(inspect.getmodule(make)),
        f'Parameters: config/{name}.yaml, and `ros2 param describe` while the node runs.',
        usage='%(prog)s [-h] [--ros-args -p PARAMETER:=VALUE -r NAME:=NAME ...]',
    ).parse_args(own_arguments(args))
    ending = threading.Event()
    executor: Executor | None = None
    code: int | None = None
    received, written = os.pipe()
    os.set_blocking(written, False)
    signal.set_wakeup_fd(written)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)

    def end_after_signal() -> None:
        os.read(received, 1)
        ending.set()
        if executor is None:
            os._exit(0)  # nothing has been started yet that would have to be ended
        executor.create_task(lambda: None)  # ends the wait
        sleep(END_TIME)
        sys.stderr.write(f'{name}: a callback has not returned {END_TIME:g} s after a signal\n')
        os._exit(1)

    threading.Thread(target=end_after_signal, daemon=True).start()
    try:
        with initialized(args, signal_handler_options=SignalHandlerOptions.NO):
            node = make()
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            # Objects created so far are permanent. Searching all of them for garbage would stop
            # the node for some hundredths of a second from time to time.
            gc.collect()
            gc.freeze()
            try:
                while not ending.is_set():
                    try:
                        executor.spin_once()
                    except ExternalShutdownException:
                        break
                    except EndError as error:
                        node.get_logger().fatal(str(error))
                        code = 1
                        break
                    except Exception as error:
                        if survive is None:
                            raise
                        survive(node, error)
            finally:
                leave(node)
    except ParameterException as error:
        sys.exit(f'{name}: {error}')
    finally:
        if code is not None or ending.is_set():
            # rclpy is shut down. On Jazzy the middleware sometimes crashes when Python exits.
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code or 0)
