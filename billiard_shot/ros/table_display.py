"""
The node `table_display`: shows the table and the current balls. The markers of all nodes.

Shots for RViz and Foxglove are markers of the cue, of paths coloured by motion, and a timed path.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import math

from billiard_shot_msgs.msg import BallTrajectory, TableState
from geometry_msgs.msg import Point, Pose, PoseStamped, Vector3
from nav_msgs.msg import Path
import numpy as np
from numpy.typing import ArrayLike
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot import Shot
from billiard_shot.pictures.canvas import ball_colour, GREY, MOTIONS
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.records import Array
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import check_frame, filled, sightings_of, vectors
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.outline import outline_of
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


CLOTH, CUSHION, WOOD, HOLE, TEXT = map(
    colour, ('#2f7d5b', '#236349', '#6f4426', '#111111', '#ffffff')
)
THICKNESS = 0.03  # m, of the bed
CLOTH_SIZE = 8.0  # m, side of the square that shows an infinite cloth
MARKER_LIFT = 5e-4  # m, height of flat markers above the surface under them
MIN_CHANGE = 1e-5  # m, smallest shown motion of a ball; a smaller one may be noise

BallCentres = Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True)
class TableDisplayParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Table, and balls until table_state has been received: name of a bundled scene, or path of
        a YAML file.

    """

    scene: str = checked('paper', Scene.load)


class TableDisplay(Node):
    """
    Node that publishes markers (visualization_msgs/msg/MarkerArray), latched.

    `~/table` shows the bed, cushions, rails and pockets of the scene. `~/balls` shows the balls of
    the topic `table_state` (billiard_shot_msgs/msg/TableState); until a message is received, it
    shows those of the scene. Its parameters are `TableDisplayParameters`.
    """

    def __init__(self) -> None:
        super().__init__('table_display')
        self._table = self.create_publisher(MarkerArray, '~/table', LATCHED)
        self._balls = self.create_publisher(MarkerArray, '~/balls', LATCHED)
        parameters.declare(self, TableDisplayParameters)
        self.add_post_set_parameters_callback(lambda _: self._show())
        self._show()
        self.create_subscription(TableState, 'table_state', self._show_balls, LATCHED)
        self.get_logger().info('ready: shows the table')

    def _show(self) -> None:
        """Show the scene of the parameters."""
        self._places: BallCentres = {}
        scene = Scene.load(self.get_parameter('scene').value)
        self._radius = scene.ball.radius
        self._table.publish(table_markers(scene, parameters.table_header(self)))
        balls = {name: (x, y, self._radius) for name, (x, y) in scene.balls.items()}
        self._publish_balls({CUE_BALL: scene.cue_ball, **balls}, parameters.table_header(self))

    def _show_balls(self, message: TableState) -> None:
        try:
            check_frame('header.frame_id', message.header, self.get_parameter('frame').value)
            balls = ball_centres(message, self._radius)
        except ValueError as error:
            self.get_logger().error(f'ignored a table_state: {error}')
            return
        self._publish_balls(balls, parameters.table_header(self, message.header.stamp))

    def _publish_balls(self, balls: BallCentres, header: Header) -> None:
        """Show the balls, unless they are shown where they are."""
        if balls.keys() == self._places.keys() and all(
            math.dist(place, self._places[name]) < MIN_CHANGE for name, place in balls.items()
        ):
            return
        self._places = balls
        self._balls.publish(ball_markers(balls, self._radius, header))


# --- markers ----------------------------------------------------------------------------------


def table_markers(scene: Scene, header: Header) -> MarkerArray:
    """Bed, cushions, rails and pockets; for a scene without a table, a square of cloth."""

    def slab(namespace: str, half: Array, top: float, paint: ColorRGBA) -> Marker:
        centre, size = (0.0, 0.0, top - 0.5 * THICKNESS), (*(2 * half), THICKNESS)
        return shape(namespace, Marker.CUBE, paint, centre, size)

    if scene.table is None:
        return array_of([slab('bed', np.full(2, 0.5 * CLOTH_SIZE), 0.0, CLOTH)], header)
    outline = outline_of(scene)
    rails = (_rail(each, outline.back, outline.frame) for each in outline.cushions)
    shown = [
        slab('bed', outline.back, 0.0, CLOTH),
        slab('frame', outline.frame, -MARKER_LIFT, WOOD),
        solids('cushions', _upright(outline.cushions, outline.height), CUSHION),
        solids('rails', _upright(rails, outline.height), WOOD),
    ]
    for x, y, radius in outline.holes.tolist():
        size = (2 * radius, 2 * radius, 2 * MARKER_LIFT)
        shown.append(shape('pockets', Marker.CYLINDER, HOLE, (x, y, 0.0), size))
    return array_of(shown, header)


def ball_markers(balls: BallCentres, radius: float, header: Header) -> MarkerArray:
    """Balls with centres (x, y, z) [m], and their names above them."""
    shown = []
    for name, (x, y, z) in balls.items():
        shown += [
            ball('balls', (x, y, z), radius, colour(ball_colour(name))),
            label(name, (x, y, z + 3 * radius), 2 * radius, TEXT),
        ]
    return array_of(shown, header)


def ball_centres(table: TableState, radius: float) -> BallCentres:
    """Centres of the balls on the table [m]; a ball with z = 0 rests on the cloth."""
    known = sightings_of(table.balls)
    return {
        ball.id: (ball.position.x, ball.position.y, ball.position.z or radius)
        for ball in table.balls
        if ball.id in known
    }


def _upright(outlines: Iterable[Array], height: float) -> Iterator[tuple[Array, Array]]:
    """Bottoms and tops of prisms of a height [m] over outlines (n, 2) [m]."""
    for outline in outlines:
        top = np.insert(outline, 2, height, axis=1)
        yield top * (1.0, 1.0, 0.0), top


def _rail(cushion: Array, back: Array, frame: Array) -> Array:
    """Outline (4, 2) of the wood behind a cushion, out to the frame."""
    ends = cushion[[0, -1]]
    # the axis along which the cushion is at the back
    side = np.isclose(np.abs(ends), back).all(axis=0)
    beyond = np.where(side, np.sign(ends) * frame, ends)
    return np.concatenate([ends, beyond[::-1]])


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(TableDisplay, 'table_display', args)
