"""The scale of a player's errors, from watched shots whose intention is not known."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, shots, Status, Stroke, TableStates
from billiard_shot.calibration.player import most_likely_scale, Tried
from billiard_shot.calibration.reader import write_csv
from billiard_shot.calibration.recording import RecordedShot, Recording, Track
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE

SCENE = Scene.load('pool_table')
NAMES = 'cue', '1', '2', '3'
SIGMA = 1e-3  # m, of a seen place
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
    draw, radius = np.random.default_rng(seed), SCENE.ball.radius
    half = np.array([SCENE.table.length, SCENE.table.width]) / 2 - 3 * radius
    noise = SCENE.noise.times(factor)
    while count:
        places = draw.uniform(-half, half, (len(NAMES), 2))
        lying = np.append(places, np.full((len(NAMES), 1), radius), axis=1)
        apart = np.linalg.norm(places[:, np.newaxis] - places, axis=-1) + np.eye(len(NAMES))
        direct = shots(SCENE, TableStates(NAMES, lying[np.newaxis]), workers=1)
        if apart.min() < 3 * radius or direct.best[0] < 0.3:
            continue
        planned = Stroke.from_offsets(*direct.offsets[direct.chance.argmax()].tolist())
        balls = dict(zip(NAMES, places.tolist(), strict=True))
        shot = predict(replace(SCENE, balls=balls), noise.perturb(planned, draw, radius))
        if shot.status != Status.OK:
            continue
        tracks = {}
        for name, place in balls.items():
            path = shot.run.balls[name]
            seen = np.array([path.at(t).position[:2] if t > 0 else place for t in TIMES])
            lost = np.cumsum((np.abs(seen) > half + 2 * radius).any(axis=1)) > 0
            seen = (seen + draw.normal(0.0, SIGMA, seen.shape))[~lost]
            tracks[name] = Track(1.0 + TIMES[~lost], seen, np.full(len(seen), SIGMA))
        yield RecordedShot(str(count), tracks)
        count -= 1


def test_the_command_finds_the_scale_in_a_recording(tmp_path, capsys):
    recording, scene = tmp_path / 'watched.csv', tmp_path / 'mine.yaml'
    write_csv(Recording('watched', tuple(watched_shots(25, 2.0, 3))), recording)
    words = ['calibrate', 'errors', '--watched', str(recording), '-o', str(scene)]
    assert main(words) == DONE
    found = Scene.load(scene).noise.azimuth_deg / SCENE.noise.azimuth_deg
    assert found == pytest.approx(2.0, rel=0.3)  # two standard deviations
    assert f'watched shots: {found:.3g} times those before' in capsys.readouterr().out
