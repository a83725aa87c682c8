"""Shots for RViz and Foxglove: the cue, paths of balls coloured by motion, a timed path."""

from collections.abc import Sequence

from billiard_shot_msgs.msg import BallTrajectory
from geometry_msgs.msg import Pose, PoseStamped
from nav_msgs.msg import Path
import numpy as np
from rclpy.time import Time
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot import Shot
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.records import Array
from billiard_shot.ros import markers
from billiard_shot.ros.conversions import vectors
from billiard_shot.table.clearance import BUTT
from billiard_shot.table.colours import ball_colour, GREY, MOTIONS

LAST_SECOND = 2**31 - 1  # that fits into a stamp; later times of extreme shots are clipped to it
CUE_PAINT = '#c8955c'
MARKER_CUE_LENGTH, DRAWN_CUE_RADIUS = 0.5, 0.0065  # m, if the scene does not give its shape
CUE_SIDES = 24  # of the polygon that stands for the round cue
FAINT = 0.3  # opacity of starting positions, and of plans that are not the best


def path_of(trajectory: BallTrajectory, header: Header) -> Path:
    """Path whose poses have the times of the samples; the strike ends at the stamp of the path."""
    start = Time.from_msg(header.stamp).nanoseconds
    path = Path(header=header)
    points = markers.points_of(vectors(trajectory.positions))
    for time, point in zip(trajectory.times, points, strict=True):
        nanoseconds = min(start + round(min(time, LAST_SECOND) * 1e9), LAST_SECOND * 10**9)
        stamp = Time(nanoseconds=nanoseconds).to_msg()
        at_that_time = Header(frame_id=header.frame_id, stamp=stamp)
        path.poses.append(PoseStamped(header=at_that_time, pose=Pose(position=point)))
    return path


def shot_markers(shot: Shot, header: Header) -> MarkerArray:
    """Show the cue as it meets the ball, and the path of every moving ball."""
    return markers.array_of(_shot(shot, 1.0), header)


def plan_markers(ranking: Sequence[RankedStroke], header: Header) -> MarkerArray:
    """
    Show planned strokes: the first, which is the best, as `shot_markers` does, the others faint.

    At the end of each cue stand the kind of the stroke and its success probability.
    """
    shown = []
    for rank, planned in enumerate(ranking):
        shot, opacity = planned.shot, FAINT if rank else 1.0
        text, paint = f'{planned.kind}: {planned.chance}', markers.colour(CUE_PAINT, opacity)
        shown += _shot(shot, opacity)
        shown.append(markers.label(text, _ends(shot)[1], 2 * shot.scene.ball.radius, paint))
    return markers.array_of(shown, header)


def _shot(shot: Shot, opacity: float) -> list[Marker]:
    radius = shot.scene.ball.radius
    shown = [_cue(shot, markers.colour(CUE_PAINT, opacity))]
    trails = trails_of(shot)
    for name in trails.balls:
        pieces = trails.pieces(name)
        if not pieces:
            continue
        paint = markers.colour(ball_colour(name), opacity)
        faint = markers.colour(ball_colour(name), FAINT * opacity)
        path = markers.shape('paths', Marker.LINE_STRIP, paint, size=(0.2 * radius, 0.0, 0.0))
        path.points = markers.points_of(np.concatenate([piece.points for piece in pieces]))
        path.colors = [
            markers.colour(MOTIONS.get(piece.motion, GREY), opacity)
            for piece in pieces
            for _ in piece.times
        ]
        shown += [path, markers.ball('starts', trails.start(name), radius, faint)]
        if (end := trails.end(name)) is not None:
            shown.append(markers.ball('ends', end, radius, paint))
    return shown


def _cue(shot: Shot, paint: ColorRGBA) -> Marker:
    """Cone frustum between both ends of the cue."""
    cue, (tip, butt) = shot.scene.cue, _ends(shot)
    radii = (cue.ferrule_radius, BUTT) if cue.length else (DRAWN_CUE_RADIUS, DRAWN_CUE_RADIUS)
    axis = (butt - tip) / np.linalg.norm(butt - tip)
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    angles = np.linspace(0.0, 2 * np.pi, CUE_SIDES, endpoint=False)[:, np.newaxis]
    around = np.cos(angles) * one + np.sin(angles) * np.cross(axis, one)
    return markers.solids('cue', [(tip + radii[0] * around, butt + radii[1] * around)], paint)


def _ends(shot: Shot) -> tuple[Array, Array]:
    """Both ends of the cue as it meets the ball [m]."""
    along = np.array(shot.stroke.velocity) / shot.stroke.speed
    tip = shot.position + shot.scene.ball.radius * np.array(shot.stroke.normal)
    return tip, tip - (shot.scene.cue.length or MARKER_CUE_LENGTH) * along
