"""
Recordings: where balls were seen during shots, and what else is known of these shots.

Fits take of a shot which ball was struck and when, and all samples after that.

The errors of a tracker are measured from its tracks: while a ball lies or rolls, its places across
the way are a parabola in time, and those of a short time scatter around it by the errors alone.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.stats import chi2

from billiard_shot.scene import Noise, Scene
from billiard_shot.shot.stroke import Stroke

Floats = NDArray[np.float64]
USUAL_SIGMA = 1e-3
"""
Standard deviation of a seen coordinate if a recording states none, at least [m].

Errors that samples share, such as the distortion of a picture or a late time stamp, do not show in
how they scatter.
"""

WINDOW, LONGEST_STEP = 8, 0.1
"""Samples to which a parabola is fitted, and the mean time between them, at most [s]."""

LEAST_WINDOWS = 30
"""So many parabolas tell the errors of a tracker."""

MOST_RATIO = 1.5
"""Errors that exceed the stated ones by this factor contradict them."""

MOVED, MOVED_SIGMAS = 3e-3, 4.0
"""A ball that is farther than this [m], and so many deviations, from its first place has moved."""

FASTEST = 12.0
"""Speed [m/s] that no ball has: samples that need it are errors of the tracker."""

FIRST_SAMPLES, FIRST_SIGMAS, FIRST_TIME = 4, 20.0, 0.2
"""
How many samples tell the first velocity, or until how many deviations from the first place, and
the longest time between them [s].
"""

UNEVEN = 0.25
"""Relative change of velocity between these samples by which the ball has met something."""

START_SIGMA = 8e-3
"""Standard deviation of the estimated time of a strike [s]."""

LEAST_SAMPLES = 5
"""Number of samples that the struck ball must have after the strike."""

FIT_PERIOD = 0.06
"""Samples of a ball that are nearer in time are left out of fits [s]: their errors are alike."""

LONGEST_SHARE = 0.1
"""Longest time for which a sample stands [s]: what happened in longer gaps is not known."""

USUAL_SPINS = np.array([(0.0, 0.0, 0.0), (0.8, 0.8, 0.12)])
"""
Means and deviations of follow, side and masse: of spins times the radius, relative to the speed.

