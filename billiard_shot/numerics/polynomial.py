"""Polynomials, lowest coefficient first: products, powers, integrals, and the first root."""

import math
from math import inf

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import Floats, Vector

NO_ROOT = -1.0
MIN_SEPARATION = 1e-7  # of two roots, relative to the interval: closer ones are not an event
MAX_SUBDIVISIONS = 500  # a polynomial that is zero except for rounding would need infinitely many
NOT_ZERO = -1.0  # in place of `noise`: the function is not known to be zero at the start


@innermost
def evaluate(c: Vector, degree: int, x: float) -> float:
    """Value at x of the polynomial with coefficients c[0..degree], lowest first."""
    value = c[degree]
    for k in range(degree - 1, -1, -1):
        value = value * x + c[k]
    return value


@innermost
def product_coefficient(a: Vector, b: Vector, k: int) -> float:
    """Coefficient k of the product of two polynomials."""
    total = 0.0
    for i in range(k + 1):
        total += a[i] * b[k - i]
    return total


@innermost
def power_coefficient(base: Vector, power: Vector, exponent: float, k: int) -> float:
    """
    Coefficient k of a power of a polynomial, from those below k; base[0] is above 0.

    From base * power' = exponent * base' * power (Knuth, The Art of Computer Programming, vol. 2,
    section 4.7).
    """
    if k == 0:
        return base[0] ** exponent
    total = 0.0
    for i in range(1, k + 1):
        total += (exponent * i - (k - i)) * base[i] * power[k - i]
    return total / (k * base[0])


@inner
def integral(c: Vector, count: int, x: float) -> float:
    """Integral from 0 to x of a polynomial with `count` coefficients."""
    total = 0.0
    for k in range(count - 1, -1, -1):
        total = total * x + c[k] / (k + 1)
    return total * x


@inner
def integrals(c: Vector, count: int, x: float) -> tuple[float, float]:
    """Integral from 0 to x of a polynomial with `count` coefficients, and the integral of it."""
    once, twice = 0.0, 0.0
    for k in range(count - 1, -1, -1):
        term = c[k] / (k + 1)
        once, twice = once * x + term, twice * x + term / (k + 2)
    return once * x, twice * x * x


@inner
def product_integral(a: Vector, b: Vector, count: int, x: float) -> float:
    """Integral from 0 to x of the first `count` terms of the product of two polynomials."""
    total, power = 0.0, x
    for k in range(count):
        total += product_coefficient(a, b, k) * power / (k + 1)
        power *= x
    return total


@inner
def sign_changes(c: Vector, degree: int, low: float, high: float, work: Floats) -> int:
    """
    Count the sign changes of the polynomial's Bernstein coefficients on [low, high].

    Zero means that there is no root inside, one means exactly one (variation diminishing property
    of the Bernstein basis; Farin, Curves and Surfaces for CAGD, ch. 5).
    """
    width = high - low
    for k in range(degree + 1):
        work[k] = c[k]
    if low != 0.0:  # Taylor shift to the interval's start
        for i in range(degree):
            for k in range(degree - 1, i - 1, -1):
                work[k] += low * work[k + 1]
    power = 1.0
    binomial = 1.0
    for k in range(degree + 1):
        work[k] *= power / binomial
        power *= width
        binomial = binomial * (degree - k) / (k + 1)
    for i in range(1, degree + 1):
        for k in range(degree, i - 1, -1):
            work[k] += work[k - 1]
    changes = 0
    last = work[0]
    for k in range(1, degree + 1):
        if work[k] != 0.0:
            if last * work[k] < 0.0:
                changes += 1
            last = work[k]
    return changes


@inner
def refine_root(c: Vector, degree: int, low: float, high: float) -> float:
    """Root between low (polynomial positive) and high (not positive): Newton inside a bracket."""
    x = 0.5 * (low + high)
    for _ in range(80):
        value = c[degree]
        slope = 0.0
        for k in range(degree - 1, -1, -1):
            slope = slope * x + value
            value = value * x + c[k]
        if value == 0.0:
            return x
        if value > 0.0:
            low = x
        else:
            high = x
        step = x - value / slope if slope < 0.0 else inf
        if abs(step - x) <= 2e-16 * x:
            return x
        x = step if low < step < high else 0.5 * (low + high)
        if high - low <= 2e-16 * high:
            return high
    return x


@inner
def first_root(
    c: Vector, degree: int, sign: float, offset: float, noise: float, end: float, work: Floats
) -> float:
    """
    First point of (0, end] where sign * c(x) - offset goes from positive to negative, or NO_ROOT.

    The function is positive at 0 (`noise` is NOT_ZERO), or exactly zero because an event happened
    there. In the second case that root is divided out, and so are the lowest coefficients if they
    change the function by less than `noise`: their signs are not known. If the lowest remaining
    coefficient is negative, the event is immediate, at 0. `work`: two rows or more.
    """
    p = work[0]
    zero_at_start = noise >= 0.0
    first = 1 if zero_at_start else 0
    if not zero_at_start and sign * c[0] - offset <= 0.0:
        return 0.0
    power = 1.0
    while first <= degree and zero_at_start and abs(c[first]) * end**first <= noise:
        first += 1
    if first > degree:
        return NO_ROOT
    degree -= first
    bound = 0.0
    for k in range(degree + 1):
        p[k] = sign * c[k + first]
        if k == 0 and not zero_at_start:
            p[0] -= offset
        bound += p[k] * power if k == 0 else min(p[k], 0.0) * power
        power *= end
    if p[0] < 0.0:
        return 0.0
    if bound > 0.0:
        return NO_ROOT
    low = 0.0
    width = end
    for _ in range(MAX_SUBDIVISIONS):
        high = min(low + width, end)
        changes = sign_changes(p, degree, low, high, work[1])
        if changes == 1:
            return refine_root(p, degree, low, high)
        if changes == 0 and evaluate(p, degree, high) <= 0.0:
            return high
        if changes == 0 or width < MIN_SEPARATION * end:
            # Nothing here, or a pair of roots so close that nothing happens between them.
            low = high
            width *= 2.0
        else:
            width *= 0.5
        if low >= end:
            break
    return NO_ROOT


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
