"""`tolerance` and `error_estimate` over random shots (more: benchmarks/tolerance.py)."""
from pathlib import Path
import sys

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status

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
