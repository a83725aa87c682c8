"""
Racks: the positions of the balls at the start of a game.

The foot of the table is at +x. Sites are counted row by row from the apex, and in a row from left
to right as seen from the head. The rules fix the sites of some balls. The others, in ascending
order, are shuffled with the Fisher-Yates algorithm and the random numbers of Python's
`random.Random(seed).random()`. Python promises never to change this sequence: the same seed gives
the same rack in every process, on every machine.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math
import random
from typing import Any

from billiard_shot.scene.checks import check
from billiard_shot.scene.errors import Mistake
from billiard_shot.scene.fields import choice, number, whole_number
from billiard_shot.scene.placement import lying, no_place, overlaps, too_near

Place = tuple[float, float]

# Spots of a snooker table (WPBSA, Official Rules of the Games of Snooker and English Billiards,
# section 1): distances from the nearer short cushion, and the radius of the D [m].
BAULK_LINE, D_RADIUS, BLACK_SPOT = 0.737, 0.292, 0.324


@dataclass(frozen=True, slots=True)
class Rack:
    """
    The balls at the start of a game, without the cue ball.

    Parameters
    ----------
    game : str
        `nine_ball`: a diamond with ball 1 on the foot spot and 9 in the middle. `eight_ball`: a
        triangle with 8 in the middle of the third row, and one ball of each kind in the two back
        corners (both WPA, The Rules of Play). `snooker`: 15 reds in a triangle right behind the
        pink, and six colours on their spots.
    gap : float
        Mean gap between neighbours in the rack [m], at least 0. 0.05 mm is a guess at a careful
        rack. Each ball lies at a random point within half a gap of its site; with 0, all touch.
    seed : int
        Seed of the gaps and of the shuffle, at least 0.

    """

    game: str = choice('nine_ball', 'eight_ball', 'snooker')
    gap: float = number('m', minimum=0, maximum=0.01, default=5e-5)
    seed: int = whole_number(minimum=0, default=0)

    def __post_init__(self) -> None:
        check(self)


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
