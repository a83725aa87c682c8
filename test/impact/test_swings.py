"""Leaps over swings that repeat: the same answer as one swing after the other."""
import numpy as np
import pytest
from setups import guided_scene, guided_strike, solved

from billiard_shot import Stroke
from billiard_shot.impact import kernel, leaps, multirevolution, swings, walk
from billiard_shot.impact.laws import ENERGETIC
from billiard_shot.impact.state import initial_state, Model, STAGES
from billiard_shot.status import Status
from billiard_shot.study.problem import Problem


def leap(change, start, count, jacobian, sweeps=30):
    """Where `count` applications of x + change(x) lead, by collocation."""
    p = multirevolution.empty_span(len(start), len(start))
    p.start[:], p.jacobian[:] = start, jacobian
    p.change[:] = change(p.start)
    multirevolution.weigh(p, count)
    multirevolution.set_nodes(p)
    for _ in range(sweeps):
        for node in range(STAGES):
            p.change[node] = change(p.node[node])
        assert multirevolution.move_nodes(p)
    multirevolution.finish(p)
    return p.start, max(multirevolution.rest(p, row) for row in range(len(start)))


def one_by_one(change, start, count):
    x = np.array(start)
    for _ in range(count):
        x = x + change(x)
    return x


@pytest.mark.parametrize('count', [64, 1000, 20_000])
def test_sums_over_swings_are_exact_where_the_change_is_smooth(count):
    slow = 0.5 / count

    def change(x):
        return slow * np.array([x[1], -np.sin(x[0]), x[0] * x[1]])

    start = np.array([1.0, 0.2, 0.0])
    jacobian = slow * np.array([[0, 1, 0], [-np.cos(1.0), 0, 0], [0.2, 1.0, 0]])
    end, rest = leap(change, start, count, jacobian)
    # A polynomial that is resolved to 1e-8 gives the sum, of twice its order, far better.
    assert count * rest < 1e-7
    np.testing.assert_allclose(end, one_by_one(change, start, count), rtol=0, atol=2e-11)


@pytest.mark.parametrize('kept', [0.0, 0.5, 0.99])
def test_what_a_swing_forgets_follows_what_it_does_not(kept):
    slow = 1e-3

    def change(x):
        return np.array([-slow * x[0], (1.0 - kept) * (np.cos(x[0]) - x[1])])

    start = one_by_one(change, [1.0, np.cos(1.0)], 2000)  # what it brought along is forgotten
    jacobian = np.array([[-slow, 0], [-(1 - kept) * np.sin(start[0]), kept - 1]])
    end, _ = leap(change, start, 1000, jacobian)
    np.testing.assert_allclose(end, one_by_one(change, start, 1000), rtol=0, atol=1e-11)


STROKES = {
    'stays pressed': ((-0.3, 0, 1), (0.1, 0, -1), 1e6, 'bistiffness'),
    'leaves and meets again': ((-1, -2, 3), (0, 0.3, -1), 1e6, 'energetic'),
    'no event at all': ((-0.3, 0, 1), (0.1, 0, -1), 1e-6, 'energetic'),
}


@pytest.mark.parametrize('name', STROKES)
def test_leaps_end_where_single_swings_do(name, monkeypatch):
    normal, velocity, ratio, law = STROKES[name]
    scene = guided_scene(0.5 / 0.17, ratio, law, (0.4, 0.15), (0.7, 0.5))
    problem = Problem.of(scene, Stroke(normal=normal, velocity=velocity))
    compiled = problem.adaptive(1e-10)[0]  # before anything is replaced in what is compiled
    leapt = []

    def finish(span):
        leapt.append(None)
        multirevolution.finish(span)

    def played():
        impulse, account, log = np.zeros(6), np.zeros((2, 4)), np.zeros((0, 12))
        status, _, _ = kernel.solve.py_func(
            problem.response, problem.velocity, problem.friction, problem.restitution,
            problem.stiffness, problem.model.law, 1.0, 1e-10, impulse, account, log,
        )
        assert status == Status.OK
        return impulse

    # In Python, where one can look inside, and where short leaps will do.
    monkeypatch.setattr(kernel, 'run', walk.run.py_func)
    monkeypatch.setattr(swings, 'FIRST', 32)
    monkeypatch.setattr(leaps, 'SHORTEST', 16)
    monkeypatch.setattr(leaps, 'finish', finish)
    leaping = played()
    assert leapt
    monkeypatch.setattr(leaps, 'ALIKE', 10**9)  # never
    leapt.clear()
    single = played()
    assert not leapt
    unit = problem.speed * scene.ball.mass
    np.testing.assert_allclose(leaping, single, rtol=0, atol=1e-9 * unit)
    np.testing.assert_allclose(compiled, single, rtol=0, atol=1e-9 * unit)


@pytest.mark.parametrize(('compression', 'steps'), [(1e-3, 0), (-1e-3, swings.STEPS)])
def test_a_leap_that_goes_beyond_the_end_of_a_contact_is_given_up_at_once(compression, steps):
    """Nothing moved there any more, and steps grew without bound."""
    model = Model(np.eye(3), ENERGETIC, 1.0, 1e-12, False)
    state, all_swings = initial_state(1, np.zeros(3)), swings.no_swings(1)
    node = np.zeros(11)
    node[3], all_swings.span.start[3] = compression, 1e-2
    leaps.send(model, state, all_swings, 0, node)
    assert all_swings.now[0].steps == steps


def test_what_is_zero_at_the_start_of_every_swing_stays_so():
    """A contact that is met anew in each swing was a rounding error away, and never met."""
    model = Model(np.eye(3), ENERGETIC, 1.0, 1e-12, False)
    state, all_swings = initial_state(1, np.zeros(3)), swings.no_swings(1)
    all_swings.span.start[:] = all_swings.first[:] = 0.0
    all_swings.begun[:] = 0.0
    all_swings.first[2] = 1e-3
    state.u[:, 0] = 1e-24, 2e-24, 3e-24
    change = np.empty(11)
    swings.changed(model, state, all_swings, change)
    np.testing.assert_array_equal(change[:3], (0.0, 0.0, 3e-24))


def test_a_table_without_restitution_under_a_soft_heavy_cue_is_solved():
    solved(guided_strike(9.77e4, 1.63e-8, 'energetic', (1.04e-3, 1.74), (0.443, 0.0), 2.82e-5,
                         0.0, (0.0, -0.452, 0.892)), 1e-12)


def test_what_a_leap_came_to_that_was_given_up_is_forgotten():
    """It ended at velocities of 1e125, against which the slip at its start was taken for none."""
    solved(guided_strike(0.06827722527789867, 76938576.80433057, 'bistiffness',
                         (5.9444299653699675, 2.2850157985359516), (0.0, 0.527857380119023),
                         0.25446961400442175, 0.7578197583901314,
                         (0.45802499, -0.24595693, 0.8542355)), 1e-12)
