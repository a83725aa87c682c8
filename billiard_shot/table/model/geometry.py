"""
What balls meet on the table, in the form that compiled code takes: numbers, lines and arcs.

Pockets are numbered 0 to 5: corners in the quadrants (+, +), (-, +), (-, -), (+, -) of (x, y),
then the sides at y > 0 and y < 0. Each has two jaws, numbered 2 p and 2 p + 1: an arc that rounds
off the end of a nose, and the facing that goes on from it into the pocket.
"""

from math import gamma, inf, pi, sqrt
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.records import Floats, record
from billiard_shot.table.model.cue import CueParams

GATE_AUTO, GATE_ON, GATE_OFF = 0, 1, 2

Mouth = tuple[float, float, float, float, float]
NO_MOUTH: Mouth = (1.0, 1.0, 0.0, 0.0, 0.0)


class BallClothParams(NamedTuple):
    """A ball and the cloth it is on. Effects override fields by name, see table/effects."""

    mass: float  # kg
    radius: float  # m
    inertia: float  # kg m^2
    gravity: float  # m/s^2
    sliding_friction: float  # coefficient while the ball slides; inf: it rolls at once
    rolling_resistance: float  # deceleration of a rolling ball, relative to gravity
    rolling_rise: float  # s/m, of that with speed, see rolling.py
    spin_deceleration: float  # of the spin about the vertical, rad/s^2
    cloth_restitution: float  # of a bounce
    cloth_friction: float  # coefficient in a bounce
    law: int  # of restitution in clusters, see billiard_shot.impact.options
    exponent: float  # of the virtual springs
    flight_gate: int = GATE_AUTO  # GATE_AUTO, GATE_ON or GATE_OFF
    bounce_gate: int = GATE_AUTO  # or GATE_ON; off is a restitution of 0


class TableParams(NamedTuple):
    """
    A table, and how balls meet it and each other; by default cloth without end, for one ball.

    Infinite length: there are no cushions. Effects override fields by name, see table/effects. A
    mouth is its width [m], sine and cosine of the turn from nose to facing, radius of the jaws
    [m], and setback [m]: how far along the nose the jaw begins before the point where nose and
    facing would meet.
    """

    length: float = inf  # m
    width: float = inf  # m
    pockets: bool = False
    cushion_model: int = 0  # see cushion_models.py
    cushion_restitution: float = 0.0
    cushion_friction: float = 0.0
    cushion_early_fading: float = 0.0  # s/m, of the restitution, from low speeds on
    cushion_fading: float = 0.0  # s/m, of the restitution, at high speeds
    cushion_frequency_ratio: float = 0.0  # of the tangential spring to the normal one; 0: none
    cushion_stiffness: float = 1.0  # for a strike on a ball that touches a cushion
    cushion_duration: float = 0.0  # s, of a contact; 0: none
    cushion_depth: float = 0.0  # m
    nose_height: float = 0.0  # m, above the cloth
    corner: Mouth = NO_MOUTH
    side: Mouth = NO_MOUTH
    # m: distance of its centre from the corner, radius
    corner_hole: tuple[float, float] = 0.0, 0.0
    side_hole: tuple[float, float] = 0.0, 0.0  # m: the same, from the line of noses
    ball_restitution: float = 1.0
    ball_stiffness: float = 1.0
    ball_duration: float = 0.0  # s, of a contact of two balls that meet at `DURATION_SPEED`
    friction_fast: float = 0.0
    friction_slow: float = 0.0  # of balls: fast + slow exp(-decay slip)
    friction_decay: float = 0.0  # s/m
    contact_gap: float = 0.0  # m, within which bodies touch
    pair_gate: int = GATE_AUTO  # GATE_ON: looks at every pair of balls; GATE_OFF: at none
    pocket_gate: int = GATE_AUTO  # GATE_ON: every pocket is looked at


DURATION_SPEED = 3.0  # m/s, of the contacts of balls and cushions
STROKE_SPEED = 2.0  # m/s, of those of a struck ball with tip and cloth


