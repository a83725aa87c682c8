"""
Direct shots: the cue ball sends a ball straight into a pocket. Found and rated in closed form.

The opening of a pocket (pocket_openings.py), less the directions in which other balls block the
path, is an interval of directions of the ball, and by the geometry of the contact and the throw an
interval of azimuths of the cue ball. A direct shot aims at its middle. The errors of the player
turn the azimuth by a normal error, so that the chance is the probability that this error stays
within half of the interval, and that the error of the speed lets the ball reach the pocket.

The cue hits the cue ball in the middle, with the cue as low as clearance allows. The ball is to
arrive at the pocket at one of a few speeds: at the one with the best chance.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.compiled import entry, inner
from billiard_shot.planning.pocket_openings import ANGLE_STEP, ANGLE_STEPS, ANGLES, HOLE_SPEEDS
from billiard_shot.records import Floats, record, Storage
from billiard_shot.shot.clearance import BUTT
from billiard_shot.table.ball_collision import friction_of_balls
from billiard_shot.table.geometry import (
    lay_out,
    PackedTable,
    PocketGeometry,
    POCKETS,
    TableNumbers,
)
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.params import BallClothParams, GATE_AUTO

NO_BALL, PRESENT, LEGAL = 0, 1, 2  # kinds of a ball: not on the table; on it; also a target
THINNEST = math.cos(math.radians(80.0))  # cosine of the largest cut that is tried
ARRIVALS = 0.5, 1.0, 2.0  # m/s, of the ball at the pocket
CORNERS = 4
# Speeds [m/s], elevations, and their step [rad], of `PlayerRecord.strikes`.
STRIKE_SPEEDS = 0.5, 5.0
ELEVATION_COUNT, ELEVATION_STEP = 25, math.radians(2.5)
# Columns of `PlayerRecord.strikes`, over the speed of the cue: velocity along the stroke, and
# surface speed of the spin along it; changes per a, in ball radii: of the velocity across, of that
# when the ball rolls, and of the surface speed of the spin about the vertical.
COLUMNS = 5
ALONG, TOP, ACROSS, ROLLING, SIDE = range(COLUMNS)
OUT = -10.0  # rad: a bound of an interval without directions


@record
class DirectShot:
    """A direct shot with its stroke; the tip hits the middle of the cue ball."""

    table: int
    ball: int
    pocket: int
    elevation: float  # rad
    azimuth: float  # rad
    speed: float  # m/s, of the cue
    cut: float  # rad, positive if the ball goes off to the left of the cue ball's path
    distance: float  # m that the cue ball goes to the ball
    way: float  # m that the ball goes to the middle of the hole
    chance: float


class PlayerRecord(NamedTuple):
    """Strokes and errors of a player."""

    # (len(STRIKE_SPEEDS), ELEVATION_COUNT, COLUMNS) at elevations in steps of ELEVATION_STEP
    strikes: Floats
    sigma_a: float  # ball radii
    sigma_azimuth: float  # rad
    sigma_speed: float  # m/s
    margin: float  # rad, of the elevation
    lowest: float  # rad, limits of the elevation
    highest: float
    slowest: float  # m/s, limits of the speed
    fastest: float
    cue_length: float  # m, 0: nothing is in the way of the cue
    ferrule_radius: float  # m


class Seen(NamedTuple):
    """One table: its balls, and what they roll on."""

    params: BallClothParams
    numbers: TableNumbers
    places: Floats  # (balls, 2) m
    kinds: Any  # (balls,) ints: NO_BALL, PRESENT or LEGAL


@inner
def edge_of(openings: Floats, pocket: int, angle: float, speed: float, end: int) -> float:
    """Interpolate an end of the opening of a pocket [m], see `openings_of`."""
    x = angle / ANGLE_STEP + ANGLE_STEPS
    if not 0.0 <= x <= ANGLES - 1:
        return 0.0
    y = min(max(math.log2(speed / SPEED_0), 0.0), SPEED_COUNT - 1.0)
    i, j = min(int(x), ANGLES - 2), min(int(y), SPEED_COUNT - 2)
    x, y = x - i, y - j
    of_kind = openings[0] if pocket < CORNERS else openings[1]
    a = of_kind[i][j][end] * (1.0 - y) + of_kind[i][j + 1][end] * y
    b = of_kind[i + 1][j][end] * (1.0 - y) + of_kind[i + 1][j + 1][end] * y
    return a * (1.0 - x) + b * x


SPEED_0, SPEED_COUNT = float(HOLE_SPEEDS[0]), len(HOLE_SPEEDS)


@inner
def turned(angle: float) -> float:
    """Return an angle from -pi to pi."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@inner
