"""Markers of a table and its balls, for RViz and Foxglove."""

from collections.abc import Iterable, Iterator, Mapping

from billiard_shot_msgs.msg import BallState, TableState
import numpy as np
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.records import Array
from billiard_shot.ros.markers import array_of, ball, colour, label, shape, solids
from billiard_shot.scene import Scene
from billiard_shot.table.colours import ball_colour
from billiard_shot.table.outline import outline_of

CLOTH, CUSHION, WOOD, HOLE, TEXT = map(
    colour, ('#2f7d5b', '#236349', '#6f4426', '#111111', '#ffffff')
)
THICKNESS = 0.03  # m, of the bed
CLOTH_SIZE = 8.0  # m, side of the square that shows an infinite cloth
MARKER_LIFT = 5e-4  # m, height of flat markers above the surface under them

BallCentres = Mapping[str, tuple[float, float, float]]


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
    return {
        ball.id: (ball.position.x, ball.position.y, ball.position.z or radius)
        for ball in table.balls
        if ball.state != BallState.POCKETED
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
