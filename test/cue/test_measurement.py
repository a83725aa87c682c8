"""The measured speed of a strike, from joints that arrive seldom, or not at all."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from plans import HOME, MECHANISM
import pytest

from billiard_shot.cue.controller import StrikeDetector
from billiard_shot.cue.joint_trajectory import stroke_trajectory, StrokeProfile
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.simulated import Imperfections, SimulatedMechanism

PERIOD = 0.01
"""Time between two messages [s]."""


def strike(speed, drive, random, loss):
    """Play a stroke with a drive of some bandwidth; the true speed, and the measured one."""
    profile = StrokeProfile(MECHANISM, speed, 0.4 * speed, 0.002, 150.0, 150.0)
    stroke = stroke_trajectory(profile, HOME, HOME[2])
    mechanism = SimulatedMechanism(
        MECHANISM, Imperfections(bandwidth=drive, noise=0.002), 1.0, HOME, 0.0, random.integers(99)
    )
    mechanism.command(stroke.trajectory, 0.0)
    detector = StrikeDetector(profile)
    true, now = None, random.uniform(0.0, PERIOD)
    while now < stroke.stop:
        while mechanism._now < now:
            before = mechanism.velocity[STROKE]
            mechanism.advance(mechanism._now + 1e-3)
            if true is None and mechanism.position[STROKE] >= profile.contact_at:
                true = before
        if random.random() >= loss:
            detector.update(*mechanism.measured())
        now += PERIOD
    return true, detector.strike and detector.strike.speed


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 5.5))
def test_the_speed_is_that_of_the_contact_or_it_is_not_measured(seed, speed):
    random = np.random.default_rng(seed)
    true, measured = strike(speed, random.uniform(120.0, 300.0), random, 0.1)
    assert measured is None or measured == pytest.approx(true, rel=0.02)


@pytest.mark.parametrize(('loss', 'least'), [(0.0, 95), (0.1, 80)])
def test_nearly_all_strikes_are_measured(loss, least):
    """The distance at constant speed lasts for two messages."""
    random = np.random.default_rng(1)
    strokes = [strike(random.uniform(0.1, 5.5), 150.0, random, loss) for _ in range(100)]
    assert sum(measured is not None for _, measured in strokes) >= least