def free_part(
    seen: Seen,
    besides: int,
    besides_too: int,
    x: float,
    y: float,
    way: float,
    ahead: float,
    low: float,
    high: float,
) -> tuple[float, float]:
    """
    Cut an interval of directions to those that no ball blocks.

    Parameters
    ----------
    seen : Seen
    besides, besides_too : int
        Balls that are not in the way.
    x, y : float
        Where the path begins [m].
    way : float
        Length of the path [m].
    ahead, low, high : float
        A direction, and the interval around it [rad]: from ahead + low to ahead + high.

    Returns
    -------
    low, high : float
        The part around `ahead`; OUT for both if a ball blocks that direction.

    """
    diameter = 2.0 * seen.params.radius
    along_x, along_y = math.cos(ahead), math.sin(ahead)
    for k in range(len(seen.kinds)):
        if k in (besides, besides_too) or seen.kinds[k] == NO_BALL:
            continue
        u, v = seen.places[k][0] - x, seen.places[k][1] - y
        along, aside = u * along_x + v * along_y, v * along_x - u * along_y
        if along <= 0.0 or along > way + diameter:
            continue
        if abs(aside) > diameter + 1.5 * along * max(high, -low):
            continue
        square = u * u + v * v
        angle = math.atan2(aside, along)
        half = math.asin(min(diameter / math.sqrt(square), 1.0))
        if abs(angle) < half:
            if along - math.sqrt(max(diameter * diameter - aside * aside, 0.0)) < way:
                return OUT, OUT
        elif square - diameter * diameter < way * way:
            if angle > 0.0:
                high = min(high, angle - half)
            else:
                low = max(low, angle + half)
    return low, high


@inner
def needed_speed(params: BallClothParams, way: float, arrival: float) -> float:
    """Speed [m/s] of a ball without spin that arrives at a speed after a way [m]."""
    share = params.inertia / (params.inertia + params.mass * params.radius * params.radius)
    left, slide, roll = 1.0 - share, params.sliding_friction, params.rolling_resistance
    if slide == 0.0:
        return arrival
    # it slides over share (1 - share / 2) v^2 / (mu g), and rolls off at (1 - share) v
    sliding = share * (1.0 - 0.5 * share) / slide
    square = (arrival * arrival + 2.0 * roll * params.gravity * way) / (
        left * left + 2.0 * roll * sliding
    )
    if sliding * square / params.gravity > way:
        square = arrival * arrival + 2.0 * slide * params.gravity * way
    return math.sqrt(square)


@inner
def roll_after(params: BallClothParams, speed: float, way: float) -> float:
    """Surface speed of the spin over the speed, of a ball without spin at first, after a way."""
    slide = 2.0 * params.sliding_friction * params.gravity * way
    if slide >= speed * speed:
        return 1.0
    now = math.sqrt(speed * speed - slide)
    lever = params.mass * params.radius * params.radius / params.inertia
    return min((speed - now) * lever / now, 1.0)


@inner
def throw(seen: Seen, cut: float, speed: float, rolls: float, side: float) -> float:
    """
    Angle by which friction turns a ball away from the line of centres, to the left [rad].

    Coulomb friction at the slip of the two surfaces, which it stops at most (Alciatore, technical
    proof TP A.14).

    Parameters
    ----------
    seen : Seen
    cut : float
        Angle from the path of the cue ball to the line of centres, to the left [rad].
    speed : float
        Of the cue ball [m/s].
    rolls, side : float
        Surface speeds of its spin, along its path, and about the vertical [m/s].

    """
    params = seen.params
    approach = speed * math.cos(cut)
    across, upright = side - speed * math.sin(cut), rolls * math.cos(cut)
    slip = math.sqrt(across * across + upright * upright)
    if slip == 0.0:
        return 0.0
    push = 0.5 * (1.0 + seen.numbers.ball_restitution) * approach  # over the mass
    response = 2.0 * (1.0 + params.mass * params.radius * params.radius / params.inertia)
    drag = min(friction_of_balls(seen.numbers, slip) * push / slip, 1.0 / response)
    return math.atan(drag * across / push)


