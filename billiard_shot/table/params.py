"""Parameters that the motion on the table depends on, in the form that compiled code takes."""

from typing import NamedTuple

GATE_AUTO, GATE_ON, GATE_OFF = 0, 1, 2

Mouth = tuple[float, float, float, float, float]


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
    law: int  # of restitution in clusters, see billiard_shot.impact.laws
    exponent: float  # of the virtual springs
    flight_gate: int  # GATE_AUTO, GATE_ON or GATE_OFF
    bounce_gate: int = GATE_AUTO  # or GATE_ON; off is a restitution of 0


class TableParams(NamedTuple):
    """
    A table, and how balls meet it and each other. Infinite length: there are no cushions.

    Effects override fields by name, see table/effects. A mouth is its width [m], sine and cosine
    of the turn from nose to facing, radius of the jaws [m], and setback [m]: how far along the
    nose the jaw begins before the point where nose and facing would meet.
    """

    length: float  # m
    width: float  # m
    pockets: bool
    cushion_model: int  # see cushion_models.py
    cushion_restitution: float
    cushion_friction: float
    cushion_early_fading: float  # s/m, of the restitution, from low speeds on
    cushion_fading: float  # s/m, of the restitution, at high speeds
    cushion_frequency_ratio: float  # of the tangential spring to the normal one; 0: none
    cushion_stiffness: float  # for a strike on a ball that touches a cushion
    cushion_duration: float  # s, of a contact; 0: none
    nose_height: float  # m, above the cloth
    cushion_depth: float  # m
    corner: Mouth
    side: Mouth
    corner_hole: tuple[float, float]  # m: distance of its centre from the corner, radius
    side_hole: tuple[float, float]  # m: distance of its centre from the line of noses, radius
    ball_restitution: float
    friction_fast: float
    friction_slow: float  # of balls: fast + slow exp(-decay slip)
    friction_decay: float  # s/m
    ball_stiffness: float
    ball_duration: float  # s, of a contact of two balls that meet at `DURATION_SPEED`
    contact_gap: float  # m, within which bodies touch
    pair_gate: int = GATE_AUTO  # GATE_ON: looks at every pair of balls; GATE_OFF: at none
    pocket_gate: int = GATE_AUTO  # GATE_ON: every pocket is looked at
