"""
Gaps from 1e-12 to 1e-3 m in rows, racks and before cushions: the outcome is continuous.

Two balls that meet alone collide in no time; if a third one is within reach, their impact takes
time, and they go on meanwhile. Between the two there is a step of about 1 % of the speed.
"""

import numpy as np
import pytest
from tables import POOL, R, state

from billiard_shot import simulate
from billiard_shot.scene.placement import sites

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
