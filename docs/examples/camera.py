"""A camera above the table, which publishes the balls that it sees in a frame of its own."""

from billiard_shot_msgs.msg import BallState, TableState
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

HEIGHT = 1.5  # m above the cloth; x is that of the table, y and z are turned by 180 degrees
NOISE = 5e-4  # m, standard deviation of a coordinate
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Camera(Node):
    def __init__(self):
        super().__init__('camera')
        self.random = np.random.default_rng(0)
        self.table = TableState()
        self.create_subscription(TableState, 'simulated_table', self.look, LATCHED)
        self.detections = self.create_publisher(Detection3DArray, 'detections', 10)
        self.transforms = self.create_publisher(TFMessage, '/tf_static', LATCHED)
        place = TransformStamped(header=Header(frame_id='table'), child_frame_id='camera')
        turn = Quaternion(x=1.0, w=0.0)
        place.transform = Transform(translation=Vector3(z=HEIGHT), rotation=turn)
        self.transforms.publish(TFMessage(transforms=[place]))
        self.create_timer(1 / 30, self.see)

    def look(self, table):  # your camera takes a picture
        self.table = table

    def balls(self):  # your vision finds names and centres, in the frame of the camera [m]
        for ball in self.table.balls:
            if ball.state == BallState.ON_TABLE:
                centre = (ball.position.x, -ball.position.y, HEIGHT - ball.position.z)
                yield ball.id, centre + self.random.normal(0.0, NOISE, 3)

    def see(self):
        stamp = self.get_clock().now().to_msg()  # of the exposure, not of the end of the vision
        message = Detection3DArray(header=Header(frame_id='camera', stamp=stamp))
        for name, (x, y, z) in self.balls():
            found = ObjectHypothesisWithPose()
            found.hypothesis.class_id, found.hypothesis.score = name, 1.0
            found.pose.pose.position = Point(x=x, y=y, z=z)
            found.pose.covariance = np.diag([NOISE**2] * 3 + [0.0] * 3).ravel()
            message.detections.append(Detection3D(header=message.header, results=[found]))
        self.detections.publish(message)


if __name__ == '__main__':
    rclpy.init()
    rclpy.spin(Camera())
