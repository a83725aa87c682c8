"""Shots from the strike on: what was struck when, and which samples count."""

import numpy as np
import pytest

from billiard_shot.calibration.recording import RecordedShot, samples_of, Track

SIGMA = 1e-3


def track(time, place, sigma=SIGMA):
    time = np.array(time, float)
    return Track(time, np.array(place, float), np.full(len(time), sigma))


def straight(start, speed, times, rest=(0.0, 0.0)):
    """A ball that is struck at a time [s] and moves along x at a speed [m/s]."""
    x = speed * np.maximum(np.asarray(times) - start, 0.0)
    return track(times, np.stack([rest[0] + x, np.full(len(x), rest[1])], axis=-1))


def lying(times, place):
    return track(times, np.repeat([place], len(times), axis=0))


TIMES = np.arange(0.0, 2.0, 0.02)


def test_the_ball_that_moves_first_was_struck():
    tracks = {
        'red': straight(0.7, 0.5, TIMES, (0.5, 0.0)),
        'white': straight(0.313, 1.5, TIMES),
        'yellow': lying(TIMES, (0.0, 0.5)),
    }
    seen = samples_of(RecordedShot('1', tracks))
    assert seen.balls == ('white', 'red', 'yellow')
    assert seen.start == pytest.approx(0.313, abs=1e-6)
    assert seen.velocity == pytest.approx([1.5, 0.0])
    assert seen.rest == pytest.approx(np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]))
    assert seen.times[seen.at][seen.ball == 1] == pytest.approx(TIMES[TIMES > 0.313] - 0.313)
    assert samples_of(RecordedShot('1', tracks, struck='red')).start == pytest.approx(
        0.7, abs=1e-6
    )


def test_places_before_the_strike_are_known_better_with_more_samples():
    draw = np.random.default_rng(1)
    moving = straight(1.0, 2.0, TIMES)
    noisy = Track(
        moving.time, moving.place + draw.normal(0.0, SIGMA, moving.place.shape), moving.sigma
    )
    seen = samples_of(RecordedShot('1', {'cue': noisy}))
    assert seen.rest_sigma[0] == pytest.approx(SIGMA / np.sqrt(50), rel=0.05)
    assert np.abs(seen.rest).max() < 5.0 * seen.rest_sigma[0]
    assert seen.start == pytest.approx(1.0, abs=2e-3)


def test_jumps_of_the_tracker_are_left_out_and_gaps_are_allowed():
    moving = straight(0.3, 1.0, TIMES)
    moving.place[40] = 1.2, -0.6  # another ball
    kept = np.r_[0:50, 80:100]  # lost for 0.6 s
    lost = Track(moving.time[kept], moving.place[kept], moving.sigma[kept])
    seen = samples_of(RecordedShot('1', {'cue': lost}))
    assert len(seen.place) == len(kept) - 16 - 1
    assert seen.place[:, 0] == pytest.approx(seen.times[seen.at])
    assert (np.abs(seen.place[:, 1]) < 1e-9).all()
    assert seen.share.max() <= 0.1  # a sample beside the gap does not stand for it


def test_a_clock_that_runs_fast_is_corrected():
    fast = track(TIMES * 1.5, straight(0.3, 1.0, TIMES).place)
    seen = samples_of(RecordedShot('1', {'cue': fast}), rate=1.5)
    assert (seen.start, *seen.velocity) == pytest.approx((0.3, 1.0, 0.0))


def test_of_samples_that_are_near_in_time_one_stands_for_all():
    shot = RecordedShot('1', {'cue': straight(0.3, 1.0, TIMES)})
    all_of_them, some = samples_of(shot), samples_of(shot, period=0.1)
    assert len(some.times) == 17
    assert some.share.sum() == pytest.approx(all_of_them.share.sum(), rel=0.1)
    assert (some.start, some.until(0.5).duration) == (
        all_of_them.start,
        pytest.approx(0.487, abs=0.1),
    )
    assert some.until(0.5).at.max() == len(some.until(0.5).times) - 1


@pytest.mark.parametrize(
    ('tracks', 'struck', 'said'),
    [
        ({'cue': lying(TIMES, (0.0, 0.0))}, None, 'no ball moves'),
        ({'cue': lying([0.0], (0.0, 0.0))}, None, 'no ball moves'),
        ({'cue': straight(0.3, 1.0, TIMES[:17])}, None, 'no ball moves'),  # it is seen once
        ({'cue': straight(0.3, 1.0, TIMES)}, 'red', "ball 'red' does not move"),
        (
            {'cue': straight(0.3, 1.0, TIMES[:18])},
            None,
            'at least 5 samples after the strike, got',
        ),
    ],
)
def test_shots_that_tell_nothing_are_refused(tracks, struck, said):
    with pytest.raises(ValueError, match=f"shot 'a': .*{said}"):
        samples_of(RecordedShot('a', tracks, struck))
