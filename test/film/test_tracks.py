"""Tracks and shots from sights that are made up."""

from dataclasses import replace
from pathlib import Path as FilePath

import cv2
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from rendered import Filming, OVERHEAD, Painter, Placed

from billiard_shot import Scene
from billiard_shot.film.balls import SEEN
from billiard_shot.film.film import exchanged, find_shots
from billiard_shot.film.kinds import named
from billiard_shot.film.lens import (
    Camera,
    camera_of_corners,
    Edges,
    fit_camera,
    SIGHT_AWAY,
    sight_places,
    SIGHT_UP,
    Sights,
)
from billiard_shot.film.reading import Film
from billiard_shot.film.tracks import Path, Tracker
from billiard_shot.film.watched_table import WatchedTable

WHITE, RED, YELLOW = (235.0, 235.0, 225.0), (190.0, 25.0, 30.0), (235.0, 200.0, 60.0)
RADIUS, RATE = 0.03, 60.0


def seen(places, colours, draw):
    """A picture, its balls in any order."""
    order = draw.permutation(len(places))
    colour = np.array(colours, float).reshape(-1, 3)[order] + draw.normal(
        0.0, 3.0, (len(places), 3)
    )
    place = np.array(places, float).reshape(-1, 2)[order]
    place += draw.normal(0.0, 2e-4, place.shape)
    sights = np.zeros(len(place), SEEN)
    sights['place'], sights['sigma'], sights['pixel'] = place, 2e-4, 500 * place
    sights['colour'] = colour
    sights['white'] = [1.0 if min(colours[k]) > 200 else 0.1 for k in order]
    return sights


def tracked(ways, colours, times, hidden=(), readout=0.0):
    """Track balls whose ways are functions of time."""
    tracker, draw = Tracker(), np.random.default_rng(3)
    for time in times:
        there = [k for k in range(len(ways)) if not any(
            ball == k and begin < time < end for ball, begin, end in hidden
        )]  # fmt: skip
        picture = seen([ways[k](time) for k in there], [colours[k] for k in there], draw)
        picture['time'] = time + readout * (picture['place'][:, 1] + 0.7)
        tracker.add(picture, time)
    return tracker


def test_balls_that_collide_keep_their_tracks():
    """The first one stops where it meets the second one, which goes on with its velocity."""
    ways = [
        lambda t: (min(-0.5 + 2.0 * t, -2 * RADIUS), 0.0),
        lambda t: (max(0.0, 2.0 * (t - 0.22)), 0.0),
    ]
    tracker = tracked(ways, [WHITE, RED], np.arange(0.0, 0.6, 1 / RATE))
    assert len(tracker.paths) == 2
    for path in tracker.paths:
        k = int(path.colour[1] < 100.0)
        sights = path.sights
        truth = [ways[k](time) for time in sights['time']]
        np.testing.assert_allclose(sights['place'], truth, atol=2e-3)


def test_a_hidden_ball_keeps_its_track():
    ways = [lambda t: (-0.5 + 1.0 * t, 0.3), lambda t: (0.2, -0.2)]
    hidden = [(0, 0.4, 0.55), (1, 0.2, 0.9)]
    tracker = tracked(ways, [WHITE, WHITE], np.arange(0.0, 1.2, 1 / RATE), hidden)
    assert len(tracker.paths) == 2
    for path in tracker.paths:
        np.testing.assert_allclose(np.ptp(path.sights['place'][:, 1]), 0.0, atol=2e-3)


def test_rows_may_be_read_for_longer_than_a_picture_lasts():
    """Each row is read later than the same row of the picture before."""
    ways = [lambda t: (-0.5 + 2.0 * t, 0.1), lambda t: (0.3, -0.6)]
    tracker = tracked(ways, [WHITE, RED], np.arange(0.0, 0.3, 1 / 240), readout=0.012)
    assert len(tracker.paths) == 2


def sights_of(way, colour, times):
    """A ball in successive pictures."""
    sights = np.zeros(len(times), SEEN)
    sights['time'], sights['place'] = times, [way(time) for time in times]
    sights['sigma'], sights['colour'] = 2e-4, colour
    sights['white'] = 1.0 if min(colour) > 200 else 0.1
    return sights


def path_of(way, colour, times):
    return Path([*sights_of(way, colour, times)])


