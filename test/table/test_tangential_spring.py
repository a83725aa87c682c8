"""
A nose with a spring along its surface: Stronge's solutions, a scheme of small steps, limits.

Without a cloth and without spin about the normal, Stronge (Impact Mechanics, 2nd ed., 2018,
chapter 5) has solutions in closed form. With the cloth there is the scheme of test_rebound.py.
"""

import numpy as np
import pytest
from tables import rolling, scene_with
from test_rebound import random_contacts, rebounds, Steps, TURN

from billiard_shot import EventKind, simulate

NEVER_LANDS = 1e9


def stiffness(ratio):
    """Tangential stiffness at a ratio of frequencies, relative to the normal stiffness."""
    return ratio**2 / (1 + TURN)


def slip_after(slip, approach, ratio, friction, restitution):
    """Slip after a contact of a ball without spin, with a nose at the height of its centre."""
    velocity, spin, _, _ = rebounds(
        (slip, approach, 0.0),
        (0.0, 0.0, 0.0),
        NEVER_LANDS,
        0.0,
        friction,
        restitution=restitution,
        tangential_stiffness=stiffness(ratio),
    )
    assert velocity[1] == pytest.approx(-restitution * approach, abs=1e-7)
    return velocity[0] - spin[2]


@pytest.mark.parametrize('share', [0.1, 0.5, 0.99])
def test_a_spring_as_fast_as_the_normal_one_reverses_the_slip(share):
    """Its force is then a constant share of the limit of friction, so it never slips."""
    slip = share * 0.4 / stiffness(1.0)
    assert slip_after(slip, 1.0, 1.0, 0.4, 1.0) == pytest.approx(-slip, abs=1e-6)


@pytest.mark.parametrize(('ratio', 'restitution'), [(1.8, 0.6), (1.8, 0.98), (1.2, 0.9)])
def test_a_ball_that_slips_all_the_time_has_coulomb_friction(ratio, restitution):
    """If the restitution is above 1 / ratio, the slip is closest to sticking at the end."""
    friction = 0.14
    most = friction * ((1 + TURN) * (1 + restitution) - 1 / (stiffness(ratio) * restitution))
    rigid = most * 1.01 - friction * (1 + TURN) * (1 + restitution)
    assert slip_after(most * 1.01, 1.0, ratio, friction, restitution) == pytest.approx(
        rigid, abs=1e-6
    )
    # a slower one sticks before the end, and is pushed back
    slower = most * 0.9 - friction * (1 + TURN) * (1 + restitution)
    assert slip_after(most * 0.9, 1.0, ratio, friction, restitution) > slower + 1e-4


# Of pooltool 0.6.0, `stronge_compliant`. Slips and approach in m/s.
@pytest.mark.parametrize(
    ('slip', 'approach', 'friction', 'restitution', 'after'),
    [
        (0.102046, 0.841020, 0.14, 0.98, 0.049574),
        (0.757221, 0.364620, 0.14, 0.98, 0.403467),
        (0.800241, 0.743907, 0.50, 0.85, -0.328406),
        (0.959645, 0.863909, 1.00, 0.85, 0.069377),
        (0.046532, 0.827135, 0.20, 0.50, -0.023389),
    ],
)
def test_slips_after_contacts_are_those_of_pooltool(slip, approach, friction, restitution, after):
    assert slip_after(slip, approach, 1.8, friction, restitution) == pytest.approx(after, abs=2e-6)


@pytest.mark.parametrize('height', [0.0, 0.3, NEVER_LANDS])
@pytest.mark.parametrize('ratio', [1.0, 1.8, 3.0])
def test_contacts_agree_with_small_steps(height, ratio):
    velocity, spin = np.array([0.4, 1.0, 0.0]), np.array([-1.0, 0.4, 0.5])
    steps = Steps(velocity, spin, height, 0.25, 2e-4, stiffness(ratio)).run()
    found = rebounds(velocity, spin, height, 0.25, tangential_stiffness=stiffness(ratio))
    for one, other in zip(found[:2], steps[:2], strict=True):
        assert one == pytest.approx(other, abs=1e-3)


@pytest.mark.parametrize('height', [0.0, NEVER_LANDS])
@pytest.mark.parametrize('friction', [0.14, 0.5])
def test_a_stiff_spring_is_a_rigid_nose(height, friction):
    given = (0.2, 1.0, 0.0), (0.3, 0.1, -0.1), height, 0.2, friction, 1e-7
    rigid = np.hstack(rebounds(*given)[:2])
    errors = [
        np.abs(np.hstack(rebounds(*given, tangential_stiffness=k)[:2]) - rigid).max()
        for k in (1.0, 3e3)
    ]
    assert errors[1] < min(2e-3, 0.1 * errors[0])


def test_energy_is_never_gained_and_the_tolerance_holds():
    random = np.random.default_rng(4)
    for velocity, spin, height, sine, friction in random_contacts(60):
        spring = {'tangential_stiffness': stiffness(random.choice([0.5, 1.0, 1.8, 3.0]))}
        coarse = rebounds(velocity, spin, height, sine, friction, 1e-5, **spring)
        fine = rebounds(velocity, spin, height, sine, friction, 1e-8, **spring)
        scale = max(*np.abs(velocity), *np.abs(spin))
        for one, other in zip(coarse[:2], fine[:2], strict=True):
            assert one == pytest.approx(other, abs=300 * 1e-5 * scale)
        before = velocity @ velocity + spin @ spin / TURN
        assert fine[0] @ fine[0] + fine[1] @ fine[1] / TURN <= before * (1 + 1e-7)


def test_a_landing_between_two_steps_is_found():
    """The spring lifts the ball soon after it met the cloth, within one step."""
    given = (
        (0.891167, 0.320848, -0.245469),
        (1.463305, -1.002880, 1.758321),
        0.362222,
        0.438269,
        2.0,
    )
    spring = {'restitution': 0.5, 'tangential_stiffness': stiffness(1.8), 'cloth_friction': 0.2}
    fine = np.hstack(rebounds(*given, 1e-10, **spring)[:2])
    for tolerance in (1e-5, 1e-6, 1e-7):
        found = np.hstack(rebounds(*given, tolerance, **spring)[:2])
        assert found == pytest.approx(fine, abs=100 * tolerance)


# -- on the table


def leaves(start, **cushion):
    """Velocity with which a ball leaves the first cushion that it meets."""
    run = simulate(scene_with(cushion=cushion), {'cue': start})
    hit = next(event for event in run.events if event.kind == EventKind.CUSHION)
    segments = run.balls['cue'].segments
    return run.balls['cue'].at(max(s.end for s in segments if s.start == hit.time)).velocity


def test_the_option_changes_the_rebound_of_a_scene():
    start = rolling(0.3, 0.5, 0.7, 1.9)
    rigid, compliant = (leaves(start, friction=0.2, frequency_ratio=x) for x in (0.0, 1.8))
    # more of the slip is given back: the ball leaves faster, and nearer to the normal
    assert np.linalg.norm(compliant) > 1.02 * np.linalg.norm(rigid)
    assert compliant[0] / -compliant[1] < 0.95 * rigid[0] / -rigid[1]
    lying = [leaves(start, model='han', frequency_ratio=x) for x in (0.0, 1.8)]
    assert lying[0] == pytest.approx(lying[1], abs=0.0)
