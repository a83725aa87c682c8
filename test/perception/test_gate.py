"""The gate lets every ball of a real table through, and nothing that could not be one."""

from contextlib import suppress
import math

from hypothesis import example, given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot.perception.gate import (
    check_count,
    check_name,
    check_position,
    check_quaternion,
    MAX_DEVIATION,
    plane_covariance,
)

ANY = st.floats(width=64)
DEVIATION = st.floats(1e-6, 0.7 * MAX_DEVIATION)
ANGLE = st.floats(-math.pi, math.pi)


@given(st.lists(ANY, min_size=3, max_size=3))
@example([1e308, 0.0, 0.0])
@example([0.0, 1e160, 0.0])
def test_positions_are_within_10_m(position):
    if all(abs(each) <= 10.0 for each in position):
        check_position('there', position)
    else:
        with pytest.raises(ValueError, match=r'^there\.[xyz] must be from -10 to 10 m, got \S+$'):
            check_position('there', position)


@given(ANGLE, ANGLE, DEVIATION, DEVIATION, st.floats(0.0, 0.005))
def test_covariances_of_a_camera_that_looks_from_anywhere(turn, tilt, one, other, depth):
    """A rotation keeps a covariance symmetric and positive semi-definite, but for rounding."""
    c, s, k, q = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ [[1, 0, 0], [0, k, -q], [0, q, k]]
    matrix = rotation @ np.diag([one**2, other**2, (0.7 * depth) ** 2]) @ rotation.T
    found = plane_covariance('it', matrix.ravel().tolist())
    assert found == (matrix[0, 0], matrix[0, 1], matrix[1, 1])


def test_a_height_may_be_uncertain_and_an_exact_position_is_a_position():
    assert plane_covariance('it', [1e-8, 0, 0, 0, 1e-8, 0, 0, 0, 1.0]) == (1e-8, 0, 1e-8)
    assert plane_covariance('it', [0.0] * 9) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    'values',
    [
        [-1e-6, 0, 0, 0, -1e-6, 0, 0, 0, 0],
        [1.0, 0, 0, 0, 1e-6, 0, 0, 0, 0],
        [1e-6, 0, 0, 0, 26e-6, 0, 0, 0, 0],
        [1e-6, 5e-7, 0, -5e-7, 1e-6, 0, 0, 0, 0],
        [1e-6, 2e-6, 0, 2e-6, 1e-6, 0, 0, 0, 0],
        [0, 1e-6, 0, 1e-6, 0, 0, 0, 0, 0],
    ],
)
def test_what_is_no_covariance(values):
    words = (
        r'^it must be symmetric and positive semi-definite .* of at most 5 mm, got \[.*\] m\^2$'
    )
    with pytest.raises(ValueError, match=words):
        plane_covariance('it', values)


@given(st.lists(ANY, min_size=9, max_size=9))
@example([1e308] * 9)
@example([5e-324] * 9)
@example([1e-6, math.nan, 0.0, math.nan, 1e-6, 0.0, 0.0, 0.0, 0.0])
def test_any_numbers_are_a_covariance_or_refused(values):
    with suppress(ValueError):
        xx, xy, yy = plane_covariance('it', values)
        assert (xx, xy, yy) == (values[0], values[1], values[4])
        assert 0.0 <= xx <= MAX_DEVIATION**2
        assert 0.0 <= yy <= MAX_DEVIATION**2
        assert abs(xy) <= math.sqrt(xx) * math.sqrt(yy) * (1.0 + 1e-5) + 1e-18


@given(st.text(max_size=70))
@example('8')
@example('x' * 64)
@example('x' * 65)
@example('\x1b[2J')
def test_names_can_be_printed(name):
    if 1 <= len(name) <= 64 and name.isprintable():
        check_name('id', name)
    else:
        with pytest.raises(
            ValueError, match=r'^id must be 1 to 64 printable characters, got'
        ) as no:
            check_name('id', name)
        assert str(no.value).isprintable()


def test_a_refusal_of_a_long_name_is_short():
    with pytest.raises(ValueError, match='must be') as refused:
        check_name('id', 'x' * 1_000_000)
    assert len(str(refused.value)) < 300


class Counted(list):
    """A list whose elements nobody may look at."""

    def __iter__(self):
        raise AssertionError('somebody looked at the elements')

    __getitem__ = __iter__


def test_numbers_are_counted_first():
    check_count('balls', range(64))
    with pytest.raises(ValueError, match=r'^balls must have at most 64 elements, got 100000$'):
        check_count('balls', Counted(['x'] * 100_000))


@given(st.lists(ANY, min_size=4, max_size=4))
@example([0.0, 0.0, 0.0, 0.0])
@example([0.0, 0.0, 0.70711, 0.70711])
@example([1e308] * 4)
def test_quaternions_have_the_length_1(values):
    if 0.995 <= math.hypot(*values) <= 1.005:
        check_quaternion('turn', values)
    else:
        with pytest.raises(ValueError, match=r'^turn must have the length 1, within 0\.005, got'):
            check_quaternion('turn', values)
