"""Positions of balls: not in each other, not in a cushion, not over a pocket."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, count
import math
from typing import Any

from billiard_shot.numerics import rounding
from billiard_shot.scene.errors import Mistake, must_be

CUE_BALL = 'cue'
UNPLACED = "; ball 'cue' has no position, so it lies at [0, 0]"
# Largest depth of a moving ball in a nose [radii]: at 20 m/s a ball reaches 0.4.
PRESSED = 0.5


def overlapping_balls(scene: Any) -> Iterator[Mistake]:
    """One mistake for each pair of balls that overlap."""
    diameter = 2.0 * scene.ball.radius
    unplaced = '' if CUE_BALL in scene.balls else UNPLACED
    for (one, here), (other, there) in combinations(lying(scene).items(), 2):
        overlap = diameter - math.dist(here, there)
        if overlap > rounding.PLACE:
            yield Mistake(
                ('balls', other),
                (
                    f'must be at least {1e3 * diameter:.4g} mm from ball {one!r}, got '
                    f'{1e3 * (diameter - overlap):.4g} mm' + unplaced * (one == CUE_BALL)
                ),
            )


def lying(scene: Any) -> dict[str, tuple[float, float]]:
    """Positions of all balls; the cue ball is in the middle if it has no position."""
    return {CUE_BALL: (0.0, 0.0), **scene.balls}


def balls_off_the_table(scene: Any) -> Iterator[Mistake]:
    """One mistake for each ball in a cushion, outside of the table, or over a pocket."""
    if scene.table is not None:
        for name, (x, y) in scene.balls.items():
            if why := no_place(scene.table, x, y, scene.ball.radius):
                yield Mistake(('balls', name), must_be(why, [x, y], 'm'))


def in_hand(scene: Any, others: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """Find the free place of the head string that is nearest to its middle (x, y) [m]."""
    x = -0.25 * scene.table.length if scene.table is not None else 0.0
    step, apart = 0.25 * scene.ball.radius, 2.0 * scene.ball.radius
    tried = (sign * i * step for i in count() for sign in (1.0, -1.0))
    return next(
        (x, y) for y in tried if all(math.dist((x, y), place) > apart for place in others.values())
    )


def no_place(table: Any, x: float, y: float, radius: float, pressed: float = 0.0) -> str:
    """
    Say where a ball must lie if it cannot lie at (x, y) [m]; empty if it can.

    It can between the noses, and in a pocket's mouth.

    The ball may be in a nose up to the depth `pressed` [m].
    """
    # a nose is higher than the centre of a ball, so their horizontal distance is below a radius
    standoff = 2.0 * radius * math.sqrt(table.cushion.height * (1.0 - table.cushion.height))
    standoff -= pressed
    beyond = abs(x) - 0.5 * table.length, abs(y) - 0.5 * table.width
    # Distance of the ball from the mouth of the pocket, outwards, and from its middle, sideways.
    corner = (beyond[0] + beyond[1] + table.corner.mouth * math.sqrt(0.5)) * math.sqrt(0.5)
    pockets = (
        (table.corner, corner, abs(beyond[0] - beyond[1]) * math.sqrt(0.5)),
        (table.side, beyond[1], abs(x)),
    )
    for pocket, out, aside in pockets if table.pockets else ():
        if math.hypot(out - pocket.shelf - pocket.radius, aside) < pocket.radius:
            return 'beside the pockets, not over one'
        # The edge of the hole is round: beside its middle the shelf is longer than `pocket.shelf`.
        in_reach = -radius <= out <= pocket.shelf + pocket.radius
        if in_reach and _between_noses(pocket, out, aside, standoff):
            return ''
    if max(beyond) <= rounding.PLACE - standoff:
        return ''
    along, across = 0.5 * table.length - standoff, 0.5 * table.width - standoff
    return (
        f'between the cushions, x from {-along:.4g} to {along:.4g} and y from {-across:.4g} to '
        f'{across:.4g}'
    )


def no_start(
    table: Any, position: Sequence[float], velocity: Sequence[float], radius: float
) -> str:
    """
    Say where a ball must be if it cannot begin at (x, y, z) [m] with a velocity; empty if it can.

    At rest it must lie as `no_place` says. If it moves, it may be pressing a nose; in the air, it
    may be above one.
    """
    x, y, z = position
    beyond = abs(x) > 0.5 * table.length or abs(y) > 0.5 * table.width
    if z - radius > rounding.PLACE and not beyond:
        return ''
    return no_place(table, x, y, radius, PRESSED * radius if any(velocity) else 0.0)


def _between_noses(pocket: Any, out: float, aside: float, standoff: float) -> bool:
    """Whether a ball at distances [m] out of a mouth and beside its middle clears the noses."""
    room = 0.5 * pocket.mouth - aside
    # A jaw rounds the corner of nose and facing: there a ball comes closer to the corner.
    rounded = pocket.jaw_radius * (1.0 / math.sin(math.radians(0.5 * pocket.cut_deg)) - 1.0)
    if out > 0.0:
        return room >= standoff - rounded
    return room >= 0.0 and math.hypot(room, out) >= standoff - rounded - rounding.PLACE
