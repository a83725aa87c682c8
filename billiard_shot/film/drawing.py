"""Pictures with what was found in them: noses, sights, balls and tracks."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from billiard_shot.film.lens import Bytes, Floats
from billiard_shot.film.table_in_picture import FoundTable
from billiard_shot.pictures.canvas import ball_colour

NOSE, SIGHT, BALL, UNDER = (240, 228, 66), (204, 121, 167), (255, 255, 255), (0, 0, 0)


def outlined(
    picture: Bytes,
    table: FoundTable,
    balls: Mapping[str, Floats],
    tracks: Sequence[tuple[str, Floats]] = (),
) -> Bytes:
    """
    Draw what was found into a copy of a picture.

    Parameters
    ----------
    picture : (height, width, 3) uint8 array
        RGB.
    table : FoundTable
    balls : mapping of str to (2,) float array
        Places of balls [m].
    tracks : sequence of (str, (n, 2) float array)
        Names of balls, and places that they pass [m].

    """
    shown, camera, radius = picture.copy(), table.camera, table.radius

    def line(
        pixels: Floats, colour: Sequence[float], closed: bool = False, width: int = 1
    ) -> None:
        fine = np.round(8.0 * pixels).astype(np.int32)
        cv2.polylines(shown, [fine], closed, colour, width, cv2.LINE_AA, 3)

    line(camera.rim(table.height), NOSE, True)
    for u, v in np.round(8.0 * table.sights.pixel).astype(int).tolist():
        cv2.circle(shown, (u, v), 40, SIGHT, 1, cv2.LINE_AA, 3)
    for name, places in tracks:
        pixels = camera.project(np.insert(places, 2, radius, axis=1))
        line(pixels, UNDER, width=3)
        line(pixels, bytes.fromhex(ball_colour(name)[1:]))
    for name, place in balls.items():
        ring = camera.outlines(np.array([[*place, radius]]), radius, 36)[0]
        line(ring, BALL, True)
        at = ring.max(axis=0).astype(int).tolist()
        cv2.putText(shown, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, BALL, 1, cv2.LINE_AA)
    return shown