@inner
def contact_direction(distance: float, diameter: float, off: float) -> float:
    """
    Angle from the path of the cue ball to the line of centres, to the left [rad].

    It passes a ball at a distance [m], whose direction is `off` to the left of the path [rad].
    """
    return math.asin(min(max(distance * math.sin(off) / diameter, -1.0), 1.0))


@inner
def azimuth_to(distance: float, diameter: float, line: float) -> float:
    """
    Direction of the path that makes a line of centres [rad]; both relative to the other ball.

    `line` is the direction of the line of centres, relative to the direction of the ball that is
    hit, whose distance [m] is given.
    """
    return math.atan2(-diameter * math.sin(line), distance - diameter * math.cos(line))


@inner
def needed_elevation(
    seen: Seen, player: PlayerRecord, x: float, y: float, azimuth: float
) -> float:
    """Lowest elevation at which the cue has room behind a ball at (x, y), without margin [rad]."""
    if player.cue_length == 0.0:
        return 0.0
    radius, length, ferrule = seen.params.radius, player.cue_length, player.ferrule_radius
    back_x, back_y = -math.cos(azimuth), -math.sin(azimuth)
    highest = 0.0
    for k in range(len(seen.kinds)):
        u, v = seen.places[k][0] - x, seen.places[k][1] - y
        along = u * back_x + v * back_y
        if seen.kinds[k] == NO_BALL or along <= radius or along > length + radius:
            continue
        aside = v * back_x - u * back_y
        reach = radius + ferrule + (BUTT - ferrule) * along / length
        square = reach * reach - aside * aside
        if square > 0.0:
            highest = max(highest, math.asin(min(math.sqrt(square) / along, 1.0)))
    if seen.numbers.endless:
        return highest
    above = seen.numbers.nose_height - radius
    for axis in range(2):
        half = seen.numbers.nose_half_length if axis == 0 else seen.numbers.nose_half_width
        back, place = (back_x, x) if axis == 0 else (back_y, y)
        if back == 0.0:
            continue
        along = ((half if back > 0.0 else -half) - place) / back
        if 0.0 < along <= length + radius:
            thick = ferrule + (BUTT - ferrule) * along / length
            far = math.sqrt(along * along + above * above)
            over = math.atan2(above, along) + math.asin(min(thick / far, 1.0))
            highest = max(highest, over)
    return highest


@inner
def side_error(
    seen: Seen, player: PlayerRecord, elevation: float, speed: float, way: float
) -> float:
    """Deviation of the cue ball, over its way [m], per error of a in ball radii."""
    params = seen.params
    across = interpolated_strike(player, elevation, speed, ACROSS) * speed
    rolling = interpolated_strike(player, elevation, speed, ROLLING) * speed
    fast = interpolated_strike(player, elevation, speed, ALONG) * speed
    slip = fast - interpolated_strike(player, elevation, speed, TOP) * speed
    share = params.inertia / (params.inertia + params.mass * params.radius * params.radius)
    deceleration = params.sliding_friction * params.gravity
    if slip <= 0.0 or deceleration == 0.0:
        return across / fast
    lasting = slip * share / deceleration
    slides = (fast - 0.5 * share * slip) * lasting
    if way >= slides:
        aside = 0.5 * (across + rolling) * lasting + rolling / (fast - share * slip) * (
            way - slides
        )
    else:
        time = 2.0 * way / (fast + math.sqrt(max(fast * fast - 2.0 * deceleration * way, 0.0)))
        aside = (across + 0.5 * (rolling - across) * time / lasting) * time
    return aside / way


