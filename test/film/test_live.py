"""A camera whose pictures come one after the other: which balls, where, and whether it moved."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from rendered import Filming, OVERHEAD, Painter, Placed

from billiard_shot import Scene
from billiard_shot.film.live import LiveTable

SCENE = Scene.load('pool_table')
SMALL = replace(OVERHEAD, size=(640, 360), focal=546.5)
NAMES = ['cue', *map(str, range(1, 16))]
SPREAD = {
    name: (-1.05 + 0.3 * (k % 8), -0.3 + 0.5 * (k // 8) + 0.06 * (k % 3))
    for k, name in enumerate(NAMES)
}


@pytest.fixture(scope='module')
def painter():
    filming = Filming(SMALL, hand=False, readout=0, cloth='pool')
    return Painter(SCENE, Placed(NAMES, SCENE.ball.radius), filming)


def seen(painter, places, **how):
    painter.motion.put(places)
    live = LiveTable([painter.at(0.0) for _ in range(3)], SCENE, NAMES, **how)
    return live, [live.balls(painter.at(0.0), 0.1 * k) for k in range(1, 12)]


def test_all_balls_of_pool_have_their_names_and_places(painter):
    live, pictures = seen(painter, SPREAD)
    for balls in pictures:
        assert len(balls) == 16
        for ball in balls:
            nearest = min(SPREAD, key=lambda name: np.hypot(*(SPREAD[name] - ball.place)))
            assert np.hypot(*(SPREAD[nearest] - ball.place)) < 4e-3
    last = {ball.name: ball for ball in pictures[-1]}
    assert last.keys() == SPREAD.keys()
    off = np.array([last[name].place - SPREAD[name] for name in NAMES])
    assert np.median(np.hypot(*off.T)) < 1.2e-3
    assert all(ball.likeness > 0.5 for ball in last.values())
    assert live.move(painter.at(0.0)) < 0.4


def test_a_moving_ball_is_followed_and_a_pocketed_one_is_gone(painter):
    live, _ = seen(painter, {'cue': (0.4, 0.1), '8': (-0.8, 0.2)})
    for k in range(12):
        x = 0.4 - 0.06 * k  # 1.8 m/s at 30 pictures a second
        painter.motion.put({'cue': (x, 0.1)} | ({'8': (-0.8, 0.2)} if k < 6 else {}))
        balls = {ball.name: ball for ball in live.balls(painter.at(0.0), 2.0 + k / 30)}
        assert balls.keys() == ({'cue', '8'} if k < 6 else {'cue'})
        assert np.hypot(*(balls['cue'].place - (x, 0.1))) < 3e-3


def test_a_table_may_be_turned(painter):
    _, pictures = seen(painter, {'cue': (0.4, 0.1)}, turned=True)
    (ball,) = pictures[-1]
    np.testing.assert_allclose(ball.place, (-0.4, -0.1), atol=3e-3)


def test_a_camera_that_moves_is_noticed(painter):
    live, _ = seen(painter, {'cue': (0.4, 0.1)})
    moved = cv2.warpAffine(painter.at(0.0), np.float64([[1, 0, 3.0], [0, 1, -1.0]]), (640, 360))
    assert live.move(moved) == pytest.approx(3.0, abs=0.3)
    assert live.move(np.full_like(moved, 90)) == np.inf


def test_outlines_are_drawn_into_a_copy(painter):
    live, pictures = seen(painter, {'cue': (0.4, 0.1)})
    picture = painter.at(0.0)
    shown = live.outlined(picture, pictures[-1])
    assert (shown != picture).any()
    u, v = live.camera.project(np.array([[0.4, 0.1, SCENE.ball.radius]]))[0].round().astype(int)
    np.testing.assert_array_equal(shown[v, u], picture[v, u])
