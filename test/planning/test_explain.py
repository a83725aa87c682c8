"""Why a shot misses: the causes add up, and each one is what it says."""

import dataclasses
import json
import math

import numpy as np
import pytest

from billiard_shot import aim, plan, predict, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.planning.result import deviation_of, why_missed

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