def test_balls_get_the_names_of_their_colours():
    times = np.arange(0.0, 1.0, 1 / RATE)
    paths = [path_of(lambda t: (0.0, 0.0), each, times) for each in (RED, WHITE, YELLOW)]
    late = path_of(lambda t: (0.1, 0.0), RED, times + 2.0)
    hand = path_of(lambda t: (0.1, 0.0), (150.0, 120.0, 100.0), times[:20])
    balls, (note,) = named([*paths, late, hand], ['cue', 'yellow', 'red'])
    assert balls['cue']['time'].tolist() == times.tolist()
    assert balls['red']['time'].tolist() == [*times, *(times + 2.0)]
    assert 'a spot from 0.00 s on, seen 20 times, is no ball' in note


def test_a_hand_that_takes_a_track_over_costs_the_time_of_the_overlap():
    """It covers the red ball from 1 s on, and is held beside it from 1.5 to 1.8 s."""
    times = np.arange(0.0, 4.0, 1 / RATE)
    skin = (165.0, 90.0, 75.0)
    taken = path_of(lambda t: (0.4, 0.1), RED, times[times < 1.0])
    for sight in sights_of(
        lambda t: (0.4 + 0.1 * (t - 1.0), 0.1), skin, times[(times >= 1) & (times < 1.8)]
    ):
        taken.add(sight)
    again = path_of(lambda t: (0.4, 0.1), RED, times[times > 1.5])
    cue = path_of(lambda t: (0.0, 0.0), WHITE, times)
    balls, (note,) = named([taken, again, cue], ['cue', 'red'])
    assert note == "'red' does not count from 1.52 to 1.78 s: seen twice"
    seen = balls['red']['time']
    assert {*seen} == {t for t in times if not 1.51 < t < 1.79}
    assert len(balls['cue']) == len(times)


@pytest.mark.parametrize('readout', [0.0, 0.012])
def test_balls_that_may_have_been_exchanged_are_named(readout):
    """With rows read at one time, all balls have the times of the pictures."""
    times = np.arange(0.0, 0.5, 1 / RATE)
    ways = [lambda t: (-0.5 + 2.0 * t, 0.0), lambda t: (0.5 - 2.0 * t, 0.001), lambda t: (0, 0.4)]
    tracker = tracked(ways, [WHITE, WHITE, RED], times, readout=readout)
    named(tracker.paths, ['cue', 'white', 'red'])
    (note,) = exchanged(tracker)
    assert note.startswith("'cue' and 'white' may have been exchanged at 0.2")


def rolling(begin, speed=1.0):
    """Rest, then a roll that slows down evenly, to rest."""

    def way(time):
        since = min(max(time - begin, 0.0), speed / 0.5)
        return -0.8 + speed * since - 0.25 * since**2, 0.0

    return way


@pytest.mark.parametrize('strike', [0.503, 0.511])
def test_a_strike_is_found_between_pictures(strike):
    times = np.arange(0.0, 4.0, 1 / RATE)
    balls = {
        'cue': sights_of(rolling(strike), WHITE, times),
        'red': sights_of(lambda t: (0.5, 0.1), RED, times),
    }
    (shot,), notes = find_shots(balls, times)
    assert (shot.struck, notes) == ('cue', [])
    assert abs(shot.strike - strike) < 0.25 / RATE
    assert shot.begin < strike < strike + 2.0 < shot.end


def test_shots_are_cut_by_rests_and_only_whole_ones_count():
    """The film begins in the middle of a shot; then two follow, and a ball that is nudged."""
    times = np.arange(0.0, 12.0, 1 / RATE)
    first, second, third = rolling(-0.5), rolling(3.0), rolling(6.5, 0.5)

    def way(t):
        x = first(t)[0] + second(t)[0] + third(t)[0] + 1.6
        return x + 0.01 * min(max(t - 10.0, 0.0), 1.0), 0.0

    shots, notes = find_shots({'cue': sights_of(way, WHITE, times)}, times)
    assert [round(shot.strike, 1) for shot in shots] == [3.0, 6.5]
    assert any('begins before the film' in note for note in notes)


def test_a_ball_that_moves_while_it_is_hidden_does_not_rest():
    times = np.arange(0.0, 4.0, 1 / RATE)
    shown = times[(times < 0.9) | (times > 1.4)]
    balls = {'cue': sights_of(rolling(0.5), WHITE, shown)}
    (shot,), _ = find_shots(balls, times)
    assert shot.strike == pytest.approx(0.5, abs=0.25 / RATE)


def test_a_spot_of_a_rack_is_no_motion():
    """Balls of a rack look as one ball elsewhere, until they have left it."""
    times = np.arange(0.0, 4.0, 1 / RATE)
    racked = sights_of(lambda t: (0.8, 0.0), RED, times[times < 0.15])
    left = sights_of(lambda t: (0.8, 0.06), RED, times[times > 0.8])
    red = np.concatenate([racked, left])
    (shot,), notes = find_shots({'cue': sights_of(rolling(0.5), WHITE, times), 'red': red}, times)
    assert shot.struck == 'cue'
    assert notes == []


