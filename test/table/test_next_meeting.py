"""The next meeting that is kept for each ball is the one that a search of all pairs finds."""

import math

import numpy as np
import pytest

from billiard_shot.records import OBJECTS
from billiard_shot.table.contacts.balls import find_next_meeting, note_collision
from billiard_shot.table.model.motion import NOTHING, room_for_simulation, Simulation, start_ball
from billiard_shot.table.run.event_loop import next_event

BALLS = 6
TIMES = (0.1, 0.2, 0.3, math.inf)  # few, so that many are equal


def simulation():
    """Balls that meet nothing yet."""
    room = room_for_simulation(OBJECTS, BALLS)
    s = Simulation(
        room.balls,
        [[math.inf] * BALLS for _ in range(BALLS)],
        room.progress[0],
        room.rebound[0],
        [],
        [],
        rules=[],
        cue=room.cue[0],
    )
    s.cue.meeting_time = math.inf
    for ball in s.balls:
        start_ball(ball, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        ball.end = math.inf
    return s


@pytest.mark.parametrize('seed', range(3))
def test_the_first_of_all_pairs_is_next(seed):
    """Of equal times the pair with the lowest indices; whatever the order of changes."""
    draw, s = np.random.default_rng(seed), simulation()
    for _ in range(300):
        index = int(draw.integers(BALLS))
        for i, time in enumerate(draw.choice(TIMES, BALLS).tolist()):
            if i > index:
                s.collisions[index][i] = time
            elif i < index:
                note_collision(s, i, index, time)
        find_next_meeting(s, index)
        pairs = [(s.collisions[i][j], i, j) for j in range(BALLS) for i in range(j)]
        first = min(pair for pair in [*pairs, (math.inf, NOTHING, NOTHING)])
        assert next_event(s) == (first if first[0] < math.inf else (math.inf, NOTHING, NOTHING))
