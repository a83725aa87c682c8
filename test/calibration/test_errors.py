"""Errors of a player, from commanded and measured strokes."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, shots, Status, Stroke, TableStates
from billiard_shot.calibration.player import errors_of, most_likely_scale, Tried
from billiard_shot.calibration.reader import read_errors, write_csv
from billiard_shot.calibration.recording import RecordedShot, Recording, Track
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, WRONG_INPUT
from billiard_shot.scene import Bias, Noise
from billiard_shot.scene.player import IN_DEGREES

SCENE = Scene.load('pool')
BIAS = np.array([1e-3, -5e-4, 0.2, -0.1, 0.05])  # m, m, degrees, degrees, m/s
SIGMA = np.array([5e-4, 4e-4, 0.1, 0.125, 0.075])


def test_intervals_from_thirty_strokes_hold_the_truth_in_95_percent():
    draw = np.random.default_rng(1)
    truth = dict(zip([f'noise.bias.{name}' for name in IN_DEGREES], BIAS, strict=True))
    truth |= dict(zip([f'noise.{name}' for name in IN_DEGREES], SIGMA, strict=True))
    held = []
    for _ in range(2000):
        found = errors_of(SCENE, BIAS + SIGMA * draw.standard_normal((30, 5)))
        for each in found.estimates:
            low, high = each.interval
            held.append(low <= truth[each.name] <= high)
    shares = np.reshape(held, (-1, 10)).mean(axis=0)
    assert shares.min() > 0.93
    assert shares.max() < 0.97


def written(path, errors, names=IN_DEGREES):
    """Write strokes whose azimuth is near 180 degrees, so that measured ones pass it."""
    commanded = np.array([0.1, 0.2, 5.0, 179.95, 2.0])
    scale = np.array([1.0, 1.0, 1.0, 1.0, 1.0])
    scale[:2] = 1.0 / SCENE.ball.radius
    measured = commanded + scale * errors
    measured[:, 3] = (measured[:, 3] + 180.0) % 360.0 - 180.0
    columns = [IN_DEGREES.index(name) for name in names]
    lines = [','.join([*names, *(f'measured_{name}' for name in names)])]
    for row in measured:
        lines.append(','.join(map(repr, [*commanded[columns].tolist(), *row[columns].tolist()])))
    path.write_text('\n'.join(lines))


def test_the_command_writes_a_scene_that_holds_the_errors(tmp_path, capsys):
    strokes, scene = tmp_path / 'strokes.csv', tmp_path / 'mine.yaml'
    errors = BIAS + SIGMA * np.random.default_rng(2).standard_normal((40, 5))
    errors[:, 4] += 0.5 * errors[:, 2]  # faster if steeper
    written(strokes, errors)
    assert main(['calibrate', 'errors', str(strokes), '-o', str(scene)]) == DONE
    noise = Scene.load(scene).noise
    found = [[getattr(each, name) for name in IN_DEGREES] for each in (noise.bias, noise)]
    np.testing.assert_allclose(found, [errors.mean(axis=0), errors.std(axis=0, ddof=1)])
    said = 'elevation_deg and speed are correlated'
    assert said in capsys.readouterr().out
    assert said in scene.read_text()


def test_errors_that_were_not_measured_stay(tmp_path):
    strokes = tmp_path / 'strokes.csv'
    written(strokes, BIAS + SIGMA * np.random.default_rng(3).standard_normal((10, 5)), ['speed'])
    found = errors_of(SCENE, read_errors(strokes, SCENE.ball.radius))
    assert found.scene.noise.azimuth_deg == SCENE.noise.azimuth_deg
    assert [each.name for each in found.estimates if each.interval] == [
        'noise.bias.speed',
        'noise.speed',
    ]


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('speed\n1\n', 'line 1: speed needs the column measured_speed'),
        ('speed,measured_speed,force\n', 'line 1: force is unknown'),
        ('stroke\n1\n', 'a header must have columns such as speed,measured_speed'),
        (
            'speed,measured_speed\n1\n',
            'line 2: a line must be 2 fields, as in the header, got',
        ),
        ('speed,measured_speed\n1,x\n', 'line 2: measured_speed must be a number from 0 to 50'),
        ('a,measured_a\n0,3\n', 'line 2: measured_a must be a number from -1 to 1, got'),
        ('speed,measured_speed\n1,1\n', 'strokes must be at least 5, got 1'),
    ],
)
def test_files_that_make_no_sense_are_refused(text, said, tmp_path, capsys):
    path = tmp_path / 'strokes.csv'
    path.write_text(text)
    assert main(['calibrate', 'errors', str(path)]) == WRONG_INPUT
    assert said in capsys.readouterr().err


def test_a_player_with_a_bias_plays_the_planned_stroke_if_it_is_corrected():
    noise = Noise(bias=Bias(*BIAS.tolist()))
    planned = Stroke.from_offsets(0.1, 0.2, 0.1, 3.0, 2.0)
    commanded = noise.commanded(planned)
    away = np.array(planned.offsets) - commanded.offsets
    np.testing.assert_allclose(away[:2] * SCENE.ball.radius, BIAS[:2])
    np.testing.assert_allclose(np.degrees(away[2:4]), BIAS[2:4])
    assert away[4] == pytest.approx(BIAS[4])
    assert noise.times(2.0).bias == noise.bias
    assert Noise().commanded(planned) is planned


def test_no_correction_asks_for_a_stroke_that_cannot_be_played():
    noise = Noise(bias=Bias(elevation_deg=1.0, speed=1.0))
    commanded = noise.commanded(Stroke.from_offsets(speed=0.5))
    assert commanded.offsets[2] == 0.0
    assert commanded.speed == pytest.approx(1e-3)


# --- the scale of a player's errors, from watched shots whose intention is not known -------------

WATCHED = Scene.load('pool_table')
NAMES = 'cue', '1', '2', '3'
DEVIATION = 1e-3  # m, of a seen place
TIMES = np.arange(-15, 100) / 50.0  # s after the strike


def test_the_scale_of_a_hundred_shots_is_within_15_percent_and_its_interval_holds_it():
    draw, near, held = np.random.default_rng(1), [], []
    for _ in range(80):
        scale, tried = np.exp(draw.uniform(-0.7, 0.7)), []
        for number in range(100):
            count = draw.integers(1, 9)
            intended, sigma = draw.uniform(-1.5, 1.5, count), draw.uniform(2e-3, 4e-3, count)
            direction = intended[0] + scale * sigma[0] * draw.standard_normal()
            if number % 10 == 0:  # it was no direct shot
                direction = draw.uniform(-3.0, 3.0)
            tried.append(
                Tried(direction - intended, sigma, 1e-4 * sigma, np.full(count, 1 / count))
            )
        found, (low, high) = most_likely_scale(tried)
        near.append(abs(found / scale - 1.0) < 0.15)
        held.append(low <= scale <= high)
    assert np.mean(near) > 0.85
    assert np.mean(held) > 0.87


def test_shots_that_are_not_near_direct_shots_tell_no_scale():
    draw = np.random.default_rng(2)
    one = np.ones(1)
    tried = [Tried(draw.uniform(-3.0, 3.0, 1), 3e-3 * one, 1e-5 * one, one) for _ in range(100)]
    with pytest.raises(ValueError, match='got shots that are not near direct shots'):
        most_likely_scale(tried)


def watched_shots(count, factor, seed):
    """Shots of a player who tries the best direct shot, with errors, as a camera sees them."""
    draw, radius = np.random.default_rng(seed), WATCHED.ball.radius
    half = np.array([WATCHED.table.length, WATCHED.table.width]) / 2 - 3 * radius
    noise = WATCHED.noise.times(factor)
    while count:
        places = draw.uniform(-half, half, (len(NAMES), 2))
        lying = np.append(places, np.full((len(NAMES), 1), radius), axis=1)
        apart = np.linalg.norm(places[:, np.newaxis] - places, axis=-1) + np.eye(len(NAMES))
        direct = shots(WATCHED, TableStates(NAMES, lying[np.newaxis]), workers=1)
        if apart.min() < 3 * radius or direct.best[0] < 0.3:
            continue
        planned = Stroke.from_offsets(*direct.offsets[direct.chance.argmax()].tolist())
        balls = dict(zip(NAMES, places.tolist(), strict=True))
        shot = predict(replace(WATCHED, balls=balls), noise.perturb(planned, draw, radius))
        if shot.status != Status.OK:
            continue
        tracks = {}
        for name, place in balls.items():
            path = shot.run.balls[name]
            seen = np.array([path.at(t).position[:2] if t > 0 else place for t in TIMES])
            lost = np.cumsum((np.abs(seen) > half + 2 * radius).any(axis=1)) > 0
            seen = (seen + draw.normal(0.0, DEVIATION, seen.shape))[~lost]
            tracks[name] = Track(1.0 + TIMES[~lost], seen, np.full(len(seen), DEVIATION))
        yield RecordedShot(str(count), tracks)
        count -= 1


def test_the_command_finds_the_scale_in_a_recording(tmp_path, capsys):
    recording, scene = tmp_path / 'watched.csv', tmp_path / 'mine.yaml'
    write_csv(Recording('watched', tuple(watched_shots(25, 2.0, 3))), recording)
    words = ['calibrate', 'errors', '--watched', str(recording), '-o', str(scene)]
    assert main(words) == DONE
    found = Scene.load(scene).noise.azimuth_deg / WATCHED.noise.azimuth_deg
    assert found == pytest.approx(2.0, rel=0.3)  # two standard deviations
    assert f'watched shots: {found:.3g} times those before' in capsys.readouterr().out
