"""Strokes: whether they can be played, and the cues with which their runs begin."""

from math import cos, hypot, inf, isfinite, nan, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot import status
from billiard_shot.compiled import inner
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Array, Floats, Storage, Vector
from billiard_shot.scene import Scene
from billiard_shot.scene.player import A, B, ELEVATION, SPEED
from billiard_shot.table.model.cue import CueParams, CueRecord, follow_through_time
from billiard_shot.table.model.geometry import BallClothParams, GATE_OFF, TableModel
from billiard_shot.table.model.motion import ABSENT, FLIGHT, Simulation, TableBall

# Velocity and spin err together; spin comes with the factor 7/2 of slip against velocity, of which
# the roll that follows keeps 2/7.
AMPLIFICATION = 4.0
HOPS = 0.25  # share of the tolerance for hops that are left out
HOPS_BEFORE_CUSHIONS = 0.1 * HOPS  # cushions magnify the error of a hop ten times
ROLLS = 0.25  # and for rolls whose resistance rises with speed, see rolling.py
CUSHION_SHARE = 0.5  # of the tolerance is set aside for cushions, which magnify errors
# A stroke that is played again gets a share FINER of the tolerance. Its error is far below that
# share, so jaws may magnify it more than a hundred times. The error that is left is at most a
# share LEFT of the change that the repetition made.
FINER, LEFT = 1e-2, 0.05
FINEST_IMPACT, COARSEST_IMPACT = 1e-13, 1e-4  # of what the impact can be asked for


@inner
def strike_tolerance(ball: BallClothParams, speed: float, tolerance: float) -> float:
    """
    Accuracy of the impact, relative to the cue's speed, for a tolerance [m] of the trajectory.

    With it the error is at most half the tolerance, unless `FINEST_IMPACT` is not fine enough: a
    ball leaves at less than twice the speed of the cue.
    """
    lasting = 0.0
    if ball.rolling_resistance > 0.0:
        lasting += 1.0 / ball.rolling_resistance
    if ball.sliding_friction > 0.0:
        lasting += 1.0 / ball.sliding_friction
    if ball.cloth_restitution < 1.0:
        lasting += 2.0 / (1.0 - ball.cloth_restitution)
    duration = 2.0 * speed * lasting / ball.gravity
    accuracy = (
        0.5 * tolerance / (AMPLIFICATION * speed * duration) if duration > 0.0 else FINEST_IMPACT
    )
    return min(max(accuracy, FINEST_IMPACT), COARSEST_IMPACT)


@inner
def drift_of(accuracy: float, speed: float) -> float:
    """Estimate how fast a trajectory departs from the exact one after such an impact [m/s]."""
    return AMPLIFICATION * (accuracy + rounding.SUM) * speed


BUTT = 0.0145  # m: half of the 29 mm that most cues measure at their end
NOSES = 4  # at x > 0, x < 0, y > 0 and y < 0, as in NOSE_NAMES


class Surroundings(NamedTuple):
    """The cue, and what may be in its way. Lengths in m, frame `table`."""

    cue_length: float  # 0: nothing is in its way
    ferrule_radius: float
    ball_radius: float
    half_length: float  # of the rectangle of the noses; infinite without a table
    half_width: float
    nose_height: float
    balls: Any  # (balls, 2) floats: centres of the others

    def stored(self, storage: Storage) -> 'Surroundings':
        """Return them as compiled functions take them."""
        return self._replace(balls=storage.array(self.balls))


def nothing_around(ferrule_radius: float, ball_radius: float) -> Surroundings:
    """Make surroundings without obstacles, for a cue and a ball of these radii [m]."""
    return Surroundings(0.0, ferrule_radius, ball_radius, inf, inf, 0.0, balls=np.zeros((0, 2)))


def surroundings_of(scene: Scene) -> Surroundings:
    """Collect what may be in the way of the cue."""
    ferrule_radius, ball_radius = float(scene.cue.ferrule_radius), float(scene.ball.radius)
    if scene.cue.length == 0.0:
        return nothing_around(ferrule_radius, ball_radius)
    table = scene.table
    half_length, half_width, nose_height = inf, inf, 0.0
    if table is not None:
        half_length, half_width = 0.5 * float(table.length), 0.5 * float(table.width)
        nose_height = 2.0 * ball_radius * table.cushion.height
    return Surroundings(
        float(scene.cue.length),
        ferrule_radius,
        ball_radius,
        half_length,
        half_width,
        nose_height,
        balls=np.array(list(scene.object_balls.values()), float).reshape(-1, 2),
    )


