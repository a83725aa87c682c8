"""Strokes: whether they can be played, and the cues with which their runs begin."""

from math import hypot, inf, isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Array, Storage, Vector
from billiard_shot.status import CUE_THROUGH_CLOTH, INVALID_STROKE, MISS, NEGATIVE_ELEVATION, OK
from billiard_shot.table.clearance import clearance, nothing_around, Surroundings
from billiard_shot.table.cue import CueParams, CueRecord, follow_through_time
from billiard_shot.table.geometry import TableModel
from billiard_shot.table.initial_states import BallStart
from billiard_shot.table.mapped_strike import ALL_SOLVED, Mapped, SOLVED, write_motion
from billiard_shot.table.motion import FLIGHT
from billiard_shot.table.params import GATE_OFF
from billiard_shot.table.simulation_state import Simulation
from billiard_shot.table.stroke_accuracy import drift_of, strike_tolerance

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
    around : Surroundings
        Compiled functions write its balls.
    mapped : Mapped
        Of the n strokes, or of one that stands for all. Strikes that may reach others are solved.
    checked : bool
        Whether errors are estimated, and a stroke that does not keep its tolerance is told.

    """

    normals: Array
    velocities: Array
    around: Surroundings
    mapped: Mapped = ALL_SOLVED
    checked: bool = False

    def stored(self, storage: Storage, balls: int) -> 'Strokes':
        """Return them as compiled functions take them, for tables of so many balls."""
        return Strokes(
            storage.array(self.normals),
            storage.array(self.velocities),
            self.around._replace(balls=storage.zeros(balls - 1, 2)),
            self.mapped.stored(storage),
            self.checked,
        )


_NONE: NDArray[np.float64] = np.zeros((0, 3))
NO_STROKES = Strokes(_NONE, _NONE, nothing_around(0.0, 1.0))
"""Tables are simulated without a cue."""


@inner
def refusal(around: Surroundings, n: Vector, c: Vector, position: Vector) -> int:
    """Why a stroke along c, at the normal n, cannot be played, or OK."""
    cosine = dot(n, c)
    if not -inf < cosine < inf:
        return INVALID_STROKE
    if cosine > -GRAZING:
        return MISS
    if c[2] > LEVEL:
        return NEGATIVE_ELEVATION
    height = around.ball_radius * (1.0 + n[2])
    lowest = height - around.ferrule_radius * sqrt(max(1.0 - c[2] * c[2], 0.0))
    if lowest < -ROUNDED * height:
        return CUE_THROUGH_CLOTH
    return clearance(around, n, c, position)


@inner
def reaching_speed(table: TableModel, balls: list[BallStart], first: int, count: int) -> float:
    """
    Find the speed of the cue from which on balls may reach others, or noses, in a strike.

    Parameters
    ----------
    table : TableModel
    balls : BallStart
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
            if not balls[i].absent:
                p = balls[i].position
                u, v, w = p[0] - x, p[1] - y, p[2] - z
                nearest = min(nearest, sqrt(u * u + v * v + w * w) - 2.0 * radius)
    near = nearest <= table.cue.neighbour_reach
    return nearest / (FARTHEST * table.cue.tip_duration) if near else inf


@inner
def place_cue(
    table: TableModel,
    s: Simulation,
    balls: list[BallStart],
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
    ball, around, mapped = balls[first], strokes.around, strokes.mapped
    for i in range(len(around.balls)):
        other, place = balls[first + 1 + i], around.balls[i]
        for k in range(2):
            place[k] = nan if other.absent else other.position[k]
    speed = unit(strokes.velocities[number], cue.axis)
    unit(strokes.normals[number], cue.normal)
    cue.status = MISS
    if isfinite(ball.position[0]) and not ball.absent:
        cue.status = refusal(around, cue.normal, cue.axis, ball.position)
    if cue.status != OK:
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
