"""The table from above: what is drawn is what the trajectories say, and the files come out."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
import re
import sys

import numpy as np
import pytest

from billiard_shot import BallState, predict, Scene, simulate, Stroke
from billiard_shot.game import game_names, start
from billiard_shot.game.rack import Pairing, play
from billiard_shot.pictures import rack
from billiard_shot.pictures.canvas import ball_colour, CUE_BALL_COLOUR, is_striped, OTHER, POOL
from billiard_shot.pictures.plan import plan_figure
from billiard_shot.pictures.rack import COLUMNS, table_text, write_rack
from billiard_shot.pictures.table import (
    draw_shot,
    draw_trails,
    MOVING_COLOURS,
    PALE_PATH,
    table_axes,
)
from billiard_shot.pictures.trails import ENDLESS_SHOWN, path_colours, Trails, trails_of
from billiard_shot.planning.problem import limits_of
from billiard_shot.planning.result import RankedStroke, sample_outcomes
from billiard_shot.planning.targets import Pot
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import EventKind

FROZEN = Scene.load('frozen_combination')
COMBINATION = predict(
    FROZEN, Stroke.from_offsets(a=0, b=0.1, elevation=0.1, azimuth=0.55, speed=2)
)
BREAK = predict('eight_ball', Stroke.from_offsets(b=0.1, elevation_deg=5, azimuth_deg=-4, speed=8))
MASSE = predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16)))
drawn = pytest.importorskip  # matplotlib is an extra


def test_lines_follow_the_ball():
    for shot in (COMBINATION, MASSE):
        trails = trails_of(shot)
        for name, ball in trails.balls.items():
            pieces = trails.pieces(name)
            for piece in pieces:
                inside = np.linspace(piece.times[0], piece.times[-1], 50)[1:-1]
                states = ball.at(inside)
                assert set(np.unique(states.motion)) == {piece.motion}
                for point in states.position:
                    edges = pairwise(piece.points)
                    assert min(_distance(point, a, b) for a, b in edges) < 1.01e-4
            for before, after in pairwise(pieces):
                assert before.times[-1] == after.times[0]
                assert before.points[-1] == pytest.approx(after.points[0], abs=1e-12)


def test_ghosts_touch_the_balls_that_the_cue_ball_meets():
    trails = trails_of(COMBINATION)
    met = [
        event
        for event in COMBINATION.run.events
        if event.kind in ('ball', 'cluster') and 'cue' in event.balls
    ]
    assert len(trails.ghosts) == len(met) > 0
    for ghost, event in zip(trails.ghosts, met, strict=True):
        gaps = [
            np.linalg.norm(ghost - COMBINATION.run.balls[name].at(event.time).position)
            for name in event.balls
            if name != 'cue'
        ]
        assert min(gaps) == pytest.approx(2 * FROZEN.ball.radius, abs=1e-5)
    assert trails.end('8') is None  # pocketed
    assert trails.end('cue') == pytest.approx(COMBINATION.run.final_position['cue'])


def test_a_refused_stroke_moves_nothing():
    trails = trails_of(predict(FROZEN, Stroke((1, 0, 0), (1, 0, 0))))
    assert set(trails.balls) == {'cue', '1', '8'}
    assert not any(trails.pieces(name) for name in trails.balls)
    assert trails.end('8')[:2] == pytest.approx(FROZEN.balls['8'])


def test_endless_motion_is_shown_for_a_while():
    scene = Scene.from_dict({'like': 'pool', 'cloth': {'rolling_resistance': 0}})
    run = simulate(scene, {'cue': BallState((0, 0, 0.028575), (1, 0, 0))})
    trails = Trails(scene, run)
    assert trails.until == run.balls['cue'].duration + ENDLESS_SHOWN
    assert trails.pieces('cue')[-1].times[-1] == trails.until


@pytest.mark.parametrize('name', ['pool_table', 'snooker', 'carom'])
def test_outline_is_where_balls_turn_back(name):
    """No ball's surface ever gets farther than the polygons of the cushions, at their height."""
    scene = Scene.load(name)
    outline = outline_of(scene)
    assert len(outline.cushions) == (4 if name == 'carom' else 6)
    half = 0.5 * np.array([scene.table.length, scene.table.width])
    for polygon in outline.cushions:
        inside = (np.abs(polygon) < half - 1e-9).all(axis=1)
        assert not inside.any()
        assert (np.abs(polygon) <= outline.back + 1e-9).all()
    assert (outline.frame > outline.back).all()
    for x, y, radius in outline.holes:
        assert (np.abs([x, y]) + radius < outline.frame).all()


