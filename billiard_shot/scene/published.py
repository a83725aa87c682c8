"""
Ranges of published values of the numbers of a scene, with their sources.

They are for pool if the source names no other game.
"""

from typing import NamedTuple

PROPERTIES = 'Alciatore: physical properties of pool balls, cues and tables'
EQUIPMENT = 'WPA: Tables & Equipment Specifications'
CUSHION_SOURCE = f'{PROPERTIES}; snooker: Mathavan, Jackson and Parkin, Proc. IMechE C 224 (2010)'
RECORDED = 'carom: recordings of tailuge/billiards; pool and snooker: no rise is reported'
INCH, OUNCE = 0.0254, 0.028349523  # m, kg


class Published(NamedTuple):
    """A range of published values, in the unit of the number."""

    low: float
    high: float
    source: str


PUBLISHED = {
    'ball.mass': Published(5.5 * OUNCE, 6.0 * OUNCE, EQUIPMENT),
    'ball.radius': Published(1.1225 * INCH, 1.1275 * INCH, EQUIPMENT),
    'cue.tip_curvature_radius': Published(9.0e-3, 10.6e-3, 'curvatures of a dime and a nickel'),
    'contacts.cue_ball.restitution': Published(0.71, 0.87, f'{PROPERTIES}: leather to phenolic'),
    'contacts.cue_ball.duration': Published(
        0.8e-3, 3e-3, 'Alciatore: high-speed films, phenolic and fast to soft and slow'
    ),
    'contacts.ball_table.friction': Published(0.15, 0.4, PROPERTIES),
    'contacts.ball_ball.restitution': Published(0.92, 0.98, PROPERTIES),
    'cloth.sliding_friction': Published(0.15, 0.4, PROPERTIES),
    'cloth.rolling_resistance': Published(0.005, 0.015, PROPERTIES),
    'cloth.rolling_rise': Published(0.0, 0.0017, RECORDED),
    'cloth.spin_deceleration': Published(5.0, 15.0, PROPERTIES),
    'table.cushion.restitution': Published(0.6, 0.98, CUSHION_SOURCE),
    'table.cushion.friction': Published(
        0.14, 0.2, f'{CUSHION_SOURCE}; Han, J. Mech. Sci. Technol. 19 (2005)'
    ),
    'table.cushion.height': Published(0.625, 0.645, EQUIPMENT),
    'table.corner.mouth': Published(4.5 * INCH, 4.625 * INCH, EQUIPMENT),
    'table.corner.cut_deg': Published(141.0, 143.0, EQUIPMENT),
    'table.corner.shelf': Published(1.0 * INCH, 2.25 * INCH, EQUIPMENT),
    'table.side.mouth': Published(5.0 * INCH, 5.125 * INCH, EQUIPMENT),
    'table.side.cut_deg': Published(103.0, 105.0, EQUIPMENT),
    'table.side.shelf': Published(0.0, 0.375 * INCH, EQUIPMENT),
}
