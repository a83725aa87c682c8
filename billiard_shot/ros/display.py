"""A predicted trajectory as RViz shows it: a path, and markers coloured by what the ball does."""
from billiard_shot_msgs.msg import BallTrajectory
from builtin_interfaces.msg import Time as Stamp
from geometry_msgs.msg import Point, PoseStamped, Vector3
from nav_msgs.msg import Path
import numpy as np
from rclpy.time import Time
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.ros.conversions import FRAME, vectors

COLOURS = {
    BallTrajectory.REST: ColorRGBA(r=0.6, g=0.6, b=0.6, a=1.0),
    BallTrajectory.SLIDE: ColorRGBA(r=0.9, g=0.4, b=0.1, a=1.0),
    BallTrajectory.ROLL: ColorRGBA(r=0.1, g=0.7, b=0.2, a=1.0),
    BallTrajectory.SPIN: ColorRGBA(r=0.6, g=0.3, b=0.8, a=1.0),
    BallTrajectory.FLIGHT: ColorRGBA(r=0.1, g=0.5, b=0.9, a=1.0),
    BallTrajectory.POCKETED: ColorRGBA(r=0.1, g=0.1, b=0.1, a=1.0),
    BallTrajectory.OFF_TABLE: ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0),
}

LAST_SECOND = 2**31 - 1
"""Largest second that fits into a stamp; a shot absurd enough may last beyond it."""


def path_of(trajectory: BallTrajectory, stamp: Stamp) -> Path:
    """Path whose poses carry the times of the samples, as if the strike ended at `stamp`."""
    start = Time.from_msg(stamp).nanoseconds
    path = Path(header=Header(frame_id=FRAME, stamp=stamp))
    for time, point in zip(trajectory.times, _points(trajectory), strict=True):
        pose = PoseStamped()
        pose.header.frame_id = FRAME
        nanoseconds = min(start + round(min(time, LAST_SECOND) * 1e9), LAST_SECOND * 10**9)
        pose.header.stamp = Time(nanoseconds=nanoseconds).to_msg()
        pose.pose.position = point
        path.poses.append(pose)
    return path


def markers_of(trajectory: BallTrajectory, radius: float, stamp: Stamp) -> MarkerArray:
    """Line of the ball's centre, and the ball (radius in metres) where it starts and rests."""
    points = _points(trajectory)
    line = _marker('trajectory', 0, Marker.LINE_STRIP, stamp)
    line.scale.x = 0.2 * radius
    line.points = points
    line.colors = [COLOURS[motion] for motion in trajectory.motion]
    balls = []
    for number, (point, opacity) in enumerate(((points[0], 0.4), (points[-1], 1.0))):
        ball = _marker('ball', number, Marker.SPHERE, stamp)
        ball.pose.position = point
        ball.scale = Vector3(x=2 * radius, y=2 * radius, z=2 * radius)
        ball.color = ColorRGBA(r=1.0, g=1.0, b=0.95, a=opacity)
        balls.append(ball)
    return MarkerArray(markers=[line, *balls])


def _marker(namespace: str, number: int, kind: int, stamp: Stamp) -> Marker:
    marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.header = Header(frame_id=FRAME, stamp=stamp)
    marker.pose.orientation.w = 1.0
    return marker


def _points(trajectory: BallTrajectory) -> list[Point]:
    positions: np.ndarray = vectors(trajectory.positions)
    return [Point(x=x, y=y, z=z) for x, y, z in positions.tolist()]
