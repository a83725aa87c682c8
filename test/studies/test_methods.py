"""The methods compared: closed form, SciPy and the solver agree; every method has its order."""

import csv
from dataclasses import replace
from importlib.util import find_spec
import math

import numpy as np
from paper_values import FIG_4_IMPULSES, TABLE_1
import pytest
from scipy.integrate import solve_ivp
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

from billiard_shot import Scene, Stroke
from billiard_shot.status import Status
from studies import methods
from studies.closed_form import applies, closed_form
from studies.impulse_scheme import solve_strike, two_balls
from studies.problem import ContactProblem
from studies.scipy_strike import ScipyStrike

PAPER = Scene.load('paper')
SLIDING = Stroke((-0.6, -0.7, 0.3), (1, 0, -0.4))  # both contacts slide to the end
ONSET = Stroke((0, 0.3, 1.2), (-0.3, -0.7, -0.7))  # at friction .49 and .62 both stick, then slip


def with_friction(tip, table):
    contacts = PAPER.contacts
    return replace(
        PAPER,
        contacts=replace(
            contacts,
            cue_ball=replace(contacts.cue_ball, friction=tip),
            ball_table=replace(contacts.ball_table, friction=table),
        ),
    )


PROBLEMS = {
    'smooth': ContactProblem.of(with_friction(0.0, 0.0), SLIDING),
    'sliding': ContactProblem.of(PAPER, SLIDING),
    'onset': ContactProblem.of(with_friction(0.49, 0.62), ONSET),
}


def slope(x, y):
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def error(problem, impulse):
    exact, _, _ = problem.adaptive(methods.FLOOR)
    return np.abs(problem.response @ (impulse - exact)).max() / problem.speed


def test_closed_form_is_what_the_solver_finds():
    rng = np.random.default_rng(0)
    for i in range(60):
        cue = (
            {'mass': float(np.exp(rng.uniform(-4, 2))), 'guided': True}
            if i % 2
            else {'mass': 0.5, 'end_mass': float(rng.uniform(0.003, 0.1)), 'ferrule_radius': 0}
        )
        tip = {
            'restitution': float(rng.uniform()),
            'friction': float(rng.uniform()),
            'stiffness': 1.5,
        }
        table = PAPER.to_dict()['contacts']['ball_table']
        scene = Scene.from_dict(
            {
                'ball': {'mass': 0.1673, 'radius': 0.0286},
                'cue': cue,
                'contacts': {'cue_ball': tip, 'ball_table': table},
                'law': ('energetic', 'bistiffness')[i % 3 == 0],
            }
        )
        angle = rng.uniform(-1.0, 1.0)
        problem = ContactProblem.of(scene, Stroke((-np.cos(angle), np.sin(angle), 0), (1.3, 0, 0)))
        assert applies(problem)
        assert error(problem, closed_form(problem)) < 1e-11


def test_closed_form_is_for_level_strokes_only():
    problem = ContactProblem.of(PAPER, Stroke((-1, 0, 0.3), (1, 0, 0)))
    assert not applies(problem)
    with pytest.raises(ValueError, match='level'):
        closed_form(problem)


@pytest.mark.parametrize('name', ['vertical', 'jump'])
@pytest.mark.parametrize('method', ['DOP853', 'Radau'])
def test_the_truth_is_what_scipy_finds(name, method):
    problem = ContactProblem.of(PAPER, methods.PAPER_STROKES[name])
    assert error(problem, ScipyStrike(problem, method).solve(1e-10)) < 1e-9


@pytest.mark.parametrize('name', PROBLEMS)
def test_the_solvers_error_goes_with_its_tolerance(name):
    # Its order grows with the accuracy: the error is proportional to the tolerance instead.
    problem = PROBLEMS[name]
    tolerances = 10.0 ** -np.arange(6.0, 12.1, 0.25)
    errors = [max(error(problem, problem.adaptive(t)[0]), 1e-17) for t in tolerances]
    assert slope(tolerances, errors) == pytest.approx(1.0, abs=0.2)
    assert (np.array(errors) <= tolerances).all()


def in_one_phase(method, **options):
    """Impulses of a phase in which both contacts compress and slide."""
    strike = ScipyStrike(PROBLEMS['sliding'], method)
    strike.still, strike.onset, strike.mode = 1e-12, [False, False], [0, 0]
    strike.active, strike.restoring = [True, True], [False, False]
    run = solve_ivp(strike.rate, (0.0, 0.9), np.zeros(8), method, **options)
    return run.y[:, -1]


@pytest.mark.parametrize(
    ('method', 'order', 'rtol', 'counts'),
    [('DOP853', 8.0, 0.1, (1, 2, 3, 4, 6)), ('Radau', 5.0, 1e-4, (8, 10, 12, 14, 16, 20))],
)
def test_orders_of_scipys_methods_where_all_is_smooth(method, order, rtol, counts):
    exact = in_one_phase('DOP853', rtol=1e-13, atol=1e-15, max_step=0.01)
    errors = []
    for count in counts:  # equal steps: the tolerance is so loose that it is never the limit
        length = 0.9 / count
        found = in_one_phase(
            method, rtol=rtol, atol=1e-2 * rtol, max_step=length, first_step=length
        )
        errors.append(np.abs(found - exact).max())
    assert -slope(counts, errors) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize('method', ['DOP853', 'Radau'])
def test_scipy_across_a_slip_onset(method):
    # Events are located to the tolerance: of the order only that remains.
    problem = ContactProblem.of(PAPER, methods.PAPER_STROKES['vertical'])
    tolerances = 10.0 ** -np.arange(4.0, 10.1, 1.0)
    errors = [error(problem, ScipyStrike(problem, method).solve(rtol)) for rtol in tolerances]
    assert slope(tolerances, errors) == pytest.approx(0.9, abs=0.3)


def test_command(tmp_path, capsys):
    path, picture = tmp_path / 'a.csv', tmp_path / 'a.png'
    arguments = ['--normal', '-1', '-1', '0', '--velocity', '0.8', '0', '0']
    if_drawn = ['--picture', str(picture)] if find_spec('matplotlib') else []
    assert methods.main([*arguments, '--output', str(path), *if_drawn]) == 0
    out, err = capsys.readouterr()
    assert err == ''
    rows = list(csv.DictReader(path.open()))
    assert {'impulse scheme', 'this library', 'closed form', 'SciPy DOP853', 'SciPy Radau'} <= {
        row['method'] for row in rows
    }
    assert min(float(r['velocity']) for r in rows if r['method'] == 'closed form') < 1e-12
    assert 'the impulse scheme takes' in out
    assert not if_drawn or picture.stat().st_size > 10_000


def test_order_is_not_turned_by_one_bad_answer():
    def point(setting, part):
        return methods.MethodPoint(setting, 1, part, part, part, part, 1 / setting, 1.0)

    points = [point(10.0**-i, 3 * 10.0 ** (-2 * i)) for i in range(1, 6)]
    assert methods.order(points) == pytest.approx(2.0)
    points[2] = point(1e-3, 0.5)
    assert methods.order(points) == pytest.approx(2.0)
    assert math.isnan(methods.order(points[:1]))


def test_the_impulse_scheme_is_left_out_if_it_is_not_compiled(monkeypatch):
    monkeypatch.setattr(methods.impulse_scheme, 'IS_COMPILED', False)
    tasks, left_out = methods.tasks(PAPER, {'sliding': SLIDING})
    assert tasks
    assert not any(task.method.name == 'impulse scheme' for task in tasks)
    assert any('without numba' in line for line in left_out)


# --- the paper's impulse-space scheme: its example, its order, and its agreement with the rest

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
