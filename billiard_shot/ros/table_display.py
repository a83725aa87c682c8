"""The node `table_display`: shows the table and the current balls."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import math

from billiard_shot_msgs.msg import TableState
import numpy as np
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.pictures.colours import ball_colour
from billiard_shot.records import Array
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import check_frame, sightings_of
from billiard_shot.ros.display import array_of, ball, colour, label, shape, solids
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.outline import outline_of

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


if __name__ == '__main__':
    main()
