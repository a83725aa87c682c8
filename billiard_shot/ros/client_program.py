"""Programs that ask the nodes: their common options, their signals and exit codes."""

import argparse
from collections.abc import Callable, Sequence
import gc
import signal
import sys
from typing import Any

from rclpy.signals import SignalHandlerOptions

from billiard_shot.ros.client import LOOK_PERIOD, NotReadyError, RobotClient, START_UP
from billiard_shot.ros.node_runner import initialized, steady_timer
from billiard_shot.ros.terminal import say
from billiard_shot.shot.stroke_options import add_stroke_arguments

PLAYED, SHOT_FAILED, NOT_READY = 0, 1, 3  # exit codes; argparse ends with 2

CLIENT_HELP = """\
exit codes:
  0  every shot was played, and reached its target if it has one; a turn was played, and the
     rack was not lost; with --serve, after Ctrl+C or SIGTERM
  1  a shot was refused, ended early, or missed its target; the output says why; later
     shots are not played
  2  the arguments are invalid
  3  a node is missing or not ready; the message names it
  130, 143  ended by Ctrl+C or SIGTERM; a shot that has not begun is cancelled

ROS arguments follow --ros-args, such as -r __ns:=/left_robot"""
"""End of the help of programs that ask the nodes."""


def add_client_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of all programs that ask the nodes for strokes."""
    add_stroke_arguments(parser)
    add = parser.add_argument
    scene = 'bundled scene or YAML file, for given strokes; the same as for the nodes (paper)'
    add('--scene', default='paper', metavar='SCENE', help=scene)
    wait = f'time to wait for each node in seconds ({START_UP:g})'
    add('--wait', type=float, default=START_UP, metavar='S', help=wait)


def run_client(
    name: str,
    args: Sequence[str] | None,
    work: Callable[[RobotClient], bool],
    *,
    serves: bool = False,
    **options: Any,
) -> None:
    """
    Do some work with a client, and exit with one of the codes of `CLIENT_HELP`.

    A client that `serves` is the node `name`, which ends with 0 after a signal. `options` are
    parameters of `RobotClient`.
    """
    caught: list[int] = []

    # A signal handler that raises SystemExit would sometimes do so within rclpy, which drops the
    # exception. So a timer exits between two callbacks.
    def end_if_caught() -> None:
        if caught:
            sys.exit(0 if serves else 128 + caught.pop())

    # The handlers of rclpy would shut down its context, and then no goal could be cancelled.
    with initialized(args, signal_handler_options=SignalHandlerOptions.NO):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, _: caught.append(number))
        try:
            client = RobotClient(name if serves else f'{name}_client', **options)
            steady_timer(client, LOOK_PERIOD, end_if_caught)
            gc.freeze()  # a long garbage collection would silence the safety inputs
            code = PLAYED if work(client) else SHOT_FAILED
        except NotReadyError as error:
            say(f'{name}: {error}', sys.stderr)
            code = NOT_READY
    sys.exit(code)
