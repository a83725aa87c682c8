"""Published values of balls, cloth and cushions, with their sources."""

from dataclasses import dataclass

SOURCES = {
    'imaging': (
        'S. Mathavan, M. R. Jackson, R. M. Parkin: Application of high-speed imaging to determine '
        'the dynamics of billiards, Am. J. Phys. 77 (2009)'
    ),
    'prediction': (
        'S. Mathavan, M. R. Jackson, R. M. Parkin: Numerical simulations of the frictional '
        'collisions of solid balls on a rough surface, Sports Engineering 17 (2014)'
    ),
    '30 degrees': (
        'D. G. Alciatore: the 30 degree rule, technical proof TP 3.3 (billiards.colostate.edu)'
    ),
    'draw': 'D. G. Alciatore: draw shots (billiards.colostate.edu)',
    'throw': 'D. G. Alciatore: Throw, part II: results, Billiards Digest, September 2006',
    'throw formula': 'D. G. Alciatore: technical proof TP A.14 (billiards.colostate.edu)',
    'carom': (
        'Recorded shots that repository tailuge/billiards publishes: 99 roll-outs, 363 rebounds'
    ),
    'properties': (
        'D. G. Alciatore: physical properties of pool balls, cues and tables '
        '(billiards.colostate.edu)'
    ),
    'efficiency': 'D. G. Alciatore: cushion efficiency (billiards.colostate.edu)',
    'equipment': 'World Pool-Billiard Association: Tables & Equipment Specifications',
    'speeds': 'D. G. Alciatore: typical speeds of shots (billiards.colostate.edu)',
    'corner five': 'D. G. Alciatore: technical proof TP 7.2 (billiards.colostate.edu)',
    'ramp': 'Roll-outs from a ramp; the publication is not identified',
}


@dataclass(frozen=True, slots=True)
class PublishedCollision:
    """A rolling cue ball meets a resting ball; results after both have stopped slipping."""

    speed: float  # m/s, of the cue ball
    cut: float  # degrees, of the line of centres from the incoming direction
    cue_speed: float  # m/s, after slip
    object_speed: float  # m/s, after slip
    direction: float  # degrees, of the cue ball after slip, from the incoming direction


PUBLISHED_COLLISIONS = (
    PublishedCollision(1.539, 33.83, 0.816, 0.836, 35.96),
    PublishedCollision(1.032, 26.36, 0.520, 0.629, 33.20),
    PublishedCollision(1.364, 40.52, 0.925, 0.700, 30.50),
    PublishedCollision(1.731, 46.50, 1.275, 0.787, 27.97),
    PublishedCollision(0.942, 18.05, 0.365, 0.581, 29.86),
)
SPEED_ACCURACY = 0.011  # m/s

# RMS deviations of the authors' own prediction from these five: object ball and cue ball speed,
# relative; direction of the cue ball in degrees. They fitted restitution and friction between the
# balls. Their friction of the cloth, 0.21, does not matter: speeds after slip do not depend on it.
PREDICTED_RMS = 0.027, 0.058, 1.9
AUTHORS_RESTITUTION = 0.89
AUTHORS_FRICTION = 0.05

REBOUND_RANGE = 0.28, 3.5  # m/s


def rebound_speed(speed: float) -> float:
    """Return the rebound speed [m/s] of a snooker ball that rolls squarely at a cushion: a fit."""
    return (-0.0877 * speed + 1.131) * speed - 0.0953


@dataclass(frozen=True, slots=True)
class Rebounds:
    """
    Medians over rebounds of carom balls that rolled or slid at a cushion and rolled after it.

    Measured from the recorded shots, by lines fitted to the rolling ball before and after. The
    side spin is not known. It hardly changes the speed away from a cushion that is met steeply. At
    more than 20 degrees there are only object balls at their first cushion, whose side spin comes
    from throw alone. The follow of balls that slid is that of a ball which a hit gives a follow of
    -0.08, and which then slides with friction 0.19.
    """

    speed: float  # m/s, before
    angle: float  # degrees, of the way before from the normal of the cushion
    away: float  # from the cushion: speed after over speed before
    away_error: float  # standard error of the median
    along: float | None = None  # the cushion
    along_error: float | None = None
    follow: float = 1.0  # surface speed of the rolling spin over the speed, before


CAROM_REBOUNDS = (
    Rebounds(0.32, 10.0, 0.618, 0.005),
    Rebounds(0.70, 7.0, 0.593, 0.003),
    Rebounds(1.02, 8.0, 0.575, 0.006),
    Rebounds(1.42, 11.0, 0.575, 0.009),
    Rebounds(2.07, 9.0, 0.552, 0.008),
    Rebounds(0.86, 32.0, 0.588, 0.010, 0.694, 0.032),
    Rebounds(0.84, 60.0, 0.533, 0.016, 0.762, 0.012),
    Rebounds(2.85, 9.0, 0.572, 0.010, follow=0.39),
    Rebounds(1.70, 30.0, 0.573, 0.012, follow=0.45),
)

POOL_RESTITUTION = 0.6, 0.9  # of ball and cushion
POOL_KEPT = 0.5  # of the speed, after a cushion that is met steeply: "about half"
# Least way, in table lengths, of a ball that is shot firmly from the head spot along the table.
# The fastest power shot of Alciatore's list and the least rolling resistance of his range.
TABLE_LENGTHS = 4.0, 4.5
POWER_SHOT = 4.4704  # m/s, 10 mph
LEAST_ROLLING = 0.005

# Corner-five system for three cushions: place at the third one = origin - place at the first one.
CORNER_FIVE = (  # origin and place at the first cushion
    (5.0, 2.0),
    (5.0, 2.5),
    (5.0, 3.0),
    (4.5, 1.5),
    (4.5, 2.5),
    (4.0, 1.0),
    (4.0, 2.0),
    (3.0, 1.0),
)

HALF_BALL_DEFLECTION = 33.7  # degrees
DEFLECTION_RANGE = 27.0, 34.0  # degrees, from 1/4 to 3/4 ball
DRAW_DEFLECTION = {0.25: 58.0, 0.5: 90.0, 0.75: 128.0}  # degrees, over the ball-hit fraction

SLOW, FAST = 0.44704, 3.12928  # m/s: 1 and 7 mph, Alciatore's slow and fast shots
THROW_MAXIMUM = 5.8, 35.0  # degrees: throw of a slow stun shot, cut angle (measured)
THROW_FORMULA_MAXIMUM = 5.30, 33.0  # the same, after the formula of TP A.14, for restitution 1
THROW_AT_10_DEGREES = 1.5  # degrees, at any speed (measured)

SNOOKER_ROLLING = 0.0127, 0.0129  # deceleration over gravity
# Speed [m/s], deceleration over gravity there, and its standard error.
CAROM_ROLLING = ((0.26, 0.0043, 0.0001), (0.47, 0.0047, 0.0001), (0.68, 0.0049, 0.0001))

# Height of release and length of the roll-out [m]. The coefficient is published as force over
# weight, m g h = mu m g d. A rolling ball loses 5/7 of that as deceleration over gravity, because
# 2/7 of its energy is in its spin.
RAMP = ((0.013, 0.941), (0.019, 1.295))
RAMP_COEFFICIENT = 0.0142
