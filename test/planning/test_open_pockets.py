"""Into how many pockets balls can be sent: what closes a pocket to a ball."""

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.planning.shots import open_pockets
from billiard_shot.table.run.states import TableStates

TABLE = Scene.load('pool_table')
R, LENGTH = TABLE.ball.radius, TABLE.table.length
AT_CUSHION = 0.5 * LENGTH - 1.05 * R


def count(**balls):
    """Pockets that are open to the ball b1."""
    names = tuple(balls)
    position = [[(x, y, R) for x, y in balls.values()]]
    which = np.array([[name == 'b1' for name in names]])
    found = open_pockets(TABLE, TableStates(names, position), which)
    assert found[~which].sum() == 0
    return int(found[which][0])


def test_all_pockets_are_open_to_a_ball_in_the_middle():
    assert count(b1=(0.0, 0.0)) == 6


def test_a_ball_at_a_cushion_goes_along_it_and_away_from_it_to_no_pocket():
    # the cue ball has no room behind it, but for the two corners of its own cushion
    assert count(b1=(AT_CUSHION, 0.0)) == 2


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_a_ball_in_the_way_closes_a_pocket_and_so_does_one_where_the_cue_ball_has_to_be(side):
    assert count(b1=(0.0, 0.0), b2=(0.3, side * 0.5)) == 6
    assert count(b1=(0.0, 0.0), b2=(0.0, side * 0.2)) == 5
    assert count(b1=(0.0, 0.0), b2=(0.0, side * 0.08)) == 4


def test_a_ball_in_the_middle_of_a_row_at_a_cushion_is_blocked():
    beside = 2.01 * R
    assert count(b1=(AT_CUSHION, 0.0), b2=(AT_CUSHION, beside), b3=(AT_CUSHION, -beside)) == 0


def test_absent_balls_are_not_in_the_way():
    position = np.full((2, 2, 3), R)
    position[:, 0, :2], position[:, 1, :2] = (0.0, 0.0), (0.0, 0.08)
    present = np.array([[True, True], [True, False]])
    which = np.array([[True, False]] * 2)
    found = open_pockets(TABLE, TableStates(('b1', 'b2'), position, present=present), which)
    assert found.tolist() == [[4, 0], [6, 0]]
    assert open_pockets(TABLE, TableStates(('b1',), np.zeros((0, 1, 3))), which[:0, :1]).size == 0