@pytest.mark.parametrize('azimuth', [0.0, 0.25, 1.3, -2.0])
def test_balls_turn_at_the_outline(azimuth):
    scene = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [0.3, 0.1]}})
    shot = predict(scene, Stroke.from_offsets(0, 0, 0.2, azimuth, 1.5))
    bounce = next(e for e in shot.run.events if e.kind == EventKind.CUSHION)
    x, y, z = bounce.position
    edges = [(a, b) for polygon in outline_of(scene).cushions for a, b in pairwise(polygon)]
    height = outline_of(scene).height - z
    reach = np.sqrt(scene.ball.radius**2 - height**2)
    assert min(_distance((x, y), a, b) for a, b in edges) == pytest.approx(reach, abs=1e-4)


def _distance(point, a, b):
    part = np.clip((point - a) @ (b - a) / max((b - a) @ (b - a), 1e-30), 0, 1)
    return np.linalg.norm(a + part * (b - a) - point)


def test_colours_of_balls():
    assert ball_colour('cue') == CUE_BALL_COLOUR
    assert [ball_colour(str(n)) for n in range(1, 9)] == list(POOL)
    assert [ball_colour(str(n)) for n in range(9, 16)] == list(POOL[:7])
    assert [is_striped(name) for name in ('9', '15')] == [True, True]
    assert not any(is_striped(name) for name in ('8', '16', 'red1'))
    assert ball_colour('red12') == ball_colour('red')
    assert ball_colour('16') == ball_colour('Ω') == OTHER


def test_lines_tell_balls_by_colour_and_motions_by_style():
    drawn('matplotlib', reason='needs matplotlib, an extra')
    trails = trails_of(COMBINATION)
    _, axes = table_axes(FROZEN)
    draw_trails(axes, trails)
    colours = path_colours(trails, MOVING_COLOURS, PALE_PATH)
    assert list(colours) == ['cue', '1', '8']
    assert len(set(colours.values())) == 3
    legend = {line.get_label(): line for line in axes.get_lines()}
    for name, label in (('cue', 'cue ball'), ('1', '1'), ('8', '8')):
        assert legend[label].get_color() == colours[name]
        lines = [
            line
            for line in axes.get_lines()
            if len(line.get_xdata()) > 1 and line.get_color() == colours[name]
        ]
        assert len(lines) == len([p for p in trails.pieces(name) if p.motion != Motion.SPIN])
    assert len({legend[motion].get_linestyle() for motion in ('rolls', 'slides')}) == 2


def test_a_break_shows_what_matters():
    """Cue ball, first contact, and balls that fall have a colour; the other balls are pale."""
    trails, colours, pale = trails_of(BREAK), MOVING_COLOURS, PALE_PATH
    paths = path_colours(trails, colours, pale)
    told = [name for name, colour in paths.items() if colour != pale]
    gone = {name for name in trails.balls if trails.end(name) is None}
    assert set(told) == {'cue', trails.run.first_met['cue']} | gone
    assert paths['cue'] == colours[0]
    assert len({paths[name] for name in told}) == len(told)
    assert len(paths) > 10
    few = path_colours(trails, colours[:2], pale)  # even if there are more than colours
    assert sorted(few.values()) == sorted([*colours[:2], *[pale] * (len(paths) - 2)])


