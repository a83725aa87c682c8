"""Strokes that graze and jam: what presses comes to be billions of times faster than it met."""

import math

import numpy as np
import pytest
from setups import guided_strike, solved

from billiard_shot.impact import Body, collide, Contact, kernel
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.options import ENERGETIC, METHOD_OPTIONS
from billiard_shot.impact.state import ContactState, Model, SECTION, workspace
from billiard_shot.records import OBJECTS
from billiard_shot.status import Status

# As of `guided_strike`.
STROKES = {
    'heavy cue': (
        80.0,
        0.0165,
        'bistiffness',
        (8.2, 0.47),
        (0.54, 0.98),
        1e-11,
        0.32,
        (0.24, 0.65, 0.72),
    ),
    'light cue': (
        1e-4,
        0.003,
        'bistiffness',
        (4.9, 4.2),
        (0.79, 0.62),
        9e-11,
        0.59,
        (-0.46, -0.56, -0.69),
    ),
    'cue of a millionth': (
        1.8e-6,
        1.9,
        'bistiffness',
        (7.9, 0.28),
        (0.49, 0.61),
        2.5e-11,
        1.03,
        (0.59, -0.73, 0.35),
    ),
    'steep': (
        4.5e-4,
        0.075,
        'bistiffness',
        (9.6, 2.9),
        (0.37, 0.88),
        7e-10,
        1.29,
        (0.96, 0.0, 0.28),
    ),
    'energetic': (770.0, 0.13, 'energetic', (2.8, 1.5), (0.6, 0.4), 1e-10, 0.5, (0.5, 0.86, 0.09)),
}
# It was taken to leave its cone of friction at once, whatever it had just been found to do.
AT_ITS_CONE = (
    82.4998,
    0.0164986,
    'bistiffness',
    (8.20919, 0.465922),
    (0.543221, 0.978531),
    1.06972e-11,
    0.320556,
    (0.23833352, 0.65412259, 0.71785846),
)
# Its slip stopped and began again for ever, where hardly anything is left of the motion.
DEAD_TIP = (
    1.4e-4,
    5.88342,
    'bistiffness',
    (0.687788, 0.0189014),
    (0.0, 0.094228),
    0.124068,
    0.403421,
    (0.2754, 0.0, 0.9613),
)


# With a light cue and n.c of 1e-11 the sequence of events changes all the time.
HOPELESS = 'light cue', 'cue of a millionth'


@pytest.mark.parametrize('name', sorted({*STROKES} - {*HOPELESS}))
def test_what_grows_is_followed_in_steps_that_grow_with_it(name):
    problem = guided_strike(*STROKES[name])
    exact, status, steps = solved(problem, 1e-12)
    assert status == Status.OK
    assert steps < 6000
    assert np.abs(exact).max() > 1e3 * problem.model.surface.mass * problem.speed  # it jams
    rough, status, _ = solved(problem, 1e-9)
    assert status == Status.OK
    np.testing.assert_allclose(rough, exact, rtol=0, atol=1e-6 * np.abs(exact).max())


def test_contacts_at_their_cone_do_not_reach_it_for_ever():
    _, _, steps = solved(guided_strike(*AT_ITS_CONE), 1e-12)
    assert steps < 6000


def test_slip_does_not_stop_and_start_for_ever():
    solved(guided_strike(*DEAD_TIP), 1e-12)


@pytest.mark.parametrize('name', HOPELESS)
def test_a_hopeless_jam_ends_soon_and_says_so(name):
    problem = guided_strike(*STROKES[name])
    impulse, steps, status = problem.adaptive(1e-12)
    assert status == Status.BUDGET_EXCEEDED
    assert steps < 1.01 * METHOD_OPTIONS.max_steps
    assert np.isfinite(impulse).all()
    work = impulse @ (problem.velocity + 0.5 * problem.response @ impulse)
    assert work < 1e-9 * problem.model.cue_mass  # no energy is gained


