"""
Direct shots: the cue ball sends a ball straight into a pocket. Found and rated in closed form.

The directions that pot the ball (pockets.py) are an interval. By the geometry of the
contact and the throw they become an interval of azimuths of the cue ball. A direct shot aims at
its middle. The errors of the player turn the azimuth by a normal error, so that the chance is the
probability that this error stays within half of the interval, and that the error of the speed lets
the ball reach the pocket.

The cue hits the cue ball in the middle, with the cue as low as clearance allows. The ball is to
arrive at the pocket at one of a few speeds: at the one with the best chance.
"""

import math
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.planning.pockets import (
    ARRIVALS,
    ball_fits,
    Directions,
    example_tables,
    free_directions,
    LEGAL,
    NO_BALL,
    pot_of,
    PotInterval,
    TableView,
)
from billiard_shot.records import Floats, record, Storage
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.shot.ghost_ball import cut_of_path, grazing, path_of_line
from billiard_shot.shot.lowest_elevation import clear_elevation, example_raising, Raising
from billiard_shot.table.contacts.balls import friction_of_balls
from billiard_shot.table.model.geometry import BallClothParams, PackedTable, POCKETS
from billiard_shot.table.motion.cloth import rolling_after, rolling_share, speed_to_arrive
from billiard_shot.table.strike.placement import BUTT

THINNEST = math.cos(math.radians(80.0))  # cosine of the largest cut that is tried
# Speeds [m/s], elevations, and their step [rad], of `CentralStrikes`.
STRIKE_SPEEDS = 0.5, 5.0
ELEVATION_COUNT, ELEVATION_STEP = 25, math.radians(2.5)
# Wider intervals of paths [rad] are searched for the throw, in so many steps to each side. Their
# ends may be beside the directions that pot by this share of half of the width of these.
NARROW_PATHS, PATH_STEPS, SLACK = 0.1, 16, 0.1
# rad: where the balls meet while the tip still pushes, the cue ball turns along the other ball,
# and friction acts at other slips. So much the ball then leaves beside the throw that is stated:
# the root mean square of strikes at 0.7 to 5 m/s, with gaps of 0.2 to 3 mm and cuts up to 70
# degrees.
PUSHED_ERROR = math.radians(0.8)


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


class CentralStrikes(NamedTuple):
    """
    Strikes in the middle, (STRIKE_SPEEDS, ELEVATION_COUNT) each, over the speed of the cue.

    They are at multiples of ELEVATION_STEP.
    """

    forward: Floats  # velocity along the stroke
    roll: Floats  # surface speed of the spin along the stroke
    # Changes per a, in ball radii:
    across: Floats  # of the velocity to the left
    rolling_across: Floats  # of that velocity when the ball rolls
    side: Floats  # of the surface speed of the spin about the vertical


class PlayerRecord(NamedTuple):
    """Strokes, limits and errors of a player."""

    strikes: CentralStrikes
    sigma_a: float  # ball radii
    sigma_azimuth: float  # rad
    sigma_speed: float  # m/s
    sigma_balls: float  # m, of the places of balls
    pushing: float  # s that the tip pushes the cue ball
    slowest: float  # m/s, limits of the speed
    fastest: float
    lowest: float  # rad, of the elevation
    raising: Raising  # its place, and its balls, as many as a table has, are written
    stroke: Floats  # (5,) as low as errors make it; its azimuth is written


class Aim(NamedTuple):
    """How the cue ball meets a ball; directions as in ghost_ball.py."""

    distance: float  # m, of the ball
    ahead: float  # rad, direction of the ball, frame `table`
    line: float
    path: float
    run: float  # m that the cue ball goes; below 0: it cannot send the ball there
    speed: float  # m/s of the cue ball at the contact


@inner
def lies_behind(seen: TableView, cue: int, ball: int, pocket: int) -> bool:
    """Whether the cue ball lies on the side of a ball from which it can go towards a pocket."""
    x, y = seen.places[ball][0], seen.places[ball][1]
    u, v = x - seen.places[cue][0], y - seen.places[cue][1]
    ahead = u * (seen.holes[pocket].hole_x - x) + v * (seen.holes[pocket].hole_y - y)
    return ahead >= 0.0 and u * u + v * v > 4.0 * seen.params.radius * seen.params.radius