def test_rows_of_turned_pictures_have_their_times():
    film = Film(FilePath('any.mp4'), readout=0.01)
    corner = np.array([[1280.0, 0.0]])
    times = [float(film.row_time(corner, turns, (1280, 720))[0]) for turns in range(4)]
    assert times == [0.0, 0.01, 0.01, 0.0]


# --- the camera: projection, outlines of balls, and fits -----------------------------------------

HALF, HEIGHT, SIZE = np.array([1.42, 0.71]), 0.037, (1280, 720)


def camera(x=0.1, y=-0.2, z=2.6, tilt=0.1, k1=-0.06, k2=0.02, focal=1000.0):
    rotation = cv2.Rodrigues(np.array([np.pi - tilt, 0.02, 0.03]))[0]
    return Camera(focal, np.array([k1, k2]), rotation, np.array([x, y, z]), SIZE, HALF)


cameras = st.builds(
    camera,
    x=st.floats(-0.5, 0.5),
    y=st.floats(-2.0, 0.5),
    z=st.floats(1.5, 4.0),
    tilt=st.floats(-0.5, 0.7),
    k1=st.floats(-0.1, 0.1),
    k2=st.floats(-0.02, 0.02),
)


@given(cameras, st.floats(0.0, 0.1))
@settings(max_examples=40, deadline=None)
def test_a_plane_is_seen_where_it_is_projected(made, height):
    pixels = np.stack(np.meshgrid([300.0, 640.0, 900.0], [200.0, 360.0, 500.0]), -1)
    places = made.to_plane(pixels, height)
    back = made.project(np.concatenate([places, np.full((3, 3, 1), height)], -1))
    np.testing.assert_allclose(back, pixels, atol=1e-6)


@given(cameras, st.floats(-0.6, 0.6), st.floats(-0.3, 0.3))
@settings(max_examples=40, deadline=None)
def test_rays_of_an_outline_touch_the_ball(made, x, y):
    centre, radius = np.array([x, y, 0.03]), 0.03
    pixels = made.outlines(centre[np.newaxis], radius, 16)[0]
    ends = np.column_stack([made.to_plane(pixels, 0.0), np.zeros(16)])
    rays = ends - made.place
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    away = centre - made.place
    off = np.linalg.norm(away - (rays @ away)[:, np.newaxis] * rays, axis=1)
    np.testing.assert_allclose(off, radius, rtol=1e-6)


def seen_by(made):
    """What a camera sees of a table: noses and sights, without errors."""
    signs = [(axis, sign) for axis in (0, 1) for sign in (-1.0, 1.0)]
    at = np.full((4, 15, 2), 0.0)
    for k, (axis, sign) in enumerate(signs):
        at[k, :, axis], at[k, :, 1 - axis] = sign, np.linspace(-0.9, 0.9, 15)
    at = at.reshape(-1, 2)
    pixels = made.project(np.column_stack([at * made.half, np.full(len(at), HEIGHT)]))
    across = np.eye(2)[np.repeat([0, 0, 1, 1], 15)]
    dots = np.array([(x, y) for x in (-0.75, -0.25, 0.5) for y in (-1.0, 1.0)])
    places = sight_places(dots, made.half, SIGHT_AWAY, HEIGHT + SIGHT_UP)
    return Edges(at, pixels, across), Sights(dots, made.project(places))


@pytest.mark.parametrize('tilt', [0.05, 0.5])
def test_a_fit_finds_the_camera(tilt):
    truth = camera(y=-2.6 * np.tan(tilt), tilt=tilt)
    edges, sights = seen_by(truth)
    begin = replace(truth, focal=900.0, radial=np.zeros(2), place=truth.place + 0.05)
    found, errors = fit_camera(begin, HALF, HEIGHT, edges, sights)
    assert np.abs(errors).max() < 0.02
    grid = np.stack(np.meshgrid(np.linspace(-1.3, 1.3, 5), np.linspace(-0.6, 0.6, 5)), -1)
    lifted = np.concatenate([grid, np.full((5, 5, 1), 0.03)], -1)
    np.testing.assert_allclose(found.to_plane(truth.project(lifted), 0.03), grid, atol=2e-4)


def test_wrong_dots_do_not_count():
    truth = camera()
    edges, sights = seen_by(truth)
    moved = sights.pixel.copy()
    moved[0] += (9.0, -7.0)
    found, errors = fit_camera(truth, HALF, HEIGHT, edges, Sights(sights.at, moved))
    assert np.median(np.abs(errors)) < 0.05
    assert np.abs(errors[len(edges.at) :][:2]).min() > 5.0
    corner = np.array([[1.3, 0.6, 0.03]])
    np.testing.assert_allclose(
        found.to_plane(truth.project(corner), 0.03), corner[:, :2], atol=1e-3
    )


