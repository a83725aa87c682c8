"""Strokes at many tables: each is what `predict` gives in the scene of its table."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status, Stroke, TableStates
from billiard_shot.shot.play import play, play_by, prepared_scene, USUAL_ACCURACY
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.run.task import run_recorded

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


def test_the_record_of_a_stroke_that_is_played_again_is_that_of_the_second_time():
    strokes = np.tile((0.0, 0.0, 0.15, 0.0, 3.0), (40, 1))
    strokes[:, 3] = np.random.default_rng(5).uniform(-np.pi, np.pi, len(strokes))
    played = play_by(
        run_recorded, prepared_scene(TABLE), *vectors_of(strokes), None, USUAL_ACCURACY
    )
    assert (played.tables['jaws_met'] > 0).sum() >= 5
    motions = np.split(played.segments, played.tables['segments'][:-1])
    for motion, cue, balls in zip(motions, played.cues, played.balls, strict=True):
        of_cue_ball = motion[motion['ball'] == 0]
        assert (of_cue_ball['velocity'][0] == cue['velocity']).all()
        assert (of_cue_ball['position'][-1] == balls['position'][0]).all()


def test_the_cue_ball_must_come_first():
    normals, velocities = vectors_of(np.zeros((1, 5)))
    tables = TableStates(('1', 'cue'), [[(0.5, 0.0, TABLE.ball.radius), (0.0, 0.0, 0.0)]])
    with pytest.raises(ValueError, match="tables must have 'cue' first, got 1, cue"):
        play(TABLE, normals, velocities, tables)