@pytest.fixture(scope='module')
def plan_and_picture():
    drawn('matplotlib', reason='needs matplotlib, an extra')
    scene = Scene.load('blocked')
    stroke = Stroke.from_offsets(0.06, -0.001, 0.56, -0.02, 3.2)
    limits = limits_of(scene, None, scene.noise)
    planned = RankedStroke(
        scene,
        Pot('8'),
        limits,
        stroke,
        stroke,
        successes=300,
        trials=1000,
        value=0.3,
        value_error=0.01,
    )
    return planned, plan_figure(planned, sample_outcomes(planned, scene.noise, 20))


def test_balls_are_pale_where_they_start_and_full_where_they_rest(plan_and_picture):
    planned, picture = plan_and_picture
    trails = trails_of(planned.shot)
    starts = {(*trails.start(name)[:2], 0.35) for name in trails.balls if trails.moved(name)}
    ends = [trails.end(name) for name in trails.balls]
    full = {(*end[:2], 1.0) for end in ends if end is not None}
    assert len(starts) > 1
    for figure in (planned.shot.plot(), picture):
        balls = [each for each in figure.axes[0].patches if each.get_zorder() in (2, 4)]
        assert {(*ball.get_center(), ball.get_alpha() or 1.0) for ball in balls} == starts | full


def test_the_title_of_a_plan_has_its_numbers(plan_and_picture):
    planned, picture = plan_and_picture
    title = picture.axes[0].get_title('left')
    assert re.findall(r'[-+]?\d+(?:\.\d+)?', title) == [
        *('30', '95', *re.findall(r'\d+(?:\.\d+)?', planned.estimate)[2:]),
        *('+0.06', '+0.00', '32.1', '3.20'),
    ]
    assert title.startswith(f'{planned.kind}: success {planned.estimate}; a ')


@pytest.mark.parametrize('shot', [COMBINATION, MASSE])
def test_file_comes_out(shot, tmp_path):
    drawn('matplotlib', reason='needs matplotlib, an extra')
    draw_shot(shot, tmp_path / 'shot.png', 'a shot')
    assert (tmp_path / 'shot.png').read_bytes().startswith(b'\x89PNG')
    with pytest.raises(ValueError, match='picture: '):
        draw_shot(shot, tmp_path / 'no' / 'shot.png')


def test_without_matplotlib_it_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib.figure', None)
    with pytest.raises(ValueError, match=r'pip install .billiard_shot\[plot\]'):
        draw_shot(MASSE, Path('never.png'))


# --- the table in the terminal: it fits, and shows each ball where it lies -----------------------

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


# --- the pages of a rack: each shot has one, with links to the others and to the list ------------

TABLE = Scene.load('seven_foot')


@pytest.fixture(scope='module')
def record():
    played = play(Pairing('practice', TABLE, ('greedy',), seed=4, balls=3), 0)
    assert len(played.shots) > 2
    return played


def links_in(page):
    return dict(
        reversed(each) for each in re.findall(r'<a href="([^"]*)">([^<]*)</a>', page.read_text())
    )


def test_each_page_leads_to_the_next(record, tmp_path):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    listed = write_rack(record, TABLE, tmp_path / 'rack')
    names = re.findall(r'<a href="(shot-\d+.html)"><img src="(shot-\d+.png)"', listed.read_text())
    pages = [listed.parent / page for page, _ in names]
    assert len(pages) == len(record.shots)
    for _, picture in names:
        assert (listed.parent / picture).read_bytes().startswith(b'\x89PNG')
    for before, page, after in zip([None, *pages], pages, [*pages[1:], None], strict=False):
        links = {'All shots': listed.name}
        links |= {'← Previous': before.name} if before else {}
        links |= {'Next →': after.name} if after else {}
        assert links_in(page) == links


def test_without_matplotlib_the_list_has_no_pictures(record, tmp_path, monkeypatch):
    monkeypatch.setattr(rack, 'has_matplotlib', lambda: False)
    listed = write_rack(record, TABLE, tmp_path)
    assert listed.read_text().count('<li>') == len(record.shots)
    assert not list(tmp_path.glob('*.png'))
    assert '<img' not in listed.read_text()
