"""The second ply tells end states apart that the next shot alone does not."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.game import Ruling, start
from billiard_shot.game.batch_outcomes import RuledBatch
from billiard_shot.game.placing import placed
from billiard_shot.game.second_ply import second_ply
from billiard_shot.game.valuation import values

TABLE = Scene.load('pool_table')


def end_states(*rows):
    """Practice with two balls left, in several places."""
    state = start('practice', TABLE, balls=2)
    states = [replace(state, balls=balls, in_hand='', shots=1) for balls in rows]
    tables = placed(states[0])
    many = tables.take(np.zeros(len(rows), int))
    for i, each in enumerate(states):
        many.position[i, :, :2] = [each.balls[name] for name in many.names]
    return RuledBatch((Ruling(states[0]),), np.zeros(len(rows), int), many)


def test_a_second_ball_that_can_be_reached_is_worth_more():
    near = {'cue': (0.7, 0.35), '1': (0.95, 0.475)}
    easy = near | {'2': (0.9, -0.45)}  # beside the other corner
    hard = near | {'2': (-1.2, 0.0)}  # frozen to the middle of the far cushion
    batch = end_states(easy, hard)
    first = values(TABLE, 0, batch)
    assert first[0] == pytest.approx(first[1], abs=0.01)
    second = second_ply(TABLE, 0, batch, first)
    assert second[0] > second[1] + 0.1


def test_without_a_shot_the_first_value_stays():
    blocked = {'cue': (0.0, 0.0), '1': (1.2, 0.0), '2': (1.2, 0.1)}
    batch = end_states(blocked)
    first = np.array([0.123])
    assert second_ply(TABLE, 1, batch, first).tolist() == [0.123]  # it is not this player's turn


def test_the_last_two_balls_are_won_by_two_pots():
    last = {'cue': (0.7, 0.35), '1': (0.95, 0.475), '2': (0.9, -0.45)}
    batch = end_states(last)
    assert second_ply(TABLE, 0, batch, values(TABLE, 0, batch))[0] > 0.9