@inner
def clearance(s: Surroundings, n: Vector, c: Vector, position: Vector) -> int:
    """Whether the cue of a stroke has room: OK, CUE_THROUGH_BALL or CUE_THROUGH_CUSHION."""
    if s.cue_length == 0.0:
        return status.OK
    for i in range(len(s.balls)):
        if depth_in_ball(s, i, n, c, position) > rounding.PLACE:
            return status.CUE_THROUGH_BALL
    for i in range(NOSES):
        if depth_in_cushion(s, i, n, c, position) > rounding.PLACE:
            return status.CUE_THROUGH_CUSHION
    return status.OK


@inner
def least_turn(s: Surroundings, n: Vector, c: Vector, position: Vector) -> float:
    """
    Find an angle by which a cue must at least be raised to have clearance [rad].

    A raised cue turns about the centre of the cue ball. So nothing comes out of it by more than
    this angle times its distance from there. Arguments as of `depth_in_ball`.
    """
    turn = 0.0
    for i in range(len(s.balls)):
        x, y = s.balls[i][0] - position[0], s.balls[i][1] - position[1]
        z = s.ball_radius - position[2]
        turn = max(turn, depth_in_ball(s, i, n, c, position) / sqrt(x * x + y * y + z * z))
    for i in range(NOSES):
        along = along_to_nose(s, i, n, c, position)
        if along >= 0.0:
            depth = depth_in_cushion(s, i, n, c, position) * hypot(c[0], c[1])
            turn = max(turn, depth / (along + s.ball_radius))
    return turn