def duration_constant(exponent: float) -> float:
    """Return the constant C of a spring's exponent."""
    x = 1.0 / (exponent + 1.0)
    return 2.0 * sqrt(pi) * gamma(1.0 + x) / gamma(0.5 + x)


def stiffness_of(
    mass: float,
    duration: float,
    exponent: float,
    speed: float = DURATION_SPEED,
    restitution: float = 1.0,
) -> float:
    """
    Stiffness of two balls whose contact has a duration [N/m^exponent].

    Parameters
    ----------
    mass : float
        Of each ball [kg]: twice the effective mass of two bodies.
    duration : float
        From touch to parting [s].
    exponent : float
        Of the spring.
    speed : float
        At which they meet [m/s].
    restitution : float

    """
    depth = speed * 2.0 * duration / (1.0 + restitution) / duration_constant(exponent)
    return 0.25 * (exponent + 1.0) * mass * speed**2 / depth ** (exponent + 1.0)


@inner
def reach_of_impact(
    gap: float, duration: float, exponent: float, approach: float, along: float
) -> float:
    """
    Distance [m] up to which balls take part in the impact of two balls.

    A ball that touches another one goes as far while they do: along the line of centres half of
    what their approach gives, because they part at the same speeds exchanged; across it all.

    Parameters
    ----------
    gap : float
        Between bodies that touch [m].
    duration : float
        Of a contact at DURATION_SPEED [s].
    exponent : float
        Of the springs.
    approach, along : float
        Speed at which the balls meet; the larger one of their speeds across that direction [m/s].

    """
    if duration == 0.0:
        return gap
    slower = (DURATION_SPEED / approach) ** ((exponent - 1.0) / (exponent + 1.0))
    speed = sqrt((0.5 * approach) ** 2 + along * along)
    return max(gap, speed * duration * slower)


POCKETS = 6


@record
class TableNumbers(TableParams):
    """A table as compiled code takes it: its numbers, and what follows from them; lengths in m."""

    endless: bool  # there are no cushions
    centre_half_length: float  # of where a lying ball's centre can be
    centre_half_width: float
    nose_standoff: float  # horizontal distance from a nose at which a lying ball touches it
    nose_half_length: float  # of the rectangle of the noses
    nose_half_width: float
    corner_end: float  # from the corner to the straight nose's end, along the nose; 0: no pockets
    side_end: float  # from the middle of a long side to the straight nose's end
    impact_stiffness: float  # N/m^exponent, of balls with `ball_duration`
    hop_tolerance: float  # for leaving out hops after impacts


@record
class Jaw:
    """An arc at the end of a nose, and the facing that goes on from it [m]."""

    arc_x: float  # centre
    arc_y: float
    arc_radius: float
    start_x: float  # of the facing
    start_y: float
    end_x: float
    end_y: float
    normal_x: float  # of the facing, a unit vector into the mouth
    normal_y: float


@record
class PocketGeometry:
    """A hole, and the rectangle in which a ball's centre can meet anything of the pocket [m]."""

    hole_x: float  # centre
    hole_y: float
    hole_radius: float
    bounds_x: float  # centre
    bounds_y: float
    bounds_half_length: float
    bounds_half_width: float


class TableModel(NamedTuple):
    """All that a simulation takes of a table."""

    params: BallClothParams
    numbers: TableNumbers
    jaws: list[Jaw]  # 12, or none
    pockets: list[PocketGeometry]  # 6, or none
    rebounds: Floats  # see table/contacts/cushion_models.py; empty: all rebounds are solved
    cue: CueParams
    tolerance: float = 1.0  # m, for leaving out bounces of a ball that flies
    roll_tolerance: float = 1.0  # m, for dividing rolls, see rolling.py


class PackedTable(NamedTuple):
    """A `TableModel` as compiled code is given it: to pass a record of its own takes long."""

    params: BallClothParams
    numbers: list[TableNumbers]  # 1
    jaws: list[Jaw]
    pockets: list[PocketGeometry]
    rebounds: Floats
    cue: CueParams
