"""
From metres on the cloth to the accuracy of a strike and its run, and back to an estimated error.

An error dv in the velocity or r dw in the spin after the strike moves the ball by at most about
dv t until time t, while it slides, rolls or flies: slides and rolls only lose speed. What remains
is how long the motion can last: at speed v, v / (mu_r g) to roll out, 2 |u| / (7 mu g) to slide,
and 2 v / (g (1 - e)) in the air. Cushions magnify errors; rounded jaws of pockets do so a few
hundred times each, so that a stroke whose ball meets some is played again, finer.
"""

from billiard_shot.compiled import inner
from billiard_shot.numerics import rounding
from billiard_shot.table.params import BallClothParams

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
