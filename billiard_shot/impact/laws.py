"""
Laws of restitution: how a compressed contact spring gives its energy back.

One spring a contact, F = k y^exponent, E = k y^(exponent+1)/(exponent+1) (exponent 1, or 3/2 after
Hertz). A law says how fast the spring opens and when its contact ends:

bistiffness  opens 1/e^2 times as fast as it closed and ends at y = 0, whatever the peak was.
energetic    ends when the energy fell to (1 - e^2) of its maximum (paper, section 2.2).
poisson      ends when the impulse reached (1 + e) times its value at the end of compression.
"""

from typing import NamedTuple

from billiard_shot.compiled import inner

BISTIFFNESS, ENERGETIC, POISSON = 0, 1, 2
LAWS = {'bistiffness': BISTIFFNESS, 'energetic': ENERGETIC, 'poisson': POISSON}


class Opening(NamedTuple):
    """Opening of a spring after its compression; the numbers have no unit."""

    rate: float  # opening speed of the spring relative to the speed at which the bodies part
    end: float  # compression at which the contact ends, relative to the peak
    lost: float  # share of the energy that is lost while the spring opens


@inner
def opening(law: int, restitution: float, exponent: float) -> Opening:
    """
    Return the opening of springs by a law.

    Law poisson opens a spring until its impulse is complete (events.py). The contact may then end
    before the spring is relaxed, or need more energy than the spring has.
    """
    if restitution == 0.0:
        return Opening(1.0, 1.0, 0.0)
    square = restitution * restitution
    if law == BISTIFFNESS:
        return Opening(1.0 / square, 0.0, 1.0 - square)
    if law == ENERGETIC:
        return Opening(1.0, (1.0 - square) ** (1.0 / (exponent + 1.0)), 0.0)
    return Opening(1.0, 0.0, 0.0)


@inner
def elastic_energy(stiffness: float, compression: float, exponent: float) -> float:
    """Energy in a contact's spring; zero at an open contact."""
    return stiffness * max(compression, 0.0) ** (exponent + 1.0) / (exponent + 1.0)
