"""
Contacts with distances: bodies that do not touch yet, or no longer.

The numbers come from an integration of the same law by another method (event-driven Runge-Kutta,
differences between two step sizes below the digits given), in units of mass, stiffness and speed.
"""

from dataclasses import replace
import itertools

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import Status
from billiard_shot.impact import Body, collide, Contact
from billiard_shot.impact.collide import direction

UP = (0.0, 0.0, 1.0)


def settle(bodies, contacts, **options):
    """
    Let bodies that are held on a line collide until none approaches any other.

    A collision ends as soon as no contact is active. Then the bodies fly on, and the contact that
    closes first begins the next one.
    """
    options = {'tolerance': 1e-12, 'reactivation': 'distance', **options}
    gaps = np.array([contact.gap for contact in contacts])
    results = []
    while True:
        closing = np.array(
            [-np.dot(bodies[c.a].velocity - bodies[c.b].velocity, c.normal) for c in contacts]
        )
        approaches = closing > 1e-14
        if not approaches.any():
            return results
        times = np.full(len(gaps), np.inf)
        times[approaches] = gaps[approaches] / closing[approaches]
        first = times.argmin()
        gaps = np.maximum(gaps - closing * times[first], 0.0)
        gaps[first] = 0.0
        touching = [replace(c, gap=gap) for c, gap in zip(contacts, gaps, strict=True)]
        results.append(collide(bodies, touching, **options))
        gaps = -results[-1].lengths
        velocities = results[-1].velocities
        bodies = [replace(b, velocity=v) for b, v in zip(bodies, velocities, strict=True)]


def chain(velocities, gaps, e, masses=None, stiffnesses=None, wall=False):
    """Bodies in a row along z, each in contact with the next; the last one perhaps with a wall."""
    masses = masses or [1.0] * len(velocities)
    bodies = [Body(m, velocity=(0, 0, v)) for m, v in zip(masses, velocities, strict=True)]
    bodies += [Body.fixed()] if wall else []
    stiffnesses = stiffnesses or [1.0] * len(gaps)
    e = e if isinstance(e, list) else [e] * len(gaps)
    contacts = [
        Contact(i, i + 1, (0, 0, -i), UP, e[i], 0.0, stiffnesses[i], gap=gaps[i])
        for i in range(len(gaps))
    ]
    return bodies, contacts


def speeds(bodies, contacts, **options):
    """Velocities along z when all is over."""
    last = settle(bodies, contacts, **options)[-1].velocities[:, 2]
    return last[[body.mass < np.inf for body in bodies]]


THREE = [
    (1.0, 1.0, 0.0, (0.13026170, -0.15022957, -0.98003213)),
    (1.0, 1.0, 0.01, (0.12441681, -0.14246808, -0.98194873)),
    (1.0, 1.0, 0.1, (0.08015222, -0.08719024, -0.99296197)),
    (1.0, 1.0, 0.3, (0.02652475, -0.02724802, -0.99927673)),
    (1.0, 1.0, 0.5, (0.00716228, -0.00721395, -0.99994833)),
    (1.0, 1.0, 1.0, (0.00000630, -0.00000630, -1.0)),
    (1.0, 1.0, 1.1107, (0.0, 0.0, -1.0)),
    (1.0, 0.9, 0.0, (0.06530459, -0.16719295, -0.89811164)),
    (1.0, 0.9, 0.1, (0.01674289, -0.11217795, -0.90456494)),
    (1.0, 0.9, 0.3, (-0.03110537, -0.06488220, -0.90401244)),
    (1.0, 0.9, 0.5, (-0.04599010, -0.05113399, -0.90287591)),
    (1.0, 0.9, 1.2, (-0.04762500, -0.04987500, -0.90250000)),
    (1.0, 0.5, 0.0, (-0.18273486, -0.23398418, -0.58328096)),
    (1.0, 0.5, 0.1, (-0.20899740, -0.21749252, -0.57351008)),
    (1.0, 0.5, 0.5, (-0.20312659, -0.23436989, -0.56250352)),
    (1.5, 1.0, 0.0, (0.07095235, -0.07640304, -0.99454931)),
    (1.5, 1.0, 0.1, (0.04134429, -0.04313068, -0.99821360)),
    (1.5, 1.0, 0.3, (0.01277696, -0.01294235, -0.99983461)),
    (1.5, 0.9, 0.0, (0.00861536, -0.10414280, -0.90447256)),
    (1.5, 0.9, 0.1, (-0.01815601, -0.07720733, -0.90463666)),
]


@pytest.mark.parametrize(('exponent', 'e', 'gap', 'expected'), THREE)
def test_three_in_a_row(exponent, e, gap, expected):
    found = speeds(*chain((-1.0, 0.0, 0.0), (0.0, gap), e), exponent=exponent)
    assert found == pytest.approx(expected, abs=2e-8)


