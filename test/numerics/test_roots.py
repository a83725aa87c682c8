"""The first root of a polynomial: against NumPy's roots, for both ways to find it."""

import math

from hypothesis import assume, given
from hypothesis import strategies as st
import numpy as np
from numpy.polynomial import Polynomial
import pytest

from billiard_shot.numerics import polynomial
from billiard_shot.numerics import polynomial as quartic

COEFFICIENTS = st.lists(st.floats(-10.0, 10.0), min_size=4, max_size=4)
STARTS = st.floats(1e-3, 10.0)


def first_crossing(coefficients):
    """The first root in (0, 1], or inf."""
    p = Polynomial(coefficients)
    roots = p.roots()
    real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
    inside = real[(real > 0.0) & (real < 1.0)]
    # Neighbours that nearly touch the axis, or the end, are decided by rounding.
    near = np.abs(roots - roots[:, np.newaxis])[~np.eye(len(roots), dtype=bool)]
    assume(near.size == 0 or near.min() > 1e-3)
    assume((np.abs(real - 1.0) > 1e-6).all())
    return inside[0] if len(inside) else math.inf


def found(coefficients):
    """What polynomial.py finds, with 1 as the end; inf if it finds nothing."""
    work = [[0.0] * 8 for _ in range(2)]
    root = polynomial.first_root(
        coefficients, len(coefficients) - 1, 1.0, 0.0, polynomial.NOT_ZERO, 1.0, work
    )
    return math.inf if root == polynomial.NO_ROOT else root


@given(STARTS, COEFFICIENTS)
def test_both_find_the_first_root(start, others):
    assume(abs(others[-1]) > 1e-2)
    coefficients = [start, *others]
    expected = first_crossing(coefficients)
    assert found(coefficients) == pytest.approx(expected, abs=1e-9)
    assert quartic.first_quartic_root(*coefficients) == pytest.approx(expected, abs=1e-9)


def test_roots_close_to_each_other_are_told_apart():
    near = (Polynomial([0.3, -1.0]) * Polynomial([0.3001, -1.0]) * Polynomial([0.9, -1.0])).coef
    coefficients = [*near, 0.0]
    assert found(coefficients) == pytest.approx(0.3, abs=1e-9)
    assert quartic.first_quartic_root(*coefficients) == pytest.approx(0.3, abs=1e-9)


def test_a_polynomial_that_stays_just_above_zero_has_no_root():
    above = [*(Polynomial([0.5, -1.0]) ** 2 + 1e-9).coef, 0.0, 0.0]
    assert found(above) == math.inf
    assert quartic.first_quartic_root(*above) == math.inf


def test_an_event_that_has_just_happened_is_divided_out():
    work = [[0.0] * 8 for _ in range(2)]
    coefficients = [1e-17, 0.3, -1.0]  # zero at the start but for rounding, then x (0.3 - x)
    root = polynomial.first_root(coefficients, 2, 1.0, 0.0, 1e-15, 1.0, work)
    assert root == pytest.approx(0.3, abs=1e-9)
    falling = polynomial.first_root([0.0, -0.3, 1.0], 2, 1.0, 0.0, 1e-15, 1.0, work)
    assert falling == 0.0