@inner
def aimed(seen: TableView, cue: int, ball: int, into: float, speed: float) -> Aim:
    """Aim so that a ball leaves in a direction [rad], with the speed of a full hit [m/s]."""
    params, diameter = seen.params, 2.0 * seen.params.radius
    x, y = seen.places[cue][0], seen.places[cue][1]
    u, v = seen.places[ball][0] - x, seen.places[ball][1] - y
    distance, ahead = math.sqrt(u * u + v * v), math.atan2(v, u)
    turn, path, run, moves = 0.0, 0.0, 0.0, 0.0
    # the path, the speed of the cue ball, and the throw depend on each other a little
    for _ in range(3):
        line = wrapped(into - turn - ahead)
        if math.cos(line) <= diameter / distance:  # the ghost ball is behind the ball
            return Aim(distance, ahead, line, 0.0, -1.0, 0.0)
        path = path_of_line(distance, diameter, line)
        cut = line - path
        if math.cos(cut) < THINNEST:
            return Aim(distance, ahead, line, path, -1.0, 0.0)
        run = distance * math.cos(path) - diameter * math.cos(cut)
        moves = speed / math.cos(cut)
        rolls = rolling_after(params, speed_to_arrive(params, run, moves), run)
        turn = throw_angle(seen, cut, moves, moves * rolls, 0.0)
    if not ball_fits(seen, x + run * math.cos(ahead + path), y + run * math.sin(ahead + path)):
        run = -1.0
    return Aim(distance, ahead, wrapped(into - turn - ahead), path, run, moves)


@inner
def paths_of(seen: TableView, cue: int, ball: int, aim: Aim, half: float) -> Directions:
    """Find the free paths of the cue ball whose lines of centres are within `half` of `aim`."""
    diameter, distance = 2.0 * seen.params.radius, aim.distance
    most, reach = grazing(distance, diameter), math.acos(diameter / distance)
    low = path_of_line(distance, diameter, min(aim.line + half, reach))
    high = path_of_line(distance, diameter, max(aim.line - half, -reach))
    low, high = max(low, -most) - aim.path, min(high, most) - aim.path
    wanted = Directions(aim.ahead + aim.path, low, high)
    x, y = seen.places[cue][0], seen.places[cue][1]
    return free_directions(seen, cue, ball, x, y, aim.run, wanted)


@inner
def thrown_within(
    seen: TableView, aim: Aim, paths: Directions, into: float, half: float
) -> Directions:
    """
    Cut an interval of paths to those that send the ball within `half` of a direction [rad].

    Where the balls nearly touch, the line of centres is nearly the same for all paths, but the
    throw is not. From the path of `aim`, each end goes as far as the throw allows.
    """
    if paths.high - paths.low < NARROW_PATHS:
        return paths
    ahead, low, high = paths
    low *= part_thrown(seen, aim, ahead, low, into, half)
    high *= part_thrown(seen, aim, ahead, high, into, half)
    return Directions(ahead, low, high)


@inner
def part_thrown(
    seen: TableView, aim: Aim, ahead: float, end: float, into: float, half: float
) -> float:
    """Part of the way to an end of the paths on which the throw stays, see `thrown_within`."""
    for k in range(PATH_STEPS + 1):
        if thrown_beside(seen, aim, ahead + end * k / PATH_STEPS, into) > half:
            return max(k - 1, 0) / PATH_STEPS
    return 1.0


@inner
def thrown_beside(seen: TableView, aim: Aim, path: float, into: float) -> float:
    """Angle between where a path of the cue ball sends the ball, and a direction [rad]."""
    cut = cut_of_path(aim.distance, 2.0 * seen.params.radius, path - aim.ahead)
    rolls = rolling_after(seen.params, speed_to_arrive(seen.params, aim.run, aim.speed), aim.run)
    turn = throw_angle(seen, cut, aim.speed, aim.speed * rolls, 0.0)
    return abs(wrapped(path + cut + turn - into))


