"""Launches of shots: what they mean, and whether a search finds them."""

from dataclasses import replace

import numpy as np
import pytest
from simulated import simulated_recording

from billiard_shot import Scene
from billiard_shot.calibration.fit import even_until, Launch
from billiard_shot.calibration.launch import (
    CalibrationModel,
    compare,
    DIRECTION,
    FIRST_SCALES,
    FOLLOW,
    horizons,
    middle_launch,
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
from billiard_shot.calibration.recording import Frame, samples_of

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
        untils.append(even_until(TABLE, [], Launch(seen, launch)))
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
    launch = middle_launch(TABLE, seen, 0.06, spins, draw)
    follow, side, masse = spins_of([launch])[0]
    assert follow == pytest.approx(0.6, abs=0.15)
    assert abs(side) == pytest.approx(0.3, abs=0.15)  # left or right: nobody knows
    assert abs(masse) < 0.1


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