@pytest.mark.parametrize('guide', [(0.3007058, 0, 0.953717), (0.24, 0.18, 0.9539392014169456)])
@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_a_guided_body_that_friction_holds_comes_to_rest(guide, exponent):
    """Rounding was left of its mobility: impulses of 1e7 N s, or NaN, with status OK."""
    guide = np.array(guide) / np.linalg.norm(guide)
    result = collide(
        [Body(1.0, velocity=-guide, guide=guide), Body.fixed()],
        [Contact(0, 1, (0, 0, 0), (1, 0, 0), 0.5, 0.9)],
        exponent=exponent,
    )
    assert result.status == Status.OK
    assert result.velocities == pytest.approx(np.zeros((2, 3)), abs=1e-9)
    assert np.sum(result.dissipated) == pytest.approx(0.5, rel=1e-6)


def test_two_contacts_of_the_same_two_bodies():
    """The friction along the line between them is shared; the slip began again without end."""
    contacts = [
        Contact(0, 1, place, (1, 0, 0), 0.5, 0.9) for place in ((-0.5, 0, 0), (-0.5, 0.2, 0))
    ]
    spatial, planar = (
        collide([Body(10, 1.0, (-0.95, 0.5, vz)), Body.fixed()], contacts) for vz in (0.05, 0.0)
    )
    assert spatial.status == planar.status == Status.OK
    assert spatial.evaluations < 500
    assert spatial.impulses[:, 0] == pytest.approx(planar.impulses[:, 0], abs=1e-2)


def test_contacts_that_open_do_not_close_at_the_same_moment_without_end():
    bodies = [
        Body(0.1, None, (1, 0, 1)),
        Body(10, None, (-1, 0, 1), (0, 0, 0), (1, 0, 0)),
        Body.fixed(),
    ]
    contacts = [
        Contact(0, 2, (-0.5, 0, 0), (1, 0, 0), 0.5, 0.6),
        Contact(0, 2, (0, 0, -0.5), (0, 0, 1), 0.5, 0.6, 100.0),
        Contact(0, 2, (0.2, 0, -0.5), (0, 0, 1), 0.5, 0.6),
        Contact(1, 0, (0.5, 0, 0), (1, 0, 0), 1.0, 0.6),
        Contact(1, 2, (1, -0.5, 0), (0, 1, 0), 0.5, 0.6),
    ]
    assert collide(bodies, contacts, exponent=1.5).status == Status.INFINITE_SEQUENCE


def test_the_books_of_law_poisson_close():
    """An impulse that is applied at once leaves another contact a velocity that counts."""
    masses, speeds = np.array([10, 0.1, 10]), np.array([1, 0, -0.3])
    bodies = [Body(m, velocity=(v, 0, 0)) for m, v in zip(masses, speeds, strict=True)]
    contacts = [Contact(1, 0, (0, 0, 0), (1, 0, 0), 1.0), Contact(2, 1, (0, 0, 0), (1, 0, 0), 1.0)]
    result = collide(bodies, contacts, law='poisson')
    after = result.velocities[:, 0]
    gain = 0.5 * (masses * (after**2 - speeds**2)).sum()
    assert gain == pytest.approx(-np.sum(result.dissipated), rel=1e-9)
    assert (np.diff(after) > 0).all()  # they part


@pytest.mark.parametrize('tiny', [0.0, 1e-15, 1e-13, 5e-13])
def test_a_negligible_approach_ends_no_collision(tiny):
    bodies = [
        Body(1, velocity=(-tiny, 0, 0)), Body.fixed(), Body(1, velocity=(0, 0, -1)), Body(1),
    ]  # fmt: skip
    contacts = [Contact(0, 1, (0, 0, 0), (1, 0, 0)), Contact(2, 3, (0, 0, 0), (0, 0, 1), gap=0.1)]
    result = collide(bodies, contacts, reactivation='distance')
    assert result.status == Status.OK
    assert result.velocities[2:, 2] == pytest.approx([0.0, -1.0], abs=1e-9)


# --- bodies that are pressed together and lose a share of their motion in every cycle of impacts