@inner
def depth_in_ball(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """
    How deep the cue would go into a ball [m]; negative if it has room.

    Parameters
    ----------
    s : Surroundings
    i : int
        The ball in `s.balls`.
    n, c : (3,) floats
        Where the tip meets the cue ball, and the direction of the stroke; unit vectors.
    position : (3,) floats
        Centre of the cue ball [m].

    """
    x = s.balls[i][0] - position[0] - s.ball_radius * n[0]
    y = s.balls[i][1] - position[1] - s.ball_radius * n[1]
    z = s.ball_radius - position[2] - s.ball_radius * n[2]
    along = -(x * c[0] + y * c[1] + z * c[2])
    if not along > 0.0:  # what reaches no farther back than the tip is in front of the cue
        return -inf
    along = min(along, s.cue_length)
    x, y, z = x + along * c[0], y + along * c[1], z + along * c[2]
    return s.ball_radius + thickness(s, along) - sqrt(x * x + y * y + z * z)


@inner
def depth_in_cushion(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """How deep the cue would go into a cushion [m]; arguments as of `depth_in_ball`."""
    along = along_to_nose(s, i, n, c, position)
    if along < 0.0:
        return -inf
    height = position[2] + s.ball_radius * n[2] - along * c[2]
    return s.nose_height - height + thickness(s, along) / hypot(c[0], c[1])


@inner
def along_to_nose(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """How far behind its tip a cue is above a nose, or below it [m]; -inf: nowhere."""
    axis, sign = i // 2, 1.0 - 2.0 * (i % 2)
    half = s.half_length if axis == 0 else s.half_width
    toward = -sign * c[axis]
    if toward == 0.0:
        return -inf
    along = (half - sign * (position[axis] + s.ball_radius * n[axis])) / toward
    return along if 0.0 <= along <= s.cue_length else -inf


@inner
def thickness(s: Surroundings, along: float) -> float:
    """Half of the thickness of the cue so far behind its tip [m]."""
    return s.ferrule_radius + (BUTT - s.ferrule_radius) * along / s.cue_length


MOTION = 7  # numbers of a motion: velocity [m/s] and spin [rad/s]; speed of the cue [m/s]
VARIED = [A, B, ELEVATION, SPEED]  # columns of strokes that a polynomial depends on
# Of a, b and elevation. The motion over the speed changes little with the speed, so that the speed
# has few terms: times a linear polynomial of all four.
DEGREE = 3
EXPONENTS = np.array(
    [
        (i, j, k, n)
        for i in range(DEGREE + 1)
        for j in range(DEGREE + 1 - i)
        for k in range(DEGREE + 1 - i - j)
        for n in range(max(DEGREE - i - j - k, 1))
    ]
)  # of `VARIED` in each term, in the order of `write_motion`
TERMS = len(EXPONENTS)


class StrikePolynomials(NamedTuple):
    """
    Strikes of n strokes by polynomials of k cells, see planning/within_noise.py.

    Attributes
    ----------
    strokes : (n, 5) float array
        a, b, elevation, azimuth, speed, see `vectors_of`.
    number : (n,) int array
        The cell of each stroke; SOLVED if its strike is to be solved.
    middles, half_sizes : (k, 4) float arrays
        Of the cells: a and b (ball radii), elevation (rad), speed (m/s).
    coefficients : (k, TERMS, MOTION) float array
        Of the polynomials: the motion after strikes along +x, over the speed of the cue.

    """

    strokes: Array
    number: NDArray[np.int64]
    middles: Array
    half_sizes: Array
    coefficients: Array

    def part(self, part: slice | NDArray[np.integer]) -> 'StrikePolynomials':
        """Return some of the strokes; one stands for all."""
        if len(self.number) == 1:
            return self
        return self._replace(strokes=self.strokes[part], number=self.number[part])

    def stored(self, storage: Storage) -> 'StrikePolynomials':
        """Return them as compiled functions take them."""
        return StrikePolynomials(*map(storage.array, self))


SOLVED = -1
_NO_PIECES = np.zeros((0, len(VARIED)))
ALL_SOLVED = StrikePolynomials(
    np.zeros((1, 5)), np.array([SOLVED]), _NO_PIECES, _NO_PIECES, np.zeros((0, TERMS, MOTION))
)
"""For any number of strokes whose strikes are to be solved."""


@inner
def write_motion(
    stroke: Vector, mapped: StrikePolynomials, cell: int, velocity: Floats, spin: Floats
) -> float:
    """Write the motion of the ball after a stroke by a cell, and return the speed of the cue."""
    middle, half, coefficients = (
        mapped.middles[cell],
        mapped.half_sizes[cell],
        mapped.coefficients[cell],
    )
    x = (abs(stroke[0]) - middle[0]) / half[0]
    y, z = (stroke[1] - middle[1]) / half[1], (stroke[2] - middle[2]) / half[2]
    faster = (stroke[4] - middle[3]) / half[3]
    for k in range(3):
        velocity[k] = spin[k] = 0.0
    speed, term, in_x = 0.0, 0, 1.0
    for i in range(DEGREE + 1):
        in_y = in_x
        for j in range(DEGREE + 1 - i):
            in_z = in_y
            for k in range(DEGREE + 1 - i - j):
                product = in_z
                for _ in range(max(DEGREE - i - j - k, 1)):
                    for m in range(3):
                        velocity[m] += product * coefficients[term][m]
                        spin[m] += product * coefficients[term][3 + m]
                    speed += product * coefficients[term][MOTION - 1]
                    term += 1
                    product *= faster
                in_z *= z
            in_y *= y
        in_x *= x
    # the cells are those of a > 0
    sin_t, cos_t = sin(stroke[3]), cos(stroke[3])
    mirrored = -stroke[4] if stroke[0] < 0.0 else stroke[4]
    for m in range(3):
        velocity[m] *= mirrored if m == 1 else stroke[4]
        spin[m] *= stroke[4] if m == 1 else mirrored
    for vector in (velocity, spin):
        along, across = vector[0], vector[1]
        vector[0], vector[1] = cos_t * along - sin_t * across, sin_t * along + cos_t * across
    return speed * stroke[4]


GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
ROUNDED = 1e-9  # of the tip's height: so deep in the cloth a cue may be by rounding
FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


class Strokes(NamedTuple):
    """
    n strokes, each at ball 0 of a table.

    Attributes
    ----------
    normals : (n, 3) float array
        From the centre of the ball to where the tip touches it, of any length.
    velocities : (n, 3) float array
        Of the cue [m/s]; NaN where there is no stroke.
    obstacles : Surroundings
        Compiled functions write its balls.
    mapped : StrikePolynomials
        Of the n strokes, or of one that stands for all. Strikes that may reach others are solved.
    checked : bool
        Whether errors are estimated, and a stroke that does not keep its tolerance is told.

    """

    normals: Array
    velocities: Array
    obstacles: Surroundings
    mapped: StrikePolynomials = ALL_SOLVED
    checked: bool = False

    def stored(self, storage: Storage, balls: int) -> 'Strokes':
        """Return them as compiled functions take them, for tables of so many balls."""
        return Strokes(
            storage.array(self.normals),
            storage.array(self.velocities),
            self.obstacles._replace(balls=storage.zeros(balls - 1, 2)),
            self.mapped.stored(storage),
            self.checked,
        )


_NO_VECTORS: NDArray[np.float64] = np.zeros((0, 3))
NO_STROKES = Strokes(_NO_VECTORS, _NO_VECTORS, nothing_around(0.0, 1.0))
"""Tables are simulated without a cue."""


@inner
def refusal(obstacles: Surroundings, n: Vector, c: Vector, position: Vector) -> int:
    """Why a stroke along c, at the normal n, cannot be played, or OK."""
    cosine = dot(n, c)
    if not -inf < cosine < inf:
        return status.INVALID_STROKE
    if cosine > -GRAZING:
        return status.MISS
    if c[2] > LEVEL:
        return status.NEGATIVE_ELEVATION
    height = obstacles.ball_radius * (1.0 + n[2])
    lowest = height - obstacles.ferrule_radius * sqrt(max(1.0 - c[2] * c[2], 0.0))
    if lowest < -ROUNDED * height:
        return status.CUE_THROUGH_CLOTH
    return clearance(obstacles, n, c, position)


@inner
def reaching_speed(table: TableModel, balls: list[TableBall], first: int, count: int) -> float:
    """
    Find the speed of the cue from which on balls may reach others, or noses, in a strike.

    Parameters
    ----------
    table : TableModel
    balls : TableBall
        Of many tables; those of this one are `count`, from `first` on, which is struck.

    Returns
    -------
    float
        [m/s]; infinite if no others are near.

    """
    n, radius = table.numbers, table.params.radius
    x, y, z = balls[first].position[0], balls[first].position[1], balls[first].position[2]
    away = min(n.nose_half_length - abs(x), n.nose_half_width - abs(y))
    nearest = hypot(away, z - n.nose_height) - radius
    if n.pair_gate != GATE_OFF:
        for i in range(first + 1, first + count):
            if balls[i].motion != ABSENT:
                p = balls[i].position
                u, v, w = p[0] - x, p[1] - y, p[2] - z
                nearest = min(nearest, sqrt(u * u + v * v + w * w) - 2.0 * radius)
    near = nearest <= table.cue.neighbour_reach
    return nearest / (FARTHEST * table.cue.tip_duration) if near else inf


@inner
def place_cue(
    table: TableModel,
    s: Simulation,
    balls: list[TableBall],
    first: int,
    strokes: Strokes,
    number: int,
    tolerance: float,
    cue: CueRecord,
) -> None:
    """
    Put the cue of a stroke at ball 0 of its table, or note why the stroke is refused.

    If its strike is mapped, the ball begins as the strike leaves it.

    Parameters
    ----------
    table : TableModel
    s : Simulation
        Its balls are placed already.
    balls, first
        As of `reaching_speed`.
    strokes : Strokes
    number : int
        The stroke.
    tolerance : float
        Of the trajectory [m].
    cue : CueRecord
        Written; if the stroke is refused only its status.

    """
    ball, obstacles, mapped = balls[first], strokes.obstacles, strokes.mapped
    for i in range(len(obstacles.balls)):
        other, place = balls[first + 1 + i], obstacles.balls[i]
        for k in range(2):
            place[k] = nan if other.motion == ABSENT else other.position[k]
    speed = unit(strokes.velocities[number], cue.axis)
    unit(strokes.normals[number], cue.normal)
    cue.status = status.MISS
    if isfinite(ball.position[0]) and ball.motion != ABSENT:
        cue.status = refusal(obstacles, cue.normal, cue.axis, ball.position)
    if cue.status != status.OK:
        for k in range(3):
            cue.axis[k] = cue.normal[k] = 0.0
    else:
        for k in range(3):
            cue.tip[k] = ball.position[k] + table.cue.reach * cue.normal[k]
        cue.others = speed >= reaching_speed(table, balls, first, len(s.balls))
        cell = mapped.number[number % len(mapped.number)]
        cue.strikes = cell == SOLVED or cue.others
        if cue.strikes:
            cue.speed, cue.tolerance = speed, strike_tolerance(table.params, speed, tolerance)
            cue.drift = drift_of(cue.tolerance, speed)
        else:
            strike_as_mapped(table.cue, s, strokes, number, cell, cue)
    for k in range(3):
        s.cue.position[k], s.cue.velocity[k] = cue.tip[k], cue.speed * cue.axis[k]
    s.cue.end = cue.end
    s.cue.motion = FLIGHT  # its height counts


@inner
def strike_as_mapped(
    q: CueParams, s: Simulation, strokes: Strokes, number: int, cell: int, cue: CueRecord
) -> None:
    """Let ball 0 and the cue of a stroke begin as the polynomial of a cell says."""
    ball, mapped = s.balls[0], strokes.mapped
    cue.speed = write_motion(mapped.strokes[number], mapped, cell, cue.velocity, cue.spin)
    for k in range(3):
        ball.velocity[k], ball.spin[k] = cue.velocity[k], cue.spin[k]
    if not q.on_cloth:  # a ball that would go down is put onto the cloth
        ball.velocity[2] = max(ball.velocity[2], 0.0)
    cue.hits, cue.double_hit, cue.end = 1, inf, follow_through_time(q.follow_through, cue.speed)
