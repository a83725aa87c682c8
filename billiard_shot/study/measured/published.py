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
    'carom': '99 roll-outs among the recorded shots that repository tailuge/billiards publishes',
    'ramp': 'Roll-outs from a ramp; the publication is not identified',
}


@dataclass(frozen=True, slots=True)
class Collision:
    """A rolling cue ball meets a resting ball; results after both have stopped slipping."""

    speed: float  # m/s, of the cue ball
    cut: float  # degrees, of the line of centres from the incoming direction
    cue_speed: float  # m/s, after slip
    object_speed: float  # m/s, after slip
    direction: float  # degrees, of the cue ball after slip, from the incoming direction


COLLISIONS = (
    Collision(1.539, 33.83, 0.816, 0.836, 35.96),
    Collision(1.032, 26.36, 0.520, 0.629, 33.20),
    Collision(1.364, 40.52, 0.925, 0.700, 30.50),
    Collision(1.731, 46.50, 1.275, 0.787, 27.97),
    Collision(0.942, 18.05, 0.365, 0.581, 29.86),
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


HALF_BALL_DEFLECTION = 33.7  # degrees
DEFLECTION_RANGE = 27.0, 34.0  # degrees, from 1/4 to 3/4 ball
DRAW_DEFLECTION = {0.25: 58.0, 0.5: 90.0, 0.75: 128.0}  # degrees, over the ball-hit fraction

SLOW, FAST = 0.44704, 3.12928  # m/s: 1 and 7 mph, Alciatore's slow and fast shots
THROW_MAXIMUM = 5.8, 35.0  # degrees: throw of a slow stun shot, cut angle (measured)
THROW_FORMULA_MAXIMUM = 5.30, 33.0  # the same, after the formula of TP A.14, for restitution 1
THROW_AT_10_DEGREES = 1.5  # degrees, at any speed (measured)

SNOOKER_ROLLING = 0.0127, 0.0129  # deceleration over gravity
CAROM_ROLLING = 0.0040, 0.0043, 0.0046  # deceleration over gravity

# Height of release and length of the roll-out [m]. The coefficient is published as force over
# weight, m g h = mu m g d. A rolling ball loses 5/7 of that as deceleration over gravity, because
# 2/7 of its energy is in its spin.
RAMP = ((0.013, 0.941), (0.019, 1.295))
RAMP_COEFFICIENT = 0.0142
