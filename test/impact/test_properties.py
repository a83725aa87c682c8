"""What holds for every collision: the paper's theorems, balances, bounds and symmetries."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from setups import (
    block,
    chain,
    difference,
    kinetic_energy,
    random_shot,
    run,
    shot,
    SHOTS,
    start_of,
    states,
    TABLE,
    two_balls,
)
from slow_check import frame, inverse_mass, jacobian, rotation

from billiard_shot.impact import Body, collide
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.kernel import energy_imbalance
from billiard_shot.impact.state import ContactState, workspace
from billiard_shot.records import OBJECTS
from billiard_shot.status import Status

examples = settings(derandomize=True, deadline=None, max_examples=60, database=None)
LAWS = ('bistiffness', 'energetic')
laws = st.sampled_from(LAWS)
unit = st.floats(0.0, 1.0)
seeds = st.integers(0, 10**6)
powers = st.floats(-1.0, 1.0).map(lambda x: 10.0**x)


@st.composite
def falling_balls(draw, speed=None):
    speed = draw(st.floats(0.1, 10.0)) if speed is None else speed
    masses = draw(st.tuples(powers, powers))
    restitution = draw(st.tuples(st.floats(0.05, 1.0), st.floats(0.05, 1.0)))
    return {'masses': masses, 'restitution': restitution, 'ratio': draw(powers), 'speed': speed}


def random_bodies(rng, count=3, friction=None, table=True):
    """A body of any inertia between others, touching at `count` random points."""
    bodies = [TABLE] if table else [random_body(rng)]
    bodies.append(random_body(rng))
    bodies.append(random_body(rng))
    contacts = []
    for j in range(count):
        n = rng.normal(size=3)
        contacts.append({
            'a': 1, 'b': 0 if j % 2 else 2, 'point': bodies[1]['position'] + rng.normal(size=3),
            'normal': n / np.linalg.norm(n), 'stiffness': float(np.exp(rng.uniform(-1, 1))),
            'friction': float(rng.uniform(0.0, 1.0)) if friction is None else friction,
            'restitution': float(rng.uniform(0.3, 0.95)),
        })  # fmt: skip
    return bodies, contacts


def random_body(rng):
    edges = rng.uniform(0.3, 1.5, 3) ** 2
    shape = rng.normal(size=(3, 3))
    turn = np.linalg.qr(shape)[0]
    principal = np.array([edges[1] + edges[2], edges[0] + edges[2], edges[0] + edges[1]])
    quaternion = rng.normal(size=4)
    return {
        'mass': float(rng.uniform(0.5, 3.0)), 'inertia': turn @ np.diag(principal) @ turn.T,
        'orientation': quaternion / np.linalg.norm(quaternion),
        'position': rng.normal(size=3), 'velocity': rng.normal(size=3),
        'spin': rng.normal(size=3),
    }  # fmt: skip


def check_ledger(setup, result, tolerance=1e-7):
    """Momentum, energy, cones, and nothing left approaching."""
    bodies, contacts = setup
    v, w = start_of(setup)
    assert result.status in (Status.OK, Status.INFINITE_SEQUENCE)
    impulses = result.impulses
    change = np.zeros((len(bodies), 6))
    for contact, impulse in zip(contacts, impulses, strict=True):
        for body, sign in ((contact['a'], 1.0), (contact['b'], -1.0)):
            lever = contact['point'] - np.asarray(bodies[body].get('position', (0, 0, 0)))
            push = np.hstack([impulse, np.cross(lever, impulse)])
            change[body] += sign * inverse_mass(bodies[body]) @ push
    after = np.hstack([v, w]) + change
    scale = max(1.0, np.abs(after).max())
    np.testing.assert_allclose(result.velocities, after[:, :3], atol=1e-12 * scale)
    np.testing.assert_allclose(result.spins, after[:, 3:], atol=1e-12 * scale)
    before = kinetic_energy(setup, v, w)
    lost = before - kinetic_energy(setup, result.velocities, result.spins)
    losses = np.asarray(result.dissipated)[:, :2]
    assert lost >= -tolerance * before
    assert losses.sum() == pytest.approx(lost, abs=tolerance * before)
    assert (losses >= -tolerance * before).all()
    for contact, impulse in zip(contacts, impulses, strict=True):
        n = np.asarray(contact['normal'], float)
        normal = impulse @ n
        tangential = np.linalg.norm(impulse - normal * n)
        assert normal >= 0.0
        assert tangential <= contact.get('friction', 0.0) * normal * (1 + 1e-9) + 1e-12
    rows = jacobian(bodies, contacts)
    start = rows @ np.hstack([v, w]).ravel()
    end = rows @ after.ravel()
    assert end[::3].min() >= tolerance * start[::3].min()


@examples
@given(falling_balls(), laws)
def test_theorems_2_and_3(balls, law):
    result = run(two_balls(**balls), law=law, tolerance=1e-10)
    m1, m2 = balls['masses']
    v0 = -balls['speed']
    energy = 0.5 * m1 * v0**2
    impulses = np.array([p.impulses for p in result.phases])[:, :, 2]
    energies = np.array([p.energies for p in result.phases])
    i1, i2 = impulses.T
    assert (energies >= 0.0).all()
    bound = -v0 * i1 - i1**2 / (2 * m1) - (i1 - i2) ** 2 / (2 * m2)  # (14)
    assert (energies.sum(axis=1) <= bound + 1e-8 * energy).all()
    assert (np.diff(impulses, axis=0) >= 0.0).all()
    v1, v2 = result.velocities[:2, 2]
    assert result.status in (Status.OK, Status.INFINITE_SEQUENCE)
    assert v1 >= v2 - 1e-8 * balls['speed']
    assert v2 >= -1e-8 * balls['speed']


@examples
@given(falling_balls(speed=1.0), laws, st.floats(0.01, 50.0))
def test_theorem_4_scaling(balls, law, s):
    one = run(two_balls(**balls), law=law)
    other = run(two_balls(**{**balls, 'speed': s}), law=law)
    np.testing.assert_allclose(other.velocities, s * one.velocities, atol=1e-9 * s)
    losses = s**2 * np.asarray(one.dissipated)
    np.testing.assert_allclose(other.dissipated, losses, atol=1e-9 * s**2)
    if one.status == other.status == Status.OK:
        assert states(one) == states(other)
        for a, b in zip(one.phases, other.phases, strict=True):
            np.testing.assert_allclose(b.impulses, s * np.asarray(a.impulses), atol=1e-8 * s)
            np.testing.assert_allclose(b.energies, s**2 * np.asarray(a.energies), atol=1e-8 * s**2)


@examples
@given(seeds, laws, st.integers(-8, 8))
def test_only_ratios_of_stiffness_matter(seed, law, power):
    setup = random_shot(np.random.default_rng(seed))
    stiffer = setup[0], [dict(c) for c in setup[1]]
    for contact in stiffer[1]:
        contact['stiffness'] = contact.get('stiffness', 1.0) * 2.0**power
    one, other = run(setup, law=law), run(stiffer, law=law)
    np.testing.assert_array_equal(one.velocities, other.velocities)
    np.testing.assert_array_equal(one.spins, other.spins)


@examples
@given(seeds, laws, st.booleans())
def test_ledger_of_strokes(seed, law, end_mass):
    setup = random_shot(np.random.default_rng(seed), end_mass=end_mass)
    check_ledger(setup, run(setup, law=law, tolerance=1e-9))


@examples
@given(seeds, laws, st.sampled_from((2, 3)), st.booleans())
def test_ledger_of_bodies_of_any_shape(seed, law, count, table):
    setup = random_bodies(np.random.default_rng(seed), count, table=table)
    check_ledger(setup, run(setup, law=law, tolerance=1e-9))


def test_a_slip_that_creeps_to_its_end_stops_no_other_one():
    """A light cue grazes the equator and wedges itself in, while the ball slips on the cloth."""
    c = 89.8 * np.array([0.5494068109989165, 0.0, -0.8355549988049864])
    setup = shot(
        (0.0070960783575323, -0.9999639367753486, 0.004665921204928289), c, ratio=10.735636393648,
        masses=(0.000181955, 0.1673), friction=(4.264453599380557, 9.295376590566079),
        restitution=(0.24031108500774578, 0.8637994309341525),
    )  # fmt: skip
    check_ledger(setup, run(setup, law='energetic', tolerance=1e-12), 1e-10)


@pytest.mark.parametrize('exponent', [1.0, 1.5])
@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('mu', [0.0, 0.3, 10.0])
@pytest.mark.parametrize('e', [0.0, 0.5, 1.0])
def test_ledger_at_the_ends_of_the_ranges(e, mu, law, exponent):
    for name in SHOTS:
        setup = shot(*SHOTS[name], friction=(mu, mu), restitution=(e, e))
        result = run(setup, law=law, exponent=exponent, tolerance=1e-9)
        check_ledger(setup, result)
        if e == 1.0 and mu == 0.0:
            assert np.abs(result.dissipated).max() < 1e-8 * 0.25 * np.dot(*[SHOTS[name][1]] * 2)


@examples
@given(seeds, laws)
def test_rotation_symmetry(seed, law):
    rng = np.random.default_rng(seed)
    setup = random_bodies(rng, 2)
    quaternion = rng.normal(size=4)
    turn = rotation(quaternion)
    turned = [], []
    for body in setup[0]:
        new = dict(body)
        for key in ('position', 'velocity', 'spin', 'guide'):
            if key in body:
                new[key] = turn @ body[key]
        if 'inertia' in body:  # the matrix is in the body's frame: turn it there and back
            old = rotation(body['orientation'])
            new['inertia'] = turn @ old @ body['inertia'] @ old.T @ turn.T
            new['orientation'] = (0.0, 0.0, 0.0, 1.0)
        turned[0].append(new)
    for contact in setup[1]:
        turned[1].append(contact | {k: turn @ contact[k] for k in ('point', 'normal')})
    one, other = run(setup, law=law), run(turned, law=law)
    np.testing.assert_allclose(other.velocities, one.velocities @ turn.T, atol=1e-7)
    np.testing.assert_allclose(other.spins, one.spins @ turn.T, atol=1e-7)


@examples
@given(seeds, laws)
def test_mirror_symmetry(seed, law):
    mirror = np.array([1.0, -1.0, 1.0])
    setup = random_shot(np.random.default_rng(seed))
    mirrored = [dict(b) for b in setup[0]], [dict(c) for c in setup[1]]
    mirrored[0][0]['velocity'] = mirror * setup[0][0]['velocity']
    mirrored[0][0]['guide'] = mirror * setup[0][0]['guide']
    for contact in mirrored[1]:
        contact['point'] = mirror * contact['point']
        contact['normal'] = mirror * contact['normal']
    one, other = run(setup, law=law), run(mirrored, law=law)
    np.testing.assert_allclose(other.velocities, one.velocities * mirror, atol=1e-7)
    np.testing.assert_allclose(other.spins, -one.spins * mirror, atol=1e-5)


@examples
@given(seeds, laws, st.permutations(range(3)), st.permutations(range(3)))
def test_order_of_bodies_and_contacts_does_not_matter(seed, law, bodies, contacts):
    setup = random_bodies(np.random.default_rng(seed), 3)
    place = {old: new for new, old in enumerate(bodies)}
    moved = [setup[0][i] for i in bodies], [dict(setup[1][j]) for j in contacts]
    for contact in moved[1]:
        contact['a'], contact['b'] = place[contact['a']], place[contact['b']]
    one, other = run(setup, law=law), run(moved, law=law)
    np.testing.assert_allclose(other.velocities, one.velocities[list(bodies)], atol=1e-7)
    np.testing.assert_allclose(other.spins, one.spins[list(bodies)], atol=1e-7)


@examples
@given(seeds, laws)
def test_swapping_the_two_bodies_of_a_contact_does_not_matter(seed, law):
    setup = random_bodies(np.random.default_rng(seed), 2)
    swapped = setup[0], [dict(c) for c in setup[1]]
    for contact in swapped[1]:
        contact['a'], contact['b'] = contact['b'], contact['a']
        contact['normal'] = -contact['normal']
    one, other = run(setup, law=law), run(swapped, law=law)
    np.testing.assert_allclose(other.velocities, one.velocities, atol=1e-7)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('friction', [0.0, 0.3, 10.0])
@pytest.mark.parametrize('velocity', [(0, 0, -1), (0.3, 0.1, -1), (2.0, -1.0, -0.5)])
def test_block_on_four_corners_whatever_their_order(velocity, friction, law):
    setup = block(velocity, (0.1, -0.2, 0.3), friction)
    one = run(setup, law=law)
    check_ledger(setup, one)
    for order in ((3, 2, 1, 0), (1, 3, 0, 2), (2, 0, 3, 1)):
        other = run(block(velocity, (0.1, -0.2, 0.3), friction, order=order), law=law)
        np.testing.assert_allclose(other.velocities, one.velocities, atol=1e-7)
        np.testing.assert_allclose(other.spins, one.spins, atol=1e-7)
        # How the corners share the friction depends on when it is found to give way.
        np.testing.assert_allclose(other.impulses, one.impulses[list(order)], atol=1e-6)


def test_block_falling_flat_shares_the_load_equally():
    result = run(block((0.0, 0.0, -1.0)))
    np.testing.assert_allclose(result.impulses, np.tile((0, 0, 1.5 * 1.3 / 4), (4, 1)), atol=1e-9)


def test_end_mass_between_free_and_guided():
    # A heavy end is the guided cue, an end as heavy as the whole cue a free point mass.
    normal, velocity = (-0.9, 0.4, 0.1), (2.0, 0.0, 0.0)
    guided = run(shot(normal, velocity), law='bistiffness')
    heavy = run(shot(normal, velocity, end_mass=1e9), law='bistiffness')
    np.testing.assert_allclose(heavy.velocities, guided.velocities, atol=1e-7)
    setup = shot(normal, velocity, end_mass=0.5018)
    free = setup[0].copy(), setup[1]
    free[0][0] = {'mass': 0.5018, 'velocity': velocity}
    assert difference(setup, run(setup), run(free)) < 1e-9
    off_line = [
        np.arctan2(*run(shot(normal, velocity, end_mass=m)).velocities[1][[1, 0]])
        for m in (0.005, 0.02, 0.1, 0.5)
    ]
    assert (np.diff(np.abs(off_line)) > 0.0).all()


@pytest.mark.parametrize('law', LAWS)
def test_restitution_of_a_single_contact(law):
    # Whatever the law and the force exponent: v' = -e v.
    for e in (0.0, 0.3, 1.0):
        for exponent in (1.0, 1.5):
            setup = chain(2)
            setup[1][0]['restitution'] = e
            result = run(setup, law=law, exponent=exponent, tolerance=1e-10)
            expected = ((1 - e) / 2, (1 + e) / 2)
            np.testing.assert_allclose(result.velocities[:, 0], expected, atol=1e-9)


def test_nothing_happens_where_nothing_approaches():
    setup = chain(3, speed=-1.0)
    result = run(setup)
    assert result.status == Status.OK
    assert len(result.phases) == 0
    np.testing.assert_array_equal(result.velocities, start_of(setup)[0])


@pytest.mark.parametrize('reactivation', ['instant', 'distance'])
def test_bodies_without_contacts_keep_their_motion(reactivation):
    body = Body(mass=1.0, inertia=1.0, velocity=(1.0, 2.0, 3.0), spin=(4.0, 0.0, 0.0))
    for bodies in ([], [body, body]):
        result = collide(bodies, [], reactivation=reactivation)
        assert result.status == Status.OK
        assert result.velocities.tolist() == [[1.0, 2.0, 3.0]] * len(bodies)
        assert result.spins.tolist() == [[4.0, 0.0, 0.0]] * len(bodies)
        assert result.impulses.shape == (0, 3)
        assert result.dissipated.shape == (0, 2)
        assert result.phases == ()


def test_frames_of_the_slow_check_are_orthonormal():
    for n in ((0, 0, 1), (1, 2, 3), (-1, 0, 0)):
        np.testing.assert_allclose(frame(n) @ frame(n).T, np.eye(3), atol=1e-15)


@pytest.mark.parametrize(('kept', 'gap'), [(0.25, 0.0), (0.1, 0.2)])
def test_energy_without_an_account_is_noticed(kept, gap):
    contact = ContactState()
    contact.velocity[0] = 0.5  # met at 1: the impulse 1 took away 0.25
    contact.impulse[0] = 1.0
    contact.restitution_loss = kept
    ws = workspace(OBJECTS, 1, TABLEAUS[OBJECTS])
    ws.vector[2][0] = -2.0  # the velocity before
    found = energy_imbalance([contact], 2.0, ws)
    assert found == pytest.approx(gap, abs=1e-15)
