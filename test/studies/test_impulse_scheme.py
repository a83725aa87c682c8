"""The paper's impulse-space scheme: its example, its order, and its agreement with the rest."""

import numpy as np
from paper_values import FIG_4_IMPULSES, TABLE_1
import pytest
from setups import (
    BALL,
    CLOTH_FRICTION,
    CLOTH_RESTITUTION,
    CUE,
    RADIUS,
    SHOTS,
    TIP_FRICTION,
    TIP_RESTITUTION,
)

from billiard_shot.status import Status
from studies.impulse_scheme import solve_strike, two_balls

FIG_4 = {'masses': (1.0, 1.0), 'restitution': (0.9**0.5, 0.4**0.5), 'ratio': 10.0, 'speed': 3.0}
CUE_AND_BALL = {
    'cue_mass': CUE,
    'ball_mass': BALL,
    'radius': RADIUS,
    'friction': (TIP_FRICTION, CLOTH_FRICTION),
    'restitution': (TIP_RESTITUTION, CLOTH_RESTITUTION),
}


def order_of(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def test_fig_4_at_first_order():
    steps = (1e-2, 1e-3, 1e-4, 1e-5)
    runs = [two_balls(**FIG_4, step=step) for step in steps]
    errors = [np.abs(r.velocities[:, 2] - (2.441360, 0.735552)).max() for r in runs]
    for error, bound in zip(errors, (2e-2, 3e-3, 3e-4, 3e-5), strict=True):
        assert error < bound
    assert order_of(steps, errors) == pytest.approx(1.0, abs=0.15)
    fine = runs[-1]
    assert fine.status == Status.OK
    assert fine.states == ('S1', 'S3', 'S1', 'S2')
    np.testing.assert_allclose(fine.impulses, FIG_4_IMPULSES, atol=1e-4)
    assert fine.lost == pytest.approx(1.249363, abs=2e-5)
    left = (fine.energies[0, 1], fine.energies[2, 0], fine.energies[3, 1])  # lost at three ends
    assert sum(left) == pytest.approx(1.249363, abs=1e-4)


def test_curve_stays_inside_the_ellipse():
    curve = two_balls(**FIG_4, step=1e-4).curve
    assert 500 < len(curve) <= 2000
    i1, i2, e1, e2 = curve.T
    assert (np.diff(curve[:, :2], axis=0) >= 0).all()
    assert (e1 + e2 <= 3.0 * i1 - 0.5 * i1**2 - 0.5 * (i1 - i2) ** 2 + 1e-9).all()  # (14)
    assert (curve[:, 2:] > -1e-3).all()


def test_poisson_hypothesis_makes_energy():
    result = two_balls(**FIG_4, step=1e-5, law='poisson')
    assert result.status == Status.NEGATIVE_ENERGY
    assert result.impulses[-1, 0] == pytest.approx(6.444, abs=1e-3)
    assert result.energies[:, 0].min() == pytest.approx(-2.15, abs=5e-3)


@pytest.mark.parametrize(('ratio', 'name'), [k[1:] for k in TABLE_1 if k[0] == 'energetic'])
def test_four_shots_at_first_order(ratio, name):
    sequence, velocity, spin = TABLE_1['energetic', ratio, name]
    normal, cue_velocity = SHOTS[name]
    speed = np.linalg.norm(cue_velocity)
    steps = np.array([1e-3, 1e-4, 1e-5])  # in units of ball mass and cue speed
    errors = []
    for step in steps:
        impulse = step * BALL * speed
        result = solve_strike(normal, cue_velocity, ratio=ratio, step=impulse, **CUE_AND_BALL)
        assert result.status == Status.OK
        assert ' '.join(result.states) == sequence
        off = np.hstack([result.velocities[1] - velocity, (result.spins[1] - spin) * RADIUS])
        errors.append(np.abs(off).max() / speed)
    assert (errors < 3 * steps).all()
    assert order_of(steps, errors) == pytest.approx(1.0, abs=0.3)


def test_a_level_draw_stroke_presses_the_ball_onto_the_cloth():
    draw = solve_strike((-0.9, 0, -0.3), (2, 0, 0), ratio=1.5, step=1e-5, **CUE_AND_BALL)
    follow = solve_strike((-0.9, 0, 0.1), (2, 0, 0), ratio=1.5, step=1e-5, **CUE_AND_BALL)
    assert draw.states == ('S1', 'S3')
    assert follow.states[0] == 'S3'  # lifted: the table comes in later, if at all


@pytest.mark.parametrize(
    ('field', 'value'),
    [('step', 0.0), ('ratio', -1.0), ('speed', np.nan), ('restitution', (0.5, 1.5)),
     ('law', 'bistiffness'), ('masses', (0.0, 1.0))],
)  # fmt: skip
def test_bad_input_is_named(field, value):
    name = 'upper_mass' if field == 'masses' else field
    with pytest.raises(ValueError, match=name):
        two_balls(**{**FIG_4, 'step': 1e-3, field: value})
