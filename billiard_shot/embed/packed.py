"""A scene as the arguments of the entries that programs without Python call."""

from inspect import signature
from typing import Any

import numpy as np

from billiard_shot.compiled import Entry
from billiard_shot.impact.kernel import new_scratch
from billiard_shot.planning.direct_shots import find_direct_shots
from billiard_shot.planning.pot_directions import LEGAL, PRESENT
from billiard_shot.planning.shots import arguments_of
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.shot.accuracy import Accuracy, DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.stroke_vectors import write_strokes
from billiard_shot.table.cluster import room_for
from billiard_shot.table.play_tables import play_tables
from billiard_shot.table.simulation_state import room_for_simulation
from billiard_shot.table.task import CAPACITY, packed


def packed_scene(
    scene: Scene, tolerance: float = DEFAULT_SHOT_TOLERANCE
) -> dict[Entry, dict[str, Any]]:
    """
    Pack a scene as arguments of each entry, with room for one table of its balls and a stroke.

    Who calls the entries writes where balls lie, and the stroke; all else is there. Arrays of the
    entries are apart: the vectors that `write_strokes` writes are to be given to `play_tables`.
    Without pockets there is no `find_direct_shots`.
    """
    count = len(setting_of(scene).names)
    played = packed_play(scene, tolerance)
    made = {
        write_strokes: _named(
            write_strokes, (np.zeros((1, 5)), np.zeros((1, 3)), np.zeros((1, 3)))
        ),
        play_tables: played,
    }
    if len(played['layout'].pockets):
        places, kinds = np.zeros((1, count, 2)), np.array([[PRESENT] + [LEGAL] * (count - 1)])
        made[find_direct_shots] = _named(
            find_direct_shots, arguments_of(ROWS, scene, scene.noise, places, kinds, 0)
        )
    return made


def packed_play(scene: Scene, tolerance: float = DEFAULT_SHOT_TOLERANCE) -> dict[str, Any]:
    """Pack a scene as arguments of `play_tables` alone; see `packed_scene`."""
    setting = setting_of(scene)
    count = len(setting.names)
    task = task_of(setting, np.zeros((1, 3)), np.zeros((1, 3)), None, Accuracy(tolerance))
    room = room_for(ROWS, count, True)  # with scratch that this thread has used
    capacity = CAPACITY * (2 + count)
    room = room._replace(
        scratch=new_scratch(ROWS, len(room.properties)),
        participants=np.zeros((capacity, 2), np.int64),
    )
    rooms = room_for_simulation(ROWS, count), room
    named = _named(play_tables, packed(task, ROWS, rooms, capacity, capacity))
    for record in (named['tables'].segments, named['tables'].events):
        record.view(np.uint8).fill(0)  # it was not set
    return named


def _named(entry: Entry, arguments: tuple[Any, ...]) -> dict[str, Any]:
    return dict(zip(signature(entry.function).parameters, arguments, strict=True))
