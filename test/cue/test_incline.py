import math

from hypothesis import assume, given
from hypothesis import strategies as st
import pytest

from billiard_shot.cue.mechanism import Incline, LimitError

DEFAULT = Incline()


@st.composite
def inclines(draw):
    """An incline, and two lengths of its actuator."""
    base, arm = draw(st.floats(0.05, 2.0)), draw(st.floats(0.05, 2.0))
    least, most = abs(base - arm), base + arm
    low, high = sorted((draw(st.floats(0.01, 0.99)), draw(st.floats(0.01, 0.99))))
    assume(high - low > 0.01)
    incline = Incline(base, arm, draw(st.floats(0.1, 2.0)))
    return incline, least + low * (most - least), least + high * (most - least)


@given(inclines(), st.floats(0.0, 1.0))
def test_length_to_elevation_and_back(drawn, part):
    incline, shortest, longest = drawn
    length = shortest + part * (longest - shortest)
    elevation = incline.elevation(length)
    slope = incline.base * incline.arm * math.sin(elevation + incline.level_angle) / length
    assert incline.length(elevation) == pytest.approx(length, rel=1e-14, abs=4e-16 * slope + 1e-16)


@given(inclines(), st.floats(0.0, 1.0))
def test_elevation_to_length_and_back(drawn, part):
    incline, shortest, longest = drawn
    low, high = incline.elevation(shortest), incline.elevation(longest)
    elevation = low + (0.001 + 0.998 * part) * (high - low)
    back = incline.elevation(incline.length(elevation))
    # The triangle is nowhere flat, so that an angle is as good as the length it comes from.
    angle = elevation + incline.level_angle
    lever = incline.base * incline.arm * math.sin(angle) / incline.length(elevation)
    assert back == pytest.approx(elevation, abs=1e-15 * (4 + 4 * (incline.base + 1) / lever))


@given(inclines(), st.floats(0.0, 1.0))
def test_it_is_the_law_of_cosines(drawn, part):
    incline, shortest, longest = drawn
    length = shortest + part * (longest - shortest)
    angle = incline.elevation(length) + incline.level_angle
    square = incline.base**2 + incline.arm**2 - 2 * incline.base * incline.arm * math.cos(angle)
    assert math.sqrt(square) == pytest.approx(length, rel=1e-6)


def test_a_longer_actuator_raises_the_cue():
    low, high = DEFAULT.elevation(0.40), DEFAULT.elevation(0.72)
    assert low < 0.0 < 1.2 < high
    assert DEFAULT.elevation(0.5) < DEFAULT.elevation(0.5001)


def test_limits_say_which_and_by_how_much():
    with pytest.raises(LimitError, match=r'0\.9 m is 0\.1 m above the limit of 0\.8 m'):
        DEFAULT.elevation(0.9)
    with pytest.raises(LimitError, match=r'below the limit of 0\.2 m'):
        DEFAULT.elevation(0.1)
