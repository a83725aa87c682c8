"""Aiming: the ball goes where the cut says, into the pocket, and the cue ball along the line."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from billiard_shot import aim, lowest_elevation, predict, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.shot.lowest_elevation import refusals_in
from billiard_shot.shot.stroke import vectors_of

PLAIN = {'ball_ball': {'restitution': 1.0, 'friction_fast': 0, 'friction_slow': 0}}
TABLE = Scene.from_dict(
    {'like': 'pool_table', 'contacts': PLAIN, 'balls': {'cue': [-0.4, 0.1], '8': [0.2, 0.3]}}
)


def heading(vector):
    return math.degrees(math.atan2(vector[1], vector[0]))


@pytest.mark.parametrize('cut', [-75.0, -30.0, 0.0, 10.0, 60.0, 85.0])
def test_the_ball_leaves_at_the_cut_angle(cut):
    """Balls without friction: the ball goes along the line of centres. Positive is right."""
    stroke = aim(TABLE, '8', speed=2.0, cut_deg=cut)
    shot = predict(TABLE, stroke)
    assert shot.first_contact == '8'
    met = next(event for event in shot.events if '8' in event.balls)
    line = heading(shot.run.at(met.time)['8'].velocity)
    assert heading(stroke.velocity) - line == pytest.approx(cut, abs=0.05)
    assert aim(TABLE, '8', speed=2.0, cut=math.radians(cut)) == stroke


@pytest.mark.parametrize(
    ('pocket', 'place'),
    [('foot_left', (0.6, 0.0)), ('foot_right', (0.6, 0.0)), ('side_left', (0.1, 0.2))],
)
def test_the_pocket_is_reached(pocket, place):
    scene = dataclasses.replace(TABLE, balls={'cue': (-0.4, -0.2), '8': place})
    shot = predict(scene, aim(scene, '8', speed=2.0, pocket=pocket, b=-0.2))
    assert shot.pocketed['8'] == pocket


def test_squirt_is_corrected_on_request():
    place = (0.6, -0.3)
    line = heading(np.subtract(place, TABLE.cue_ball[:2]))
    plain = aim(TABLE, place, speed=2.0, a=0.4)
    assert heading(plain.velocity) == pytest.approx(line)
    assert abs(heading(predict(TABLE, plain).velocity) - line) > 1.0
    turned = aim(TABLE, place, speed=2.0, a=0.4, correct_squirt=True)
    assert heading(predict(TABLE, turned).velocity) == pytest.approx(line, abs=1e-6)


def test_the_cue_is_as_low_as_it_can_be():
    scene = dataclasses.replace(TABLE, balls={'cue': (-1.2, 0.0), '8': (0.2, 0.0)})
    stroke = aim(scene, '8', speed=1.0, margin=0.0)
    assert not predict(scene, stroke).status.refused
    _, _, elevation, azimuth, _ = stroke.offsets
    lower = Stroke.from_offsets(0.0, 0.0, elevation - math.radians(0.26), azimuth, 1.0)
    assert predict(scene, lower).status.refused
    assert aim(scene, '8', speed=1.0, elevation_deg=20).offsets[2] == pytest.approx(
        math.radians(20)
    )


@pytest.mark.parametrize('margin_deg', [0.0, 0.6, 3.0])
def test_the_cue_can_be_lower_by_the_margin(margin_deg):
    stroke = aim(TABLE, '8', speed=1.0, margin_deg=margin_deg)
    assert stroke == aim(TABLE, '8', speed=1.0, margin=math.radians(margin_deg))
    elevation = stroke.offsets[2]
    lowest = lowest_elevation(TABLE, [stroke.offsets])[0]
    assert abs(math.degrees(elevation - lowest) - margin_deg) < 0.051
    level = aim('pool', (1.0, 0.0), speed=1.0, margin_deg=margin_deg).offsets[2]
    assert math.degrees(level) == pytest.approx(margin_deg)  # it does not point up


@pytest.mark.parametrize('balls', [1, 6])
def test_a_player_with_errors_has_room(balls):
    """Of 10,000 strokes with errors fewer than 50 are refused; without a margin, 2000."""
    draw = np.random.default_rng(4)
    half = 0.5 * np.array([TABLE.table.length, TABLE.table.width]) - 1.1 * TABLE.ball.radius
    refused = {None: 0, 0.0: 0}
    for _ in range(100):
        places = draw.uniform(-half, half, (1 + balls, 2))
        while pdist(places).min() < 2.1 * TABLE.ball.radius:
            places = draw.uniform(-half, half, (1 + balls, 2))
        names = ['cue', *map(str, range(1, 1 + balls))]
        scene = dataclasses.replace(TABLE, balls=dict(zip(names, places.tolist(), strict=True)))
        a, b = draw.uniform(-0.3, 0.3, 2)
        for margin in refused:
            stroke = aim(scene, '1', speed=2.0, a=a, b=b, margin=margin)
            played = vectors_of(scene.noise.sample(stroke, 100, draw))
            refused[margin] += np.count_nonzero(refusals_in(scene, *played))
    assert refused[0.0] > 1500
    assert refused[None] < 50


@pytest.mark.parametrize(
    ('target', 'options', 'text'),
    [
        ('9', {}, "target must be one of 8, got '9'"),
        ('8', {'cut_deg': 90}, r'cut must be .*, got 90 \(degrees\)'),
        ('8', {'cut_deg': 95}, 'cut_deg must be .*, got 95'),
        (
            '8',
            {'pocket': 'head_left'},
            'pocket must be one that ball .8. reaches .*, got head_left',
        ),
        ('8', {'pocket': 'left'}, "pocket must be one of foot_left, .*, got 'left'"),
        ('8', {'pocket': 'foot_left', 'cut': 0.1}, 'pocket must not be given together with a cut'),
        ((0.1, 0.2), {'pocket': 'foot_left'}, 'pocket must not be given for a point'),
        ((0.1, 0.2), {'cut': 0.1}, 'cut must not be given for a point'),
        ((-0.4, 0.1), {}, r'target must be a point other than .*, got \(-0.4, 0.1\)'),
        ((0.1, math.nan), {}, r'target must .*, got nan'),
        ('8', {'margin_deg': 95}, 'margin_deg must be 0 to 90, got 95'),
        ('8', {'margin': -0.1}, 'margin must be 0 to 1.571, got -0.1'),
        ('8', {'margin': 0.1, 'elevation': 0.1}, 'margin must not be given together with'),
    ],
)
def test_what_cannot_be_aimed_at(target, options, text):
    with pytest.raises(ValueError, match=text):
        aim(TABLE, target, speed=2.0, **options)


def test_commands_aim(capsys, tmp_path):
    (tmp_path / 'cut.yaml').write_text(
        "like: pool_table\nballs: {cue: [0.4, 0.1], '8': [0.9, 0.265]}\n"
    )
    scene = str(tmp_path / 'cut.yaml')
    assert main(['predict', scene, '--aim', '8', '--pocket', 'foot_left', '-s', '2']) == 0
    assert '8 into foot left' in capsys.readouterr().out
    assert main(['predict', scene, '--aim', '8', '--cut', '20', '--pot', '8', '-s', '2']) == 0
    assert 'missed          8 beside' in capsys.readouterr().out
    assert main(['predict', scene, '--aim', '-0.5', '0.2', '-s', '2']) == 0
    assert 'azimuth 173.66°' in capsys.readouterr().out
    for wrong, text in (
        (['--aim', '8'], '--speed is missing'),
        (['--aim', '8', '-s', '2', '-z', '3'], '--aim must not be given together with --azimuth'),
        (['--aim', 'x', 'y', '-s', '2'], '--aim must be a ball, or X Y, got x y'),
        (['--cut', '3', '-s', '2'], '--cut needs --aim BALL'),
        (['--aim', '9', '-s', '2'], '--aim must be a ball, or X Y, got 9 (m); the balls are: 8'),
        (['--aim', '0.1', '-s', '2'], 'or X Y, got 0.1 (m)'),
        (['--aim', '8', '--cut', '95', '-s', '2'], '--cut must be -90 to 90, got 95.0 (degrees)'),
        (['--aim', '1', '0', '--cut', '0', '-s', '2'], '--cut must not be given for a point'),
    ):
        assert main(['predict', scene, *wrong]) == 2
        assert text in capsys.readouterr().err