# As of `guided_strike`. Step by step each takes more than 50,000 steps to come to nothing: cycles
# of one section and of several, slip that fades and slip that does not.
TAILS = {
    'bistiffness': (
        3.9698,
        1.6893,
        'bistiffness',
        (0.667811, 0.414364),
        (0.319557, 0.872115),
        0.415723,
        0.0,
        (-0.415723, 0.0981968, 0.904175),
    ),
    'energetic': (
        6.4654,
        8.48738,
        'energetic',
        (0.44868, 0.219278),
        (0.337391, 0.762341),
        0.339312,
        0.0,
        (-0.339312, 0.0375052, 0.939926),
    ),
    'near the top': (
        3.4782,
        2.07108,
        'energetic',
        (0.704991, 0.242991),
        (0.792055, 0.328708),
        0.377529,
        0.0,
        (-0.377529, 0.0220178, 0.925736),
    ),
    'from the side': (
        8.051,
        3.20615,
        'energetic',
        (0.878461, 0.540594),
        (0.366016, 0.468503),
        0.412183,
        0.0,
        (-0.412183, 0.463215, 0.784562),
    ),
    'light cue': (
        2.8324,
        1.49378,
        'energetic',
        (0.820307, 0.685111),
        (0.54644, 0.308641),
        0.603912,
        0.0,
        (-0.603912, 0.402232, 0.688113),
    ),
}


@pytest.mark.parametrize('name', TAILS)
def test_the_rest_of_a_decaying_sequence_is_added_at_once(name):
    problem = guided_strike(*TAILS[name])
    exact, status, steps = solved(problem, 1e-12)
    assert status == Status.INFINITE_SEQUENCE
    assert steps < 20_000
    for tolerance in (1e-11, 1e-10, 1e-9):  # each adds up another part of the sequence
        rough, status, _ = solved(problem, tolerance)
        assert status == Status.INFINITE_SEQUENCE
        off = problem.response @ (rough - exact)
        assert np.abs(off).max() < 5.0 * tolerance * problem.speed


@pytest.mark.parametrize('ratio', [0.1, 0.9, 0.99])
def test_cycles_to_come_add_up_as_a_geometric_series(ratio):
    """Velocities and impulses shrink with the ratio, energies with its square or a mixture."""
    model = Model(ENERGETIC, 1e-12, False, False, 0, False, math.inf, 0.0)
    contact = ContactState()
    contact.stiffness = contact.exponent = 1.0
    ws = workspace(OBJECTS, 1, TABLEAUS[OBJECTS])
    for i in range(3):
        ws.delassus[i][i] = 1.0
    # velocity, slip (2), compression, impulses (3), losses (2), final slip
    limit = np.array([0, 0.7, 0.2, 0, 3.0, -0.4, 0.1, 0.5, 0.8, 0.7])
    once = np.array([-1, 0.1, 0, 2.0, -1.5, 0.2, 0, 0, -0.3, 0.1])  # how far it is from there
    twice = np.zeros(SECTION)
    twice[7:9] = -0.25, -0.05  # energies: the part that goes with the square
    first, last, now = (
        (limit + ratio**n * once + ratio ** (2 * n) * twice).tolist() for n in range(3)
    )
    size = kernel.amplitude([contact], ws, last, first)
    found = kernel.amplitude([contact], ws, now, last) / size
    assert found == pytest.approx(ratio, rel=1e-14)
    assert kernel.is_geometric(model, [contact], ws, now, last, first, ratio)
    kernel.add_cycles([contact], now, last, first, ratio)
    reached = (
        contact.velocity[0],
        contact.slip_1[0],
        contact.slip_2[0],
        *contact.impulse,
        contact.restitution_loss,
        contact.friction_loss,
        contact.final_slip,
    )
    np.testing.assert_allclose(reached, np.delete(limit, 3), rtol=0, atol=1e-11)
    back = np.zeros(SECTION)  # with it, the slip would turn back on the way to its limit
    back[1:3] = -0.7 - 0.05 * ratio**2, -0.2
    moved = ((np.array(x) + back).tolist() for x in (now, last, first))
    assert not kernel.is_geometric(model, [contact], ws, *moved, ratio)
    for row in (0, 1, 3, 4, 5):  # what is no series is not taken for one
        other = list(now)
        other[row] += 1e-9 * (1.0 - ratio)
        assert not kernel.is_geometric(model, [contact], ws, other, last, first, ratio)