FIVE = [
    (1.0, 1, (0, 0, 0, 0), (0.09928903, 0.04644472, 0.00966849, -0.27757563, -0.87782661)),
    (1.0, 1, (0, 0.1, 0.1, 0.1), (0.04824881, 0.00357981, -0.01110505, -0.13327081, -0.90745276)),
    (1.0, 1, (0, 0.3, 0.3, 0.3), (-0.00249791, -0.02219393, -0.02407669, -0.0446995, -0.90653196)),
    (1.5, 1, (0, 0, 0, 0), (0.03960838, 0.00241457, -0.01042068, -0.12478849, -0.90681379)),
    (1.5, 1, (0, 0.1, 0.1, 0.1), (0.01133607, -0.01576282, -0.02132205, -0.06621579, -0.90803541)),
    (1.0, 2, (0, 0, 0.1, 0.1), (0.06966571, -0.00610045, -0.27361636, -0.64248366, -1.14746524)),
]


@pytest.mark.parametrize(('exponent', 'start', 'gaps', 'expected'), FIVE)
def test_five_in_a_row(exponent, start, gaps, expected):
    velocities = [-1.0] * start + [0.0] * (5 - start)
    found = speeds(*chain(velocities, gaps, 0.95), exponent=exponent)
    assert found == pytest.approx(expected, abs=2e-8)


@pytest.mark.parametrize(
    ('law', 'gap', 'expected'),
    [
        ('bistiffness', 0.0, (2.64942547, 0.35318493)),
        ('bistiffness', 0.1, (2.48252846, 0.53863579)),
        ('bistiffness', 1.0, (2.07416766, 0.20144767)),
        ('bistiffness', 3.0, (1.79927439, 0.01742966)),
        ('energetic', 0.0, (2.42061288, 0.76248628)),
        ('energetic', 0.1, (2.28777344, 0.82854941)),
        ('energetic', 1.0, (2.11518568, 0.21256930)),
    ],
)
def test_a_gap_above_the_ground(law, gap, expected):
    # The two balls of the paper's Fig. 4.
    bodies, contacts = chain(
        (-3.0, 0.0), (0.0, gap), [0.9**0.5, 0.4**0.5], stiffnesses=[1.0, 10.0], wall=True
    )
    assert speeds(bodies, contacts, law=law) == pytest.approx(expected, abs=1e-7)


def test_a_heavy_ball_on_a_light_one():
    bodies, contacts = chain(
        (-1.0, 0.0), (0.0, 0.0), [0.9, 0.5], masses=[100.0, 1.0], stiffnesses=[1.0, 0.1], wall=True
    )
    assert speeds(bodies, contacts) == pytest.approx((0.08235773, 0.07494107), abs=1e-7)
    instant = collide(bodies, contacts, tolerance=1e-12).velocities[:2, 2]
    assert instant == pytest.approx((0.39550011, 0.01930979), abs=1e-7)


def test_bodies_far_apart_meet_one_after_the_other():
    # From pi / (2 sqrt 2) on, the first two have parted before the third is reached.
    bodies, contacts = chain((-1.0, 0.0, 0.0), (0.0, 1.2), 0.9)
    results = settle(bodies, contacts)
    assert [len(result.phases) for result in results] == [1, 1, 1]
    assert results[0].duration == pytest.approx(np.pi / np.sqrt(2.0) * 0.95)  # e = .9: 1, then e


def test_a_sequence_that_dies_down_ends_although_a_distant_body_approaches():
    """Three balls come to rest against each other, on their way to a fourth one."""
    bodies, contacts = chain(
        [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.125, 0.15625, 1.0], [0.25, 0.25, 3.0, 1.0],
        [1.0, 1.0, 1.0], False,
    )  # fmt: skip
    result = collide(bodies, contacts, tolerance=1e-9, reactivation='distance')
    assert result.status == Status.INFINITE_SEQUENCE
    assert result.evaluations < 1000
    assert result.velocities[:, 2] == pytest.approx([-1 / 14] * 3 + [0.0], abs=1e-9)
    assert result.lengths[2] < -0.1


