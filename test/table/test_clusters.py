"""Three bodies or more in touch: all at once, and who comes first in the scene does not matter."""

import dataclasses

import numpy as np
import pytest
from tables import ENDLESS, play, POOL, R, rolling, scene_with, SMOOTH, state, state_after

from billiard_shot import simulate
from billiard_shot.scene.placement import sites
from billiard_shot.status import Status
from billiard_shot.table.run.results import EventKind
from billiard_shot.table.run.simulate import simulate_batch


def speeds_of_three(exponent=1.0):
    scene = dataclasses.replace(scene_with(ENDLESS, ball_ball=SMOOTH), exponent=exponent)
    run = play(scene, a=rolling(-0.1 - 2 * R, 0, 1, 0), b=state(0, 0), c=state(2 * R, 0))
    event = next(e for e in run.events if e.kind == EventKind.CLUSTER)
    assert event.balls == ('a', 'b', 'c')
    assert event.energy_after == pytest.approx(event.energy_before, rel=1e-9)
    before = run.balls['a'].at(event.time - 1e-12).velocity[0]
    return [state_after(run, name, event).velocity[0] / before for name in 'abc']


def test_three_in_a_line():
    # linear springs of equal stiffness: the closed form of two coupled oscillators
    assert speeds_of_three() == pytest.approx([-0.13026, 0.15023, 0.98003], abs=2e-5)


def test_a_longer_line_hands_the_motion_on():
    scene = dataclasses.replace(scene_with(ENDLESS, ball_ball=SMOOTH), exponent=1.5)
    row = {str(i): state(2 * R * i, 0) for i in range(4)}
    run = play(scene, cue=rolling(-2 * R - 0.05, 0, 1, 0), **row)
    event = next(e for e in run.events if e.kind == EventKind.CLUSTER)
    ends = np.array([state_after(run, name, event).velocity[0] for name in ('cue', *row)])
    assert ends.sum() == pytest.approx(
        run.balls['cue'].at(event.time - 1e-12).velocity[0], rel=1e-9
    )
    assert (np.diff(ends) > 0).all()
    assert 0.98 < ends[-1] / ends.sum() < 1


def test_a_symmetric_break_is_symmetric_whoever_is_named_first():
    scene = scene_with(ENDLESS, ball_ball=SMOOTH | {'restitution': 0.9})
    left = state(0.05 + np.sqrt(3) * R, R)
    right = state(0.05 + np.sqrt(3) * R, -R)
    cue = rolling(-2 * R, 0, 2, 0)
    one = play(scene, cue=cue, head=state(0.05, 0), left=left, right=right)
    two = play(scene, right=right, left=left, head=state(0.05, 0), cue=cue)
    for run in (one, two):
        assert run.final_position['left'] == pytest.approx(
            run.final_position['right'] * (1, -1, 1), abs=1e-6
        )
        assert run.final_position['cue'][1] == pytest.approx(0, abs=1e-6)
    assert one.final_position['left'] == pytest.approx(two.final_position['left'], abs=1e-6)


def test_a_ball_frozen_to_a_cushion():
    reach = np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)
    frozen = state(1.27 - reach, 0.2)
    run = play(POOL, cue=rolling(0.8, 0.2, 1.0, 0), one=frozen)
    met, pressed = [e for e in run.events if e.kind in (EventKind.BALL, EventKind.CUSHION)][:2]
    assert (met.balls, pressed.balls) == (('cue', 'one'), ('one',))
    assert 0 < met.dissipated < met.energy_before
    assert 0.5 < pressed.energy_after / pressed.energy_before < 1
    assert run.final_position['one'][0] < 1.27 - reach + 1e-9


def test_no_cluster_gains_energy_and_batches_agree():
    random = np.random.default_rng(7)
    tables = []
    for _ in range(20):
        angle = random.uniform(0, 2 * np.pi)
        tables.append(
            {
                'cue': rolling(-0.3, random.normal() * R, 2, 0),
                '1': state(0, 0),
                '2': state(2 * R * np.cos(angle), 2 * R * np.sin(angle)),
            }
        )
    many = simulate_batch(POOL, tables)
    clusters = 0
    for i, states in enumerate(tables):
        run = play(POOL, **states)
        for event in run.events:
            assert event.dissipated >= -1e-9 * event.energy_before
            clusters += event.kind == EventKind.CLUSTER
        assert (
            many.final_position[i] == np.array([run.final_position[name] for name in many.names])
        ).all()
    assert clusters > 10


