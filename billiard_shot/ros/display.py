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

from billiard_shot import Shot
from billiard_shot.pictures.trails import trails_of
from billiard_shot.ros import markers
from billiard_shot.ros.conversions import vectors
from billiard_shot.shot.clearance import BUTT
from billiard_shot.table.colours import ball_colour, GREY, MOTIONS

LAST_SECOND = 2**31 - 1
"""Largest second that fits into a stamp; later times of extreme shots are clipped to it."""

CUE_PAINT, MARKER_CUE_LENGTH, DRAWN_CUE_RADIUS = '#c8955c', 0.5, 0.0065
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
            markers.label_marker(
                text,
                _ends(shot)[1],
                2 * shot.scene.ball.radius,
                markers.colour(CUE_PAINT, opacity),
            )
        )
    return markers.array_of(shown, header)


def _shot(shot: Shot, opacity: float) -> list[Marker]:
    radius = shot.scene.ball.radius
    cue = shot.scene.cue
    radii = (cue.ferrule_radius, BUTT) if cue.length else (DRAWN_CUE_RADIUS, DRAWN_CUE_RADIUS)
    shown = [markers.cone('cue', *_ends(shot), radii, markers.colour(CUE_PAINT, opacity))]
    trails = trails_of(shot)
    for name in trails.balls:
        pieces = trails.pieces(name)
        if not pieces:
            continue
        colours = [
            markers.colour(MOTIONS.get(piece.motion, GREY), opacity)
            for piece in pieces
            for _ in piece.times
        ]
        points = np.concatenate([piece.points for piece in pieces])
        paint = ball_colour(name)
        shown += [
            markers.line_marker('paths', points, 0.2 * radius, colours),
            markers.ball(
                'starts', trails.start(name), radius, markers.colour(paint, FAINT * opacity)
            ),
        ]
        end = trails.end(name)
        if end is not None:
            shown.append(markers.ball('ends', end, radius, markers.colour(paint, opacity)))
    return shown


def _ends(shot: Shot) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both ends of the cue as it meets the ball [m]."""
    along = np.array(shot.stroke.velocity) / shot.stroke.speed
    centre = shot.position
    tip = centre + shot.scene.ball.radius * np.array(shot.stroke.normal)
    return tip, tip - (shot.scene.cue.length or MARKER_CUE_LENGTH) * along
