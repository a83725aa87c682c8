"""What accuracy costs in a scene: errors stay within the tolerance."""

import json

import pytest

from billiard_shot import Scene
from billiard_shot.cli import main
from billiard_shot.study import study_accuracy


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


@pytest.mark.parametrize(
    ('words', 'text'),
    [
        (['papre'], 'scene must be one of '),
        (['--count', '0'], '--count must be a whole number, at least 1'),
    ],
)
def test_wrong_input(words, text, capsys):
    assert main(['study', 'accuracy', *words]) == 2
    assert text in capsys.readouterr().err
