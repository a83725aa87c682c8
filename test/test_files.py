"""Commands do not write what they read, and write files of the kind that they say."""

import pytest

from billiard_shot.cli import main
from billiard_shot.cli.output import WRONG_INPUT

RECORDING = 'shot,time,ball,x,y\n1,0,cue,0,0\n'
STROKES = 'speed,measured_speed\n' + '1,1.1\n' * 6
SCENE = 'like: pool_table\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (
        ('shots.csv', RECORDING),
        ('shots.yaml', 'scene: carom\n'),
        ('strokes.csv', STROKES),
        ('own.yaml', SCENE),
    ):
        (tmp_path / name).write_text(text)
    (tmp_path / 'link.yaml').symlink_to('own.yaml')
    return tmp_path


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        ('calibrate table shots.csv -o shots.csv', '--output must be a file .yaml or .yml'),
        ('calibrate table shots.csv -o shots.yaml', 'than the description that RECORDING reads'),
        ('calibrate errors strokes.csv -o strokes.csv', '--output must be a file .yaml or .yml'),
        ('calibrate errors strokes.csv --scene own.yaml -o own.yaml', 'file than --scene reads'),
        ('calibrate errors strokes.csv --scene own.yaml -o link.yaml', 'file than --scene reads'),
        ('calibrate errors strokes.csv --scene own.yaml -o ./own.yaml', 'than --scene reads'),
        ('calibrate convert shots.csv -o shots.csv', 'another file than FILE reads'),
        (
            'calibrate machine shots.csv --scene own.yaml -o a.yaml --errors a.yaml',
            '--output writes',
        ),
        ('predict own.yaml --speed 1 -o own.yaml', '--output must be a file .json'),
        ('predict own.yaml --speed 1 -o own.txt', '--output must be a file .json, got own.txt'),
    ],
)
def test_an_input_is_not_overwritten(words, said, folder, capsys):
    before = {path: path.read_text() for path in folder.iterdir()}
    assert main(words.split()) == WRONG_INPUT
    assert said in capsys.readouterr().err
    assert {path: path.read_text() for path in folder.iterdir()} == before


def test_another_file_beside_the_input_is_written(folder):
    assert (
        main(['calibrate', 'errors', 'strokes.csv', '--scene', 'own.yaml', '-o', 'new.yaml']) == 0
    )
    assert (folder / 'new.yaml').exists()
    assert (folder / 'own.yaml').read_text() == SCENE