A tip meets the ball up to half a radius off its centre, which gives a spin of 5/4 of the speed. A
cue that is raised by 5 degrees turns a tenth of the side into masse.
"""

MOST_OUTSIDE = 0.05
"""Part of the places that may be outside of the table, by errors of the tracker."""


@dataclass(frozen=True, slots=True)
class Frame:
    """
    How a recording measures places and times: it sees p at `scale` R(angle) p + (x, y).

    Parameters
    ----------
    x, y : float
        Where it sees the middle of the table [m].
    angle : float
        Direction in which it sees the length of the table [rad].
    scale : float
        Length that it gives to a metre.
    rate : float
        Time that it gives to a second.

    """

    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0
    scale: float = 1.0
    rate: float = 1.0

    def to_table(self, seen: Floats) -> Floats:
        """Return the places on the table (..., 2) [m] of places that the recording has."""
        return self.vectors_to_table(seen - np.array([self.x, self.y]))

    def vectors_to_table(self, seen: Floats) -> Floats:
        """Return differences of places, or velocities, on the table (..., 2) of recorded ones."""
        return seen @ self._turn / self.scale

    def to_recording(self, places: Floats) -> Floats:
        """Return where the recording has places on the table (..., 2) [m]."""
        return self.scale * places @ self._turn.T + np.array([self.x, self.y])

    @property
    def _turn(self) -> Floats:
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return np.array([[cosine, -sine], [sine, cosine]])


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """
    Where a ball was seen: times (n,) [s] ascending, places (n, 2) and deviations (n,) [m].

    A deviation is NaN if nothing states it.
    """

    time: Floats
    place: Floats
    sigma: Floats

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64] | slice) -> 'Track':
        """Return some of the samples."""
        return Track(self.time[which], self.place[which], self.sigma[which])


class StrokeErrors(NamedTuple):
    """
    The errors with which a known stroke was executed.

    If a machine measured the stroke, the errors are those of the machine alone.
    """

    noise: Noise
    measured: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class RecordedShot:
    """
    A shot as it was seen.

    Attributes
    ----------
    name : str
    tracks : mapping of str to Track
        Of each ball that was on the table. Lengths are those of the recording, see `Frame`.
    struck : str, optional
        The ball that the cue hit, if it is known.
    stroke : Stroke, optional
        The stroke as it was commanded or measured, if it is known.
    noise : Noise, optional
        Errors with which it was played: the scene then tells the launch of the shot, within these
        errors. Without it, launches are searched as if the stroke were not known.
    start : float, optional
        Time of the strike, if it is known exactly [s].

    """

    name: str
    tracks: Mapping[str, Track]
    struck: str | None = None
    stroke: Stroke | None = None
    noise: Noise | None = None
    start: float | None = None

    @property
    def command(self) -> StrokeErrors | None:
        """What tells the launch together with the stroke, if anything does."""
        return None if self.stroke is None or self.noise is None else StrokeErrors(self.noise)


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """
    Shots of one table in one frame.

    Attributes
    ----------
    name : str
        Of its file.
    shots : tuple of RecordedShot
    frame : Frame
        As far as it is known before the calibration.
    scene : str, optional
        Name or path of the scene that its description names.
    ignored : tuple of str
        What was left out of the file, and why.
    exact : bool
        Whether places and frame are exact, as simulators tell them: neither the frame nor the size
        of the table is sought.

    """

    name: str
    shots: tuple[RecordedShot, ...]
    frame: Frame = field(default_factory=Frame)
    scene: str | None = None
    ignored: tuple[str, ...] = ()
    exact: bool = False


def measured_sigma(shots: Iterable[RecordedShot]) -> float | None:
    """
    Measure the standard deviation of x and y [m] from balls at rest and straight paths.

    Balls that meet something within a window, or that the tracker holds in place, do not count:
    the deviation follows from the median of all windows. None if there are too few of them.
    """
    found = [_scatters(track) for shot in shots for track in shot.tracks.values()]
    squares = np.concatenate(found) if found else np.empty(0)
    if len(squares) < LEAST_WINDOWS:
        return None
    return math.sqrt(float(np.median(squares)) / float(chi2.ppf(0.5, WINDOW - 3)))


def _scatters(track: Track) -> Floats:
    """Return the sums of squares [m^2] of errors across the way, of each part of a track."""
    if len(track.time) < WINDOW + 2:
        return np.empty(0)
    time = sliding_window_view(track.time, WINDOW)[1:-1]
    place = sliding_window_view(track.place, WINDOW, axis=0)[1:-1]  # (windows, 2, samples)
    ends = sliding_window_view(track.place, WINDOW + 2, axis=0)
    way = ends[..., -1] - ends[..., 0]  # by samples that the window does not have
    length = np.linalg.norm(way, axis=-1)
    held = (np.abs(np.diff(ends, axis=-1)).max(axis=1) == 0.0).any(axis=-1)
    kept = ~held & (length > 0.0) & (np.ptp(time, axis=-1) < LONGEST_STEP * WINDOW)
    time, place, way = time[kept], place[kept], way[kept] / length[kept, np.newaxis]
    across = place[:, 1] * way[:, :1] - place[:, 0] * way[:, 1:]
    since = (time - time[:, :1]) / np.ptp(time, axis=-1)[:, np.newaxis]
    parabolas, _ = np.linalg.qr(since[..., np.newaxis] ** np.arange(3))
    fitted = np.einsum('wsk,wtk,wt->ws', parabolas, parabolas, across)
    squares: Floats = ((across - fitted) ** 2).sum(axis=-1)
    return squares


def with_sigma(recording: Recording, sigma: float | None) -> Recording:
    """Give samples without a deviation the stated one [m], else at least the measured one."""
    tracks = [track for shot in recording.shots for track in shot.tracks.values()]
    if not any(np.isnan(track.sigma).any() for track in tracks):
        return recording
    usual = sigma or max(measured_sigma(recording.shots) or 0.0, USUAL_SIGMA)

    def stated(track: Track) -> Track:
        return replace(track, sigma=np.where(np.isnan(track.sigma), usual, track.sigma))

    shots = [
        replace(shot, tracks={name: stated(track) for name, track in shot.tracks.items()})
        for shot in recording.shots
    ]
    return replace(recording, shots=tuple(shots))


def tracking_of(recording: Recording) -> str:
    """
    Say how large the errors of the tracker are.

    Raises
    ------
    ValueError
        If the tracks contradict the deviations that the recording states.

    """
    sigmas = [track.sigma for shot in recording.shots for track in shot.tracks.values()]
    stated = float(np.median(np.concatenate(sigmas))) if sigmas else USUAL_SIGMA
    measured = measured_sigma(recording.shots)
    name = f'{recording.name}: sigma is {1e3 * stated:.3g} mm'
    if measured is None:
        return f'{name}; too few samples to measure it'
    if measured > MOST_RATIO * stated:
        raise ValueError(
            f'{name}, but balls at rest and on straight ways scatter by {1e3 * measured:.3g} mm; '
            f'state sigma {measured:.2g} (m), or none: then it is measured'
        )
    return f'{name}; measured: {1e3 * measured:.3g} mm'


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """
    A shot from the strike on. Places are those of the recording [m], times begin at the strike.

    Attributes
    ----------
    shot : RecordedShot
    recording : int
        Number of its recording.
    balls : tuple of str
        The struck ball is the first one.
    start, start_sigma : float
        Time of the strike in the recording, and its deviation [s].
    times : (times,) float array
        Ascending [s].
    ball, at : (samples,) int array
        Indices in `balls` and `times`.
    place : (samples, 2) float array
    sigma, share : (samples,) float array
        Deviation [m], and the time for which the sample stands [s].
    rest : (balls, 2) float array
        Places before the strike.
    rest_sigma : (balls,) float array
        Their deviations [m].
    velocity : (2,) float array
        Of the struck ball, estimated from its first samples [m/s].
    left_out : tuple of str
        Samples that are errors of the tracker.
    command : StrokeErrors, optional
        What tells the launch together with the stroke of the shot.
    spins : (2, 3) float array
        Means and deviations of likely spins, as `USUAL_SPINS`.

    """

    shot: RecordedShot
    recording: int
    balls: tuple[str, ...]
    start: float
    start_sigma: float
    times: Floats
    ball: NDArray[np.int64]
    at: NDArray[np.int64]
    place: Floats
    sigma: Floats
    share: Floats
    rest: Floats
    rest_sigma: Floats
    velocity: Floats
    left_out: tuple[str, ...] = ()
    command: StrokeErrors | None = None
    spins: Floats = field(default_factory=lambda: USUAL_SPINS)

    @property
    def name(self) -> str:
        """The name of the shot."""
        return self.shot.name

    @property
    def key(self) -> tuple[int, str]:
        """Number of the recording and name, which no other shot has."""
        return self.recording, self.name

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    @property
    def time(self) -> Floats:
        """Times of the samples (samples,) [s]."""
        return self.times[self.at]

    def until(self, horizon: float | Floats) -> 'Samples':
        """Return the shot with the samples up to a time, or one for each ball [s]."""
        last = np.broadcast_to(horizon, len(self.balls))
        kept = self.time <= last[self.ball]
        times = self.times[self.times <= last.max()]
        columns = {name: getattr(self, name)[kept] for name in COLUMNS}
        return replace(self, times=times, **columns)


COLUMNS = 'ball', 'at', 'place', 'sigma', 'share'


def samples_of(
    shot: RecordedShot, rate: float = 1.0, period: float = 0.0, recording: int = 0
) -> Samples:
    """
    Find the strike of a shot, and arrange its samples.

    Parameters
    ----------
    shot : RecordedShot
    rate : float
        Of its clock, see `Frame`.
    period : float
        Of samples of a ball that are nearer in time, only the first is taken [s].
    recording : int
        Number of its recording.

    Raises
    ------
    ValueError
        Saying why the shot cannot be used.

    """
    tracks, left_out = {}, []
    for name, track in shot.tracks.items():
        tracks[name], jump = _without_errors(replace(track, time=track.time / rate))
        if jump is not None:
            left_out.append(
                f'shot {shot.name!r}: ball {name!r} jumps at {jump * rate:g} s; what follows is '
                'left out'
            )
    moves = {name: first for name, track in tracks.items() if (first := _first_move(track))}
    if not moves:
        raise ValueError(f'shot {shot.name!r}: no ball moves')
    struck = shot.struck or min(moves, key=lambda name: _moved_at(tracks[name], moves[name]))
    if struck not in moves:
        raise ValueError(f'shot {shot.name!r}: ball {struck!r} does not move')
    start, velocity = _onset(tracks[struck], moves[struck])
    if shot.start is not None:
        start = shot.start / rate
    balls = (struck, *(name for name in tracks if name != struck))
    after = [_after(tracks[name], start, period) for name in balls]
    if len(after[0].time) < LEAST_SAMPLES:
        raise ValueError(
            f'shot {shot.name!r}: ball {struck!r} must have at least {LEAST_SAMPLES} samples '
            f'after the strike, got {len(after[0].time)}'
        )
    rests = [_rest(tracks[name], moves.get(name, len(tracks[name].time))) for name in balls]
    times, at = np.unique(np.concatenate([each.time for each in after]), return_inverse=True)
    return Samples(
        shot,
        recording,
        balls,
        start,
        START_SIGMA if shot.start is None else 0.0,
        times,
        np.repeat(np.arange(len(balls)), [len(each.time) for each in after]),
        at.ravel(),
        np.concatenate([each.place for each in after]),
        np.concatenate([each.sigma for each in after]),
        np.concatenate([_shares(each.time) for each in after]),
        np.array([place for place, _ in rests]),
        np.array([sigma for _, sigma in rests]),
        velocity,
        tuple(left_out),
        shot.command,
    )


def _without_errors(track: Track) -> tuple[Track, float | None]:
    """
    Leave out samples that are too far from both neighbours, and all after a jump.

    Return also the time at which the track goes on elsewhere [s], if it does.
    """
    fast = _too_fast(track)
    wrong = np.zeros(len(track.time), np.bool_)
    wrong[1:-1] = fast[:-1] & fast[1:]
    track = track.take(~wrong)
    fast = _too_fast(track)
    if not fast.any():
        return track, None
    count = 1 + int(fast.argmax())
    return track.take(slice(count)), float(track.time[count])


def _too_fast(track: Track) -> NDArray[np.bool_]:
    """Tell which steps from sample to sample (samples - 1,) no ball makes."""
    step = np.linalg.norm(np.diff(track.place, axis=0), axis=-1)
    fast: NDArray[np.bool_] = step > FASTEST * np.diff(track.time) + MOVED_SIGMAS * track.sigma[1:]
    return fast


def _first_move(track: Track) -> int:
    """Return the number of the first sample of a movement; 0 if there is none."""
    before = np.arange(1, len(track.time))
    means = np.cumsum(track.place, axis=0)[:-1] / before[:, np.newaxis]
    far = np.maximum(MOVED, MOVED_SIGMAS * track.sigma[1:] * np.sqrt(1.0 + 1.0 / before))
    moved = np.linalg.norm(track.place[1:] - means, axis=-1) > far
    moved[:-1] &= np.linalg.norm(track.place[2:] - means[:-1], axis=-1) > far[:-1]
    moved[-1:] = False  # twice, or it was an error
    return 1 + int(moved.argmax()) if moved.any() else 0


def _moved_at(track: Track, first: int) -> tuple[float, float]:
    """Return when a ball had moved [s] and, as negative number, how far [m]."""
    away = float(np.linalg.norm(track.place[first] - track.place[0]))
    return float(track.time[first]), -away


def _onset(track: Track, first: int) -> tuple[float, Floats]:
    """
    Return when a movement began [s], and with which velocity (2,) [m/s].

    The first samples tell the velocity, until the ball meets something.
    """
    sigma = track.sigma[first]
    far = np.linalg.norm(track.place[first:] - track.place[first - 1], axis=-1)
    count = max(FIRST_SAMPLES, 1 + int((far > FIRST_SIGMAS * sigma).argmax()))
    time, place = (each[first : first + count] for each in (track.time, track.place))
    away, since = place[0] - track.place[first - 1], time[0] - track.time[first - 1]
    steps = np.diff(place, axis=0) / np.diff(time)[:, np.newaxis]
    noise = MOVED_SIGMAS * sigma / np.diff(time)
    even = np.linalg.norm(steps - steps[0], axis=-1) < UNEVEN * np.linalg.norm(steps[0]) + noise
    even &= np.diff(time) < FIRST_TIME
    count = 1 + int(np.argmin(np.append(even, False)))
    velocity = away / since  # at least as fast
    if count > 1:
        slope = np.polyfit(time[:count] - time[0], place[:count], 1)[0]
        if np.linalg.norm(velocity) < (1.0 + UNEVEN) * np.linalg.norm(slope):
            velocity = slope
    ago = np.linalg.norm(away) / np.linalg.norm(velocity)
    return float(time[0] - min(ago, since)), velocity


def _after(track: Track, start: float, period: float) -> Track:
    """Return the samples after the strike, with times from the strike on."""
    track = replace(track, time=track.time - start).take(track.time > start)
    if period > 0.0:
        _, first = np.unique(np.floor(track.time / period), return_index=True)
        track = track.take(first)
    return track


def _rest(track: Track, first: int) -> tuple[Floats, float]:
    """Return the place of a ball before its movement, and its deviation [m]."""
    place: Floats = np.median(track.place[:first], axis=0)
    return place, float(track.sigma[0]) / np.sqrt(first)


def _shares(time: Floats) -> Floats:
    """Return for how long each sample stands [s]."""
    if len(time) < 2:
        return np.full(len(time), LONGEST_SHARE)
    gap = np.minimum(np.diff(time), LONGEST_SHARE)
    return 0.5 * (np.append(gap, gap[-1]) + np.insert(gap, 0, gap[0]))


def usable_shots(
    scene: Scene, recordings: Sequence[Recording]
) -> tuple[list[Samples], list[str], list[str]]:
    """
    Return the shots that can be used, what is ignored and why, and how exact the places are.

    Raises
    ------
    ValueError
        If the scene has no table; if the balls of a recording are not on it, because it has
        another unit or frame; or if its places are not as exact as it states.

    """
    if scene.table is None:
        raise ValueError('scene must have a table, got an endless cloth')
    found, ignored, tracking = [], [], []
    for number, recording in enumerate(recordings):
        ignored += [f'{recording.name}: {each}' for each in recording.ignored]
        own = []
        for shot in recording.shots:
            try:
                own.append(samples_of(shot, recording.frame.rate, FIT_PERIOD, number))
            except ValueError as error:
                ignored.append(f'{recording.name}: {error}')
            else:
                ignored += [f'{recording.name}: {each}' for each in own[-1].left_out]
        if own:
            _check_places(scene, own, recording)
        tracking.append(tracking_of(recording))
        found += own
    return found, ignored, tracking


def _check_places(scene: Scene, shots: Sequence[Samples], recording: Recording) -> None:
    assert scene.table is not None
    half = np.array([scene.table.length, scene.table.width]) / 2.0
    places = recording.frame.to_table(np.concatenate([each.place for each in shots]))
    outside = (np.abs(places) > half).any(axis=-1).mean()
    if outside > MOST_OUTSIDE:
        low, high = places.min(axis=0), places.max(axis=0)
        raise ValueError(
            f'{recording.name}: {outside:.0%} of the places are outside of the table, x from '
            f'{low[0]:.3g} to {high[0]:.3g} and y from {low[1]:.3g} to {high[1]:.3g} m; is '
            'the frame or the unit another one?'
        )


def check_enough(
    count: int, least: int, what: str, ignored: Sequence[str], hint: str = ''
) -> None:
    """Raise ValueError if there are too few shots; it names what is ignored."""
    if count < least:
        got = '\n  '.join([f'{count}{hint}', *ignored])
        raise ValueError(f'recordings must have at least {least} {what}, got {got}')
