"""Small linear algebra and contact frames: against NumPy, and what must hold for all of them."""

import math

from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
from numpy.polynomial import Polynomial
import pytest

from billiard_shot.numerics import polynomial
from billiard_shot.numerics import polynomial as quartic
from billiard_shot.numerics.vectors import (
    contact_axes,
    pseudo_inverse,
    solve_in_place,
    unit,
    wrapped,
)

NUMBERS = st.floats(-10.0, 10.0)
VECTORS = arrays(float, 3, elements=NUMBERS)


def square(rank=None, size=4):
    return arrays(float, (size, rank or size), elements=NUMBERS)


@given(square(), arrays(float, 4, elements=NUMBERS))
def test_solving_equations(a, b):
    assume(np.linalg.cond(a) < 1e6)
    x = b.tolist()
    assert solve_in_place(a.tolist(), x, 4)
    assert np.array(x) == pytest.approx(np.linalg.solve(a, b), rel=1e-6, abs=1e-6)


def test_a_singular_matrix_is_refused():
    assert not solve_in_place([[1.0, 2.0], [2.0, 4.0]], [1.0, 1.0], 2)


@pytest.mark.parametrize('rank', [1, 2, 3, 4])
@given(data=st.data())
def test_pseudo_inverse(rank, data):
    root = data.draw(square(rank))
    a = root @ root.T
    size = np.linalg.svd(a, compute_uv=False)
    assume(size[rank - 1] > 1e-4 * size[0] > 1e-9)  # of this rank, without doubt
    inverse, scratch = np.zeros((4, 4)).tolist(), np.zeros((4, 4)).tolist()
    pseudo_inverse(a.tolist(), inverse, scratch, 4)
    expected = np.linalg.pinv(a, rcond=1e-9)
    assert np.array(inverse) == pytest.approx(expected, rel=1e-6, abs=1e-6 * abs(expected).max())


@given(VECTORS, VECTORS, VECTORS)
def test_frames_are_orthonormal_and_right_handed(n, first, second):
    assume(np.linalg.norm(n) > 1e-3)
    n /= np.linalg.norm(n)
    axes = np.zeros((3, 3)).tolist()
    contact_axes(n.tolist(), first.tolist(), second.tolist(), axes, 0)
    axes = np.array(axes)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[0] == pytest.approx(n)


@given(VECTORS, VECTORS)
def test_the_second_tangent_is_normal_to_the_plane(n, first):
    assume(np.linalg.norm(n) > 1e-3)
    n /= np.linalg.norm(n)
    assume(np.linalg.norm(np.cross(n, first)) > 1e-3)
    axes = np.zeros((3, 3)).tolist()
    contact_axes(n.tolist(), first.tolist(), [0.0, 0.0, 1.0], axes, 0)
    assert first @ axes[2] == pytest.approx(0.0, abs=1e-9)
    assert first @ axes[1] > 0.0


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_a_frame_without_any_plane(axis, sign):
    n, axes = [0.0, 0.0, 0.0], np.zeros((3, 3)).tolist()
    n[axis] = sign
    contact_axes(n, n, [0.0, 0.0, 0.0], axes, 0)
    assert np.array(axes) @ np.transpose(axes) == pytest.approx(np.eye(3), abs=1e-15)


def test_units():
    direction = [0.0] * 3
    assert unit([3.0, 0.0, -4.0], direction) == 5.0
    assert direction == [0.6, 0.0, -0.8]
    assert np.isnan(unit([0.0, 0.0, 0.0], direction))
    assert np.isnan(unit([np.inf, 0.0, 0.0], direction))


# --- angles from -pi to pi -----------------------------------------------------------------------


def test_wrapped_angles_differ_by_full_turns():
    angles = np.random.default_rng(1).uniform(-30.0, 30.0, 1000)
    found = wrapped(angles)
    assert (np.abs(found) <= math.pi).all()
    turns = (angles - found) / math.tau
    assert turns == pytest.approx(np.rint(turns), abs=1e-12)
    assert found.tolist() == [wrapped(angle) for angle in angles.tolist()]


def test_angles_within_the_range_stay_the_same_to_the_last_bit():
    angles = np.random.default_rng(2).uniform(-math.pi, math.pi, 1000)
    assert (wrapped(angles) == angles).all()
    assert wrapped(math.pi) == math.pi
    assert wrapped(-math.pi) == math.pi


# --- the first root of a polynomial: against NumPy's roots, for both ways to find it -------------

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
