"""Packed scenes: arguments that programs without Python take over."""

import numpy as np
import pytest

from billiard_shot import machine_code, predict, Scene, Stroke
from billiard_shot.embed.scenes import packed_scene
from billiard_shot.table.run.task import play_tables


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
@pytest.mark.parametrize('name', ['paper', 'blocked'])
def test_packed_arguments_play_a_shot_as_predict_does(name):
    stroke = Stroke.from_offsets(0.1, 0.2, 0.1, 0.15, 4.0)
    shot = predict(name, stroke)
    arguments = packed_scene(Scene.load(name))[play_tables]
    strokes, tables = arguments['strokes'], arguments['tables']
    strokes.normals[0], strokes.velocities[0] = stroke.normal, stroke.velocity
    play_tables.current()(*arguments.values())
    assert tables.ends['duration'].tolist() == [shot.run.duration]
    assert np.array_equal(tables.balls['position'], list(shot.run.final_position.values()))


def test_packed_scenes_have_nothing_of_shots_that_were_played():
    predict('blocked', Stroke.from_offsets(0.1, 0.2, 0.1, 0.15, 4.0))
    room = packed_scene(Scene.load('blocked'))[play_tables]['room']
    for record in (room.bodies, room.results.contacts, room.scratch.contacts):
        assert len(record) > 3
        assert not any(record.tobytes())
