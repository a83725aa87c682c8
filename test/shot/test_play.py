"""Strokes at many tables: each is what `predict` gives in the scene of its table."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status, Stroke, TableStates
from billiard_shot.shot.play import play
from billiard_shot.shot.stroke import vectors_of

TABLE = Scene.load('pool_table')
NAMES = 'cue', '1', '2'
COUNT = 24


def tables_and_strokes():
    """Balls anywhere, on every third table one of them near the cue ball, on some one missing."""
    draw = np.random.default_rng(3)
    position = np.full((COUNT, 3, 3), TABLE.ball.radius)
    position[..., 0] = draw.uniform(-1.0, 1.0, (COUNT, 3))
    position[..., 1] = (-0.3, 0.0, 0.3)
    position[::3, 1, :2] = position[::3, 0, :2] + (2.0 * TABLE.ball.radius + 0.003, 0.0)
    present = np.ones((COUNT, 3), np.bool_)
    present[1::4, 2] = False
    strokes = np.zeros((COUNT, 5))
    strokes[:, 2], strokes[:, 3] = 0.15, draw.uniform(-np.pi, np.pi, COUNT)
    strokes[::3, 3] = np.linspace(0.0, np.pi, COUNT // 3)
    strokes[:, 4] = 2.0
    return TableStates(NAMES, position, present=present), strokes


def test_strokes_at_many_tables_are_those_of_predict():
    tables, strokes = tables_and_strokes()
    batch = play(TABLE, *vectors_of(strokes), tables)
    for i, row in enumerate(strokes.tolist()):
        lie = zip(NAMES, tables.position[i, :, :2].tolist(), tables.present[i], strict=True)
        scene = replace(TABLE, balls={name: tuple(xy) for name, xy, there in lie if there})
        shot = predict(scene, Stroke.from_offsets(*row))
        assert batch.status[i] == shot.status
        assert batch.velocity[i] == pytest.approx(shot.velocity, abs=1e-9)
        assert batch.double_hit[i] == (shot.double_hit is not None)
        for k, name in enumerate(NAMES):
            if tables.present[i, k]:
                place = shot.final_position[name]
                assert batch.final_position[i, k] == pytest.approx(place, abs=1e-6)
    assert {Status.OK, Status.CUE_THROUGH_BALL} <= set(batch.status.tolist())
    assert batch.double_hit.any()
    assert not batch.double_hit.all()


def test_one_table_serves_all_strokes():
    tables, strokes = tables_and_strokes()
    one = play(TABLE, *vectors_of(strokes), tables.take(slice(0, 1)))
    many = play(TABLE, *vectors_of(strokes), tables.take(np.zeros(COUNT, int)))
    assert (one.final_position == many.final_position).all()
    assert (one.status == many.status).all()


def test_a_table_without_a_cue_ball_is_missed():
    tables, strokes = tables_and_strokes()
    tables.present[2, 0] = False
    batch = play(TABLE, *vectors_of(strokes), tables)
    assert batch.status[2] == Status.MISS
    assert (batch.final_position[2, 1] == tables.position[2, 1]).all()


def test_the_cue_ball_must_come_first():
    normals, velocities = vectors_of(np.zeros((1, 5)))
    tables = TableStates(('1', 'cue'), [[(0.5, 0.0, TABLE.ball.radius), (0.0, 0.0, 0.0)]])
    with pytest.raises(ValueError, match="tables must have 'cue' first, got 1, cue"):
        play(TABLE, normals, velocities, tables)
