"""Tracks and shots from sights that are made up."""

from pathlib import Path as FilePath

import numpy as np
import pytest

from billiard_shot.film.balls import SIGHT
from billiard_shot.film.film import exchanged, find_shots
from billiard_shot.film.kinds import named
from billiard_shot.film.reading import Film
from billiard_shot.film.tracks import Path, Tracker

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
    sights = np.zeros(len(place), SIGHT)
    sights['place'], sights['sigma'], sights['pixel'] = place, 2e-4, 500 * place
    sights['colour'] = colour
    sights['white'] = [1.0 if min(colours[k]) > 200 else 0.1 for k in order]
    return sights


def tracked(ways, colours, times, hidden=(), readout=0.0):
    """Track balls whose ways are functions of time."""
    tracker, draw = Tracker(RADIUS), np.random.default_rng(3)
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


def test_balls_that_cannot_be_told_apart_are_doubted():
    ways = [lambda t: (-0.5 + 2.0 * t, 0.0), lambda t: (0.5 - 2.0 * t, 0.001)]
    tracker = tracked(ways, [WHITE, WHITE], np.arange(0.0, 0.5, 1 / RATE))
    assert tracker.unsure


def sights_of(way, colour, times):
    """A ball in successive pictures."""
    sights = np.zeros(len(times), SIGHT)
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
