"""The node `shot_recorder`: writes shots of the robot as a recording for calibrations."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from billiard_shot_msgs.msg import Strike, TableState
from rclpy.node import Node

from billiard_shot.calibration.shot_log import ShotLog
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import check_frame, seconds, sightings_of
from billiard_shot.ros.cue_conversions import measured_stroke
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL


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
        strokes.

    """

    READ_ONLY: ClassVar = ('scene', 'file')
    scene: str = checked('paper', Scene.load)
    file: str = checked('shots.csv', _check_file)


class ShotRecorder(Node):
    """
    Node that writes shots to a file.

    A strike on the topic `cue_driver/strike` (billiard_shot_msgs/msg/Strike) begins a shot, with
    the balls on `table_state` (billiard_shot_msgs/msg/TableState) of the second before. The shot
    ends when no ball has moved for a second. Its parameters are `ShotRecorderParameters`.
    """

    def __init__(self) -> None:
        super().__init__('shot_recorder')
        parameters.declare(self, ShotRecorderParameters)
        own = parameters.read(ShotRecorderParameters, self)
        scene = Scene.load(own.scene)
        self._frame, self._radius = own.frame, scene.ball.radius
        self._curvature = scene.cue.tip_curvature_radius / scene.ball.radius
        self._log = ShotLog(Path(own.file), own.scene)
        self.create_subscription(TableState, 'table_state', self._see, LATCHED)
        self.create_subscription(Strike, 'cue_driver/strike', self._strike, 10)
        self.get_logger().info(f'ready: adds shots to {own.file}')

    def _see(self, message: TableState) -> None:
        try:
            check_frame('header.frame_id', message.header, self._frame)
            balls = sightings_of(message.balls, message.header.stamp)
        except ValueError as error:
            self.get_logger().warning(f'ignored a table state: {error}')
            return
        if shot := self._log.see(seconds(message.header.stamp), balls):
            self.get_logger().info(f'shot {shot!r} is recorded')

    def _strike(self, message: Strike) -> None:
        stamp = seconds(message.header.stamp)
        balls = self._log.seen_before(stamp)
        try:
            check_frame('header.frame_id', message.header, self._frame)
            if CUE_BALL not in balls:
                raise ValueError(f'ball {CUE_BALL!r} is not on the table')
            x, y = balls[CUE_BALL].position
            stroke = measured_stroke(message, (x, y, self._radius))
        except ValueError as error:
            self.get_logger().error(f'ignored a strike: {error}')
            return
        self._log.strike(message.shot_id, stamp, stroke.touching(self._curvature))


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(ShotRecorder, 'shot_recorder', args)


if __name__ == '__main__':
    main()
