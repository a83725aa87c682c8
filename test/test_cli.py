import json
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.cli import main

PAPER = Path(__file__).parents[1] / 'config' / 'strokes' / 'paper.yaml'


def test_json_is_what_predict_gives(capsys):
    assert main(['predict', '--scene', 'paper', '--strokes', str(PAPER), '--json']) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line['stroke'] for line in lines] == ['vertical', 'horizontal', 'jump', 'massé']
    shot = predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16)))
    assert lines[3]['velocity'] == shot.velocity.tolist()
    assert lines[3]['spin'] == shot.spin.tolist()
    assert lines[3]['rest'] == shot.trajectory.final_position.tolist()
    assert lines[3]['status'] == shot.status.name
    assert np.shape(lines[3]['dissipated']) == (2, 2)


def test_table(capsys):
    assert main(['predict', '--a', '0.2', '--elevation-deg', '10', '--speed', '1.5']) == 0
    head, units, row = capsys.readouterr().out.splitlines()
    assert head.split()[:2] == ['stroke', 'status']
    assert '(m/s)' in units
    assert row.split()[:2] == ['1', 'OK']


def test_vectors_on_the_command_line(capsys):
    arguments = ['predict', '--scene', 'paper', '--normal', '-1', '-2', '1']
    assert main([*arguments, '--velocity', '0', '0', '-2']) == 0
    assert '0.4291   0.8582   0.2831' in capsys.readouterr().out


def test_refused_strokes_are_said_on_stderr(capsys):
    assert main(['predict', '--a', '0.9', '--b', '0.9', '--speed', '1', '--json']) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)['status'] == 'MISS'
    assert 'stroke 1: MISS: a, b: (0.9, 0.9) is not allowed' in err


@pytest.mark.parametrize(
    ('arguments', 'text'),
    [
        ([], 'stroke: missing'),
        (['--speed', '-1'], 'speed: -1.0 is not allowed; it must be above 0 (m/s)'),
        (['--speed', 'nan'], 'speed: nan is not allowed'),
        (['--speed', '1', '--tolerance', '0'], 'tolerance: 0.0 is not allowed'),
        (['--speed', '1', '--scene', 'papre'], "no bundled scene 'papre'"),
        (['--speed', '1', '--strokes', 'x.yaml'], '--strokes: is not allowed together'),
        (['--strokes', 'x.yaml'], 'No such file'),
        (['--normal', '-1', '0', '0', '--a', '1'], 'must be those of one form'),
    ],
)
def test_wrong_input(capsys, arguments, text):
    assert main(['predict', *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('billiard-shot: ')
    assert text in err


def test_all_mistakes_of_a_file(tmp_path, capsys):
    path = tmp_path / 'strokes.yaml'
    path.write_text("""
- {name: good, a: 0.1, speed: 1}
- {name: typo, normal: [0, 0, 1], velocty: [0, 0, -1]}
- {name: zero, normal: [0, 0, 1], velocity: [0, 0, 0]}
- {name: pose, position: [-1, 0, 0.028575], quaternion: [0, 0, 0, 1], speed: 2}
- {name: angle, speed: 2, azimuth_deg: east}
- 7
""")
    assert main(['predict', '--strokes', str(path)]) == 2
    err = capsys.readouterr().err
    assert '4 wrong' in err
    assert 'stroke typo: velocty: unknown key; the nearest known one is velocity' in err
    assert 'stroke zero: velocity: [0, 0, 0] is not allowed' in err
    assert "stroke angle: azimuth_deg: 'east' is not allowed" in err
    assert 'stroke 6: 7 is not allowed; it must be a mapping' in err


def test_importing_the_package_is_light():
    heavy = 'numba', 'numpy', 'scipy', 'matplotlib', 'yaml'
    code = f'import sys, billiard_shot; print([m for m in {heavy} if m in sys.modules])'
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_public_names_exist():
    import billiard_shot

    assert all(getattr(billiard_shot, name) for name in billiard_shot.__all__)
    assert set(billiard_shot.__all__) <= set(dir(billiard_shot))
    with pytest.raises(AttributeError, match="no attribute 'predictt'"):
        _ = billiard_shot.predictt


def test_pictures_of_strokes(tmp_path, capsys):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    options = ['predict', '--scene', 'paper', '--strokes', str(PAPER)]
    assert main([*options, '--picture', str(tmp_path / 'paper.png')]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f'paper-{name}.png' for name in ('horizontal', 'jump', 'massé', 'vertical')
    ]
    assert main(['predict', '--speed', '1', '--picture', str(tmp_path / 'one.png')]) == 0
    assert (tmp_path / 'one.png').stat().st_size > 10_000
    capsys.readouterr()


def test_a_recorded_shot_is_shown_as_it_was(tmp_path, capsys):
    file = tmp_path / 'shot.json'
    stroke = ['predict', '--scene', 'nine_ball', '--elevation-deg', '5', '--speed', '4']
    assert main([*stroke, '--json', '--output', str(file)]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main(['predict', str(file), '--json']) == 0
    again = json.loads(capsys.readouterr().out)
    assert again == {**first, 'stroke': 'shot'}
    assert main(['predict', str(PAPER), '--scene', 'paper', '--save', str(file)]) == 0
    assert {path.name for path in tmp_path.iterdir()} > {'shot-jump.json', 'shot-massé.json'}
    capsys.readouterr()


@pytest.mark.parametrize(
    ('arguments', 'text'),
    [
        (['none.json'], 'none.json: '),
        (['x.json', '--speed', '1'], 'SHOT: x.json is not allowed together with a stroke'),
        (['x.json', '--scene', 'pool'], '--scene: is not allowed together with a recorded shot'),
        (
            ['x.json', '--tolerance', '1'],
            '--tolerance: is not allowed together with a recorded shot',
        ),
    ],
)
def test_wrong_recorded_shots(capsys, arguments, text):
    assert main(['predict', *arguments]) == 2
    assert text in capsys.readouterr().err
