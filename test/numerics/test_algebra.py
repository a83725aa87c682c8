"""Small linear algebra and contact frames: against NumPy, and what must hold for all of them."""

from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pytest

from billiard_shot.numerics.vectors import contact_axes, pseudo_inverse, solve_in_place, unit

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