def test_negative_energy_of_law_poisson_is_told():
    scene = scene_with(ball_ball={'duration': 0.0}, law='poisson')
    random = np.random.default_rng(3)
    told = set()
    for _ in range(10):
        angle = random.uniform(0, 2 * np.pi)
        run = play(
            scene,
            cue=rolling(-0.3, random.normal() * R, 2, 0),
            one=state(0, 0),
            two=state(2 * R * np.cos(angle), 2 * R * np.sin(angle)),
        )
        told.add(run.status)
        for event in run.events:
            if event.dissipated < -1e-9 * event.energy_before:
                assert run.status == Status.NEGATIVE_ENERGY
    assert Status.NEGATIVE_ENERGY in told


# --- gaps from 1e-12 to 1e-3 m in rows, racks and before cushions: the outcome is continuous -----

SOON = 0.02  # s
STEP, LARGEST = 5e-3, 1.2e-2  # of the speed
REACH = np.sqrt(R**2 - (POOL.table.cushion.height * 2 * R - R) ** 2)


def row(random, gap):
    """Rows of two to five balls with a gap at a random place, else a micrometre."""
    count, angle, y = random.integers(2, 6), random.uniform(-0.6, 0.6), random.uniform(-0.8, 0.8)
    wide, speed = random.integers(1, count), random.uniform(2, 9)
    distances = np.where(np.arange(count) == wide, 2 * R + gap, 2 * R + 1e-6)
    along = np.cumsum(distances) - distances[0]
    balls = {
        str(i): state(x * np.cos(angle), x * np.sin(angle)) for i, x in enumerate(along.tolist())
    }
    return {'cue': state(-2.4 * R, y * R, (speed, 0, 0)), **balls}


def rack(random, gap):
    """Triangles of two to five rows."""
    rows, y, speed = random.integers(2, 6), random.uniform(-1, 1), random.uniform(2, 9)
    places = sites(range(1, rows + 1), 0.0, 2 * R + gap)
    balls = {str(i): state(*place) for i, place in enumerate(places)}
    return {'cue': state(-2.4 * R, y * R, (speed, 0, 0), (0, 0.5 * speed / R, 0)), **balls}


def before_cushion(random, gap):
    """A ball near a cushion."""
    angle, aside, speed = (
        random.uniform(-0.7, 0.7),
        random.uniform(-0.8, 0.8),
        random.uniform(2, 9),
    )
    way, across = (
        np.array([np.cos(angle), np.sin(angle)]),
        np.array([-np.sin(angle), np.cos(angle)]),
    )
    place = np.array([1.27 - REACH - gap, 0.2])
    start = place - 2.4 * R * way + aside * R * across
    return {'cue': state(*start, (*speed * way, 0)), 'one': state(*place)}


def mean_velocities(layout, seed, gap):
    """Over SOON, relative to the cue ball's speed: (balls, 2)."""
    states = layout(np.random.default_rng(seed), gap)
    ends = simulate(POOL, states).at(SOON).values()
    speed = np.linalg.norm(states['cue'].velocity)
    return np.array(
        [
            (end.position - begin.position)[:2] / (SOON * speed)
            for begin, end in zip(states.values(), ends, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ('layout', 'seed'),
    [(layout, seed) for layout in (row, rack, before_cushion) for seed in range(6)],
)
def test_gaps_make_no_jumps(layout, seed):
    """Each step above 0.5 % is bisected down to a nanometre."""
    gaps = [0.0, *np.geomspace(1e-12, 1e-3, 40)]
    found = [mean_velocities(layout, seed, gap) for gap in gaps]
    for low, high, one, other in zip(gaps, gaps[1:], found, found[1:], strict=False):
        while np.abs(other - one).max() > STEP and high - low > 1e-9:
            middle = 0.5 * (low + high)
            between = mean_velocities(layout, seed, middle)
            if np.abs(between - one).max() > np.abs(other - between).max():
                high, other = middle, between
            else:
                low, one = middle, between
        assert np.abs(other - one).max() < LARGEST, (low, high)
