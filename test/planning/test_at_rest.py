"""Targets judged by the balls at rest."""

import pytest

from billiard_shot.planning.targets import read_target

CUE, EIGHT, ONE = {'cue': (0.2, 0.1)}, {'8': (0.5, 0.5)}, {'1': (-0.5, 0.2)}


@pytest.mark.parametrize(
    ('target', 'places', 'reached', 'words'),
    [
        ({'rest': (0.2, 0.0), 'radius': 0.11}, CUE, True, '100.0 mm from the point, 110 mm'),
        (
            {'rest': (0.2, 0.0), 'radius': 0.09},
            CUE,
            False,
            'not reached: the cue ball rests 100.0',
        ),
        ({'rest': (0.2, 0.0)}, EIGHT, False, 'the cue ball is not on the table'),
        ({'pot': '8'}, CUE, True, 'pocketed: 8'),
        ({'pot': '8'}, CUE | EIGHT, False, 'still on the table: 8'),
        ({'pot': ['8', '1']}, CUE | ONE, True, 'pocketed: 8'),
        ({'pot': ['8', '1']}, CUE | ONE | EIGHT, False, 'still on the table: 8, 1'),
        ({'pot': '8', 'leave': (0.2, 0.0), 'radius': 0.09}, CUE, False, '100.0 mm from'),
        ({'pot': '8', 'leave': (0.2, 0.0), 'radius': 0.2}, CUE | EIGHT, False, 'still on'),
        ({'pot': 'any'}, CUE, True, 'not judged'),
        ({'pass': (0.0, 0.0)}, CUE, True, 'not judged'),
    ],
)
def test_a_target_is_judged(target, places, reached, words):
    found, text = read_target(target).judged_at_rest(places)
    assert found is reached
    assert words in text
