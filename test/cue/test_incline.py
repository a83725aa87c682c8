import math

from hypothesis import assume, given
from hypothesis import strategies as st
import pytest

from billiard_shot.cue.incline import Incline
from billiard_shot.cue.limits import LimitError

DEFAULT = Incline()


@st.composite
def inclines(draw):
    base, arm = draw(st.floats(0.05, 2.0)), draw(st.floats(0.05, 2.0))
    least, most = abs(base - arm), base + arm
    low, high = sorted((draw(st.floats(0.01, 0.99)), draw(st.floats(0.01, 0.99))))
    assume(high - low > 0.01)
    return Incline(
        base,
        arm,
        draw(st.floats(0.1, 2.0)),
        least + low * (most - least),
        least + high * (most - least),
    )


@given(inclines(), st.floats(0.0, 1.0))
def test_length_to_elevation_and_back(incline, part):
    length = incline.shortest + part * (incline.longest - incline.shortest)
    elevation = incline.elevation(length)
    slope = incline.base * incline.arm * math.sin(elevation + incline.level_angle) / length
    assume(incline.shortest * (1 + 1e-12) < length < incline.longest * (1 - 1e-12))
    assert incline.length(elevation) == pytest.approx(length, rel=1e-14, abs=4e-16 * slope + 1e-16)


@given(inclines(), st.floats(0.0, 1.0))
def test_elevation_to_length_and_back(incline, part):
    low, high = incline.elevation(incline.shortest), incline.elevation(incline.longest)
    elevation = low + (0.001 + 0.998 * part) * (high - low)
    back = incline.elevation(incline.length(elevation))
    # The triangle is nowhere flat, so that an angle is as good as the length it comes from.
    angle = elevation + incline.level_angle
    lever = incline.base * incline.arm * math.sin(angle) / incline.length(elevation)
    assert back == pytest.approx(elevation, abs=1e-15 * (4 + 4 * (incline.base + 1) / lever))


@given(inclines(), st.floats(0.0, 1.0))
def test_it_is_the_law_of_cosines(incline, part):
    length = incline.shortest + part * (incline.longest - incline.shortest)
    angle = incline.elevation(length) + incline.level_angle
    square = incline.base**2 + incline.arm**2 - 2 * incline.base * incline.arm * math.cos(angle)
    assert math.sqrt(square) == pytest.approx(length, rel=1e-6)


def test_a_longer_actuator_raises_the_cue():
    low, high = DEFAULT.elevation(DEFAULT.shortest), DEFAULT.elevation(DEFAULT.longest)
    assert low < 0.0 < 1.2 < high
    assert DEFAULT.elevation(0.5) < DEFAULT.elevation(0.5001)


def test_limits_say_which_and_by_how_much():
    with pytest.raises(LimitError, match='incline') as caught:
        DEFAULT.length(1.3)
    (violation,) = caught.value.violations
    assert violation.limit == 'incline'
    angle = 1.3 + DEFAULT.level_angle
    length = math.sqrt(0.5**2 + 0.3**2 - 2 * 0.5 * 0.3 * math.cos(angle))
    assert f'{length:.4g} m is {length - 0.72:.3g} m above' in violation.text
    assert 'above the limit of 0.72 m (elevation 1.3 rad)' in str(caught.value)
    with pytest.raises(LimitError, match=r'0\.9 m is 0\.1 m above the limit of 0\.8 m'):
        DEFAULT.elevation(0.9)
    with pytest.raises(LimitError, match=r'below the limit of 0\.2 m'):
        DEFAULT.elevation(0.1)


@pytest.mark.parametrize(('shortest', 'longest'), [(0.2, 0.7), (0.3, 0.8), (0.5, 0.4)])
def test_lengths_must_make_a_triangle(shortest, longest):
    with pytest.raises(ValueError, match=r'must ascend, between 0\.2 and 0\.8'):
        Incline(shortest=shortest, longest=longest)
