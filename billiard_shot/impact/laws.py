"""
Laws of restitution: how a compressed contact spring gives its energy back.

One spring a contact, F = k y^exponent, E = k y^(exponent+1)/(exponent+1) (exponent 1, or 3/2 after
Hertz). A law says how fast the spring opens and when its contact ends:

bistiffness  opens 1/e^2 faster than it closed and ends at y = 0. The spring itself is the memory.
energetic    ends when the energy fell to (1 - e^2) of its maximum (paper, section 2.2).
poisson      ends when the impulse reached (1 + e) times its value at the end of compression.
"""

from billiard_shot.compiled import inner

BISTIFFNESS, ENERGETIC, POISSON = 0, 1, 2
LAWS = {'bistiffness': BISTIFFNESS, 'energetic': ENERGETIC, 'poisson': POISSON}


@inner
def elastic_energy(stiffness: float, compression: float, exponent: float) -> float:
    """Energy in a contact's spring; zero at an open contact."""
    return stiffness * max(compression, 0.0) ** (exponent + 1.0) / (exponent + 1.0)


@inner
def unloading_rate(law: int, restitution: float) -> float:
    """How much faster the spring opens than the bodies part, in restitution."""
    return 1.0 / (restitution * restitution) if law == BISTIFFNESS and restitution > 0.0 else 1.0


@inner
def restitution_end(law: int, restitution: float, exponent: float, peak: float) -> float:
    """Compression at which restitution from a peak ends (bistiffness, energetic)."""
    if restitution == 0.0:
        return peak
    if law == ENERGETIC:
        return peak * (1.0 - restitution * restitution) ** (1.0 / (exponent + 1.0))
    return 0.0


@inner
def unloading_loss(
    law: int,
    restitution: float,
    stiffness: float,
    exponent: float,
    peak: float,
    compression: float,
) -> float:
    """Energy lost while a spring opened from its peak: law bistiffness gives back e^2 of it."""
    if law != BISTIFFNESS:
        return 0.0
    released = elastic_energy(stiffness, peak, exponent)
    released -= elastic_energy(stiffness, compression, exponent)
    return (1.0 - restitution * restitution) * released
