"""`billiard-shot plan`, as people call it."""

import dataclasses
import json
import math
import re

import numpy as np
import pytest

from billiard_shot import aim, load_shot, plan, predict, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.planning.result import deviation_of, why_missed

FAST = ['--budget', '5000']


def test_ranking(capsys):
    assert main(['plan', 'frozen_combination', '--pot', '8', *FAST]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith('OK: ')
    head = next(i for i, line in enumerate(lines) if line.split()[:2] == ['success', '95'])
    assert '95 % CI' in ' '.join(lines[:head])
    assert lines[head].endswith('kind')
    assert lines[head + 2].startswith('1  ')
    assert lines[head + 2].endswith('  combination')
    assert any(line.startswith('1, played exactly: 8 into foot left') for line in lines)
    assert 'strokes simulated in' in lines[-1]
    assert max(map(len, lines)) <= 80


def test_files_of_any_rank(tmp_path, capsys):
    shot, page = tmp_path / 'shot.json', tmp_path / 'shot.html'
    command = ['plan', 'frozen_combination', '--pot', '8', *FAST, '--json']
    assert main([*command, '--rank', '2', '-o', str(shot), '--view', str(page)]) == 0
    ranking = json.loads(capsys.readouterr().out)['ranking']
    assert load_shot(shot).stroke.velocity == pytest.approx(ranking[1]['velocity'])
    assert f'"velocity": {json.dumps(ranking[1]["velocity"])}' in page.read_text()
    assert main([*command, '--rank', '99', '-o', str(shot)]) == 2
    assert re.search(
        r'--rank must be at most \d+, the strokes found, got 99', capsys.readouterr().err
    )


def test_json_says_what_plan_says(capsys):
    words = 'plan blocked --hit 8 --seed 3 --json --noise tournament --noise-scale 0.5'
    assert main([*words.split(), *FAST]) == 0
    said = json.loads(capsys.readouterr().out)
    scene = Scene.load('blocked')
    alone = plan(scene, {'hit': '8'}, scene.noise.times(0.5), int(FAST[1]), 3)
    assert said['status'] == 'OK'
    assert said['simulations'] == alone.simulations
    assert [each['success'] for each in said['ranking']] == [
        each.success for each in alone.ranking
    ]
    best = said['ranking'][0]
    assert (
        best['a'],
        best['b'],
        best['elevation'],
        best['azimuth'],
        best['speed'],
    ) == pytest.approx(alone.best.stroke.offsets)
    assert said['noise']['azimuth_deg'] == pytest.approx(0.0625)


@pytest.mark.parametrize(
    'target',
    [
        ['--rest', '0.3', '0.2', '--radius', '0.2'],
        ['--pass', '0.3', '0.2'],
        ['--gate', '0', '-0.1', '0', '0.1'],
    ],
)
def test_pictures(target, tmp_path, capsys):
    picture = tmp_path / 'plan.png'
    assert main(['plan', 'pool_table', *target, *FAST, '--picture', str(picture)]) == 0
    assert picture.read_bytes()[:4] == b'\x89PNG'
    assert capsys.readouterr().err == ''


def test_a_plan_that_is_not_found_is_a_failure(capsys):
    words = 'plan blocked --hit 8 --azimuth-deg 180 --azimuth-half-range-deg 1 --speed-max 0.2'
    assert main([*words.split(), '--budget', '200']) == 1
    assert 'NO_PLAN: no stroke reaches the target' in capsys.readouterr().err


# --- why a shot misses: the causes add up, and each one is what it says --------------------------

SCENE = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [0.4, 0.1], '8': [0.9, 0.265]}})
POCKET = ['foot_left']
IDEAL = 15.2  # degrees, at the ghost ball


def deviation(scene=SCENE, azimuth_deg=IDEAL, **offsets):
    stroke = {'b': -0.2, 'elevation_deg': 3, 'speed': 2} | offsets
    shot = predict(scene, Stroke.from_offsets(azimuth_deg=azimuth_deg, **stroke))
    return deviation_of(shot, '8', POCKET), shot


