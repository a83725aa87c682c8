"""A machine that finds its table: intervals that hold, correction of shots, refusals."""

from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import predict, Scene, Status, Stroke
from billiard_shot.calibration.csv_file import write_csv
from billiard_shot.calibration.machine import decided, NEEDED, Strike, stroke_in
from billiard_shot.calibration.machine_strokes import Recorded, Told
from billiard_shot.calibration.recording import Frame, RecordedShot, Recording, Track
from billiard_shot.calibration.watched import watch
from billiard_shot.cli import main
from billiard_shot.cli.exit_codes import DONE, WRONG_INPUT
from billiard_shot.cue.alignment import Alignment
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.numerics.angles import wrapped
from billiard_shot.scene import Noise

SCENE = Scene.load('robot_table')
RADIUS = SCENE.ball.radius
HIDDEN = Alignment(0.003, -0.003, 0.5, -0.003, 0.003, 0.96, 0.0, 1.0, 0.2)
ROBOT = Noise(a=2e-4, b=2e-4, elevation_deg=0.05, azimuth_deg=0.05, speed=0.02)
SIGMA, RATE = 5e-4, 30.0  # m and 1/s, of the camera


def strikes_at(draw, count):
    """Places of the cue ball and strokes as the encoders say, all over the table."""
    half = np.array([SCENE.table.length, SCENE.table.width]) / 2 - 4 * RADIUS
    for _ in range(count):
        numbers = *draw.uniform(-0.25, 0.25, 2), draw.choice([0.09, 0.2, 0.35, 0.5])
        direction, speed = draw.uniform(-math.pi, math.pi), draw.choice([1.0, 1.7, 2.5, 3.2])
        yield draw.uniform(-half, half), Stroke.from_offsets(*numbers, direction, speed)


def recorded_at(place, stroke):
    """Strike whose ball was seen to lie at a place, and to roll along."""
    times = np.arange(-5, 6) / RATE
    seen = place + np.maximum(times, 0.0)[:, np.newaxis]
    track = Track(times, seen, np.full(len(times), 1e-6))
    return Recorded(Frame(), watch(RecordedShot('', {'cue': track})), stroke)


def told_strikes(draw, count, alignment, one_direction=False):
    """Strikes that tell their strokes up to an error, without tracks."""
    sigma = np.array([0.01, 0.05, 0.02, 3e-3, 0.02])
    for place, stroke in strikes_at(draw, count):
        if one_direction:
            stroke = Stroke.from_offsets(*stroke.offsets[:2], 0.02, 0.3, stroke.speed)
        recorded = recorded_at(place, stroke)
        played = stroke_in(recorded, alignment, SCENE)
        played = played + ROBOT.sigmas(RADIUS) * draw.standard_normal(5)
        found, information = played + sigma * draw.standard_normal(5), np.diag(sigma**-2)
        row = np.append(found, np.zeros(3))
        yield Strike(recorded, Told(row, information, information @ found))


def test_intervals_of_twenty_cells_hold_the_truth():
    draw, held = np.random.default_rng(1), []
    for _ in range(20):
        found = decided(SCENE, list(told_strikes(draw, 20, HIDDEN)))
        truth = np.array([getattr(HIDDEN, name) for name in found.names])
        held += (np.abs(found.values - truth) <= found.reach).tolist()
        assert set(NEEDED) <= set(found.names)
    assert np.mean(held) > 0.9


def test_the_robots_errors_are_found_beside_those_of_the_tracks():
    strikes = list(told_strikes(np.random.default_rng(2), 100, HIDDEN))
    found = np.sqrt(decided(SCENE, strikes).variances)
    assert found[[0, 4]] == pytest.approx(ROBOT.sigmas(RADIUS)[[0, 4]], rel=0.3)


def test_strikes_in_one_direction_do_not_decide_where_the_machine_stands():
    strikes = list(told_strikes(np.random.default_rng(3), 20, HIDDEN, one_direction=True))
    with pytest.raises(ValueError, match=r'strikes must decide machine_x.* only to .* m.*direct'):
        decided(SCENE, strikes)


def cell(draw, count, alignment):
    """Record strikes of a robot whose tip is not where its encoders say."""
    times = np.arange(-20, 48) / RATE
    half = np.array([SCENE.table.length, SCENE.table.width]) / 2
    for number, (place, stroke) in enumerate(strikes_at(draw, count)):
        played = stroke_in(recorded_at(place, stroke), alignment, SCENE)
        played[3] = wrapped(played[3])
        real = ROBOT.perturb(Stroke.from_offsets(*played.tolist()), draw, RADIUS)
        shot = predict(replace(SCENE, balls={'cue': tuple(place.tolist())}), real)
        assert shot.status == Status.OK
        path = shot.trajectory
        seen = np.array([path.at(t).position[:2] if t > 0 else place for t in times])
        lost = np.cumsum((np.abs(seen) > half).any(axis=1)) > 0
        seen = (seen + draw.normal(0.0, SIGMA, seen.shape))[~lost]
        track = Track(1.0 + times[~lost], seen, np.full(len(seen), SIGMA))
        yield RecordedShot(str(number), {'cue': track}, 'cue', stroke)


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp('cell') / 'strikes.csv'
    shots = tuple(cell(np.random.default_rng(4), 14, HIDDEN))
    write_csv(Recording('cell', shots), path)
    strokes = [f'  {each.name!r}: {each.stroke.in_degrees()}' for each in shots]
    path.with_suffix('.yaml').write_text('\n'.join(['struck: cue', 'strokes:', *strokes]))
    return path


def test_the_command_finds_the_offsets_of_a_cell(recording, tmp_path, capsys):
    machine, scene = tmp_path / 'machine.yaml', tmp_path / 'mine.yaml'
    words = ['calibrate', 'machine', str(recording), '--scene', 'robot_table']
    assert main([*words, '-o', str(machine), '--errors', str(scene)]) == DONE
    found = Mechanism.load(machine).alignment
    assert found.machine_x == pytest.approx(HIDDEN.machine_x, abs=6e-4)
    assert found.machine_y == pytest.approx(HIDDEN.machine_y, abs=6e-4)
    assert found.machine_angle_deg == pytest.approx(0.5, abs=0.06)
    assert found.tip_right == pytest.approx(HIDDEN.tip_right, abs=5e-4)
    assert found.speed_scale == pytest.approx(0.96, abs=0.03)
    assert Scene.load(scene).noise.a == pytest.approx(ROBOT.a, rel=1.0)
    out = capsys.readouterr().out
    after, before = (float(out.split(text)[1].split()[0]) for text in ('median ', 'alignment: '))
    assert after < 0.3 * before  # of strikes that were held out
    assert 'The reach is not sought' in machine.read_text()


def test_too_few_strikes_are_refused(recording, tmp_path, capsys):
    path = tmp_path / 'few.csv'
    lines = recording.read_text().splitlines()
    path.write_text('\n'.join(line for line in lines if line[:2] in ('sh', '0,', '1,')))
    assert main(['calibrate', 'machine', str(path), '--scene', 'robot_table']) == WRONG_INPUT
    assert 'at least 10 strikes with strokes, got 0' in capsys.readouterr().err
