"""Markers of a table and its balls, for RViz and Foxglove."""

from collections.abc import Mapping

from billiard_shot_msgs.msg import BallState, TableState
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.ros import markers
from billiard_shot.scene import Scene
from billiard_shot.table.colours import ball_colour
from billiard_shot.table.outline import outline_of

CLOTH_PAINT, CUSHION_PAINT, WOOD_PAINT, HOLE_PAINT, TEXT = (
    '#2f7d5b',
    '#236349',
    '#6f4426',
    '#111111',
    '#ffffff',
)
THICKNESS = 0.03  # m, of the bed
CLOTH_SIZE = 8.0  # m, side of the square that shows an infinite cloth
MARKER_LIFT = 5e-4  # m, height of flat markers above the surface under them

BallCentres = Mapping[str, tuple[float, float, float]]


def table_markers(scene: Scene, header: Header) -> MarkerArray:
    """Bed, cushions, rails and pockets; for a scene without a table, a square of cloth."""
    if scene.table is None:
        half = np.full(2, 0.5 * CLOTH_SIZE)
        return markers.array_of([_slab('bed', half, 0.0, CLOTH_PAINT)], header)
    outline = outline_of(scene)
    shown = [
        _slab('bed', outline.back, 0.0, CLOTH_PAINT),
        _slab('frame', outline.frame, -MARKER_LIFT, WOOD_PAINT),
        markers.prisms(
            'cushions', outline.cushions, 0.0, outline.height, markers.colour(CUSHION_PAINT)
        ),
        markers.prisms(
            'rails',
            [_rail(cushion, outline.back, outline.frame) for cushion in outline.cushions],
            0.0,
            outline.height,
            markers.colour(WOOD_PAINT),
        ),
    ]
    for x, y, radius in outline.holes.tolist():
        shown.append(
            markers.disc(
                'pockets', (x, y, 0.0), radius, 2 * MARKER_LIFT, markers.colour(HOLE_PAINT)
            )
        )
    return markers.array_of(shown, header)


def ball_markers(balls: BallCentres, radius: float, header: Header) -> MarkerArray:
    """Balls with centres (x, y, z) [m], and their names above them."""
    shown = []
    for name, (x, y, z) in balls.items():
        shown += [
            markers.ball('balls', (x, y, z), radius, markers.colour(ball_colour(name))),
            markers.label_marker(name, (x, y, z + 3 * radius), 2 * radius, markers.colour(TEXT)),
        ]
    return markers.array_of(shown, header)


def ball_centres(table: TableState, radius: float) -> BallCentres:
    """Centres of the balls on the table [m]; a ball with z = 0 rests on the cloth."""
    return {
        ball.id: (ball.position.x, ball.position.y, ball.position.z or radius)
        for ball in table.balls
        if ball.state != BallState.POCKETED
    }


def _slab(namespace: str, half: NDArray[np.float64], top: float, code: str) -> Marker:
    x, y = half
    return markers.box(namespace, (-x, -y, top - THICKNESS), (x, y, top), markers.colour(code))


def _rail(
    cushion: NDArray[np.float64], back: NDArray[np.float64], frame: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Outline (4, 2) of the wood behind a cushion, out to the frame."""
    ends = cushion[[0, -1]]
    side = np.isclose(np.abs(ends), back).all(
        axis=0
    )  # the axis along which the cushion is at the back
    beyond = np.where(side, np.sign(ends) * frame, ends)
    return np.concatenate([ends, beyond[::-1]])
