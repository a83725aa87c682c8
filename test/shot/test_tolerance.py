"""`tolerance` and `error_estimate` over random shots (more: benchmarks/tolerance.py)."""

from pathlib import Path
import sys

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status, Stroke
from billiard_shot.study.laws import discontinuities, sweeps

sys.path.insert(0, str(Path(__file__).parents[2] / 'benchmarks'))

from tolerance import FLOOR, gap, random_scene, random_stroke, TOLERANCES


@pytest.mark.parametrize('name', ['paper', 'pool', 'random'])
def test_errors_keep_to_their_estimates_and_tolerances(name):
    rng = np.random.default_rng(2)
    within = []
    for _ in range(25):
        scene = random_scene(rng) if name == 'random' else Scene.load(name)
        stroke = random_stroke(rng)
        exact = predict(scene, stroke, FLOOR)
        if exact.status.refused:
            continue
        for tolerance in TOLERANCES:
            shot = predict(scene, stroke, tolerance)
            error = gap(shot.trajectory, exact.trajectory) - exact.error_estimate
            within.append((error <= shot.error_estimate, error <= tolerance))
            assert within[-1][1] or shot.status == Status.TOLERANCE_NOT_REACHED
    assert len(within) > 100
    assert np.mean(within, axis=0).min() >= 0.99


@pytest.mark.parametrize('pockets', [True, False])
def test_errors_stay_within_the_tolerance_after_cushions_and_jaws(pockets):
    data = Scene.load('pool_table').to_dict()
    data['table']['pockets'] = pockets
    scene = Scene.from_dict(data)
    rng = np.random.default_rng(5)
    within = []
    for _ in range(400):
        a, b = rng.uniform(-0.5, 0.5, 2)
        stroke = Stroke.from_offsets(
            a=a,
            b=b,
            elevation=np.radians(rng.uniform(2.0, 25.0)),
            azimuth=rng.uniform(-np.pi, np.pi),
            speed=rng.uniform(0.5, 6.0),
        )
        place = rng.uniform([-0.9, -0.4], [0.9, 0.4])
        shot, exact = (predict(scene, stroke, each, place) for each in (1e-4, 1e-9))
        # After a second hit of the cue the tolerance does not hold.
        if not (shot.status.refused or shot.double_hit or exact.double_hit):
            error = gap(shot.trajectory, exact.trajectory)
            within.append((error <= 1e-4, error <= shot.error_estimate))
    assert len(within) > 350
    within_tolerance, within_estimate = np.mean(within, axis=0)
    assert within_tolerance == 1.0
    assert within_estimate >= 0.995


def at_ratio(ratio):
    data = Scene.load('paper').to_dict()
    data['contacts']['cue_ball']['stiffness'] = ratio
    return Scene.from_dict(data)


def test_a_shot_on_a_discontinuity_of_the_law_says_so():
    massé = Stroke((-2, -1, 12), (4, 0, -16))
    sweep = next(sweeps(Scene.load('paper'), massé))
    places = [each.place for each in discontinuities(sweep.outcome('energetic'), sweep.values)]
    place = min(places, key=lambda ratio: abs(ratio - 1.0))
    for tolerance in (1e-3, 1e-5):
        on_it = predict(at_ratio(place), massé, tolerance)
        assert on_it.status == Status.TOLERANCE_NOT_REACHED
        assert 'discontinuous here' in on_it.message
        # The other side is within the estimate.
        others = [predict(at_ratio(place * factor), massé, tolerance) for factor in (0.999, 1.001)]
        apart = np.linalg.norm(
            others[0].trajectory.final_position - others[1].trajectory.final_position
        )
        assert apart > 1.0
        assert on_it.error_estimate > 0.9 * apart
        assert {other.status for other in others} <= {Status.OK, Status.MISCUE}
        assert not any(other.discontinuity for other in others)


def test_bistiffness_is_continuous_there():
    as_it_was = {**at_ratio(0.88293).to_dict(), 'law': 'bistiffness'}
    scene = Scene.from_dict({**as_it_was, 'effects': {'double_hit': 'off'}})
    shot = predict(scene, Stroke((-2, -1, 12), (4, 0, -16)))
    assert shot.discontinuity == 0.0
    assert shot.status == Status.MISCUE
