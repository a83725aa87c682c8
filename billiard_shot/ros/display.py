"""Shots for RViz and Foxglove: markers of the cue, of paths coloured by motion, a timed path."""

from collections.abc import Iterable, Sequence

from billiard_shot_msgs.msg import BallTrajectory
from geometry_msgs.msg import Point, Pose, PoseStamped, Vector3
from nav_msgs.msg import Path
import numpy as np
from numpy.typing import ArrayLike
from rclpy.time import Time
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot import Shot
from billiard_shot.pictures.colours import ball_colour, GREY, MOTIONS
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.records import Array
from billiard_shot.ros.conversions import filled, vectors
from billiard_shot.table.strike.placement import BUTT


def array_of(markers: Iterable[Marker], header: Header) -> MarkerArray:
    """Array of markers that replaces all earlier ones on its topic; ids count within each `ns`."""
    result = [Marker(action=Marker.DELETEALL), *markers]
    count: dict[str, int] = {}
    for marker in result:
        marker.header = header
        marker.id = count.get(marker.ns, 0)
        count[marker.ns] = marker.id + 1
    return MarkerArray(markers=result)


def colour(code: str, alpha: float = 1.0) -> ColorRGBA:
    """Colour of `#rrggbb`, with the opacity `alpha`, 0 to 1."""
    red, green, blue = (int(code[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return ColorRGBA(r=red, g=green, b=blue, a=float(alpha))


def shape(
    namespace: str,
    kind: int,
    paint: ColorRGBA,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    size: ArrayLike = (1.0, 1.0, 1.0),
) -> Marker:
    """Marker of a type, with a centre (3,) and a size (3,) [m]."""
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD, color=paint)
    marker.pose.orientation.w = 1.0
    marker.pose.position = filled(Point, centre)
    marker.scale = filled(Vector3, size)
    return marker


def ball(namespace: str, centre: ArrayLike, radius: float, paint: ColorRGBA) -> Marker:
    """Ball with a centre (3,) and a radius [m]."""
    return shape(namespace, Marker.SPHERE, paint, centre, np.full(3, 2 * radius))


def label(text: str, place: ArrayLike, height: float, paint: ColorRGBA) -> Marker:
    """Text of a height [m] that faces the viewer, at a place (3,) [m]."""
    marker = shape('labels', Marker.TEXT_VIEW_FACING, paint, place, (0.0, 0.0, height))
    marker.text = text
    return marker


def solids(namespace: str, ends: Iterable[tuple[Array, Array]], paint: ColorRGBA) -> Marker:
    """Solids between two convex polygons (n, 3) [m] with the same number of corners each."""
    triangles = []
    for one, other in ends:
        for i in range(len(one)):
            triangles += [one[[i - 1, i]], other[[i]], one[[i - 1]], other[[i - 1, i]]]
        for polygon in (one, other):
            triangles += [polygon[[0, i, i + 1]] for i in range(1, len(polygon) - 1)]
    marker = shape(namespace, Marker.TRIANGLE_LIST, paint)
    marker.points = points_of(np.concatenate(triangles))
    return marker


def points_of(points: Array) -> list[Point]:
    """Convert an array (n, 3) to points."""
    return [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]


LAST_SECOND = 2**31 - 1  # that fits into a stamp; later times of extreme shots are clipped to it
CUE_PAINT = '#c8955c'
MARKER_CUE_LENGTH, DRAWN_CUE_RADIUS = 0.5, 0.0065  # m, if the scene does not give its shape
CUE_SIDES = 24  # of the polygon that stands for the round cue
FAINT = 0.3  # opacity of starting positions, and of plans that are not the best


def path_of(trajectory: BallTrajectory, header: Header) -> Path:
    """Path whose poses have the times of the samples; the strike ends at the stamp of the path."""
    start = Time.from_msg(header.stamp).nanoseconds
    path = Path(header=header)
    points = points_of(vectors(trajectory.positions))
    for time, point in zip(trajectory.times, points, strict=True):
        nanoseconds = min(start + round(min(time, LAST_SECOND) * 1e9), LAST_SECOND * 10**9)
        stamp = Time(nanoseconds=nanoseconds).to_msg()
        at_that_time = Header(frame_id=header.frame_id, stamp=stamp)
        path.poses.append(PoseStamped(header=at_that_time, pose=Pose(position=point)))
    return path


def shot_markers(shot: Shot, header: Header) -> MarkerArray:
    """Show the cue as it meets the ball, and the path of every moving ball."""
    return array_of(_shot(shot, 1.0), header)


def plan_markers(ranking: Sequence[RankedStroke], header: Header) -> MarkerArray:
    """
    Show planned strokes: the first, which is the best, as `shot_markers` does, the others faint.

    At the end of each cue stand the kind of the stroke and its success probability.
    """
    shown = []
    for rank, planned in enumerate(ranking):
        shot, opacity = planned.shot, FAINT if rank else 1.0
        text, paint = f'{planned.kind}: {planned.chance}', colour(CUE_PAINT, opacity)
        shown += _shot(shot, opacity)
        shown.append(label(text, _ends(shot)[1], 2 * shot.scene.ball.radius, paint))
    return array_of(shown, header)


def _shot(shot: Shot, opacity: float) -> list[Marker]:
    radius = shot.scene.ball.radius
    shown = [_cue(shot, colour(CUE_PAINT, opacity))]
    trails = trails_of(shot)
    for name in trails.balls:
        pieces = trails.pieces(name)
        if not pieces:
            continue
        paint = colour(ball_colour(name), opacity)
        faint = colour(ball_colour(name), FAINT * opacity)
        path = shape('paths', Marker.LINE_STRIP, paint, size=(0.2 * radius, 0.0, 0.0))
        path.points = points_of(np.concatenate([piece.points for piece in pieces]))
        path.colors = [
            colour(MOTIONS.get(piece.motion, GREY), opacity)
            for piece in pieces
            for _ in piece.times
        ]
        shown += [path, ball('starts', trails.start(name), radius, faint)]
        if (end := trails.end(name)) is not None:
            shown.append(ball('ends', end, radius, paint))
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
    return solids('cue', [(tip + radii[0] * around, butt + radii[1] * around)], paint)


def _ends(shot: Shot) -> tuple[Array, Array]:
    """Both ends of the cue as it meets the ball [m]."""
    along = np.array(shot.stroke.velocity) / shot.stroke.speed
    tip = shot.position + shot.scene.ball.radius * np.array(shot.stroke.normal)
    return tip, tip - (shot.scene.cue.length or MARKER_CUE_LENGTH) * along
