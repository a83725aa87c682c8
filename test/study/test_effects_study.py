"""What effects cost and change, and the command that shows it."""

import dataclasses
import json
import math
from pathlib import Path

import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.scene import Effects
from billiard_shot.shot.effects import GATES
from billiard_shot.study import comparison_count, sample_strokes, study_accuracy, study_effects

POOL, PAPER = Scene.load('pool'), Scene.load('paper')
STROKES = Path(__file__).parents[2] / 'config' / 'strokes' / 'paper.yaml'
NAMES = [gate.name for gate in GATES]
ENGLISH = Stroke.from_offsets(0.4, 0, 0, 0, 2)
JUMP = Stroke.from_offsets(0, 0, 0.6, 0, 3)


def changes(scene, stroke, **options):
    studies = study_effects(scene, [stroke], repeats=1, **options)
    assert [study.name for study in studies] == NAMES
    return {study.name: study.changes[0] for study in studies}


def test_end_mass_is_squirt():
    """The end mass turns the ball back, from a guided cue's line to that of a player's cue."""
    found = changes(POOL, ENGLISH)['end_mass']
    guided = dataclasses.replace(POOL, cue=dataclasses.replace(POOL.cue, guided=True))
    directions = [math.atan2(*predict(scene, ENGLISH).velocity[1::-1]) for scene in (POOL, guided)]
    assert found.simulated
    assert found.turn == pytest.approx(abs(directions[0] - directions[1]), rel=1e-6)
    assert math.degrees(found.turn) > 10


def test_flight_moves_the_place_of_rest():
    found = changes(POOL, JUMP)
    flat = dataclasses.replace(POOL, effects=Effects(flight='off'))
    rests = [predict(scene, JUMP).trajectory.final_position for scene in (POOL, flat)]
    assert found['flight'].distance == pytest.approx(abs(rests[0] - rests[1])[0], rel=1e-9)
    assert found['flight'].steps > 0
    assert found['roll'].distance == math.inf
    assert found['spin_decay'].distance == 0
    assert not found['spin_decay'].simulated


def test_an_effect_that_is_not_called_for_adds_nothing():
    found = changes(PAPER, Stroke.from_offsets(0, 0, 0, 0, 1))
    for name in ('end_mass', 'flight', 'bounce', 'tip_friction', 'table_friction', 'spin_decay'):
        assert not found[name].simulated
        assert (found[name].distance, found[name].turn, found[name].steps) == (0, 0, 0)


def test_what_the_scene_forces_off_is_compared_all_the_same():
    off = dataclasses.replace(POOL, effects=Effects(flight='off'))
    assert changes(off, JUMP)['flight'].distance == changes(POOL, JUMP)['flight'].distance
    assert changes(off, JUMP)['bounce'].distance == 0


def test_progress_and_refused_strokes():
    done = []
    strokes = [JUMP, Stroke.from_offsets(0.9, 0.9, 0, 0, 1)]
    studies = study_effects(POOL, strokes, repeats=1, report=done.append)
    assert done == list(range(1, comparison_count(strokes) + 1))
    assert [len(study.changes) for study in studies] == [1] * len(NAMES)


@pytest.mark.parametrize('name', ['pool', 'blocked', 'carom'])
def test_sample_strokes_can_be_played(name):
    scene = Scene.load(name)
    strokes = sample_strokes(scene, 20)
    assert strokes == sample_strokes(scene, 20)
    assert sum(predict(scene, stroke).status.refused for stroke in strokes) < 5
    for stroke in strokes if scene.balls else ():
        x, y, _ = scene.cue_ball
        vx, vy, _ = stroke.velocity
        misses = [
            abs(vx * (v - y) - vy * (u - x)) / math.hypot(vx, vy)
            for (u, v) in scene.balls.values()
            if (u, v) != (x, y)
        ]
        assert min(misses) <= 2 * scene.ball.radius


