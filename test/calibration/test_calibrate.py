"""Calibrations of simulated recordings: what is found, how surely, and what is left alone."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
import json
import re

import numpy as np
import pytest
from simulated import simulated_recording

from billiard_shot import Scene
from billiard_shot.calibration.calibrate import calibrate
from billiard_shot.calibration.fit import FitProblem, sought_in
from billiard_shot.calibration.launch import calibration_model
from billiard_shot.calibration.reader import read_recording, write_csv
from billiard_shot.calibration.recording import Frame, Recording
from billiard_shot.calibration.result import quantiles, USUAL_NAMES
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, WRONG_INPUT

CAROM = Scene.load('carom')
FEW = {
    'cloth.sliding_friction': 0.23,
    'table.cushion.restitution': 0.85,
    'table.cushion.friction': 0.22,
}
FRAME = Frame(0.004, -0.004, 0.001)
SAID = []  # by the calibration of the fixture
pytestmark = pytest.mark.xdist_group('calibrate')  # one fit, by one worker


def recorded(numbers, shots, seed, **options):
    """Shots of a table whose numbers and frame are not those that are known of it."""
    scene = replace(CAROM, balls={}).with_parameters(list(numbers), list(numbers.values()))
    return replace(simulated_recording(scene, shots, seed, frame=FRAME, **options), frame=Frame())


@pytest.fixture(scope='module')
def few():
    return recorded(FEW, 7, 4, longest=2.0)


@pytest.fixture(scope='module')
def found(few):
    options = {'names': list(FEW), 'horizon': 1.5, 'held_out': 0.15, 'progress': SAID.append}
    with ThreadPoolExecutor(2) as executor:
        return calibrate(few, CAROM, executor=executor, **options)


def truth(numbers):
    return {**numbers, 'frame.x': FRAME.x, 'frame.y': FRAME.y, 'frame.angle': FRAME.angle}


def test_the_truth_of_a_simulated_table_is_found_within_the_intervals(found):
    assert found.converged
    assert [each.name for each in found.estimates] == list(truth(FEW))
    for each in found.estimates:
        low, high = each.interval
        assert low <= truth(FEW)[each.name] <= high, each
        assert low < each.value < high
        assert each.name == 'frame.angle' or not low <= each.before <= high  # the shots tell it
        assert set(each.shots) <= set(found.fitted)
    assert dict(found.scene.balls) == dict(CAROM.balls)
    (number,) = found.scene.parameters(['table.cushion.friction'])
    assert number.value == found.estimates[2].value


def test_shots_that_were_held_out_are_predicted_better_than_before(found, few):
    names = {each.samples.name for each in found.checks}
    assert len(names) == 1
    assert names.isdisjoint(found.fitted)
    assert len(names) + len(found.fitted) == len(few.shots)
    assert quantiles(found.checks)[0, 1] < 3e-3  # over the first second; the noise is 1.4 mm
    assert quantiles(found.checks)[0, 1] < 0.7 * quantiles(found.checks_before)[0, 1]


def test_a_shot_is_predicted_from_its_first_samples(found, few):
    shot = next(each for each in few.shots if each.name == found.checks[0].samples.name)
    seen, all_of_it = found.predict(shot, seen=0.5), found.predict(shot)
    assert seen.rmse(0.5) < 3e-3
    assert seen.rmse() > all_of_it.rmse()
    first = found.predict(shot, seen=0.3)
    assert first.rmse(0.3) < 3e-3
    assert np.array_equal(first.places, found.predict(shot, seen=0.3).places)
    assert len(seen.errors) == len(all_of_it.errors) == len(seen.times)


def test_progress_goes_to_the_end(found):
    assert found.estimates
    assert SAID[-1].done == SAID[-1].total
    assert [each.done for each in SAID] == sorted(each.done for each in SAID)
    assert any('median error' in each.text for each in SAID)


def test_what_the_shots_do_not_decide_keeps_its_value(tmp_path):
    """Balls that stop before they meet anything say nothing of balls and cushions."""
    slow = recorded({}, 6, 2, longest=1.0)
    shots = [
        replace(shot, tracks={name: shot.tracks[name] for name in ('white',)})
        for shot in slow.shots
    ]
    result = calibrate(
        replace(slow, shots=tuple(shots)),
        CAROM,
        names=['cloth.sliding_friction', 'contacts.ball_ball.restitution'],
        horizon=0.3,
        held_out=0.0,
    )
    balls = next(each for each in result.estimates if 'ball_ball' in each.name)
    assert (balls.interval, balls.value, balls.shots) == (None, 0.95, ())
    result.save(tmp_path / 'mine.yaml')
    text = (tmp_path / 'mine.yaml').read_text()
    assert '# not identifiable from these shots: default kept\n    restitution: 0.95' in text


def test_shots_that_keep_a_fit_from_converging_are_named(found):
    assert found.doubts == ()
    assert found.state == 'converged'
    failed = replace(found, doubts=('unsettled: shots 3, 5',))
    assert failed.state.endswith('do not rely on values and intervals; unsettled: shots 3, 5')
    assert not failed.converged
    assert 'NOT converged' in repr(failed)


def test_a_number_that_acts_by_its_square_is_fitted_as_its_square():
    """At 0, the scene does not depend on fading itself, and a fit would stay there."""
    scene = replace(CAROM, balls={}).with_parameters(['table.cushion.fading'], [0.2])
    (fading, *_) = sought = sought_in(scene, [Recording('none', ())], ['table.cushion.fading'])
    assert fading.start == pytest.approx(0.04)
    assert fading.stated(fading.start) == pytest.approx(0.2)
    problem = FitProblem(calibration_model(scene, [Recording('none', ())]), sought, 1.0, map)
    found = problem.model_at(problem.start + np.array([0.05, 0.0, 0.0, 0.0]))
    assert found.scene.table.cushion.fading == pytest.approx(0.3)


def test_the_scene_file_loads_and_says_what_is_known(found, tmp_path):
    path = tmp_path / 'mine.yaml'
    found.save(path)
    assert Scene.load(path) == found.scene
    lines = path.read_text().splitlines()
    row = lines.index(f'    friction: {found.estimates[2].value}')
    assert '95 %: 0.2' in lines[row - 1]
    assert 'before: 0.27; decided by shots ' in lines[row - 1]
    assert lines[0].startswith('# Fitted to 6 shots of simulated: converged')


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        ({'held_out': 1.0}, 'held_out must be a number from 0 to 0.9, got 1.0'),
        ({'held_out': 0.9}, 'at least 5 usable shots beside those held out, got 1'),
        ({'horizon': 0.0}, 'horizon must be finite and above 0'),
        ({'seed': -1}, 'seed must be a whole number, at least 0'),
        ({'names': ['cloth.friction']}, 'cloth.friction is unknown'),
        ({'scene': None}, 'scene is missing: simulated has no description'),
    ],
)
def test_requests_that_make_no_sense_are_refused(few, change, said):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (looked at below)
        calibrate(few, **{'scene': CAROM, **change})
    assert said in str(caught.value)


def test_places_of_another_unit_are_refused(few):
    """Lengths in feet leave the table."""

    def in_feet(track):
        return replace(track, place=3.28 * track.place)

    shots = [
        replace(shot, tracks={name: in_feet(each) for name, each in shot.tracks.items()})
        for shot in few.shots
    ]
    with pytest.raises(ValueError, match=r'feet: .* of the places are outside of the table'):
        calibrate(Recording('feet', tuple(shots)), CAROM)


@pytest.mark.slow
def test_all_usual_numbers_are_found_from_eight_shots():
    draw = np.random.default_rng(2)
    low = [0.15, 0.0035, 0.0, 4.0, 0.92, 0.005, 0.04, 0.84, 0.18, 0.0, 0.0, 0.5, 2.835, 1.415]
    high = [0.25, 0.008, 0.002, 11.0, 0.98, 0.06, 0.14, 0.94, 0.28, 0.05, 0.1, 0.8, 2.845, 1.425]
    numbers = dict(zip(USUAL_NAMES, draw.uniform(low, high).tolist(), strict=True))
    result = calibrate(recorded(numbers, 8, 2), CAROM, horizon=3.0, held_out=0.0)
    assert result.converged
    covered = [
        each.interval is None or each.interval[0] <= truth(numbers)[each.name] <= each.interval[1]
        for each in result.estimates
    ]
    assert sum(covered) >= len(covered) - 2  # 95 % intervals of numbers that depend on each other
    known = {each.name: each for each in result.estimates}
    for name in (
        'cloth.sliding_friction',
        'cloth.rolling_resistance',
        'table.cushion.restitution',
    ):
        assert known[name].value == pytest.approx(numbers[name], rel=0.02)


# --- the commands that calibrate, and the report -------------------------------------------------

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
    assert capsys.readouterr().out == f'1 shot in {written}\n'
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
