"""
How recorded balls slow down while they roll, beside scene `carom`.

BILLIARD_SHOT_RECORDINGS names a file of shots as the repository tailuge/billiards publishes them,
in metres: a list of shots with `balls`, which have `t` [s], `x` and `y` [m].
"""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.calibration.launch import calibration_model
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import usable_shots
from billiard_shot.calibration.result import quantiles, searched_check

SLIDE, PIECE = 0.9, 1.0  # s: nothing happens in both; a ball may still slide in the first
MOST_ACROSS, MOST_ALONG = 1e-3, 2e-3  # m, standard deviations from a line and a parabola


@pytest.fixture(scope='module')
def pieces():
    """Shot, mean speed [m/s], and deceleration over gravity, of pieces of rolling."""
    path = os.environ.get('BILLIARD_SHOT_RECORDINGS', '')
    if not Path(path).is_file():
        pytest.skip('BILLIARD_SHOT_RECORDINGS names no file of recorded shots')
    found = []
    for number, shot in enumerate(json.loads(Path(path).read_text(encoding='utf-8'))):
        for track in shot['balls'].values():
            time, *place = (np.array(track[name], float) for name in ('t', 'x', 'y'))
            found += [(number, *piece) for piece in rolls(time, np.stack(place, axis=1))]
    return np.array(found)


def rolls(time, place):
    """Speed and deceleration over gravity of pieces in which a ball goes straight on."""
    begin, gravity = time[0] + SLIDE, Scene.load('carom').cloth.gravity
    while begin + PIECE <= time[-1]:
        straight = (time >= begin - SLIDE) & (time <= begin + PIECE)
        t, at = time[straight] - begin, place[straight]
        if len(t) < 20 or np.diff(t).max() > 0.15:
            begin += 0.1
            continue
        at = at - at.mean(axis=0)
        _, _, axes = np.linalg.svd(at, full_matrices=False)
        way, across = at @ axes[0] * np.sign(axes[0] @ (at[-1] - at[0])), at @ axes[1]
        later = t >= 0.0
        parabola = np.polyfit(t[later], way[later], 2)
        along = way[later] - np.polyval(parabola, t[later])
        if (
            across.std() < MOST_ACROSS
            and along.std() < MOST_ALONG
            and (np.diff(way) > -1e-3).all()
        ):
            yield parabola[1] + parabola[0] * PIECE, -2.0 * parabola[0] / gravity
            begin += 0.5
        else:
            begin += 0.1


def fitted(speed, slowing, rises):
    """Resistance at rest and rise [s/m] with the least absolute deviations."""
    terms = np.stack([np.ones_like(speed), rises * speed], axis=1)
    weights = np.ones_like(speed)
    for _ in range(50):
        weighted = terms * weights[:, np.newaxis]
        found = np.linalg.lstsq(weighted, slowing * weights, rcond=None)[0]
        weights = np.maximum(np.abs(slowing - terms @ found), 1e-5) ** -0.5
    return found


def test_a_rise_predicts_rolls_of_other_shots_better(pieces):
    number, speed, slowing = pieces.T
    errors = {0.0: [], 1.0: []}
    for fold in range(5):
        other = number % 5 == fold
        for rises, error in errors.items():
            rest, rise = fitted(speed[~other], slowing[~other], rises)
            error.append(np.abs(slowing[other] - rest - rise * speed[other]).sum())
    assert len(pieces) > 300
    assert sum(errors[1.0]) < 0.99 * sum(errors[0.0])


def test_scene_carom_has_the_resistance_of_the_recordings(pieces):
    _, speed, slowing = pieces.T
    cloth = Scene.load('carom').cloth
    rest, rise = fitted(speed, slowing, 1.0)
    assert rest == pytest.approx(cloth.rolling_resistance, abs=2e-4)
    assert rise == pytest.approx(cloth.rolling_rise, abs=4e-4)


# --- recorded three-cushion shots beside scene `carom` -------------------------------------------

CAROM = Scene.load('carom')


@pytest.fixture(scope='module')
def recording():
    path = os.environ.get('BILLIARD_SHOT_RECORDINGS', '')
    if not Path(path).is_file():
        pytest.skip('BILLIARD_SHOT_RECORDINGS names no file of recorded shots')
    return read_recording(path)


def test_all_shots_can_be_used(recording):
    usable, ignored, _ = usable_shots(CAROM, [recording])
    assert len(usable) == len(recording.shots)
    assert not ignored
    speeds = [np.hypot(*each.velocity) for each in usable]
    assert min(speeds) > 0.3
    assert max(speeds) < 7.0


def test_launches_explain_whole_shots_within_centimetres(recording):
    """A search of other people reached 22 cm in the median, of the cue ball alone."""
    model = calibration_model(CAROM, [recording])
    usable, *_ = usable_shots(CAROM, [recording])
    checks = [searched_check(model, np.inf, (each, (1, k))) for k, each in enumerate(usable[:6])]
    assert quantiles(checks)[-1, 1] < 0.05
    assert quantiles(checks)[0, 1] < 0.025