def smooth(scene):
    """Balls without friction between them."""
    balls = dataclasses.replace(scene.contacts.ball_ball, friction_fast=0.0, friction_slow=0.0)
    return dataclasses.replace(
        scene, contacts=dataclasses.replace(scene.contacts, ball_ball=balls)
    )


def test_causes_add_up_to_the_direction_of_the_ball():
    for azimuth in (14.0, 15.2, 17.0):
        for a in (-0.3, 0.0, 0.3):
            found, shot = deviation(azimuth_deg=azimuth, a=a)
            time = next(e.time for e in shot.events if '8' in e.balls)
            velocity = shot.run.at(time)['8'].velocity
            way = shot.trajectory.at(np.nextafter(time, 0.0)).velocity
            hole = np.array([1.27, 0.635])
            real, ideal, before = (
                math.degrees(math.atan2(v[1], v[0]))
                for v in (velocity, hole - SCENE.balls['8'], way)
            )
            assert found.thick == found.aim + found.squirt + found.swerve + found.throw
            assert ideal > before  # a cut to the left: thick is a turn to the right
            # the hole is some millimetres behind the corner of the noses
            assert math.degrees(found.thick) == pytest.approx(ideal - real, abs=1.0)


def test_each_cause_is_what_it_says():
    plain, _ = deviation()
    assert plain.squirt == pytest.approx(0.0, abs=1e-6)
    assert plain.throw > math.radians(1.0)  # friction takes the ball along
    slick, _ = deviation(smooth(SCENE))
    assert slick.throw == pytest.approx(0.0, abs=1e-6)
    guided = dataclasses.replace(SCENE.cue, guided=True, end_mass=None)
    squirts = [
        deviation(dataclasses.replace(SCENE, cue=cue), a=0.05)[0].squirt
        for cue in (SCENE.cue, guided)
    ]
    assert math.radians(1.0) < squirts[0] < squirts[1]  # right-hand side: to the left, thick
    aside, _ = deviation(azimuth_deg=16.2)
    assert aside.aim - plain.aim > math.radians(5.0)
    assert aside.thick > 0.0


def test_what_is_in_the_way_is_named():
    shot = predict('blocked', aim('blocked', '8', pocket='foot_left', speed=2.0))
    assert why_missed(shot, '8') == 'the cue ball meets 1 before 8'
    _, shot = deviation(azimuth_deg=40.0)
    assert why_missed(shot, '8').startswith('the cue ball passes 8 at ')
    shot = predict(SCENE, aim(SCENE, '8', pocket='foot_left', speed=2.0))
    assert why_missed(shot, '8', POCKET) == ''


def test_a_plan_that_fails_says_where():
    result = plan(
        'blocked',
        {'pot': '8', 'pocket': 'foot_left'},
        budget=300,
        constraints={'elevation_max_deg': 3, 'speed_max': 0.3},
    )
    assert result.best is None
    assert result.message.endswith('straight at foot left, the cue ball meets 1 before 8')


def test_command(capsys, tmp_path):
    (tmp_path / 'cut.yaml').write_text(json.dumps(SCENE.to_dict()))
    command = ['predict', str(tmp_path / 'cut.yaml'), '-b', '-0.2', '-e', '3', '-s', '2', '-z']
    assert main([*command, '16.2', '--pot', '8', '--pocket', 'foot_left']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(
        line.startswith('  missed          8 beside foot left: thick by ') for line in lines
    )
    assert main([*command, '15.2', '--pot', '8', '--json']) == 0
    assert json.loads(capsys.readouterr().out)['miss'] == ''
    assert main([*command, '15.2', '--pot', '7']) == 2
    assert '--pot must be one of ' in capsys.readouterr().err


def test_without_pockets_nothing_can_be_potted(capsys):
    assert main(['predict', 'carom', '-s', '1', '-e', '5', '--pot', 'red']) != 0
    assert 'on a table with pockets' in capsys.readouterr().err
