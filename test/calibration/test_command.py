"""The commands that calibrate, and the report."""

import json
import re

import pytest
from simulated import simulated_recording

from billiard_shot import Scene
from billiard_shot.calibration.reader import read_recording, write_csv
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, WRONG_INPUT

JSON = '[{"id": 3, "balls": {"1": {"t": [0, 0.02, 0.04], "x": [0, 0.02, 0.04], "y": [0, 0, 0]}}}]'


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp('recording') / 'seen.csv'
    shots = simulated_recording(Scene.load('carom'), 7, 4, longest=1.5)
    write_csv(shots, path)
    path.with_suffix('.yaml').write_text('scene: carom')
    return path


def test_a_table_is_calibrated_and_reported(recording, tmp_path, capsys):
    scene, page = tmp_path / 'mine.yaml', tmp_path / 'mine.html'
    options = ['--output', str(scene), '--report', str(page), '--held-out', '0.25']
    words = ['calibrate', 'table', str(recording), *options, '--workers', '1', '--horizon', '0.8']
    code = main([*words, '--fit', 'cloth.sliding_friction', '--json'])
    out, err = capsys.readouterr()
    rows = [json.loads(line) for line in out.splitlines()]
    assert [row['name'] for row in rows] == [
        'cloth.sliding_friction',
        'frame.x',
        'frame.y',
        'frame.angle',
    ]
    assert (code, err) == (DONE, '')
    assert rows[0]['low'] < Scene.load('carom').cloth.sliding_friction < rows[0]['high']
    assert Scene.load(scene).cloth.sliding_friction == rows[0]['value']
    text = page.read_text()
    assert text.count('<svg') == 3 + 3 + sum(row['low'] is not None for row in rows)
    assert '<td>cloth.sliding_friction</td>' in text
    assert 'best 10 %' in text
    assert 'http' not in text.replace('http-equiv', '')  # nothing is loaded from elsewhere
    assert 'nan' not in re.sub('[a-z]*nan[a-z]+', '', text.lower())


def test_a_recording_is_converted(tmp_path, capsys):
    given, written = tmp_path / 'shots.json', tmp_path / 'shots.csv'
    given.write_text(JSON)
    assert main(['calibrate', 'convert', str(given), '-o', str(written)]) == DONE
    assert capsys.readouterr().out == f'1 shots in {written}\n'
    (shot,) = read_recording(written).shots
    assert shot.tracks['1'].place[:, 0].tolist() == [0.0, 0.02, 0.04]


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['none.csv'], 'none.csv: No such file'),
        (['none.csv', '--report', 'report.txt'], '--report must be a file .html'),
        (['none.csv', '--workers', '0'], '--workers must be a whole number, at least 1, got 0'),
    ],
)
def test_wrong_requests_are_refused(words, said, capsys):
    assert main(['calibrate', 'table', *words]) == WRONG_INPUT
    assert said in capsys.readouterr().err


def test_too_few_shots_are_refused_with_what_was_ignored(tmp_path, capsys):
    path = tmp_path / 'seen.csv'
    path.write_text('shot,time,ball,x,y\n1,0,cue,0,0\n')
    assert main(['calibrate', 'table', str(path), '--scene', 'carom']) == WRONG_INPUT
    err = capsys.readouterr().err
    assert 'at least 5 usable shots beside those held out, got 0' in err
    assert "shot '1': no ball moves" in err
