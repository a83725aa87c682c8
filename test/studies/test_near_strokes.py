"""Strokes near cushions and balls end, after few events (costs: benchmarks/near_strokes.py)."""

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status
from billiard_shot.scene.files import scene_names
from studies.near_strokes import NEAR, near_scene, near_stroke

ENDED = Status.OK, Status.OFF_TABLE
MOST_EVENTS = 3000  # balls with side spin that are pressed together meet every millisecond
KINDS = [
    (name, own)
    for name in scene_names()
    for own in (False, True)
    if not own or len(Scene.load(name).balls) > 1
]


@pytest.mark.parametrize(('name', 'own'), KINDS)
def test_they_end_after_few_events(name, own):
    scene, draw = Scene.load(name), np.random.default_rng(4)
    played = 0
    for _ in range(20):
        near = near_scene(scene, draw, own=own)
        shot = predict(near, near_stroke(near, draw))
        if not shot.status.refused:
            assert shot.run.status in ENDED
            assert len(shot.events) < MOST_EVENTS
            played += 1
    assert played > 15


def test_the_cue_ball_is_near_another_ball():
    scene, draw = Scene.load('eight_ball'), np.random.default_rng(4)
    for own in (False, True):
        for _ in range(20):
            balls = near_scene(scene, draw, own=own).balls
            assert len(balls) == 16 if own else 2 <= len(balls) <= 4
            cue, *others = np.array([balls['cue'], *(balls[b] for b in balls if b != 'cue')])
            gaps = np.linalg.norm(np.array(others) - cue, axis=1) - 2 * scene.ball.radius
            assert -1e-9 < gaps.min() < NEAR