@pytest.mark.parametrize('first', range(4))
def test_corners_tell_the_camera_whatever_the_first_is(first):
    truth = camera(tilt=0.5, y=-1.6, k1=0.0, k2=0.0)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    corners = truth.project(np.column_stack([signs * HALF, np.full(4, HEIGHT)]))
    found = camera_of_corners(np.roll(corners, first, axis=0), HALF, HEIGHT, SIZE)
    np.testing.assert_allclose(found.place, truth.place, atol=0.12)
    middle = found.to_plane(truth.project(np.array([[0.5, 0.2, 0.03]])), 0.03)
    np.testing.assert_allclose(middle, [[0.5, 0.2]], atol=0.01)


# --- A camera whose pictures come one after the other: which balls, where, and whether it moved

SCENE = Scene.load('pool_table')
SMALL = replace(OVERHEAD, size=(640, 360), focal=546.5)
NAMES = ['cue', *map(str, range(1, 16))]
SPREAD = {
    name: (-1.05 + 0.3 * (k % 8), -0.3 + 0.5 * (k // 8) + 0.06 * (k % 3))
    for k, name in enumerate(NAMES)
}


@pytest.fixture(scope='module')
def painter():
    filming = Filming(SMALL, hand=False, readout=0, cloth='pool')
    return Painter(SCENE, Placed(NAMES, SCENE.ball.radius), filming)


def watched_of(painter, places, **how):
    painter.motion.put(places)
    watched = WatchedTable([painter.at(0.0) for _ in range(3)], SCENE, NAMES, **how)
    return watched, [watched.balls(painter.at(0.0), 0.1 * k) for k in range(1, 12)]


def test_all_balls_of_pool_have_their_names_and_places(painter):
    watched, pictures = watched_of(painter, SPREAD)
    for balls in pictures:
        assert len(balls) == 16
        for ball in balls:
            nearest = min(SPREAD, key=lambda name: np.hypot(*(SPREAD[name] - ball.place)))
            assert np.hypot(*(SPREAD[nearest] - ball.place)) < 4e-3
    last = {ball.name: ball for ball in pictures[-1]}
    assert last.keys() == SPREAD.keys()
    off = np.array([last[name].place - SPREAD[name] for name in NAMES])
    assert np.median(np.hypot(*off.T)) < 1.2e-3
    assert all(ball.likeness > 0.5 for ball in last.values())
    assert watched.move(painter.at(0.0)) < 0.4


def test_a_moving_ball_is_followed_and_a_pocketed_one_is_gone(painter):
    watched, _ = watched_of(painter, {'cue': (0.4, 0.1), '8': (-0.8, 0.2)})
    for k in range(12):
        x = 0.4 - 0.06 * k  # 1.8 m/s at 30 pictures a second
        painter.motion.put({'cue': (x, 0.1)} | ({'8': (-0.8, 0.2)} if k < 6 else {}))
        balls = {ball.name: ball for ball in watched.balls(painter.at(0.0), 2.0 + k / 30)}
        assert balls.keys() == ({'cue', '8'} if k < 6 else {'cue'})
        assert np.hypot(*(balls['cue'].place - (x, 0.1))) < 3e-3


def test_a_table_may_be_turned(painter):
    _, pictures = watched_of(painter, {'cue': (0.4, 0.1)}, turned=True)
    (ball,) = pictures[-1]
    np.testing.assert_allclose(ball.place, (-0.4, -0.1), atol=3e-3)


def test_a_camera_that_moves_is_noticed(painter):
    watched, _ = watched_of(painter, {'cue': (0.4, 0.1)})
    moved = cv2.warpAffine(painter.at(0.0), np.float64([[1, 0, 3.0], [0, 1, -1.0]]), (640, 360))
    assert watched.move(moved) == pytest.approx(3.0, abs=0.3)
    assert watched.move(np.full_like(moved, 90)) == np.inf


def test_outlines_are_drawn_into_a_copy(painter):
    watched, pictures = watched_of(painter, {'cue': (0.4, 0.1)})
    picture = painter.at(0.0)
    shown = watched.outlined(picture, pictures[-1])
    assert (shown != picture).any()
    u, v = watched.camera.project(np.array([[0.4, 0.1, SCENE.ball.radius]]))[0].round().astype(int)
    np.testing.assert_array_equal(shown[v, u], picture[v, u])
