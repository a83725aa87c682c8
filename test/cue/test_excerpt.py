"""A part of a trajectory follows the trajectory, and brakes within the limits."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
from plans import HOME, MECHANISM, plan_of, SCENE
import pytest
from quintic import quintic

from billiard_shot.cue.joint_trajectory import excerpt
from billiard_shot.cue.plan import aim_trajectory, prepare_shot

SHOT = prepare_shot(MECHANISM, SCENE, plan_of((0.1, 0.2, 0.3, 0.5, 2.0)))
AIM = aim_trajectory(MECHANISM, HOME, SHOT.aimed)
LOW, HIGH = np.array([(axis.min, axis.max) for axis in MECHANISM.axes]).T


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 0.999))
@pytest.mark.parametrize('trajectory', [AIM, SHOT.stroke.trajectory], ids=['aim', 'stroke'])
def test_it_follows_the_trajectory_and_then_brakes(trajectory, fraction):
    end = fraction * trajectory.duration
    if trajectory is not AIM:  # a stroke is cut only after the cue is drawn back
        end = SHOT.stroke.home + fraction * (trajectory.duration - SHOT.stroke.home)
    part = excerpt(trajectory, end, MECHANISM.accelerations)
    assert (np.diff(part.times) > 0.0).all()
    for time in np.linspace(0.0, end * (1 - 1e-9), 40):
        np.testing.assert_allclose(quintic(part, time)[0], trajectory.at(time)[0], atol=1e-9)
    assert not part.velocities[-1].any()
    for time in np.linspace(end, part.duration, 40):
        position, _, acceleration = quintic(part, time)
        assert (position >= LOW - 1e-9).all()
        assert (position <= HIGH + 1e-9).all()
        assert (np.abs(acceleration) <= 2.0 * MECHANISM.accelerations).all()


def test_the_end_of_a_trajectory_is_the_whole_trajectory():
    assert excerpt(AIM, AIM.duration, MECHANISM.accelerations) is AIM
