"""The second ply tells end states apart that the next shot alone does not."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.game import Ruling, start
from billiard_shot.game.strokes import placed
from billiard_shot.game.valuation import BLOCKED, RuledBatch, second_ply, shots_left, values
from billiard_shot.planning.within_noise import play_within_noise
from billiard_shot.table.model.motion import NOTHING

TABLE = Scene.load('pool_table')


def end_states(*rows, game='practice', **given):
    """Several places of a few balls that are left, by default two in practice."""
    state = replace(start(game, TABLE), phase='play', **given)
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


def test_a_stroke_whose_cue_hits_the_cue_ball_again_does_not_count(monkeypatch):
    """As most strokes do that pot a ball 2 mm in front of the cue ball."""
    played = []

    def play(*arguments):
        played.append(play_within_noise(*arguments))
        rows = played[-1].played
        tables = rows.tables.copy()
        tables['double_hit'] = True
        return replace(played[-1], played=rows._replace(tables=tables))

    ball, way = np.array([0.9, 0.45]), np.array([2.0, 1.0]) / 5.0**0.5
    place = ball - way * (2.0 * TABLE.ball.radius + 0.002)
    batch = end_states({'cue': tuple(place), '1': tuple(ball), '2': (0.9, -0.45)})
    first = values(TABLE, 0, batch)
    monkeypatch.setattr('billiard_shot.game.valuation.play_within_noise', play)
    assert second_ply(TABLE, 0, batch, first).tolist() == first.tolist()
    potted = played[0].pocket[:, 1] != NOTHING
    assert played[0].double_hit[potted].mean() > 0.5


def test_a_rack_is_won_by_the_last_ball_and_the_8():
    """The 8 counted as a ball that is needed after it had fallen."""
    last = {'cue': (0.7, 0.35), '1': (0.95, 0.475), '8': (0.9, -0.45)}
    groups = 'solids', 'stripes'
    batch = end_states(last | {'9': (-0.9, 0.0)}, game='eight_ball', groups=groups)
    assert second_ply(TABLE, 0, batch, values(TABLE, 0, batch))[0] > 0.9
    on_8 = end_states({'cue': (0.7, -0.35), '8': (0.9, -0.45)}, game='eight_ball', groups=groups)
    assert second_ply(TABLE, 0, on_8, values(TABLE, 0, on_8))[0] > 0.9


def test_a_ball_that_no_pocket_is_open_to_takes_more_shots():
    free = {'cue': (-0.5, 0.0), '1': (0.6, 0.3), '8': (0.3, -0.2), '9': (-0.9, 0.2)}
    beside = {'10': (1.2414, 0.06), '11': (1.2414, -0.06)}
    theirs, both = (free | beside | {ball: (1.2414, 0.0)} for ball in ('9', '8'))
    states = [
        end_states(balls, game='eight_ball', groups=('solids', 'stripes'))
        for balls in (free, theirs, both)
    ]
    left = [shots_left(TABLE, each.after, each.kind, each.states)[0].tolist() for each in states]
    states[-1].states.present[:, states[-1].states.names.index('10')] = False
    tables = states[-1]
    fewer = shots_left(TABLE, tables.after, tables.kind, tables.states)[0].tolist()
    assert fewer == [2 + BLOCKED, 3 + 2 * BLOCKED]  # the 10 has fallen
    # no ball of the row goes along the cushion: the others are where the cue ball has to be
    assert left == [[2, 2], [2, 4 + 3 * BLOCKED], [2 + BLOCKED, 4 + 3 * BLOCKED]]
