"""
The shape of a table as seen from above, for pictures, RViz and the view in the browser.

Made of the same lines and arcs that balls meet (billiard_shot.table.furniture), not of a drawing
of its own.
"""
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.table.effects import numbers_on_table
from billiard_shot.table.furniture import Bed, lay_out

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
    _, furniture = numbers_on_table(scene)
    bed = lay_out(furniture, scene.ball.radius)
    half = 0.5 * np.array([furniture.length, furniture.width])
    back = half + furniture.depth
    holes = bed.holes
    reach = np.abs(holes[:, :2]) + holes[:, 2:] if len(holes) else back[np.newaxis]
    frame = np.maximum(back, reach.max(axis=0)) + RAIL
    cushions = _between_pockets(bed) if len(holes) else _around(half, back)
    return TableOutline(tuple(cushions), holes, back, frame, furniture.height)


def _around(half: NDArray[np.float64], back: NDArray[np.float64]) -> list[Outline]:
    """Cushions of a table without pockets: four, mitred at the corners."""
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return [np.array([back * a, half * a, half * b, back * b]) for a, b in sides]


def _between_pockets(bed: Bed) -> list[Outline]:
    """Six cushions, each from the jaw of a pocket to the jaw of the next one."""
    # around the table from the foot on; jaws are numbered as in furniture.py
    ends = ((7, 1), (0, 8), (9, 2), (3, 5), (4, 11), (10, 6))
    return [np.concatenate([_jaw(bed, a), _jaw(bed, b)[::-1]]) for a, b in ends]


def _jaw(bed: Bed, jaw: int) -> Outline:
    """From the back of a cushion along the facing and around the arc to the straight nose."""
    begin, end = bed.facings[jaw, :2], bed.facings[jaw, 2:4]
    centre, radius = bed.arcs[jaw, :2], bed.arcs[jaw, 2]
    across = 0 if jaw < 8 and jaw % 2 else 1  # the short sides' noses have x constant
    a, b = begin - centre, np.zeros(2)
    b[across] = -np.sign(centre[across]) * radius
    turn = np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)
    angles = np.linspace(0.0, turn, ARC)[:, np.newaxis]
    arc = centre + np.cos(angles) * a + np.sin(angles) * np.array([-a[1], a[0]])
    return np.concatenate([end[np.newaxis], arc])