@inner
def interpolated_strike(
    player: PlayerRecord, elevation: float, speed: float, column: int
) -> float:
    """Interpolate a column of `PlayerRecord.strikes`, which depends little on the speed."""
    x = min(max(elevation / ELEVATION_STEP, 0.0), ELEVATION_COUNT - 1.001)
    i = int(x)
    x -= i
    slow, fast = STRIKE_SPEEDS
    y = min(max((speed - slow) / (fast - slow), 0.0), 1.0)
    first, last = player.strikes[0], player.strikes[1]
    a = first[i][column] * (1.0 - x) + first[i + 1][column] * x
    b = last[i][column] * (1.0 - x) + last[i + 1][column] * x
    return a * (1.0 - y) + b * y


@inner
def within(half: float, sigma: float) -> float:
    """Probability that a normal error is at most `half`."""
    return math.erf(half / (sigma * math.sqrt(2.0))) if sigma > 0.0 else 1.0


@inner
def rate_shot(
    seen: Seen,
    player: PlayerRecord,
    openings: Floats,
    hole: PocketGeometry,
    axis: float,
    arrival: float,
    cue: int,
    shot: DirectShot,
) -> bool:
    """
    Rate the shot at `shot.ball` and `shot.pocket` at a speed of arrival [m/s]; write the best.

    Return whether there is a shot. `axis` is the direction into the pocket [rad].
    """
    params, diameter, ball = seen.params, 2.0 * seen.params.radius, shot.ball
    x, y = seen.places[ball][0], seen.places[ball][1]
    px, py = seen.places[cue][0], seen.places[cue][1]
    u, v = hole.hole_x - x, hole.hole_y - y
    way, into = math.sqrt(u * u + v * v), math.atan2(v, u)
    u, v = x - px, y - py
    distance, ahead = math.sqrt(u * u + v * v), math.atan2(v, u)
    if way == 0.0 or distance <= diameter or math.cos(into - ahead) < 0.0:
        return False
    angle = turned(into - axis)
    low, high = 0.0, 0.0
    for _ in range(2):  # the ends of the opening depend on the direction a little
        low = math.asin(max(edge_of(openings, shot.pocket, angle + low, arrival, 0) / way, -1.0))
        high = math.asin(min(edge_of(openings, shot.pocket, angle + high, arrival, 1) / way, 1.0))
        if high <= low:
            return False
    low, high = free_part(seen, cue, ball, x, y, way, ahead=into, low=low, high=high)
    if high <= low:
        return False
    into += 0.5 * (low + high)  # from here on the middle of the directions that pot the ball
    half = 0.5 * (high - low)

    # the azimuth, the speed of the cue ball, and the throw depend on each other a little
    turn, run, cut, moves, azimuth = 0.0, distance - diameter, 0.0, 0.0, 0.0
    goes = needed_speed(params, way, arrival) / (0.5 * (1.0 + seen.numbers.ball_restitution))
    for _ in range(3):
        line = turned(into - turn - ahead)
        if math.cos(line) <= diameter / distance:
            return False  # the ghost ball is behind the ball
        azimuth = azimuth_to(distance, diameter, line)
        cut = line - azimuth
        if math.cos(cut) < THINNEST:
            return False
        run = distance * math.cos(azimuth) - diameter * math.cos(cut)
        moves = goes / math.cos(cut)
        begins = needed_speed(params, run, moves)
        turn = throw(seen, cut, moves, moves * roll_after(params, begins, run), 0.0)
    numbers = seen.numbers
    ghost_x = px + run * math.cos(ahead + azimuth)
    ghost_y = py + run * math.sin(ahead + azimuth)
    if abs(ghost_x) > numbers.centre_half_length or abs(ghost_y) > numbers.centre_half_width:
        return False

    # the interval of azimuths: it ends where the cue ball would miss the ball
    line = turned(into - turn - ahead)
    grazing = math.asin(diameter / distance)
    reach = math.acos(diameter / distance)
    low = azimuth_to(distance, diameter, min(line + half, reach)) - azimuth
    high = azimuth_to(distance, diameter, max(line - half, -reach)) - azimuth
    low, high = max(low, -grazing - azimuth), min(high, grazing - azimuth)
    low, high = free_part(seen, cue, ball, px, py, run, ahead=ahead + azimuth, low=low, high=high)
    if high <= low:
        return False
    azimuth += 0.5 * (low + high)
    half = 0.5 * (high - low)
    cut = contact_direction(distance, diameter, -azimuth)

    elevation = needed_elevation(seen, player, px, py, ahead + azimuth) + player.margin
    elevation = max(elevation, player.lowest)
    if elevation > player.highest:
        return False
    begins = needed_speed(params, run, moves)
    speed = begins / interpolated_strike(player, elevation, begins, ALONG)
    if speed > player.fastest:
        return False
    speed = max(speed, player.slowest)

    # an error of a turns the cue ball, and its side spin throws the ball
    side = interpolated_strike(player, elevation, speed, SIDE) * speed * player.sigma_a
    rolls = moves * roll_after(params, begins, run)
    thrown = throw(seen, cut, moves, rolls, side) - throw(seen, cut, moves, rolls, 0.0)
    # change of the line of centres per azimuth, to the other side
    lever = max(run / (diameter * math.cos(cut)), 1e-3)
    bends = side_error(seen, player, elevation, speed, max(run, 1e-6)) * player.sigma_a
    by_side = bends - thrown / lever
    sigma = math.sqrt(player.sigma_azimuth * player.sigma_azimuth + by_side * by_side)
    stops = needed_speed(params, way, 0.0) / (0.5 * (1.0 + numbers.ball_restitution))
    stops = needed_speed(params, run, stops / math.cos(cut)) / interpolated_strike(
        player, elevation, begins, ALONG
    )
    chance = within(half, sigma)
    if player.sigma_speed > 0.0:
        chance *= 0.5 * (1.0 + math.erf((speed - stops) / (player.sigma_speed * math.sqrt(2.0))))
    if chance <= shot.chance:
        return True
    shot.elevation, shot.azimuth, shot.speed = elevation, turned(ahead + azimuth), speed
    shot.cut, shot.distance, shot.way, shot.chance = cut, run, way, chance
    return True


