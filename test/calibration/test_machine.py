"""A machine that finds its table: intervals that hold, correction of shots, refusals."""

from contextlib import redirect_stdout
from dataclasses import fields, replace
import io
import math
import os

import numpy as np
import pytest

from billiard_shot import predict, predict_batch, Scene, shots, Status, Stroke, TableStates
from billiard_shot.calibration.machine import calibrate_machine, check_conventions, NEEDED
from billiard_shot.calibration.reader import read_recording, write_csv
from billiard_shot.calibration.recording import RecordedShot, Recording, samples_of, Track
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, WRONG_INPUT
from billiard_shot.cue.mechanism import Alignment, Mechanism
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene import Noise
from billiard_shot.scene.player import with_errors

SCENE = Scene.load('robot_table')
RADIUS = SCENE.ball.radius
HIDDEN = Alignment(0.003, -0.003, 0.5, -0.003, 0.003, 0.96, 0.0, 1.0, 0.2)
ROBOT = Noise(a=2e-4, b=2e-4, elevation_deg=0.05, azimuth_deg=0.05, speed=0.02)
NIGHTLY = 'NIGHTLY' in os.environ
SIGMA, RATE = 5e-4, 30.0  # m and 1/s, of the camera


def strikes_at(draw, count):
    """Places of the cue ball and strokes as the encoders say, all over the table."""
    half = np.array([SCENE.table.length, SCENE.table.width]) / 2 - 4 * RADIUS
    for _ in range(count):
        numbers = *draw.uniform(-0.25, 0.25, 2), draw.choice([0.09, 0.2, 0.35, 0.5])
        direction, speed = draw.uniform(-math.pi, math.pi), draw.choice([1.0, 1.7, 2.5, 3.2])
        yield draw.uniform(-half, half), Stroke.from_offsets(*numbers, direction, speed)


def cell(draw, count, alignment, direction=None):
    """Record strikes of a robot whose tip is not where its encoders say."""
    times = np.arange(-20, 48) / RATE
    half = np.array([SCENE.table.length, SCENE.table.width]) / 2
    for number, (place, stroke) in enumerate(strikes_at(draw, count)):
        if direction is not None:
            stroke = Stroke.from_offsets(*stroke.offsets[:2], 0.09, direction, stroke.speed)
        tip = Stroke.from_offsets(*played(alignment, np.array(stroke.offsets), place).tolist())
        real = ROBOT.perturb(tip, draw, RADIUS)
        shot = predict(replace(SCENE, balls={'cue': tuple(place.tolist())}), real)
        assert shot.status == Status.OK
        path = shot.trajectory
        seen = np.array([path.at(t).position[:2] if t > 0 else place for t in times])
        lost = np.cumsum((np.abs(seen) > half).any(axis=1)) > 0
        seen = (seen + draw.normal(0.0, SIGMA, seen.shape))[~lost]
        track = Track(1.0 + times[~lost], seen, np.full(len(seen), SIGMA))
        yield RecordedShot(str(number), {'cue': track}, 'cue', stroke)


@pytest.mark.slow
def test_intervals_of_cells_hold_the_truth():
    truth = {f'alignment.{name}': value for name, value in vars_of(HIDDEN)}
    truth |= {f'noise.{name}': value for name, value in vars_of(ROBOT)}
    held, known = [], set()
    for seed in range(6, 26 if NIGHTLY else 9):
        strikes = tuple(cell(np.random.default_rng(seed), 14, HIDDEN))
        for each in calibrate_machine(Recording('cell', strikes), SCENE).estimates:
            if each.interval is not None:
                low, high = each.interval
                held.append(low <= truth[each.name] <= high)
                known.add(each.name)
    assert np.mean(held) > 0.9
    assert {f'alignment.{name}' for name in NEEDED} < known
    assert {'noise.a', 'noise.speed'} < known


def vars_of(record):
    return [(each.name, getattr(record, each.name)) for each in fields(record)]


def test_strikes_in_one_direction_do_not_decide_where_the_machine_stands():
    strikes = tuple(cell(np.random.default_rng(3), 12, HIDDEN, direction=0.3))
    with pytest.raises(ValueError, match=r'strikes must decide machine_x.* only to .* m.*direct'):
        calibrate_machine(Recording('cell', strikes), SCENE)


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp('cell') / 'strikes.csv'
    seen = tuple(cell(np.random.default_rng(4), 14, HIDDEN))
    write_csv(Recording('cell', seen), path)
    strokes = [f'  {each.name!r}: {each.stroke.in_degrees()}' for each in seen]
    path.with_suffix('.yaml').write_text('\n'.join(['struck: cue', 'strokes:', *strokes]))
    return path


@pytest.fixture(scope='module')
def written(recording):
    """The files and the text that the command writes."""
    machine, scene = (recording.with_name(name) for name in ('machine.yaml', 'mine.yaml'))
    words = ['calibrate', 'machine', str(recording), '--scene', 'robot_table']
    out = io.StringIO()
    with redirect_stdout(out):
        assert main([*words, '-o', str(machine), '--errors', str(scene)]) == DONE
    return machine, scene, out.getvalue()


def test_the_command_finds_the_offsets_of_a_cell(written):
    machine, scene, out = written
    found = Mechanism.load(machine).alignment
    assert found.machine_x == pytest.approx(HIDDEN.machine_x, abs=6e-4)
    assert found.machine_y == pytest.approx(HIDDEN.machine_y, abs=6e-4)
    assert found.machine_angle_deg == pytest.approx(0.5, abs=0.06)
    assert found.tip_right == pytest.approx(HIDDEN.tip_right, abs=5e-4)
    assert found.speed_scale == pytest.approx(0.96, abs=0.03)
    assert Scene.load(scene).noise.a == pytest.approx(ROBOT.a, rel=1.0)
    after, before = (float(out.split(text)[1].split()[0]) for text in ('median ', 'alignment: '))
    assert after < 0.3 * before  # of strikes that were held out
    assert 'The reach is not sought' in machine.read_text()


