"""
The first root of a polynomial of fourth degree: like polynomial.py, but without arrays.

On an interval the polynomial lies between its Bernstein coefficients. If none is below zero, there
is no root. If their sign changes once, there is exactly one root (variation diminishing property;
Farin, Curves and Surfaces for CAGD, ch. 5), and Newton's method finds it inside a bracket. If the
sign changes more often, the interval is halved.
"""

import math

from billiard_shot.compiled import inner

NARROW = 1e-7  # of the interval: if the polynomial is negative for less, there is no event


@inner
def refine_quartic_root(
    a: float, b: float, c: float, d: float, e: float, low: float, high: float
) -> float:
    """Root of a + b x + ... between low (polynomial positive) and high (not positive)."""
    x = 0.5 * (low + high)
    for _ in range(80):
        value = (((e * x + d) * x + c) * x + b) * x + a
        slope = ((4.0 * e * x + 3.0 * d) * x + 2.0 * c) * x + b
        if value == 0.0:
            return x
        if value > 0.0:
            low = x
        else:
            high = x
        step = x - value / slope if slope < 0.0 else math.inf
        if abs(step - x) <= 2e-16 * x or high - low <= 2e-16 * high:
            return x
        x = step if low < step < high else 0.5 * (low + high)
    return x


@inner
def first_quartic_root(a: float, b: float, c: float, d: float, e: float) -> float:
    """First x of (0, 1] where a + b x + c x^2 + d x^3 + e x^4, a > 0, turns negative, or inf."""
    low, width = 0.0, 1.0
    while low < 1.0:
        q0 = (((e * low + d) * low + c) * low + b) * low + a
        q1 = (((4.0 * e * low + 3.0 * d) * low + 2.0 * c) * low + b) * width
        q2 = ((6.0 * e * low + 3.0 * d) * low + c) * width * width
        q3 = (4.0 * e * low + d) * width * width * width
        b1 = q0 + 0.25 * q1
        b2 = q0 + 0.5 * q1 + q2 / 6.0
        b3 = q0 + 0.75 * q1 + 0.5 * q2 + 0.25 * q3
        b4 = q0 + q1 + q2 + q3 + e * width * width * width * width
        if b1 > 0.0 and b2 > 0.0 and b3 > 0.0 and b4 > 0.0:
            low += width
            width = min(2.0 * width, 1.0 - low)
            continue
        # Starting from positive, the signs change once if they never become positive again.
        once = b4 <= 0.0 and (b3 <= 0.0 or (b2 > 0.0 and b1 > 0.0)) and (b2 <= 0.0 or b1 > 0.0)
        if once:
            return refine_quartic_root(a, b, c, d, e, low, high=low + width)
        if width < NARROW:
            low += width
            if b4 <= 0.0:
                return low
        else:
            width *= 0.5
    return math.inf