def example_layout(storage: Storage) -> PackedTable:
    """Lay out a table as entries of direct shots take it."""
    params = BallClothParams(*(1.0,) * 10, 0, 1.0, GATE_AUTO, GATE_AUTO)
    return lay_out(storage, params, ENDLESS)


def _example(storage: Storage) -> tuple[Any, ...]:
    return (
        example_layout(storage),
        storage.array(np.zeros((1, 1, 2))),
        storage.array(np.zeros((1, 1), np.int64)),
        0,
        PlayerRecord(storage.zeros(len(STRIKE_SPEEDS), ELEVATION_COUNT, COLUMNS), *(1.0,) * 10),
        storage.zeros(2, ANGLES, SPEED_COUNT, 2),
        storage.zeros(POCKETS),
        storage.records(DirectShot, 1),
    )


@entry(_example)
def find_direct_shots(
    layout: PackedTable,
    places: Floats,
    kinds: Any,
    cue: int,
    player: PlayerRecord,
    openings: Floats,
    axes: Floats,
    shots: list[DirectShot],
) -> int:
    """
    Find and rate the direct shots of many tables.

    Parameters
    ----------
    layout : PackedTable
    places : (tables, balls, 2) floats
        Centres of the balls [m].
    kinds : (tables, balls) ints
        NO_BALL, PRESENT or LEGAL.
    cue : int
        The cue ball.
    player : Player
    openings : floats
        See `openings_of`.
    axes : (POCKETS,) floats
        Directions into the pockets [rad].
    shots : records of DirectShot, written
        One more than there are shots at most: 6 for each legal ball, and one.

    Returns
    -------
    int
        Number of shots.

    """
    found = 0
    for t in range(len(places)):
        if kinds[t][cue] == NO_BALL:
            continue
        seen = Seen(layout.params, layout.numbers[0], places[t], kinds[t])
        for ball in range(len(kinds[t])):
            if kinds[t][ball] != LEGAL:
                continue
            for pocket in range(POCKETS):
                shot, there = shots[found], False
                shot.table, shot.ball, shot.pocket, shot.chance = t, ball, pocket, -1.0
                for arrival in ARRIVALS:
                    hole = layout.pockets[pocket]
                    there = (
                        rate_shot(
                            seen, player, openings, hole, axes[pocket], arrival, cue=cue, shot=shot
                        )
                        or there
                    )
                if there:
                    found += 1
    return found
