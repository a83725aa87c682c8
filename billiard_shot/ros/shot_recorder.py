"""The node `shot_recorder`: writes shots of the robot as a recording for calibrations."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math
from pathlib import Path
import sys
from time import monotonic
from typing import ClassVar

from billiard_shot_msgs.msg import Strike, TableState
from rclpy.node import Node

from billiard_shot.calibration.shot_log import ShotLog, ShotLostError, Written
from billiard_shot.ros import conversions, parameters
from billiard_shot.ros.node_runner import LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL

MAX_GAP = 0.05
"""Largest distance of the tip from the ball at a strike [m]."""

SILENCE = 2.0
"""Time without a picture after which a shot is over [s]."""


def _check_file(name: str) -> None:
    """Raise ValueError if a recording cannot be written to a file."""
    path = Path(name)
    if path.suffix != '.csv' or not path.absolute().parent.is_dir():
        raise ValueError(f'file must be a file .csv in a folder that exists, got {name!r}')


@dataclass(frozen=True)
class ShotRecorderParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Ball and tip, for the strokes: name of a bundled scene, or path of a YAML file.
    file : str
        Recording to which shots are added. The file of the same name that ends in .yaml gets their
        strokes. If they are not a recording of this scene, the node ends.

    """

    READ_ONLY: ClassVar = ('scene', 'file')
    scene: str = checked('paper', Scene.load)
    file: str = checked('robot_shots.csv', _check_file)


class ShotRecorder(Node):
    """
    Node that writes shots to a file.

    A strike on the topic `cue_driver/strike` (billiard_shot_msgs/msg/Strike) begins a shot, with
    the balls on `table_state` (billiard_shot_msgs/msg/TableState) of the second before. The shot
    ends when no ball has moved for a second. If it ends earlier, because the pictures or the node
    end, or the clock is set back, it is written as far as it was seen, and the log says so. A
    strike past the ball is no shot. Its parameters are `ShotRecorderParameters`.
    """

    def __init__(self) -> None:
        super().__init__('shot_recorder')
        parameters.declare(self, ShotRecorderParameters)
        own = parameters.values_of(ShotRecorderParameters, self)
        scene = Scene.load(own.scene)
        self._frame, self._radius = own.frame, scene.ball.radius
        self._curvature = scene.cue.tip_curvature_radius / scene.ball.radius
        try:
            self._log = ShotLog(Path(own.file), own.scene)
        except ValueError as error:
            sys.exit(f'shot_recorder: file: {error}')
        self._heard = 0.0  # steady time of the last picture [s]
        self._last = ''  # the last strike, which may be repeated
        steady_timer(self, 0.5 * SILENCE, self._listen)
        self.create_subscription(TableState, 'table_state', self._see, LATCHED)
        self.create_subscription(Strike, 'cue_driver/strike', self._strike, 10)
        self.get_logger().info(f'ready: adds shots to {own.file}')

    def _see(self, message: TableState) -> None:
        try:
            conversions.check_frame('header.frame_id', message.header, self._frame)
            balls = conversions.sightings_of(message.balls, message.header.stamp)
            now = 1e-9 * self.get_clock().now().nanoseconds
            time = conversions.picture_time(message.header.stamp, now)
        except ValueError as error:
            self.get_logger().warning(f'ignored a table state: {error}')
            return
        self._heard = monotonic()
        self._report(lambda: self._log.see(time, balls))

    def _listen(self) -> None:
        """End a shot if there are no more pictures."""
        if self._log.is_open and monotonic() - self._heard > SILENCE:
            self.finish(f'there was no table state for {SILENCE:g} s')

    def finish(self, why_early: str) -> None:
        """Write the shot that is not over, if there is one."""
        self._report(lambda: self._log.finish(why_early))

    def _report(self, write: Callable[[], Written | None]) -> None:
        """Log what is written, or why it cannot be."""
        try:
            written = write()
        except ShotLostError as error:
            self.get_logger().error(str(error))
            return
        if written and written.why_early:
            self.get_logger().warning(
                f'shot {written.shot!r} is recorded, but not to its end: {written.why_early}'
            )
        elif written:
            self.get_logger().info(f'shot {written.shot!r} is recorded')

    def _strike(self, message: Strike) -> None:
        stamp = conversions.seconds(message.header.stamp)
        if (strike := f'{stamp} {message.shot_id}') == self._last:
            return
        self._last = strike
        balls = self._log.seen_before(stamp)
        try:
            conversions.check_frame('header.frame_id', message.header, self._frame)
            if CUE_BALL not in balls:
                raise ValueError(f'ball {CUE_BALL!r} is not on the table')
            centre = (*balls[CUE_BALL].position, self._radius)
            stroke = conversions.measured_stroke(message, centre)
            if stroke.miss:
                raise ValueError(f'cue_pose: {stroke.miss}')
            gap = math.dist(conversions.xyz(message.cue_pose.position), centre) - self._radius
            if not gap <= MAX_GAP:
                raise ValueError(
                    f'cue_pose.position must be within {MAX_GAP:g} m of the ball, got {gap:.3g} m'
                )
        except ValueError as error:
            self.get_logger().error(f'ignored a strike: {error}')
            return
        self.finish('the next one has begun')
        name = self._log.strike(message.shot_id, stamp, stroke.touching(self._curvature))
        if name != message.shot_id:
            self.get_logger().warning(
                f'there is a shot {message.shot_id!r}: this one is recorded as {name!r}'
            )


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(ShotRecorder, 'shot_recorder', args, lambda node: node.finish('the node has ended'))