def test_bodies_at_rest_in_touch_do_not_end_a_collision():
    """They ended it before other bodies, a micrometre apart, met."""
    bodies = [Body(mass=1.0, velocity=(0, 0, -1)), *[Body(mass=1.0)] * 3]
    contacts = [
        Contact(0, 1, (0, 0, 0), UP, restitution=0.9, stiffness=1e6, gap=1e-6),
        Contact(2, 3, (5, 0, 0), UP, restitution=0.9, stiffness=1e6),
    ]
    result = collide(bodies, contacts, law='bistiffness', reactivation='distance', tolerance=1e-9)
    assert result.status == Status.OK
    assert result.velocities[:, 2] == pytest.approx([-0.05, -0.95, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_the_duration_of_a_contact(exponent):
    # Ball on ball: pi sqrt(m / 2 k); after Hertz 2.943 y / v, y = (5/4 m v^2 / 2 k)^(2/5).
    mass, stiffness, speed = 0.17, 9.2e8 if exponent == 1.5 else 3.0e7, 3.0
    bodies = [Body(mass, velocity=(0, 0, -speed)), Body(mass)]
    contact = Contact(0, 1, (0, 0, 0), UP, stiffness=stiffness)
    result = collide(bodies, [contact], exponent=exponent, reactivation='distance')
    peak = (1.25 * 0.5 * mass * speed**2 / stiffness) ** 0.4
    expected = np.pi * np.sqrt(mass / (2 * stiffness)) if exponent == 1 else 2.9432 * peak / speed
    assert result.duration == pytest.approx(expected, rel=1e-4)
    assert result.lengths == pytest.approx([0.0], abs=1e-15)


def test_open_contacts_know_their_distance():
    bodies, contacts = chain((-1.0, 0.0, 0.0), (0.0, 5.0), 1.0)
    result = collide(bodies, contacts, tolerance=1e-12, reactivation='distance')
    # Over its duration the middle ball goes half as far as the first one would have.
    assert result.lengths[1] == pytest.approx(-5.0 + 0.5 * result.duration)


LAWS = ['bistiffness', 'energetic']
E_AND_GAPS = st.lists(
    st.tuples(
        st.floats(0.1, 1.0),
        st.one_of(st.just(0.0), st.floats(0.0, 2.0)),
        st.floats(0.2, 5.0),
        st.floats(0.05, 20.0),
    ),
    min_size=1,
    max_size=5,
)


@settings(deadline=None)
@given(
    E_AND_GAPS,
    st.booleans(),
    st.sampled_from([1.0, 1.5]),
    st.sampled_from(['bistiffness', 'energetic']),
)
def test_energy_is_never_gained(links, wall, exponent, law):
    count = len(links) + (not wall)
    masses = [link[2] for link in links] + [1.0] * (not wall)
    bodies, contacts = chain(
        [-1.0] + [0.0] * (count - 1),
        [0.0] + [link[1] for link in links[1:]],
        [link[0] for link in links],
        masses,
        [link[3] for link in links],
        wall,
    )
    result = collide(
        bodies, contacts, law=law, exponent=exponent, tolerance=1e-9, reactivation='distance'
    )
    if law == 'bistiffness':  # under law energetic, springs may lose their energy without end
        assert result.status in (Status.OK, Status.INFINITE_SEQUENCE)
    before = 0.5 * masses[0]
    after = 0.5 * np.dot(masses, result.velocities[:count, 2] ** 2)
    assert after + result.dissipated.sum() == pytest.approx(before, rel=1e-6)
    assert (result.dissipated >= -1e-9).all()


@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_the_answer_is_continuous_in_the_gap(exponent):
    # Bisection: a step that does not shrink with the interval would be a jump.
    def at(gap):
        return speeds(
            *chain((-1.0, 0.0, 0.0, 0.0), (0.0, gap, gap), [0.9, 0.8, 0.95]), exponent=exponent
        )

    gaps = [0.0, *np.geomspace(1e-9, 2.0, 40)]
    for low, high in itertools.pairwise(gaps):
        below, above = at(low), at(high)
        while np.abs(above - below).max() > 5e-3:
            middle = 0.5 * (low + high)
            assert high - low > 1e-9, f'a jump near {middle}'
            halfway = at(middle)
            if np.abs(halfway - below).max() > np.abs(above - halfway).max():
                high, above = middle, halfway
            else:
                low, below = middle, halfway


def test_gaps_of_almost_nothing_are_no_gaps():
    touching = speeds(*chain((-1.0, 0.0, 0.0), (0.0, 0.0), 0.9))
    assert speeds(*chain((-1.0, 0.0, 0.0), (0.0, 1e-12), 0.9)) == pytest.approx(touching, abs=1e-9)


def test_friction_acts_where_a_gap_closes():
    # A ball that slides over the ground, onto which another one presses it.
    normal = direction('normal', (0.3, 0.0, 1.0))
    ball = {'mass': 1.0, 'inertia': 0.4}
    bodies = [Body(**ball, velocity=(0, 0, -1), position=(0.6, 0, 2)), Body(**ball), Body.fixed()]
    contacts = [
        Contact(0, 1, (0.3, 0, 1), normal, 0.9, 0.1),
        Contact(1, 2, (0, 0, -1), UP, 0.5, 0.3, 2.0, gap=0.05),
    ]
    result = collide(bodies, contacts, reactivation='distance')
    assert result.status == Status.OK
    assert result.impulses[1, 2] > 0.0
    assert 0.0 < np.hypot(*result.impulses[1, :2]) <= 0.3 * result.impulses[1, 2] * (1 + 1e-9)
    energy = 0.5 * (result.velocities**2).sum() + 0.2 * (result.spins**2).sum()
    assert energy + result.dissipated.sum() == pytest.approx(0.5)


def test_bad_gaps():
    with pytest.raises(ValueError, match='gap'):
        Contact(0, 1, (0, 0, 0), UP, gap=-1e-3)
    bodies, contacts = chain((-1.0, 0.0, 0.0), (0.0, 0.1), 0.9)
    with pytest.raises(ValueError, match='gap must be 0 with reactivation instant'):
        collide(bodies, contacts)
    with pytest.raises(ValueError, match='reactivation must be one of instant, distance'):
        collide(bodies, contacts, reactivation='later')
