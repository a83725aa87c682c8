"""The triangle of cue ball, ball and ghost ball."""

import math

import numpy as np
import pytest

from billiard_shot.shot.ghost_ball import cut_of_path, grazing, path_of_cut, path_of_line

DIAMETER = 0.05715


@pytest.mark.parametrize('distance', [0.06, 0.3, 2.0])
@pytest.mark.parametrize('cut', np.radians([-85.0, -30.0, 0.0, 10.0, 60.0]).tolist())
def test_the_ghost_ball_is_on_the_path_and_touches_the_ball(distance, cut):
    path = path_of_cut(distance, DIAMETER, cut)
    assert abs(path) < grazing(distance, DIAMETER)
    run = distance * math.cos(path) - DIAMETER * math.cos(cut)
    ghost = run * np.array([math.cos(path), math.sin(path)])
    across = np.array([distance, 0.0]) - ghost
    assert math.hypot(*across) == pytest.approx(DIAMETER, rel=1e-9)
    line = math.atan2(across[1], across[0])
    assert line - path == pytest.approx(cut, abs=1e-9)
    assert path_of_line(distance, DIAMETER, line) == pytest.approx(path, abs=1e-9)
    assert cut_of_path(distance, DIAMETER, path) == pytest.approx(cut, abs=1e-7)


def test_a_grazing_path_makes_a_cut_of_a_right_angle():
    assert abs(cut_of_path(0.3, DIAMETER, grazing(0.3, DIAMETER))) == pytest.approx(
        0.5 * math.pi, abs=1e-6
    )
