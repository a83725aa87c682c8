"""
From a film to a recording: the table, the balls of each picture, their tracks, and the shots.

A shot is what lies between two rests. Its times count from its strike, which is found between two
pictures: the struck ball slows down evenly at first, so its way is a parabola that begins at rest.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from billiard_shot.calibration.recording import RecordedShot, Recording, Track
from billiard_shot.film.balls import Seen
from billiard_shot.film.kinds import described, named
from billiard_shot.film.lens import Bytes, Floats
from billiard_shot.film.reading import Film, FilmError, LARGEST_MOVE, Steady, STILL
from billiard_shot.film.table_in_picture import FoundTable
from billiard_shot.film.tracks import LEAST_SEEN, Tracker
from billiard_shot.film.watched_table import WatchedTable
from billiard_shot.scene import Scene

WINDOW = 0.12
"""Time within which motion shows [s]."""

MOVED, DEVIATIONS = 0.003, 5.0
"""A ball moves if it goes so far in that time [m], and so many deviations of its place."""

HIDDEN = 2.0
"""A ball that is elsewhere after it was hidden for less than so long has moved meanwhile [s]."""

REST = 0.2
"""Shots are apart by so long a rest [s]."""

LEAST_WAY = 0.05
"""Shorter ways are no shot [m]."""

BEFORE, AFTER = 0.5, 0.3
"""Time before the strike and after the last motion that belongs to a shot [s]."""

LAUNCH = 0.15
"""Time after the strike that tells when it was [s]."""

MOST_SCATTER = 0.003
"""A track whose places are farther from the middle of their neighbours is no ball [m]."""

LEAST_SEEN_PART = 0.9
"""If a ball is seen in a smaller part of the pictures of a shot, a note says so."""

UNSEEN = 1.0
"""A ball that is not seen for so long at the begin or the end of a film is noted [s]."""

UPSIDE_DOWN = 0.3
"""How much the lower side of a picture points up, at least, if the film is upside down."""


@dataclass(frozen=True, slots=True)
class Shot:
    """Times of a shot in the film [s]: its strike, what its samples span, and the struck ball."""

    strike: float
    begin: float
    end: float
    struck: str


@dataclass(frozen=True, slots=True, eq=False)
class FilmResult:
    """
    The table, balls and shots of a film.

    Attributes
    ----------
    recording : Recording
        In the frame of the table; times count from the strikes.
    table : FoundTable
    balls : mapping of str to Seen
        Whole tracks, with the times of the film.
    shots : tuple of Shot
    pictures : list of (float, picture)
        Times [s], and pictures (height, width, 3), RGB.
    notes : list of str
        On balls, tracks and shots that were found or given up, and why.

    """

    recording: Recording
    table: FoundTable
    balls: Mapping[str, Seen]
    shots: tuple[Shot, ...]
    pictures: list[tuple[float, Bytes]]
    notes: list[str]


def read_film(
    path: FilePath,
    scene: Scene,
    corners: Floats | None = None,
    readout: float = 0.0,
    progress: Callable[[int], None] = lambda done: None,
) -> FilmResult:
    """
    Track the balls of a film.

    Parameters
    ----------
    path : Path
    scene : Scene
        Its table, and the balls that are on it.
    corners : (4, 2) float array, optional
        Where the lines of the noses cross in the first picture [px]; by default they are found.
    readout : float
        Time from the first to the last row of a picture [s].
    progress : callable
        Called with the number of pictures that are done.

    Raises
    ------
    FilmError, NoTableError
        If the film has no table in sight, moves too much, or cannot be read.

    """
    film = Film(path, readout)
    samples = film.samples()
    watched = WatchedTable([picture for _, picture in samples], scene, (), corners)
    steady = Steady(samples[0][1], watched.cloth.bed)
    move = steady.largest([picture for _, picture in samples])
    if move > LARGEST_MOVE * watched.camera.size[0]:
        raise FilmError(f'{path}: the camera moves too much ({move:.0f} px): fix it')
    notes = []
    if move > STILL:
        notes.append(f'the camera moves by up to {move:.1f} px: taken out with marks of the rails')
        held = [steady.held(picture) for _, picture in samples]
        watched = WatchedTable(
            [picture for picture in held if picture is not None], scene, (), corners
        )
    size, tracker = watched.camera.size, watched.tracker
    notes.append(watched.table.note)
    if watched.camera.rotation[1, 2] > UPSIDE_DOWN:
        notes.append('the film is upside down, and is read as it is')
    times, lost = [], 0
    for number, (time, turns, taken) in enumerate(film.pictures()):
        picture = steady.held(taken) if move > STILL else taken
        if picture is None or picture.shape[1::-1] != size:
            lost += 1
            continue
        watched.see(picture, time, partial(film.row_time, turns=turns, size=size))
        times.append(time)
        progress(number + 1)
    if lost:
        notes.append(f'{lost} pictures are left out: the camera moved out of sight of its marks')
    often = [path for path in tracker.paths if len(path.seen) >= LEAST_SEEN]
    shaking = [path for path in often if _scatter(path.sights) > MOST_SCATTER]
    balls, given_up = named([path for path in often if path not in shaking], [*scene.balls])
    given_up += [described(path, 'its place shakes') for path in shaking]
    notes += [f'ball {name!r} was not found' for name in scene.balls if name not in balls]
    notes += given_up + exchanged(tracker)
    for name, ball in balls.items():
        first, last = ball['time'][[0, -1]]
        if first > times[0] + UNSEEN:
            notes.append(f'{name!r} is not seen before {first:.2f} s: in a rack, or hidden')
        if last < times[-1] - UNSEEN:
            notes.append(f'{name!r} is not seen after {last:.2f} s: pocketed, or hidden')
    seen_at = np.array(times)
    shots, about = find_shots(balls, seen_at)
    recorded = tuple(
        _recorded(str(k + 1), shot, balls, seen_at, about) for k, shot in enumerate(shots)
    )
    recording = Recording(str(path), recorded, ignored=tuple(about))
    return FilmResult(recording, watched.table, balls, tuple(shots), samples, notes + about)


def _scatter(sights: Seen) -> float:
    """Return how far places are from the middle of their neighbours [m], as a median."""
    bends = np.diff(sights['place'], n=2, axis=0)
    return 0.5 * float(np.median(np.linalg.norm(bends, axis=1)))


def exchanged(tracker: Tracker) -> list[str]:
    """Say which balls may have been exchanged, and when that was first."""
    found: dict[tuple[str, ...], float] = {}
    for (one, other), at in tracker.unsure.items():
        if one.name and other.name and one.name != other.name:
            found.setdefault(tuple(sorted([one.name, other.name])), at)
    return [
        f'{one!r} and {other!r} may have been exchanged at {at:.2f} s'
        for (one, other), at in found.items()
    ]


def find_shots(balls: Mapping[str, Seen], times: Floats) -> tuple[list[Shot], list[str]]:
    """
    Cut tracks into shots by rests.

    Parameters
    ----------
    balls : mapping of str to Seen
    times : (n,) float array
        Of the pictures [s].

    Returns
    -------
    shots : list of Shot
    notes : list of str
        Which motions are no shots, and why.

    """
    notes, shots = [], []
    moving, hidden = np.zeros((2, len(times)), bool)
    for each in balls.values():
        moves, unseen = _moving(each, times)
        moving |= moves & (unseen < 3.0 * WINDOW)
        hidden |= moves & (unseen < HIDDEN)
    at, rests = np.flatnonzero(moving), np.cumsum(~(moving | hidden))
    parted = (np.diff(times[at]) >= REST) & (np.diff(rests[at]) > 0)
    parts = np.split(times[at], 1 + np.flatnonzero(parted))
    spans = [(float(part[0]), float(part[-1])) for part in parts if len(part)]
    for k, (begin, end) in enumerate(spans):
        ways = {name: _way(each, begin, end) for name, each in balls.items()}
        if max(ways.values(), default=0.0) < LEAST_WAY:
            notes.append(f'{begin:.2f} to {end:.2f} s: no ball moves {1e3 * LEAST_WAY:.0f} mm')
            continue
        if begin < times[0] + REST:
            notes.append(f'until {end:.2f} s: left out, because it begins before the film')
            continue
        starts = {n: _strike(balls[n], begin) for n, way in ways.items() if way > 0.2 * LEAST_WAY}
        struck = min(starts, key=lambda name: starts[name])
        strike = starts[struck]
        if end > times[-1] - 0.5 * WINDOW:
            notes.append(f'shot at {strike:.2f} s: the film ends before its balls rest')
        before = spans[k - 1][1] + 0.5 * REST if k else times[0]
        after = spans[k + 1][0] - 0.5 * REST if k + 1 < len(spans) else times[-1]
        shots.append(Shot(strike, max(begin - BEFORE, before), min(end + AFTER, after), struck))
    return shots, notes


def _moving(sights: Seen, times: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Return at which times a ball moves, and between sights that are how far apart [s]."""
    known, sigma = sights['time'], sights['sigma']
    before = np.maximum(np.searchsorted(known, times - 0.5 * WINDOW, 'right') - 1, 0)
    after = np.minimum(np.searchsorted(known, times + 0.5 * WINDOW), len(known) - 1)
    away = np.linalg.norm(sights['place'][after] - sights['place'][before], axis=1)
    moves = away > np.maximum(MOVED, DEVIATIONS * np.hypot(sigma[before], sigma[after]))
    return moves, known[after] - known[before]


