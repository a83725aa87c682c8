"""Shots for RViz and Foxglove: the cue, paths of balls coloured by motion, a timed path."""

from collections.abc import Sequence

from billiard_shot_msgs.msg import BallTrajectory
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
import numpy as np
from numpy.typing import NDArray
from rclpy.time import Time
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot import Motion, Shot, Trajectory
from billiard_shot.ros import markers
from billiard_shot.ros.conversions import vectors
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.clearance import BUTT
from billiard_shot.table.colours import ball_colour, GREY, MOTIONS

LAST_SECOND = 2**31 - 1
"""Largest second that fits into a stamp; later times of extreme shots are clipped to it."""

CURVE_POINTS = 17
"""Number of points of a curved segment; a rolling ball moves straight."""

CUE, LENGTH, WIDTH = '#c8955c', 0.5, 0.0065
"""Colour of the cue; its length and radius [m] if the scene does not give its shape."""

FAINT = 0.3
"""Opacity of starting positions, and of plans that are not the best."""


def path_of(trajectory: BallTrajectory, header: Header) -> Path:
    """Path whose poses have the times of the samples; the strike ends at the stamp of the path."""
    start = Time.from_msg(header.stamp).nanoseconds
    path = Path(header=header)
    points = markers.points_of(vectors(trajectory.positions))
    for time, point in zip(trajectory.times, points, strict=True):
        pose = PoseStamped()
        pose.header.frame_id = header.frame_id
        nanoseconds = min(start + round(min(time, LAST_SECOND) * 1e9), LAST_SECOND * 10**9)
        pose.header.stamp = Time(nanoseconds=nanoseconds).to_msg()
        pose.pose.position = point
        path.poses.append(pose)
    return path


def shot_markers(shot: Shot, header: Header) -> MarkerArray:
    """Show the cue as it meets the ball, and the path of every moving ball."""
    return markers.array_of(_shot(shot, 1.0), header)


def plan_markers(shots: Sequence[Shot], labels: Sequence[str], header: Header) -> MarkerArray:
    """
    Show planned shots: the first, which is the best, as `shot_markers` does, the others faint.

    Parameters
    ----------
    shots : sequence of Shot
        Shots of the planned strokes.
    labels : sequence of str
        A line of text for each shot, such as its success probability, shown at the end of the cue.
    header : Header
        Frame of the table, and time.

    """
    shown = []
    for rank, (shot, text) in enumerate(zip(shots, labels, strict=True)):
        opacity = FAINT if rank else 1.0
        shown += _shot(shot, opacity)
        shown.append(
            markers.label(
                text, _ends(shot)[1], 2 * shot.scene.ball.radius, markers.colour(CUE, opacity)
            )
        )
    return markers.array_of(shown, header)


def _shot(shot: Shot, opacity: float) -> list[Marker]:
    radius = shot.scene.ball.radius
    cue = shot.scene.cue
    radii = (cue.ferrule_radius, BUTT) if cue.length else (WIDTH, WIDTH)
    shown = [markers.cone('cue', *_ends(shot), radii, markers.colour(CUE, opacity))]
    balls = shot.table.balls if shot.table else {CUE_BALL: shot.trajectory}
    for name, trajectory in balls.items():
        if trajectory.duration == 0.0:
            continue
        points, motions = _polyline(trajectory)
        shown += [
            markers.line(
                'paths',
                points,
                0.2 * radius,
                [markers.colour(MOTIONS.get(Motion(motion), GREY), opacity) for motion in motions],
            ),
            markers.ball(
                'starts', points[0], radius, markers.colour(ball_colour(name), FAINT * opacity)
            ),
        ]
        if trajectory.at(trajectory.duration).motion not in (Motion.POCKETED, Motion.OFF_TABLE):
            shown.append(
                markers.ball(
                    'ends', points[-1], radius, markers.colour(ball_colour(name), opacity)
                )
            )
    return shown


def _ends(shot: Shot) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both ends of the cue as it meets the ball [m]."""
    along = np.array(shot.stroke.velocity) / shot.stroke.speed
    centre = shot.trajectory.at(0.0).position
    tip = centre + shot.scene.ball.radius * np.array(shot.stroke.normal)
    return tip, tip - (shot.scene.cue.length or LENGTH) * along


def _polyline(trajectory: Trajectory) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Points (n, 3) [m] of a trajectory until its final motion, and the motions at the points."""
    times, motions = [0.0], [int(trajectory.at(0.0).motion)]
    for segment in trajectory.segments:
        if segment.start >= trajectory.duration:
            break
        count = 2 if segment.motion is Motion.ROLL else CURVE_POINTS
        times += np.linspace(segment.start, segment.end, count).tolist()
        motions += count * [int(segment.motion)]
    return trajectory.at(times).position, np.array(motions, np.uint8)
