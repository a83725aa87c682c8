"""Launches of shots: what they mean, and whether a search finds them."""

from dataclasses import replace

import numpy as np
import pytest
from simulated import simulated_recording

from billiard_shot import Scene
from billiard_shot.calibration.fit import Launch, until_bent
from billiard_shot.calibration.launch import (
    CalibrationModel,
    compare,
    DIRECTION,
    FIRST_SCALES,
    FOLLOW,
    horizons,
    likely_spins,
    PLACES,
    prior_of,
    scales_of,
    search_launches,
    SIDE,
    SPEED,
    spins_of,
    states_of,
    ways_of,
)
from billiard_shot.calibration.recording import Frame, RecordedShot, samples_of, Track, USUAL_SPINS

CAROM = replace(Scene.load('carom'), balls={})
TURNED = Frame(0.2, -0.1, 0.3, 1.1)
TABLE, TURNED_TABLE = CalibrationModel(CAROM, (Frame(),)), CalibrationModel(CAROM, (TURNED,))


def shot(seed, **options):
    return simulated_recording(CAROM, 1, seed, **options).shots[0]


def test_a_launch_is_a_state_of_the_balls_in_the_frame_of_the_table():
    seen = samples_of(shot(1, frame=TURNED))
    launch = np.zeros((1, PLACES + 6))
    launch[0, [SPEED, DIRECTION, FOLLOW, SIDE]] = 2.2, 0.3 + np.pi / 2, 1.1, 0.55
    launch[0, PLACES + 2] = 0.011  # the second ball, 11 mm along x of the recording
    states = states_of(TURNED_TABLE, seen, launch)
    radius = CAROM.ball.radius
    assert states.velocity[0, 0] == pytest.approx([0.0, 2.0, 0.0])
    assert states.spin[0, 0] * radius == pytest.approx([-1.0, 0.0, 0.5])
    assert not states.velocity[0, 1:].any()
    moved = TURNED.to_table(seen.rest[1] + [0.011, 0.0])
    assert states.position[0, 1] == pytest.approx([*moved, radius])


def test_balls_that_were_seen_to_overlap_are_moved_apart():
    seen = samples_of(shot(1))
    touching = replace(seen, rest=np.array([[0.0, 0.0], [0.06, 0.0], [1.5, 0.0]]))
    states = states_of(TABLE, touching, prior_of(touching)[0][np.newaxis])
    first, second, third = states.position[0, :, :2]
    assert np.linalg.norm(second - first) >= 2.0 * CAROM.ball.radius
    assert (first + second) / 2 == pytest.approx([0.03, 0.0])  # each by the same distance
    assert third[0] < CAROM.table.length / 2 - 0.9 * CAROM.ball.radius
    assert np.isfinite(ways_of(TABLE, touching, prior_of(touching)[:1][0][None])).all()


def test_a_launch_that_cannot_be_is_infinitely_far():
    seen = samples_of(shot(1))
    launches = np.repeat(prior_of(seen)[0][np.newaxis], 2, axis=0)
    launches[1, SPEED] = np.nan
    places = ways_of(TABLE, seen, launches)
    assert np.isfinite(places[0]).all()
    assert np.isinf(places[1]).all()
    costs = compare(seen, FIRST_SCALES).costs(launches, places)
    assert np.isfinite(costs[0])
    assert not costs[1] < np.inf


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_the_launch_of_a_simulated_shot_is_found(seed):
    seen = samples_of(shot(seed, frame=TURNED, rate=30.0), period=0.06)
    found = search_launches(TURNED_TABLE, seen, FIRST_SCALES, 3.0, np.random.default_rng(1))
    horizon = compare(seen, FIRST_SCALES, 3.0).samples
    errors = np.linalg.norm(found.places[0] - horizon.place, axis=-1)
    assert np.sqrt((errors**2).mean()) < 2.5e-3  # the noise of both coordinates is 1.4 mm
    again = search_launches(TURNED_TABLE, seen, FIRST_SCALES, 3.0, np.random.default_rng(1))
    assert np.array_equal(found.launches, again.launches)


def test_a_path_is_followed_until_it_is_a_matter_of_chance_what_a_ball_meets():
    seen = samples_of(shot(1))
    launch, _ = prior_of(seen)
    to = seen.rest[1] - seen.rest[0]
    distance = np.linalg.norm(to)
    grazing = np.arcsin(2.0 * CAROM.ball.radius / distance)
    untils = []
    for off in (0.0, grazing):
        launch[[SPEED, DIRECTION]] = 1.0, np.arctan2(to[1], to[0]) + off
        seen = replace(seen, times=np.linspace(0.0, 4.0 * distance, len(seen.times)))
        untils.append(until_bent(TABLE, [], Launch(seen, launch)).until)
    full, grazed = untils
    assert (full > 3.0 * distance).all()
    assert (grazed[:2] > distance).all()  # at 1 m/s
    assert (grazed[:2] < 3.0 * distance).all()
    assert np.isinf(grazed[2])
    kept = seen.until(np.array([0.3, 0.5, np.inf]))
    assert [kept.time[kept.ball == k].max() <= until for k, until in enumerate((0.3, 0.5))]
    assert (kept.ball == 2).sum() == (seen.ball == 2).sum()


def test_spin_that_was_not_seen_is_that_of_other_strokes():
    draw = np.random.default_rng(1)
    spins = np.array([0.6, 0.3, 0.0]) + draw.normal(0.0, 0.02, (20, 3))
    seen = samples_of(shot(1))
    likely = likely_spins(spins)
    assert likely[0] == pytest.approx([0.6, 0.0, 0.0], abs=0.05)
    assert likely[1] == pytest.approx([0.2, 0.35, 0.03], abs=0.03)  # of these and the usual ones
    found = search_launches(TABLE, replace(seen, spins=likely), FIRST_SCALES, 0.06, draw)
    follow, side, masse = spins_of(found.launches[:1])[0]
    assert follow == pytest.approx(0.6, abs=0.15)
    assert abs(side) < 0.15  # left or right: nobody knows
    assert abs(masse) < 0.1


def test_usual_spins_are_likely_if_no_other_stroke_is_known():
    assert np.array_equal(likely_spins(spins_of([])), USUAL_SPINS)


def test_scales_are_medians_of_errors_that_do_not_fall():
    times = np.repeat([0.1, 0.6, 3.0, 9.0], 5)
    errors = np.repeat([2e-3, 1e-3, 5e-3, 9e-3], 5)
    errors[::5] = 1.0  # of a path that went elsewhere
    scales = scales_of(times, errors)
    assert scales.tolist() == [2e-3, 2e-3, 2e-3, 2e-3, 2e-3, 5e-3, 9e-3]


def test_horizons_grow_to_the_last():
    assert list(horizons(0.3)) == [0.3]
    steps = list(horizons(6.0))
    assert steps[-1] == 6.0
    assert steps == sorted(steps)
    assert len(steps) == 6


# --- shots from the strike on: what was struck when, and which samples count ---------------------

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