def test_an_aligned_machine_pots_as_often_as_an_exact_one(written):
    draw, alignment = np.random.default_rng(5), Mechanism.load(written[0]).alignment
    pots, count = np.zeros(3), 0
    while count < 30:
        places = draw.uniform(-0.45, 0.45, (2, 2)) * (SCENE.table.length, SCENE.table.width)
        lying = np.append(places, np.full((2, 1), RADIUS), axis=1)
        direct = shots(SCENE, TableStates(('cue', '1'), lying[np.newaxis]), workers=1)
        if np.linalg.norm(places[0] - places[1]) < 4 * RADIUS or direct.best[0] < 0.5:
            continue
        planned = direct.offsets[direct.chance.argmax()]
        count += 1
        at = replace(
            SCENE, balls=dict(zip(('cue', '1'), map(tuple, places.tolist()), strict=True))
        )
        by_encoders = commanded(alignment, planned, places[0])
        told = [planned, *(played(HIDDEN, each, places[0]) for each in (by_encoders, planned))]
        errors = ROBOT.times(0.5).sigmas(RADIUS) * draw.standard_normal(5)
        fallen = predict_batch(at, offsets=with_errors(np.array(told), errors)).pocketed
        pots += ['1' in each for each in fallen]
    exact, aligned, skew = pots
    assert skew < 0.3 * exact
    assert aligned >= exact - 3


def played(alignment, stroke, place):
    """Stroke (5,) on the table of a stroke by the encoders."""
    by_encoders = Stroke.from_offsets(*stroke.tolist())
    found = stroke_on_table(alignment, by_encoders, tuple(place.tolist()), SCENE)
    found[3] = wrapped(found[3])
    return found


def commanded(alignment, planned, place):
    """Stroke (5,) by the encoders that is a planned one on the table, as fixed point."""
    stroke = planned.copy()
    for _ in range(5):
        away = planned - played(alignment, stroke, place)
        away[3] = wrapped(away[3])
        stroke = stroke + away
        stroke[2], stroke[3] = max(stroke[2], 0.0), wrapped(stroke[3])
    return stroke


def test_too_few_strikes_are_refused(recording, tmp_path, capsys):
    path = tmp_path / 'few.csv'
    lines = recording.read_text().splitlines()
    path.write_text('\n'.join(line for line in lines if line[:2] in ('sh', '0,', '1,')))
    assert main(['calibrate', 'machine', str(path), '--scene', 'robot_table']) == WRONG_INPUT
    assert 'at least 10 strikes with strokes, got 0' in capsys.readouterr().err


def by_mistake(tracks=lambda xy: xy, stroke=lambda stroke: stroke, count=12):
    """Velocities (count, 2) and strokes of an exact machine, recorded with a mistake."""
    times, velocities, strokes = np.arange(-5, 12) / RATE, [], []
    for place, planned in strikes_at(np.random.default_rng(8), count):
        path = predict(replace(SCENE, balls={'cue': tuple(place.tolist())}), planned).trajectory
        seen = np.array([path.at(t).position[:2] if t > 0 else place for t in times])
        track = Track(times, tracks(seen), np.full(len(times), 1e-6))
        velocities.append(samples_of(RecordedShot('', {'cue': track})).velocity)
        strokes.append(stroke(planned))
    return np.array(velocities), strokes


def turned(change):
    def changed(stroke):
        a, b, elevation, azimuth, speed = stroke.offsets
        return Stroke.from_offsets(a, b, elevation, change(azimuth), speed)

    return changed


def faster(factor):
    return lambda stroke: Stroke.from_offsets(*stroke.offsets[:4], factor * stroke.speed)


@pytest.mark.parametrize(
    ('mistake', 'words'),
    [
        ({'tracks': lambda xy: xy * (1, -1)}, 'y of the tracks .* mirrored'),
        ({'tracks': lambda xy: xy * (-1, 1)}, 'x of the tracks .* mirrored'),
        ({'tracks': lambda xy: xy[:, ::-1]}, 'x and y .* swapped'),
        ({'stroke': turned(math.radians)}, 'azimuths are in radians'),
        ({'stroke': turned(lambda azimuth: azimuth + math.pi)}, 'point backwards'),
        ({'stroke': faster(1e3)}, 'must be 0.1 to 2; are the units m, s and m/s'),
        ({'stroke': faster(1e-3)}, 'must be 0.1 to 2; are the units m, s and m/s'),
    ],
)
def test_usual_mistakes_in_recordings_are_named(mistake, words):
    check_conventions(*by_mistake())
    with pytest.raises(ValueError, match=words):
        check_conventions(*by_mistake(**mistake))


def turned_by(alignment, stroke, place):
    """Stroke as a driver with an alignment measures it, for what the encoders say."""
    return Stroke.from_offsets(*played(alignment, np.array(stroke.offsets), place).tolist())


def test_strikes_of_an_aligned_driver_give_the_whole_alignment(recording, tmp_path):
    """Before, they would have given what is left of it, in place of it."""
    first = replace(HIDDEN, elevation_bias_deg=0.0)
    seen = [
        replace(each, stroke=turned_by(first, each.stroke, place))
        for each in read_recording(recording).shots
        for place in [each.tracks['cue'].place[0]]
    ]
    again = calibrate_machine(Recording('cell', tuple(seen)), SCENE, first).alignment
    assert again.machine_x == pytest.approx(HIDDEN.machine_x, abs=6e-4)
    assert again.speed_scale == pytest.approx(0.96, abs=0.03)