def _way(rows: Seen, begin: float, end: float) -> float:
    """Return how far a ball comes from where it was [m]."""
    within = rows[(rows['time'] > begin - WINDOW) & (rows['time'] < end + WINDOW)]['place']
    return float(np.linalg.norm(within - within[:1], axis=1).max(initial=0.0))


def _strike(rows: Seen, begin: float) -> float:
    """Return when a ball began to move [s], from its rest and from its first way."""
    rest = rows[rows['time'] <= begin][-LEAST_SEEN:]
    if not len(rest):
        return float(rows['time'][0])
    away = np.linalg.norm(rows['place'] - np.median(rest['place'], axis=0), axis=1)
    limit = np.maximum(MOVED, DEVIATIONS * rows['sigma'])
    later = np.flatnonzero((rows['time'] > begin - 0.5 * WINDOW) & (away > limit))
    if not len(later):
        return np.inf
    rows, away = rows[later[0] :], away[later[0] :]
    first = rows['time'][0]
    for count in range(np.count_nonzero(rows['time'] < first + LAUNCH), 1, -1):
        since, way = rows['time'][:count] - first, away[:count]
        fit = np.polyfit(way, since, 2 if count > 4 else 1)  # the strike is where the way is 0
        late = np.abs(np.polyval(fit, way) - since).max()
        if late * way[-1] < 3.0 * np.median(rows['sigma'][:count]) * since[-1] or count == 2:
            return float(first + (fit[-1] if -2.0 * WINDOW < fit[-1] < 0.0 else 0.0))
    return float(first)


def _recorded(
    name: str, shot: Shot, balls: Mapping[str, Seen], times: Floats, notes: list[str]
) -> RecordedShot:
    """Return the tracks of a shot, and note which balls have gaps."""
    tracks = {}
    pictures = np.count_nonzero((times >= shot.begin) & (times <= shot.end))
    for ball, sights in balls.items():
        rows = sights[(sights['time'] >= shot.begin) & (sights['time'] <= shot.end)]
        if len(rows):
            if len(rows) < LEAST_SEEN_PART * pictures:
                part = f'{len(rows)} of {pictures} pictures'
                notes.append(f'shot {name}: {ball!r} is seen in {part}')
            tracks[ball] = Track(rows['time'] - shot.strike, rows['place'], rows['sigma'])
    return RecordedShot(name, tracks, struck=shot.struck, start=0.0)
