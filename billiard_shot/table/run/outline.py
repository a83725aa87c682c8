"""
The shape of a table as seen from above, for pictures, RViz and the view in the browser.

Made of the same lines and arcs that balls meet (billiard_shot.table.geometry), not of a drawing
of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.table.model.geometry import Jaw
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.layout import layout_of

Outline = NDArray[np.float64]
RAIL = 0.075  # m that the wooden frame reaches beyond the cushions; for the eye only
ARC = 9  # points of a jaw's rounding


@dataclass(frozen=True, slots=True, eq=False)
class TableOutline:
    """
    Polygons (n, 2) [m] of a table.

    Attributes
    ----------
    cushions : tuple of (n, 2) float arrays
        Each from the point where its back begins, along its face, to the back's other end.
    holes : (pockets, 3) float array
        Centre (x, y) and radius.
    back : (2,) float array
        Half length and half width of the backs of the cushions.
    frame : (2,) float array
        The same of the wooden frame.
    height : float
        Of the noses above the cloth.

    """

    cushions: tuple[Outline, ...]
    holes: NDArray[np.float64]
    back: NDArray[np.float64]
    frame: NDArray[np.float64]
    height: float


def outline_of(scene: Scene) -> TableOutline:
    """Outline the table of a scene that has one."""
    params, table = params_on_table(scene)
    layout = layout_of(params, table)
    half = 0.5 * np.array([table.length, table.width])
    back = half + table.cushion_depth
    holes = np.array(
        [(pocket.hole_x, pocket.hole_y, pocket.hole_radius) for pocket in layout.pockets]
    ).reshape(-1, 3)
    reach = np.abs(holes[:, :2]) + holes[:, 2:] if len(holes) else back[np.newaxis]
    frame = np.maximum(back, reach.max(axis=0)) + RAIL
    cushions = _between_pockets(layout.jaws) if len(holes) else _around(half, back)
    return TableOutline(tuple(cushions), holes, back, frame, table.nose_height)


def _around(half: NDArray[np.float64], back: NDArray[np.float64]) -> list[Outline]:
    """Cushions of a table without pockets: four, mitred at the corners."""
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return [np.array([back * a, half * a, half * b, back * b]) for a, b in sides]


def _between_pockets(jaws: list[Jaw]) -> list[Outline]:
    """Six cushions, each from the jaw of a pocket to the jaw of the next one."""
    # around the table from the foot on; jaws are numbered as in geometry.py
    ends = ((7, 1), (0, 8), (9, 2), (3, 5), (4, 11), (10, 6))
    return [np.concatenate([_jaw(jaws, a), _jaw(jaws, b)[::-1]]) for a, b in ends]


def _jaw(jaws: list[Jaw], number: int) -> Outline:
    """From the back of a cushion along the facing and around the arc to the straight nose."""
    jaw = jaws[number]
    begin, end = np.array([jaw.start_x, jaw.start_y]), np.array([jaw.end_x, jaw.end_y])
    centre, radius = np.array([jaw.arc_x, jaw.arc_y]), jaw.arc_radius
    across = 0 if number < 8 and number % 2 else 1  # the short sides' noses have x constant
    a, b = begin - centre, np.zeros(2)
    b[across] = -np.sign(centre[across]) * radius
    turn = np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)
    angles = np.linspace(0.0, turn, ARC)[:, np.newaxis]
    arc = centre + np.cos(angles) * a + np.sin(angles) * np.array([-a[1], a[0]])
    return np.concatenate([end[np.newaxis], arc])
