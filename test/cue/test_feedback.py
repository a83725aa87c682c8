"""Measured joints: messages that have a part of them are collected; nothing is made up."""

import numpy as np
import pytest

from billiard_shot.cue.inputs import JointFeedback

NAMES = ('slide', 'lift', 'stroke')
POSITION, VELOCITY = (0.1, 0.2, 0.3), (1.0, 2.0, 3.0)


@pytest.fixture
def feedback():
    return JointFeedback(NAMES)


def test_a_complete_message_in_any_order_with_other_joints(feedback):
    position, velocity = feedback.update(
        ('arm', 'stroke', 'slide', 'lift'), (9.0, 0.3, 0.1, 0.2), (9.0, 3.0, 1.0, 2.0)
    )
    np.testing.assert_array_equal(position, POSITION)
    np.testing.assert_array_equal(velocity, VELOCITY)


def test_one_joint_a_message(feedback):
    """Every set has each joint once; a set without one joint is never complete."""
    for _ in range(2):
        assert feedback.update(('slide',), (0.1,), (1.0,)) is None
        assert feedback.update(('stroke',), (0.3,), (3.0,)) is None
        assert feedback.missing == 'lift'
        position, velocity = feedback.update(('lift',), (0.2,), (2.0,))
        np.testing.assert_array_equal(position, POSITION)
        np.testing.assert_array_equal(velocity, VELOCITY)


@pytest.mark.parametrize('velocities', [(), (np.nan,) * 3])
def test_velocities_that_are_not_measured_are_not_made_up(feedback, velocities):
    for moved in POSITION, VELOCITY:
        position, velocity = feedback.update(NAMES, moved, velocities)
        np.testing.assert_array_equal(position, moved)
        assert np.isnan(velocity).all()


def test_a_lost_encoder_is_passed_on(feedback):
    """So that the controller names it."""
    feedback.update(NAMES, POSITION, VELOCITY)
    position, _ = feedback.update(NAMES, (0.1, np.nan, 0.3), VELOCITY)
    assert np.isnan(position).tolist() == [False, True, False]


def test_joints_without_positions_are_missing(feedback):
    assert feedback.update(NAMES, (), ()) is None
    assert feedback.missing == 'slide, lift, stroke'
