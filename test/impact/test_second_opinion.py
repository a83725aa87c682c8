"""`collide` against the slow check, and against itself at other tolerances."""

import numpy as np
import pytest
from setups import chain, cluster, difference, random_shot, run, shot, SHOTS, touching, two_balls
from slow_check import slow_collide
from test_properties import random_bodies

from billiard_shot import machine_code
from billiard_shot.status import Status

LAWS = ('bistiffness', 'energetic')


def agree(setup, bound, **options):
    """Compare with the slow check, which says itself how far it can be trusted."""
    result = run(setup, tolerance=1e-9, **options)
    if not result.phases:
        return  # nothing approaches
    for steps in (500, 4000):
        slow = slow_collide(*setup, steps=steps, **options)
        error = difference(setup, result, slow)
        if slow.finished and error < max(bound, 10 * slow.spread):
            return
    assert not slow.finished or slow.spread > 1e-5, f'off by {error:.1e}'


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('end_mass', [False, True])
def test_random_strokes(law, end_mass):
    rng = np.random.default_rng(1)
    for _ in range(60):
        agree(random_shot(rng, end_mass=end_mass), 3e-6, law=law)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('count', [1, 2, 3])
def test_random_bodies(law, count):
    rng = np.random.default_rng(2)
    for _ in range(40):
        agree(random_bodies(rng, count), 1e-5, law=law)


@pytest.mark.parametrize('law', LAWS)
def test_clusters_with_friction(law):
    """What joins late may let go what joined before it; that was held by a spring that pulled."""
    rng = np.random.default_rng(5)
    for i in range(300):
        setup = cluster(rng)
        result = run(setup, law=law, tolerance=1e-7)
        assert result.status in (Status.OK, Status.INFINITE_SEQUENCE), i
        if i < 20:
            agree(setup, 1e-5, law=law)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('tolerance', [1e-4, 1e-7, 1e-9])
def test_slips_do_not_begin_one_after_the_other_for_ever(law, tolerance):
    """A branch of six balls, whose far end is pressed by rounding errors at first."""
    places = np.array([
        (0, 0), (2.53, 5.62), (0.76, 4.69), (-1.24, 4.59), (-1.63, 2.63), (-1.89, 0.64),
        (0.27, 6.63),
    ])  # fmt: skip
    setup = touching(np.column_stack([places, np.zeros(7)]), 0.01, 0.5, 0.12)
    setup[0][0] |= {'velocity': (-0.83, 0.56, 0), 'spin': (-0.56, -0.83, 0)}
    assert run(setup, law=law, tolerance=tolerance).evaluations < 1000
    agree(setup, 1e-5, law=law)


@pytest.mark.parametrize('law', LAWS)
def test_hertz_contacts(law):
    rng = np.random.default_rng(3)
    for _ in range(30):
        agree(random_shot(rng), 1e-5, law=law, exponent=1.5)
    agree(chain(5), 1e-6, law=law, exponent=1.5)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('exponents', [(1.5, 1.0), (1.0, 2.0)])
def test_contacts_with_exponents_of_their_own(law, exponents):
    """Springs of 150 and 100 N/mm at a compression of 1 mm, and only there."""
    rng = np.random.default_rng(6)
    for _ in range(30):
        bodies, contacts = random_shot(rng)
        for contact, force, exponent in zip(contacts, (150.0, 100.0), exponents, strict=True):
            contact |= {'exponent': exponent, 'stiffness': force / 1e-3**exponent}
        agree((bodies, contacts), 1e-5, law=law)


def test_only_with_equal_exponents_stiffnesses_have_no_scale():
    """Ten times as firm springs change nothing if all are linear, and much if one is not."""

    def velocity(exponent, factor):
        bodies, contacts = shot(*SHOTS['jump'])
        for contact, own in zip(contacts, (exponent, 1.0), strict=True):
            contact |= {'exponent': own, 'stiffness': factor * 100.0 / 1e-3**own}
        return run((bodies, contacts), tolerance=1e-10).velocities[1]

    np.testing.assert_allclose(velocity(1.0, 10.0), velocity(1.0, 1.0), rtol=1e-9)
    assert np.abs(velocity(1.5, 10.0) - velocity(1.5, 1.0)).max() > 1e-3


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('name', SHOTS)
def test_paper_shots_agree(law, name):
    setup = shot(*SHOTS[name])
    slow = slow_collide(*setup, law=law, steps=4000)
    assert difference(setup, run(setup, law=law, tolerance=1e-10), slow) < 1e-7
    assert [tuple(p.active) for p in run(setup, law=law).phases] == list(slow.states)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('planar', [False, True])
def test_errors_stay_within_the_tolerance(law, planar):
    rng = np.random.default_rng(4)
    worst = dict.fromkeys((1e-4, 1e-6, 1e-8, 1e-10), 0.0)
    for _ in range(300):
        if planar:
            angle = rng.uniform(-0.2, 1.3)
            setup = shot((-np.cos(angle), 0, np.sin(angle)), (1, 0, -rng.uniform(0, 2)))
        else:
            setup = random_shot(rng)
        exact = run(setup, law=law, tolerance=1e-12)
        if exact.status != Status.OK:
            continue
        for tolerance in worst:
            result = run(setup, law=law, tolerance=tolerance)
            if [p.active for p in result.phases] == [p.active for p in exact.phases]:
                error = difference(setup, result, exact)
                worst[tolerance] = max(worst[tolerance], error / tolerance)
    assert max(worst.values()) < 5.0, worst


def test_two_balls_with_any_ratio_of_stiffness():
    for ratio in np.geomspace(0.01, 100.0, 41):
        setup = two_balls(ratio=float(ratio))
        agree(setup, 3e-6, law='bistiffness')


def test_interpreted_it_gives_the_same_numbers(monkeypatch):
    vertical, light = shot(*SHOTS['vertical']), shot((-0.8, 0.3, 0.4), (2, 0.5, -1), end_mass=0.01)

    def answers():
        results = [run(vertical, law=law, tolerance=1e-6) for law in LAWS]
        results.append(run(light, tolerance=1e-6))
        return [(each.velocities[1], each.spins[1]) for each in results]

    compiled = answers()
    monkeypatch.setattr(machine_code, 'is_loaded', lambda: False)
    np.testing.assert_allclose(answers(), compiled, rtol=1e-8, atol=1e-8)