@inner
def throw_angle(seen: TableView, cut: float, speed: float, rolls: float, side: float) -> float:
    """
    Angle by which friction turns a ball away from the line of centres, to the left [rad].

    Coulomb friction at the slip of the two surfaces, which it stops at most (Alciatore, technical
    proof TP A.14).

    Parameters
    ----------
    seen : TableView
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
def elevation_at(seen: TableView, player: PlayerRecord, cue: int, azimuth: float) -> float:
    """Find the lowest elevation with clearance for errors [rad], NaN if there is none."""
    place, balls = player.raising.place, player.raising.obstacles.balls
    place[0], place[1], place[2] = seen.places[cue][0], seen.places[cue][1], seen.params.radius
    ahead_x, ahead_y = math.cos(azimuth), math.sin(azimuth)
    for k in range(len(seen.kinds)):
        balls[k][0], balls[k][1] = seen.places[k][0], seen.places[k][1]
        u, v = balls[k][0] - place[0], balls[k][1] - place[1]
        beside = abs(v * ahead_x - u * ahead_y) > seen.params.radius + BUTT
        if k == cue or beside or seen.kinds[k] == NO_BALL:  # put it in front, out of the way
            balls[k][0], balls[k][1] = place[0] + ahead_x, place[1] + ahead_y
    player.stroke[AZIMUTH] = azimuth
    return clear_elevation(player.raising, player.stroke, player.lowest)


@inner
def at(column: Floats, elevation: float, speed: float) -> float:
    """Interpolate a column of `CentralStrikes`, which depends little on the speed."""
    x = min(max(elevation / ELEVATION_STEP, 0.0), ELEVATION_COUNT - 1.001)
    i = int(x)
    x -= i
    slow, fast = STRIKE_SPEEDS
    y = min(max((speed - slow) / (fast - slow), 0.0), 1.0)
    first = column[0][i] * (1.0 - x) + column[0][i + 1] * x
    last = column[1][i] * (1.0 - x) + column[1][i + 1] * x
    return first * (1.0 - y) + last * y


@inner
def side_error(
    params: BallClothParams, strikes: CentralStrikes, elevation: float, speed: float, way: float
) -> float:
    """Deviation of the cue ball, over its way [m], per error of a in ball radii."""
    across = at(strikes.across, elevation, speed) * speed
    rolling = at(strikes.rolling_across, elevation, speed) * speed
    fast = at(strikes.forward, elevation, speed) * speed
    slip = fast - at(strikes.roll, elevation, speed) * speed
    share = 1.0 / rolling_share(params)
    deceleration = params.sliding_friction * params.gravity
    if slip <= 0.0 or deceleration == 0.0:
        return across / fast
    lasting = slip * share / deceleration
    slides = (fast - 0.5 * share * slip) * lasting
    if way >= slides:
        aside = 0.5 * (across + rolling) * lasting
        aside += rolling / (fast - share * slip) * (way - slides)
    else:
        time = 2.0 * way / (fast + math.sqrt(max(fast * fast - 2.0 * deceleration * way, 0.0)))
        aside = (across + 0.5 * (rolling - across) * time / lasting) * time
    return aside / way


@inner
def within(half: float, sigma: float) -> float:
    """Probability that a normal error is at most `half`."""
    return math.erf(half / (sigma * math.sqrt(2.0))) if sigma > 0.0 else 1.0


class StrokeRating(NamedTuple):
    """A stroke that plays a direct shot."""

    speed: float  # m/s, of the cue
    chance: float  # below 0: the cue would have to be too fast


@inner
def rate_stroke(
    seen: TableView,
    player: PlayerRecord,
    pot: PotInterval,
    aim: Aim,
    cut: float,
    half: float,
    elevation: float,
) -> StrokeRating:
    """Rate the stroke at an elevation [rad] whose path may be wrong by `half` of an interval."""
    params, run = seen.params, aim.run
    begins = speed_to_arrive(params, run, aim.speed)
    forward = at(player.strikes.forward, elevation, begins)
    speed = max(begins / forward, player.slowest)
    if speed > player.fastest:
        return StrokeRating(speed, -1.0)

    # an error of a turns the cue ball, and its side spin throws the ball
    side = at(player.strikes.side, elevation, speed) * speed * player.sigma_a
    rolls = aim.speed * rolling_after(params, begins, run)
    thrown = throw_angle(seen, cut, aim.speed, rolls, side) - throw_angle(
        seen, cut, aim.speed, rolls, 0.0
    )
    # change of the line of centres per azimuth, to the other side
    lever = max(run / (2.0 * params.radius * math.cos(cut)), 1e-3)
    bends = side_error(params, player.strikes, elevation, speed, max(run, 1e-6)) * player.sigma_a
    by_side = bends - thrown / lever
    # the places of both balls turn the line between them, as errors of the azimuth do
    apart = player.sigma_balls / aim.distance
    square = player.sigma_azimuth * player.sigma_azimuth + by_side * by_side + 2.0 * apart * apart
    if run < 0.5 * begins * player.pushing:
        square += PUSHED_ERROR * PUSHED_ERROR / (lever * lever)
    sigma = math.sqrt(square)
    chance = within(half, sigma)

    if player.sigma_speed > 0.0:
        stops = full_hit(seen, speed_to_arrive(params, pot.way, 0.0)) / math.cos(cut)
        spare = speed - speed_to_arrive(params, run, stops) / forward
        chance *= 0.5 * (1.0 + math.erf(spare / (player.sigma_speed * math.sqrt(2.0))))
    return StrokeRating(speed, chance)


@inner
def full_hit(seen: TableView, speed: float) -> float:
    """Speed of a ball that gives another one a speed [m/s] in a full hit."""
    return speed / (0.5 * (1.0 + seen.numbers.ball_restitution))


@inner
def rate_shot(
    seen: TableView, player: PlayerRecord, arrival: float, cue: int, shot: DirectShot
) -> bool:
    """
    Rate the shot at `shot.ball` and `shot.pocket` at a speed of arrival [m/s]; write the best.

    Return whether there is a shot.
    """
    params, ball = seen.params, shot.ball
    pot = pot_of(seen, ball, shot.pocket, cue, arrival)
    if pot.half <= 0.0:
        return False
    pushed = full_hit(seen, speed_to_arrive(params, pot.way, arrival))
    aim = aimed(seen, cue, ball, pot.into, pushed)
    if aim.run < 0.0:
        return False
    paths = paths_of(seen, cue, ball, aim, pot.half)
    paths = thrown_within(seen, aim, paths, pot.into, (1.0 + SLACK) * pot.half)
    half = 0.5 * (paths.high - paths.low)
    if half <= 0.0:
        return False
    azimuth = paths.ahead + 0.5 * (paths.low + paths.high)
    cut = cut_of_path(aim.distance, 2.0 * params.radius, azimuth - aim.ahead)

    if shot.chance >= 0.0:  # the clearance takes long to find, and changes the chance little
        rated = rate_stroke(seen, player, pot, aim, cut, half, shot.elevation)
        if rated.chance <= shot.chance:
            return True
    elevation = elevation_at(seen, player, cue, azimuth)
    if math.isnan(elevation):
        return False
    rated = rate_stroke(seen, player, pot, aim, cut, half, elevation)
    if rated.chance > shot.chance:
        shot.elevation, shot.azimuth, shot.speed = elevation, wrapped(azimuth), rated.speed
        shot.cut, shot.distance, shot.way, shot.chance = cut, aim.run, pot.way, rated.chance
    return rated.chance >= 0.0


def _example(storage: Storage) -> tuple[Any, ...]:
    column = storage.zeros(len(STRIKE_SPEEDS), ELEVATION_COUNT)
    strikes = CentralStrikes(*(column,) * 5)
    raising = example_raising(storage)
    return (
        *example_tables(storage),
        0,
        PlayerRecord(strikes, *(1.0,) * 8, raising, storage.zeros(5)),
        storage.records(DirectShot, 1),
    )


@entry(_example)
def find_direct_shots(
    layout: PackedTable,
    openings: Floats,
    axes: Floats,
    places: Floats,
    kinds: Any,
    cue: int,
    player: PlayerRecord,
    shots: list[DirectShot],
) -> int:
    """
    Find and rate the direct shots of many tables.

    Parameters
    ----------
    layout, openings, axes
        See `TableView`.
    places : (tables, balls, 2) floats
        Centres of the balls [m].
    kinds : (tables, balls) ints
        NO_BALL, PRESENT or LEGAL.
    cue : int
        The cue ball.
    player : PlayerRecord
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
        numbers, holes = layout.numbers[0], layout.pockets
        seen = TableView(layout.params, numbers, holes, openings, axes, places[t], kinds[t])
        for ball in range(len(kinds[t])):
            if kinds[t][ball] != LEGAL:
                continue
            for pocket in range(POCKETS):
                shot, there = shots[found], False
                shot.table, shot.ball, shot.pocket, shot.chance = t, ball, pocket, -1.0
                if lies_behind(seen, cue, ball, pocket):
                    for arrival in ARRIVALS:
                        there = rate_shot(seen, player, arrival, cue, shot) or there
                if there:
                    found += 1
    return found
