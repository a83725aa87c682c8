"""Angles from -pi to pi."""

import math

import numpy as np
import pytest

from billiard_shot.numerics.vectors import wrapped


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
