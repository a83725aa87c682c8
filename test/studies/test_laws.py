"""Discontinuities of the laws, the classical laws, and the paper's Table 1 under variants."""

from dataclasses import replace

import numpy as np
import pytest
from setups import SLOW_CLOTH

from billiard_shot import Scene, Stroke
from studies import laws, paper
from studies.classical_laws import newton, pairwise
from studies.collisions import stacked
from studies.laws import discontinuities, random_strokes, sweeps, WAYS, wedges
from studies.methods import PAPER_STROKES
from studies.paper import PRINTED, reproduce, Variant, variant_label
from studies.problem import ContactProblem

PAPER, POOL = Scene.load('paper'), Scene.load('pool')


def test_discontinuities_are_found_where_they_are():
    def outcome(x):
        return np.array([np.sin(3 * x) + 0.01 * (x > 0.123456), x * x - 2e-4 * (x > 0.7)])

    first, second = discontinuities(outcome, np.linspace(0, 1, 200))
    assert (first.place, second.place) == pytest.approx((0.123456, 0.7), abs=1e-9)
    assert (first.size, second.size) == pytest.approx((0.01, 2e-4), rel=1e-3)
    assert discontinuities(np.cos, np.linspace(0, 1, 200)) == []


def outcome_of_two_balls(law):
    def outcome(ratio):
        case = stacked(ratio=ratio, speed=3.0)
        result = case.solve(law, 1e-12)
        return case.motion(result.velocities, result.spins)

    return outcome


def test_two_balls_are_discontinuous_in_the_stiffness_ratio():
    # Each confirmed with the slow check on both sides.
    found = discontinuities(outcome_of_two_balls('energetic'), np.geomspace(1, 50, 200))
    places = [discontinuity.place for discontinuity in found]
    assert places == pytest.approx([1.7023750, 2.1250676, 23.2114208], rel=1e-7)
    assert discontinuities(outcome_of_two_balls('bistiffness'), np.geomspace(1, 50, 200)) == []


def test_guided_strokes_are_discontinuous_under_law_energetic_only():
    ratio = next(sweeps(PAPER, PAPER_STROKES['massé'], 101))
    assert len(discontinuities(ratio.outcome('energetic'), ratio.values)) >= 4
    for stroke in random_strokes(2, seed=3):
        for sweep in sweeps(PAPER, stroke, 61):
            assert discontinuities(sweep.outcome('bistiffness'), sweep.values) == []


def test_a_light_end_is_discontinuous_only_where_it_can_wedge():
    places, slow = [], Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH})
    for stroke in random_strokes(4, seed=1):
        *_, elevation, _ = sweeps(slow, stroke, 61)
        places += [
            elevation.problem(discontinuity.place, 'bistiffness')
            for discontinuity in discontinuities(
                elevation.outcome('bistiffness'), elevation.values
            )
        ]
    assert places
    assert all(map(wedges, places))
    smooth = replace(
        POOL,
        contacts=replace(POOL.contacts, cue_ball=replace(POOL.contacts.cue_ball, friction=0.05)),
    )
    for stroke in random_strokes(2, seed=1):
        for sweep in sweeps(smooth, stroke, 41):
            if not any(wedges(sweep.problem(value, 'bistiffness')) for value in sweep.values):
                assert discontinuities(sweep.outcome('bistiffness'), sweep.values) == []


@pytest.mark.parametrize('way', WAYS)
def test_speed_only_scales(way):
    *_, speed = sweeps(PAPER, Stroke((-0.7, -0.2, 0.5), (1, 0, -0.6)), 2)
    slow, fast = (speed.outcome(way)(value) for value in (0.1, 5.0))
    assert fast == pytest.approx(slow, abs=1e-9)


def test_classical_laws_agree_where_only_the_tip_acts():
    problem = ContactProblem.of(PAPER, PAPER_STROKES['horizontal'])
    exact, _, _ = problem.adaptive(1e-12)
    assert pairwise(problem) == pytest.approx(exact, abs=1e-10)
    smooth = ContactProblem.of(PAPER, Stroke((-1, 0, 0), (1, 0, 0)))
    assert newton(smooth)[0] == pytest.approx(smooth.adaptive(1e-12)[0][0], rel=1e-9)


def test_newtons_law_at_both_contacts():
    problem = ContactProblem.of(PAPER, PAPER_STROKES['vertical'])
    impulse = newton(problem)
    after = problem.velocity + problem.response @ impulse
    assert after[0] == pytest.approx(-problem.restitution[0] * problem.velocity[0])
    assert after[3] >= -1e-12
    for j in (0, 1):
        friction = np.hypot(*impulse[3 * j + 1 : 3 * j + 3])
        assert friction <= problem.friction[j] * impulse[3 * j] * (1 + 1e-9)


@pytest.mark.parametrize(
    ('name', 'variant', 'within'),
    [
        ('horizontal', Variant.POISSON, 1e-4),
        ('vertical', Variant.INVERSE_RATIO | Variant.NOT_REACTIVATED, 4e-4),
    ],
)
def test_rows_of_the_paper_that_are_explained(name, variant, within):
    row = reproduce(name, variant)
    assert row.velocity < within
    assert row.spin < within


@pytest.mark.parametrize('name', PRINTED)
def test_rows_as_written_are_the_predictions(name):
    from billiard_shot import predict

    shot = predict(PAPER, PRINTED[name][0], tolerance=1e-10)
    row = reproduce(name, Variant.NONE)
    assert row.numbers[:3] == pytest.approx(shot.velocity, abs=1e-9)
    assert row.velocity > 5e-3
    assert variant_label(row.variant) == 'as written'


def test_commands(tmp_path, capsys):
    assert paper.main([]) == 0
    assert "Poisson's law" in capsys.readouterr().out
    assert (
        laws.main(['--count', '21', '--normal', '-1', '-2', '1', '--velocity', '0', '0', '-2'])
        == 0
    )
    assert 'stiffness ratio' in capsys.readouterr().out
    assert laws.main(['--count', '11']) == 0
    assert 'none found at these 11 values' in capsys.readouterr().out  # not: there are none
    assert laws.main(['--random', '1', '--count', '11']) == 0
    assert 'bistiffness' in capsys.readouterr().out
    assert laws.main(['--count', '1']) == 2
    assert laws.main(['--random=-5']) == 2
    assert laws.main(['--random', '5', '--speed', '1']) == 2
