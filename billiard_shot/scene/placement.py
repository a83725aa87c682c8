"""Positions of balls: not in each other, not in a cushion, not over a pocket; and racks."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, count
import math
import random
from types import MappingProxyType
from typing import Any

from billiard_shot.numerics import rounding
from billiard_shot.scene.errors import Mistake, must_be
from billiard_shot.scene.fields import CheckedRecord, choice, number, whole_number

CUE_BALL = 'cue'
UNPLACED = "; ball 'cue' has no position, so it lies at [0, 0]"
# Largest depth of a moving ball in a nose [radii]: at 20 m/s a ball reaches 0.4.
PRESSED = 0.5
NO_BALLS: Mapping[str, Sequence[float]] = MappingProxyType({})


def overlapping_balls(scene: Any) -> Iterator[Mistake]:
    """One mistake for each pair of balls that overlap."""
    unplaced = '' if CUE_BALL in scene.balls else UNPLACED
    for one, other, why in overlaps(lying(scene), scene.ball.radius):
        text = must_be(why, list(scene.balls[other]), 'm') + unplaced * (one == CUE_BALL)
        yield Mistake(('balls', other), text)


def overlaps(
    places: Mapping[str, Sequence[float]], radius: float
) -> Iterator[tuple[str, str, str]]:
    """Yield each pair of balls that overlap, and where the second one must be instead."""
    for (one, there), (other, place) in combinations(places.items(), 2):
        if why := too_near(place, one, there, radius):
            yield one, other, why


def too_near(place: Sequence[float], other: str, there: Sequence[float], radius: float) -> str:
    """Say where a ball must be if at a place [m] it overlaps another one; empty if not."""
    overlap = 2.0 * radius - math.dist(place, there)
    if overlap <= rounding.PLACE:
        return ''
    return (
        f'at least {2e3 * radius:.4g} mm from ball {other!r}, which it overlaps by '
        f'{1e3 * overlap:.3g} mm'
    )


def lying(scene: Any) -> dict[str, tuple[float, float]]:
    """Positions of all balls; the cue ball is in the middle if it has no position."""
    return {CUE_BALL: (0.0, 0.0), **scene.balls}


def balls_off_the_table(scene: Any) -> Iterator[Mistake]:
    """One mistake for each ball in a cushion, outside of the table, or over a pocket."""
    for name, (x, y) in scene.balls.items():
        if why := no_place(scene.table, x, y, scene.ball.radius):
            yield Mistake(('balls', name), must_be(why, [x, y], 'm'))


def head_string(table: Any) -> float:
    """Return x of the head string [m] (WPA Equipment Specifications: a quarter of the length)."""
    return -0.25 * float(table.length)


def in_hand(scene: Any, others: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """Find the free place of the head string that is nearest to its middle (x, y) [m]."""
    x = head_string(scene.table) if scene.table is not None else 0.0
    radius = scene.ball.radius
    tried = (sign * i * 0.25 * radius for i in count() for sign in (1.0, -1.0))
    return next((x, y) for y in tried if not no_place(None, x, y, radius, others))


def nose_standoff(height: float, radius: float) -> float:
    """
    Return the horizontal distance of the centre of a ball on the cloth from a nose it touches [m].

    A nose, at its height [m], is above the centre of the ball, so the distance is below a radius.
    """
    above = height - radius
    return math.sqrt(radius * radius - above * above)


def no_place(
    table: Any,
    x: float,
    y: float,
    radius: float,
    others: Mapping[str, Sequence[float]] = NO_BALLS,
    pressed: float = 0.0,
) -> str:
    """
    Say where a ball must lie if it cannot lie at (x, y) [m]; empty if it can.

    It can lie between the noses, and in a pocket's mouth, where it overlaps none of the others.
    The ball may be in a nose up to the depth `pressed` [m]. If `table` is None, only the others
    are in the way.
    """
    for other, there in others.items():
        if why := too_near((x, y), other, there, radius):
            return why
    if table is None:
        return ''
    standoff = nose_standoff(2.0 * radius * table.cushion.height, radius) - pressed
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
    return no_place(table, x, y, radius, pressed=PRESSED * radius if any(velocity) else 0.0)


def _between_noses(pocket: Any, out: float, aside: float, standoff: float) -> bool:
    """Whether a ball at distances [m] out of a mouth and beside its middle clears the noses."""
    room = 0.5 * pocket.mouth - aside
    # A jaw rounds the corner of nose and facing: there a ball comes closer to the corner.
    rounded = pocket.jaw_radius * (1.0 / math.sin(math.radians(0.5 * pocket.cut_deg)) - 1.0)
    if out > 0.0:
        return room >= standoff - rounded
    return room >= 0.0 and math.hypot(room, out) >= standoff - rounded - rounding.PLACE


Place = tuple[float, float]

# Spots of a snooker table (WPBSA, Official Rules of the Games of Snooker and English Billiards,
# section 1): distances from the nearer short cushion, and the radius of the D [m].
BAULK_LINE, D_RADIUS, BLACK_SPOT = 0.737, 0.292, 0.324


@dataclass(frozen=True, slots=True)
class Rack(CheckedRecord):
    """
    The balls at the start of a game, without the cue ball.

    Parameters
    ----------
    game : str
        `nine_ball`: a diamond with ball 1 on the foot spot and 9 in the middle. `eight_ball`: a
        triangle with 8 in the middle of the third row, and one ball of each kind in the two back
        corners. `ten_ball`: a triangle with ball 1 on the foot spot, 10 in the middle, and 2 and 3
        in the two back corners (all WPA, The Rules of Play). `snooker`: 15 reds in a triangle
        right behind the pink, and six colours on their spots.
    gap : float
        Mean gap between neighbours in the rack [m], at least 0. 0.05 mm is a guess at a careful
        rack. Each ball lies at a random point within half a gap of its site; with 0, all touch.
    seed : int
        Seed of the gaps and of the shuffle, at least 0.

    """

    game: str = choice('nine_ball', 'eight_ball', 'ten_ball', 'snooker')
    gap: float = number('m', minimum=0, maximum=0.01, default=5e-5)
    seed: int = whole_number(minimum=0, default=0)


def racked(rack: Any, table: Any, radius: float) -> dict[str, Place]:
    """
    Positions of the balls of a rack [m], by name.

    Parameters
    ----------
    rack : Rack
    table : Table
    radius : float
        Radius of the balls [m].

    """
    draw = random.Random(rack.seed)
    spacing = 2.0 * radius + rack.gap
    spots: dict[str, Place] = {}
    apex = 0.25 * table.length  # the foot spot and, in snooker, the pink
    match rack.game:
        case 'nine_ball':
            names, rows = _nine_ball(draw), [1, 2, 3, 2, 1]
        case 'eight_ball':
            names, rows = _eight_ball(draw), [1, 2, 3, 4, 5]
        case 'ten_ball':
            names, rows = _ten_ball(draw), [1, 2, 3, 4]
        case _:
            names, rows = [f'red{number}' for number in range(1, 16)], [1, 2, 3, 4, 5]
            spots = _colours(0.5 * table.length) | {'pink': (apex, 0.0)}
            apex += spacing
    balls = {}
    for name, (x, y) in zip(names, sites(rows, apex, spacing), strict=True):
        dx, dy = _within_a_circle(draw)
        balls[name] = x + 0.5 * rack.gap * dx, y + 0.5 * rack.gap * dy
    return balls | spots


def rack_in_the_way(scene: Any) -> Iterator[Mistake]:
    """One mistake for each ball of the rack whose site is not free."""
    if scene.rack is None:
        return
    if scene.table is None:
        yield Mistake(('rack',), 'needs a table; table is missing')
        return
    radius = scene.ball.radius
    rack = racked(scene.rack, scene.table, radius)
    for name, other, _ in overlaps(rack, radius):
        yield Mistake(('rack',), f'puts balls {name!r} and {other!r} into each other')
    for name, (x, y) in rack.items():
        if name in scene.balls:
            yield Mistake(('balls', name), 'is there twice; the rack has a ball of this name')
        elif why := no_place(scene.table, x, y, radius):
            yield Mistake(('rack',), f'must put ball {name!r} {why}, got ({x:.4g}, {y:.4g}) (m)')
        for other, place in lying(scene).items():
            if other != name and too_near(place, name, (x, y), radius):
                yield Mistake(('balls', other), f'overlaps ball {name!r} of the rack')


def sites(rows: Sequence[int], apex: float, spacing: float) -> Iterator[Place]:
    """Yield sites (x, y) [m] in rows of the given lengths, from (apex, 0) on, left to right."""
    for row, size in enumerate(rows):
        for place in range(size):
            yield (apex + row * spacing * math.sqrt(0.75), (0.5 * (size - 1) - place) * spacing)


def _nine_ball(draw: random.Random) -> list[str]:
    others = _shuffled([2, 3, 4, 5, 6, 7, 8], draw)
    return [str(ball) for ball in (1, *others[:3], 9, *others[3:])]


def _eight_ball(draw: random.Random) -> list[str]:
    solids, stripes = _shuffled(list(range(1, 8)), draw), _shuffled(list(range(9, 16)), draw)
    corners = _shuffled([solids.pop(), stripes.pop()], draw)
    others = _shuffled(sorted(solids + stripes), draw)
    order = [*others[:4], 8, *others[4:9], corners[0], *others[9:], corners[1]]
    return [str(ball) for ball in order]


def _ten_ball(draw: random.Random) -> list[str]:
    others = _shuffled([4, 5, 6, 7, 8, 9], draw)
    left, right = _shuffled([2, 3], draw)
    order = [1, *others[:3], 10, others[3], left, *others[4:], right]
    return [str(ball) for ball in order]


def _shuffled(balls: list[int], draw: random.Random) -> list[int]:
    for last in range(len(balls) - 1, 0, -1):
        other = int(draw.random() * (last + 1))
        balls[last], balls[other] = balls[other], balls[last]
    return balls


def _colours(end: float) -> dict[str, Place]:
    """Places of the colours except pink; `end` [m] is half the length; yellow is on the right."""
    baulk = BAULK_LINE - end
    return {
        'yellow': (baulk, -D_RADIUS),
        'green': (baulk, D_RADIUS),
        'brown': (baulk, 0.0),
        'blue': (0.0, 0.0),
        'black': (end - BLACK_SPOT, 0.0),
    }


def _within_a_circle(draw: random.Random) -> Place:
    """Draw a point from the uniform distribution over the unit circle."""
    while True:
        x, y = 2.0 * draw.random() - 1.0, 2.0 * draw.random() - 1.0
        if x * x + y * y <= 1.0:
            return x, y