def test_command_for_one_shot(capsys):
    assert main(['study', 'effects', 'pool', '--a', '0.4', '--speed', '2']) == 0
    out, err = capsys.readouterr()
    assert err == ''
    rows, footer = out.split('\n\n')
    footer = ' '.join(footer.split())
    title, head, units, *lines = rows.splitlines()
    assert all(f'{column}: ' in footer for column in ('cost', 'steps', 'shift', 'turn'))
    assert title == 'scene pool, 1 stroke'
    assert head.split()[:3] == ['effect', 'on', 'cost']
    assert units.split() == ['(us)', '(mm)', '(°)']
    assert [line.split()[0] for line in lines if line[0] != ' '] == NAMES
    assert max(map(len, lines)) <= 80
    assert main(['study', 'effects', 'pool', '--a', '0.4', '--speed', '2', '--json']) == 0
    rows = {row['effect']: row for row in map(json.loads, capsys.readouterr().out.splitlines())}
    assert list(rows) == NAMES
    assert rows['end_mass']['why'].endswith('with 4.2 g of the cue')
    assert rows['end_mass']['simulated'] is True
    assert rows['roll']['position_change'] is None  # the ball would never rest


def test_command_for_strokes_and_for_a_scene(capsys):
    assert main(['study', 'effects', str(STROKES), '--scene', 'paper']) == 0
    title, *rows = capsys.readouterr().out.splitlines()
    assert title == 'scene paper, 4 strokes'
    assert rows[2 + NAMES.index('end_mass')].split()[1] == '0'
    assert main(['study', 'effects', 'carom', '--count', '2']) == 0
    out = capsys.readouterr().out
    assert out.startswith('scene carom, 2 sample strokes\n')
    assert max(map(len, out.splitlines())) <= 80


def test_picture(tmp_path, capsys):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    path = tmp_path / 'effects.png'
    assert (
        main(['study', 'effects', 'pool', '--a', '0.4', '--speed', '2', '--picture', str(path)])
        == 0
    )
    assert path.read_bytes().startswith(b'\x89PNG')
    wrong = str(tmp_path / 'none' / 'effects.png')
    assert main(['study', 'effects', 'pool', '--speed', '2', '--picture', wrong]) == 2
    assert 'picture ' in capsys.readouterr().err


def test_friction_is_compared_without_it():
    found = changes(POOL, ENGLISH)
    assert found['tip_friction'].distance > 0.1
    assert not found['cushion'].simulated
    assert found['cushion'].time == 0


def test_effects_of_a_table():
    """A stroke at the object ball of `frozen_combination`: throw and pockets matter, in mm."""
    scene = Scene.load('frozen_combination')
    (x, y), (u, v) = scene.balls['cue'], scene.balls['1']
    found = changes(scene, Stroke.from_offsets(0.2, 0, 0.1, math.atan2(v - y, u - x), 2))
    for name in ('ball_ball', 'throw', 'slide', 'roll'):
        assert found[name].simulated
        assert found[name].distance > 1e-3
    assert found['ball_ball'].reason.startswith('balls meet another ball')
    assert found['end_mass'].turn > math.radians(1)


# --- what accuracy costs in a scene: errors stay within the tolerance ----------------------------


def test_errors_fall_with_the_tolerance_and_stay_within():
    coarse, fine = study_accuracy(Scene.load('eight_ball'), (1e-2, 1e-6), count=10, repeats=1)
    for each in (coarse, fine):
        assert each.typical_error <= each.tolerance
        assert each.largest_error <= 2.0 * each.tolerance  # cushions met in the air enlarge errors
        assert min(each.strike, each.alone, each.shot) > 0.0
    assert fine.largest_error < 1e-3 * coarse.largest_error


def test_the_command_prints_a_line_for_each_tolerance(capsys, tmp_path):
    picture = tmp_path / 'tolerance.png'
    words = ['study', 'accuracy', 'pool_table', '--count', '3']
    assert main([*words, '--json', '--picture', str(picture)]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row['tolerance'] for row in rows] == [10.0**-n for n in range(2, 10)]
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert main(words) == 0
    title, *table = capsys.readouterr().out.splitlines()
    assert title == 'scene pool_table, 3 random strokes'
    assert max(map(len, table)) <= 80
