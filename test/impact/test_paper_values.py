"""The reference values of the paper's examples, and of other published collisions."""

import numpy as np
from paper_values import FIG_4_IMPULSES, TABLE_1
import pytest
from setups import (
    BALL,
    chain,
    paper_states,
    RADIUS,
    run,
    shot,
    SHOTS,
    states,
    TABLE,
    two_balls,
    UP,
)

from billiard_shot.status import Status

PING_PONG = (0.807755, 0.846529)


@pytest.mark.parametrize(('law', 'ratio', 'name'), TABLE_1)
def test_four_shots_of_table_1(law, ratio, name):
    sequence, velocity, spin = TABLE_1[law, ratio, name]
    result = run(shot(*SHOTS[name], ratio=ratio), law=law, tolerance=1e-11)
    assert result.status == Status.OK
    assert paper_states(result) == sequence
    digits = 100.0 if name == 'masse' and ratio == 1.5 else 1.0  # the massé is known to 7 digits
    np.testing.assert_allclose(result.velocities[1], velocity, rtol=0, atol=1.5e-10 * digits)
    np.testing.assert_allclose(result.spins[1], spin, rtol=0, atol=1.5e-8 * digits)


def test_two_balls_of_fig_4():
    result = run(two_balls(), law='energetic', tolerance=1e-12)
    assert result.status == Status.OK
    assert paper_states(result) == 'S1 S3 S1 S2'
    np.testing.assert_allclose(result.velocities[:2, 2], (2.441360, 0.735552), atol=5e-7)
    impulses = np.array([phase.impulses for phase in result.phases]) @ UP
    np.testing.assert_allclose(impulses, FIG_4_IMPULSES, atol=5.1e-7)
    assert np.sum(result.dissipated) == pytest.approx(1.249363, abs=5.1e-7)


@pytest.mark.parametrize(
    ('law', 'velocities'), [('energetic', (0.7794, 0.1866)), ('bistiffness', (0.8017, 0.1154))]
)
def test_ping_pong_balls(law, velocities):
    for speed in (1.0, 2.0):
        result = run(two_balls(restitution=PING_PONG, speed=speed), law=law)
        np.testing.assert_allclose(result.velocities[:2, 2] / speed, velocities, atol=5.1e-5)


def test_infinite_sequence_of_a_heavy_ball_on_a_light_one():
    setup = two_balls(masses=(100.0, 1.0), restitution=(0.9, 0.5), ratio=0.1, speed=1.0)
    result = run(setup, law='energetic', tolerance=1e-8)
    assert result.status == Status.INFINITE_SEQUENCE
    assert len(result.phases) > 50
    np.testing.assert_allclose(result.velocities[:2, 2], 0.0, atol=1e-7)
    result = run(setup, law='bistiffness')
    assert result.status == Status.OK
    assert len(result.phases) == 8
    np.testing.assert_allclose(result.velocities[:2, 2], (0.3955, 0.0193), atol=5.1e-5)


def test_poisson_hypothesis_makes_energy_in_fig_4():
    result = run(two_balls(), law='poisson', tolerance=1e-10)
    assert result.status == Status.NEGATIVE_ENERGY
    assert result.phases[-1].impulses[0] @ UP == pytest.approx(6.444, abs=1e-3)
    assert result.dissipated[0][0] == pytest.approx(-2.15, abs=5e-3)


def test_hertz_chain_of_ten_balls():
    expected = (-0.07106, -0.03019, -0.01575, -0.00881, -0.00506, -0.00294, -0.00170, 0.00262,
                0.14692, 0.98596)  # fmt: skip
    result = run(chain(10), exponent=1.5, tolerance=1e-8)
    np.testing.assert_allclose(result.velocities[:, 0], expected, atol=5e-4)


@pytest.mark.parametrize(
    ('stiffness', 'velocities'),
    [
        ((1.0, 1e-6), (0.0, 0.0, 1.0)),
        ((1.0, 1.0), (-0.13026, 0.15023, 0.98003)),
        ((1e-6, 1.0), (-1 / 3, 2 / 3, 2 / 3)),
    ],
)
def test_chain_of_three_balls_and_its_limits(stiffness, velocities):
    result = run(chain(3, stiffness=stiffness), tolerance=1e-8)
    np.testing.assert_allclose(result.velocities[:, 0], velocities, atol=1e-4)


@pytest.mark.parametrize('law', ['bistiffness', 'energetic', 'poisson'])
@pytest.mark.parametrize('slip', [(0.2, -0.3, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 0.0)])
def test_table_contact_alone_has_a_closed_form(law, slip):
    # S2 of section 3: the slip keeps its direction; stopping it takes (2/7) m times the slip.
    e, mu = 0.6, 0.25
    ball = {
        'mass': BALL, 'inertia': 0.4 * BALL * RADIUS**2, 'position': (0, 0, RADIUS),
        'velocity': np.array([0.0, 0.0, -1.5]) + slip,
    }  # fmt: skip
    contact = {'a': 0, 'b': 1, 'point': (0, 0, 0), 'normal': UP, 'friction': mu, 'restitution': e}
    result = run(([ball, TABLE], [contact]), law=law, tolerance=1e-12)
    normal = (1.0 + e) * BALL * 1.5
    needed = 2.0 / 7.0 * BALL * np.linalg.norm(slip)
    tangential = -min(needed, mu * normal) * np.array(slip) / max(np.linalg.norm(slip), 1e-300)
    impulse = result.phases[-1].impulses[0]
    np.testing.assert_allclose(impulse, tangential + normal * np.array(UP), atol=1e-12)
    assert states(result) == [(0,)]


def test_a_result_says_what_it_is():
    result = run(two_balls(), law='energetic', tolerance=1e-12)
    lost = f'{result.dissipated.sum():.4g} J'
    assert repr(result) == f'CollisionResult(OK, 3 bodies, 2 contacts, 4 phases, lost {lost})'
