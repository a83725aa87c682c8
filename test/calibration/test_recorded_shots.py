"""
Recorded three-cushion shots beside scene `carom`.

BILLIARD_SHOT_RECORDINGS names a file of shots as the repository tailuge/billiards publishes them,
in metres, see billiard_shot/calibration/reader.py.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.calibration.launch import calibration_model
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import usable_shots
from billiard_shot.calibration.result import quantiles, searched_check

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
