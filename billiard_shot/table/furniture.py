"""
What balls meet on the table, in the form that compiled code takes: sizes, then lines and arcs.

Pockets are numbered 0 to 5: corners in the quadrants (+, +), (-, +), (-, -), (+, -) of (x, y),
then the sides at y > 0 and y < 0. Each has two jaws, numbered 2 p and 2 p + 1: an arc that rounds
off the end of a nose, and the facing that goes on from it into the pocket.
"""
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.lent import lent
from billiard_shot.table.surface import AUTO, ON

HAN, MATHAVAN = 0, 1
POCKETS = 6


class Furniture(NamedTuple):
    """Sizes of a table, and how balls meet it and each other. Infinite length: no cushions."""

    length: float  # m
    width: float  # m
    pockets: bool
    model: int  # of cushions, HAN or MATHAVAN
    cushion_restitution: float
    cushion_friction: float
    cushion_stiffness: float
    height: float  # m, of the noses above the cloth
    depth: float  # m, of the cushions
    corner: tuple[float, float, float, float, float]  # mouth, sine and cosine of the turn from
    side: tuple[float, float, float, float, float]  # nose to facing, radius of jaws, setback
    corner_hole: tuple[float, float]  # distance of its centre from the corner, radius
    side_hole: tuple[float, float]  # the same from the line of noses
    ball_restitution: float
    friction_fast: float
    friction_slow: float  # of balls: fast + slow exp(-decay slip)
    friction_decay: float  # s/m
    ball_stiffness: float
    gap: float  # m, within which bodies touch
    pairs: int = AUTO  # ON: every pair of balls is looked at; OFF: none
    mouths: int = AUTO  # ON: every pocket is looked at


class Bed(NamedTuple):
    """Where a ball's centre can be, and the jaws and holes around that."""

    x: float  # half of the length and the width that a lying ball's centre can reach [m]
    y: float
    reach: float  # horizontal distance from a nose at which a lying ball touches it [m]
    corner_end: float  # from the corner to the straight nose's end, along the nose [m]
    side_end: float  # the same from the middle of a long side
    facings: NDArray[np.float64]  # (12, 6) start (x, y), end (x, y), normal (x, y) into the mouth
    arcs: NDArray[np.float64]  # (12, 3) centre (x, y), radius
    holes: NDArray[np.float64]  # (6, 3) centre (x, y), radius
    boxes: NDArray[np.float64]  # (6, 4) centre (x, y) and half sizes around all that is there


@fused
def lend_bed(bed: Bed) -> Bed:
    """Return the same bed, whose arrays nobody counts; the bed itself has to stay."""
    return Bed(
        bed.x, bed.y, bed.reach, bed.corner_end, bed.side_end, lent(bed.facings), lent(bed.arcs),
        lent(bed.holes), lent(bed.boxes),
    )


@fused
def place_jaw(
    f: Furniture, bed: Bed, jaw: int, mouth: tuple[float, float, float, float, float],
    x: float, y: float, dx: float, dy: float, ox: float, oy: float,
) -> None:
    """Place a jaw whose nose runs along d to (x, y), where its line meets the facing's; o: out."""
    _, sine, cosine, radius, setback = mouth
    fx, fy = cosine * dx + sine * ox, cosine * dy + sine * oy
    bed.arcs[jaw, 0] = x - setback * dx + radius * ox
    bed.arcs[jaw, 1] = y - setback * dy + radius * oy
    bed.arcs[jaw, 2] = radius
    bed.facings[jaw, 0] = x + setback * fx
    bed.facings[jaw, 1] = y + setback * fy
    bed.facings[jaw, 2] = x + f.depth / sine * fx
    bed.facings[jaw, 3] = y + f.depth / sine * fy
    bed.facings[jaw, 4] = sine * dx - cosine * ox
    bed.facings[jaw, 5] = sine * dy - cosine * oy


@fused
def enclose(bed: Bed, pocket: int) -> None:
    """Find the box within which a ball's centre can meet anything of a pocket."""
    hole = bed.holes[pocket]
    low_x, high_x = hole[0] - hole[2], hole[0] + hole[2]
    low_y, high_y = hole[1] - hole[2], hole[1] + hole[2]
    for jaw in range(2 * pocket, 2 * pocket + 2):
        around = bed.arcs[jaw, 2] + bed.reach
        low_x = min(low_x, bed.arcs[jaw, 0] - around)
        high_x = max(high_x, bed.arcs[jaw, 0] + around)
        low_y = min(low_y, bed.arcs[jaw, 1] - around)
        high_y = max(high_y, bed.arcs[jaw, 1] + around)
        for end in (0, 2):
            low_x = min(low_x, bed.facings[jaw, end] - bed.reach)
            high_x = max(high_x, bed.facings[jaw, end] + bed.reach)
            low_y = min(low_y, bed.facings[jaw, end + 1] - bed.reach)
            high_y = max(high_y, bed.facings[jaw, end + 1] + bed.reach)
    bed.boxes[pocket, 0] = 0.5 * (low_x + high_x)
    bed.boxes[pocket, 1] = 0.5 * (low_y + high_y)
    bed.boxes[pocket, 2] = 0.5 * (high_x - low_x)
    bed.boxes[pocket, 3] = 0.5 * (high_y - low_y)


@fused
def lay_out(f: Furniture, radius: float) -> Bed:
    """Lay out the table for balls of a radius [m]."""
    x, y = 0.5 * f.length, 0.5 * f.width
    above = f.height - radius
    reach = np.sqrt(radius * radius - above * above)
    count = POCKETS if f.pockets else 0
    at_corner = np.sqrt(0.5) * f.corner[0]
    bed = Bed(
        x - reach, y - reach, reach,
        at_corner + f.corner[4] if f.pockets else 0.0,
        0.5 * f.side[0] + f.side[4] if f.pockets else 0.0,
        np.empty((2 * count, 6)), np.empty((2 * count, 3)), np.empty((count, 3)),
        np.empty((count, 4)),
    )
    for pocket in range(count):
        if pocket < 4:
            sx = 1.0 if pocket in (0, 3) else -1.0
            sy = 1.0 if pocket < 2 else -1.0
            place_jaw(f, bed, 2 * pocket, f.corner, sx * (x - at_corner), sy * y, sx, 0.0, 0.0, sy)
            place_jaw(f, bed, 2 * pocket + 1, f.corner, sx * x, sy * (y - at_corner),
                      0.0, sy, sx, 0.0)
            out = np.sqrt(0.5) * f.corner_hole[0]
            bed.holes[pocket, 0] = sx * (x + out)
            bed.holes[pocket, 1] = sy * (y + out)
            bed.holes[pocket, 2] = f.corner_hole[1]
        else:
            sy = 1.0 if pocket == 4 else -1.0
            half = 0.5 * f.side[0]
            place_jaw(f, bed, 2 * pocket, f.side, half, sy * y, -1.0, 0.0, 0.0, sy)
            place_jaw(f, bed, 2 * pocket + 1, f.side, -half, sy * y, 1.0, 0.0, 0.0, sy)
            bed.holes[pocket, 0] = 0.0
            bed.holes[pocket, 1] = sy * (y + f.side_hole[0])
            bed.holes[pocket, 2] = f.side_hole[1]
        enclose(bed, pocket)
        if f.mouths == ON:
            bed.boxes[pocket, 2] = np.inf
            bed.boxes[pocket, 3] = np.inf
    return bed
