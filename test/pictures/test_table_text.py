"""The table in the terminal: it fits, and shows each ball where it lies."""

from dataclasses import replace
import re

import pytest

from billiard_shot.game import game_names, start
from billiard_shot.pictures.rack import COLUMNS, table_text

WIDTH = 80


@pytest.mark.parametrize('game', game_names())
@pytest.mark.parametrize('seed', range(3))
def test_each_ball_is_there_once(game, seed):
    state = start(game, 'carom' if game == 'three_cushion' else 'pool_table', seed=seed)
    text = table_text(state)
    assert max(map(len, text.split('\n'))) <= WIDTH
    inside = '\n'.join(re.findall(r'\|(.*)\|', text))
    labels = {'cue': '@', 'other': 'O', 'red': 'R'}
    expected = sorted(labels.get(ball, ball) for ball in state.balls)
    assert sorted(re.findall(r'[^ :\n]+', inside)) == expected


@pytest.mark.parametrize(('x', 'y'), [(0.0, 0.0), (-1.2, 0.6), (1.2, -0.6), (0.5, -0.3)])
def test_a_ball_is_drawn_where_it_lies(x, y):
    """To the left is the head, at the top the left side; to half a character."""
    state = replace(start('practice', 'pool_table', balls=1), balls={'cue': (x, y)}, in_hand='')
    lines = re.findall(r'\|(.*)\|', table_text(state))
    ((row, column),) = [(i, line.index('@')) for i, line in enumerate(lines) if '@' in line]
    assert abs((column + 0.5) / COLUMNS - 0.5 - x / state.length) <= 0.5 / COLUMNS + 1e-9
    assert abs(0.5 - (row + 0.5) / len(lines) - y / state.width) <= 0.5 / len(lines) + 1e-9
    assert 1.9 < len(lines[0]) / len(lines) / state.length * state.width < 2.1


def test_pockets_and_sizes_are_named():
    top, edge, *_, bottom, names, sizes = table_text(start('practice', 'pool_table')).split('\n')
    assert top.split() == ['head_left', 'side_left', 'foot_left']
    assert names.split() == ['head_right', 'side_right', 'foot_right']
    assert [edge.split()[-1], bottom.split()[-1]] == ['0.64', '-0.64']
    assert [sizes.split()[1], sizes.split()[-1]] == ['-1.27', '1.27']
    places = [place for place, each in enumerate(edge) if each == 'O']
    assert places == [0, (COLUMNS + 1) // 2, COLUMNS + 1]


def test_balls_beside_each_other_do_not_make_another_number():
    balls = {'1': (0.0, 0.0), '4': (0.06, 0.0), '14': (0.12, 0.0), '2': (-0.06, 0.0)}
    state = replace(start('practice', 'pool_table'), balls=balls)
    found = re.findall('[0-9]+', '\n'.join(re.findall(r'\|(.*)\|', table_text(state))))
    assert sorted(found) == ['1', '14', '2', '4']
