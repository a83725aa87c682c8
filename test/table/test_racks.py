"""
Breaks of racks with gaps, against an integration of the compliant contacts.

An event-driven Runge-Kutta integration of the same springs, with the normals as they are when the
cue ball meets the head ball: speeds of the cue ball, and of the rack row by row, from left to
right. Springs after Hertz that give a contact of 0.25 ms at 3 m/s, restitution 0.95, no friction.
"""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import BallState, EventKind, Scene, simulate
from billiard_shot.scene.rack import sites
from billiard_shot.table.contact_duration import reach_of_impact, stiffness_of

POOL = Scene.load('pool')
R, MASS, SPEED = 0.028575, 0.17, 8.0
SOON = 4e-3  # s: when the integration was read

SPEEDS = [
    (2, 0.006, 0.0, '1.06044 .69908 5.80506 4.75357'),
    (2, 0.006, 1e-5, '1.05072 .70881 5.80431 4.75106'),
    (2, 0.006, 1e-4, '1.32123 .42364 5.79417 4.69549'),
    (2, 0.006, 3e-4, '1.47968 .35347 5.83263 4.58201'),
    (
        5,
        -0.006,
        0.0,
        '1.42413 .78567 .96892 1.27911 .86877 .03758 1.14506 .82704 .22105 .18989 1.06748 3.58691 '
        '1.83308 1.88242 1.84637 4.35831',
    ),
    (
        5,
        -0.006,
        1e-4,
        '1.40473 .45007 .74022 1.09720 .77322 .24914 1.05357 .74946 .22350 .30484 .98739 3.76295 '
        '1.61622 1.83339 1.27174 4.56461',
    ),
    (
        5,
        -0.006,
        3e-4,
        '1.48199 .27372 .30346 .69990 .41469 .07193 .69940 .38016 .21787 .38066 .61788 4.11500 '
        '.88454 1.02950 .60860 5.11659',
    ),
]


def scene_of(duration, exponent=1.5):
    ball = replace(POOL.ball, mass=MASS, radius=R, inertia=0.4 * MASS * R * R)
    balls = replace(
        POOL.contacts.ball_ball,
        restitution=0.95,
        friction_fast=0.0,
        friction_slow=0.0,
        duration=duration,
    )
    contacts = replace(POOL.contacts, ball_ball=balls)
    return replace(POOL, ball=ball, contacts=contacts, exponent=exponent)


def broken(rows, offset, gap, duration=0.25e-3, exponent=1.5):
    """Speeds soon after the cue ball has met the head ball of a triangle."""
    still = {'velocity': (0, 0, 0), 'spin': (0, 0, 0)}
    cue = (-np.sqrt(4 * R * R - offset * offset) - 1e-6, offset, R)
    states = {'cue': BallState(cue, (SPEED, 0, 0), (0, 0, 0))}
    for number, site in enumerate(sorted(sites(range(1, rows + 1), 0.0, 2 * R + gap))):
        states[str(number)] = BallState((*site, R), **still)
    run = simulate(scene_of(duration, exponent), states)
    return np.array([np.linalg.norm(state.velocity) for state in run.at(SOON).values()])


@pytest.mark.parametrize(('rows', 'offset', 'gap', 'expected'), SPEEDS)
def test_racks_break_as_an_integration_has_it(rows, offset, gap, expected):
    speeds = [float(speed) for speed in expected.split()]
    assert broken(rows, offset, gap) == pytest.approx(speeds, abs=0.006 * SPEED)


@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_a_micrometre_between_the_balls_changes_little(exponent):
    touching, near = (
        broken(5, 0.0, 0.0, exponent=exponent),
        broken(5, 0.0, 1e-6, exponent=exponent),
    )
    assert near == pytest.approx(touching, abs=0.01 * SPEED)


def test_a_rack_breaks_dead_if_contacts_take_no_time():
    slow = broken(5, 0.0, 1e-6, duration=0.0)[1:] < 0.5
    assert slow.sum() > 8
    assert (broken(5, 0.0, 1e-6)[1:] < 0.5).sum() < 5


def test_stiffness_and_duration():
    # Johnson, Contact Mechanics: T = 2.943 y / v, y = (5/4 m_eff v^2 / k)^(2/5); pi sqrt(m_eff/k).
    stiffness = stiffness_of(0.17, 0.25e-3, 1.5)
    assert stiffness == pytest.approx(9.2e8, rel=5e-3)
    peak = (1.25 * 0.085 * 9.0 / stiffness) ** 0.4
    assert 2.943 * peak / 3.0 == pytest.approx(0.25e-3, rel=1e-4)
    linear = stiffness_of(0.17, 0.25e-3, 1.0)
    assert np.pi * np.sqrt(0.085 / linear) == pytest.approx(0.25e-3)
    assert reach_of_impact(0.0, 0.25e-3, 1.0, 6.0) == pytest.approx(0.5 * 6.0 * 0.25e-3)


def test_balls_that_nothing_reaches_do_not_take_part():
    still = {'velocity': (0, 0, 0), 'spin': (0, 0, 0)}
    near = 2 * R + 1e-4
    states = {
        'beside': BallState((near, near, R), **still),  # near the one that is hit, but aside
        'cue': BallState((-2 * R - 1e-6, 0, R), (3, 0, 0), (0, 0, 0)),
        'behind': BallState((near, 0, R), **still),
        'hit': BallState((0, 0, R), **still),
    }
    run = simulate(scene_of(0.25e-3), states)
    assert run.first_met['cue'] == 'hit'
    assert run.first_met['hit'] == 'cue'
    assert run.first_met['behind'] == 'hit'
    first = run.events[0]
    assert first.kind == EventKind.CLUSTER
    assert set(first.balls) == {'cue', 'behind', 'hit'}
