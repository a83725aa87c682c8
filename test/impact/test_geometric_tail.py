"""Bodies that are pressed together and lose a share of their motion in every cycle of impacts."""

import math

import numpy as np
import pytest
from setups import guided_strike, solved

from billiard_shot.impact import kernel
from billiard_shot.impact.collocation import TABLEAUS
from billiard_shot.impact.options import ENERGETIC
from billiard_shot.impact.state import ContactState, Model, SECTION, workspace
from billiard_shot.records import OBJECTS
from billiard_shot.status import Status

# As of `guided_strike`. Step by step each takes more than 50,000 steps to come to nothing: cycles
# of one section and of several, slip that fades and slip that does not.
STROKES = {
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


@pytest.mark.parametrize('name', STROKES)
def test_the_rest_of_a_decaying_sequence_is_added_at_once(name):
    problem = guided_strike(*STROKES[name])
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
