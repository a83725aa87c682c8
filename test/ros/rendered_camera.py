"""A node that publishes rendered pictures of the topic `simulated_table`, as a camera above it."""

from array import array
from dataclasses import replace
from pathlib import Path
import sys

from billiard_shot_msgs.msg import BallState, TableState
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from billiard_shot import Scene
from billiard_shot.ros.node_runner import LATCHED

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'film'))
from rendered import Filming, OVERHEAD, Painter, Placed

PERIOD = 0.25
SMALL = replace(OVERHEAD, size=(640, 360), focal=546.5)
NAMES = ['cue', *map(str, range(1, 16))]


def painter_of(scene):
    """Paint balls that lie where they are put."""
    filming = Filming(SMALL, hand=False, readout=0, cloth='pool')
    return Painter(scene, Placed(NAMES, scene.ball.radius), filming)


def image_of(picture, stamp):
    """Message of a picture."""
    height, width = picture.shape[:2]
    return Image(
        header=Header(frame_id='camera', stamp=stamp),
        height=height,
        width=width,
        step=3 * width,
        encoding='rgb8',
        data=array('B', picture.tobytes()),
    )


class RenderedCamera(Node):
    def __init__(self):
        super().__init__('rendered_camera')
        self.painter = painter_of(Scene.load('robot_table'))
        self.images = self.create_publisher(Image, 'image', 1)
        self.stamp = None  # of balls that no picture has shown
        self.create_subscription(TableState, 'simulated_table', self.look, LATCHED)
        self.create_timer(PERIOD, self.see)

    def look(self, table):
        self.stamp = table.header.stamp  # a busy simulation must not look as if balls rested
        self.painter.motion.put(
            {
                ball.id: (ball.position.x, ball.position.y)
                for ball in table.balls
                if ball.state == BallState.ON_TABLE
            }
        )

    def see(self):
        if self.stamp:
            self.images.publish(image_of(self.painter.at(0.0), self.stamp))
            self.stamp = None


if __name__ == '__main__':
    rclpy.init()
    rclpy.spin(RenderedCamera())
