"""What tolerances cost: errors stay within them, and a plan is judged alike by all."""

import json

from billiard_shot.cli import main
from billiard_shot.study.tolerances import study_tolerances


def test_errors_fall_with_the_tolerance_and_stay_within():
    coarse, fine = study_tolerances((1e-2, 1e-6), shots=10, judged=100, repeats=1)
    for each in (coarse, fine):
        assert each.typical_error <= each.tolerance
        assert each.largest_error <= 2.0 * each.tolerance  # cushions met in the air enlarge errors
        assert min(each.strike, each.shot, each.opening, each.plan) > 0.0
    assert fine.largest_error < 1e-3 * coarse.largest_error
    assert 0.5 < fine.success <= 1.0
    assert abs(fine.success - coarse.success) <= 0.05


def test_the_command_prints_a_line_for_each_tolerance(capsys, tmp_path):
    picture = tmp_path / 'tolerance.png'
    assert main(['study', 'tolerance', '--count', '3', '--json', '--picture', str(picture)]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row['tolerance'] for row in rows] == [10.0**-n for n in range(2, 10)]
    assert picture.read_bytes().startswith(b'\x89PNG')
