"""
Recordings: where balls were seen during shots, and what else is known of these shots.

The errors of a tracker are measured from its tracks: while a ball lies or rolls, its places across
the way are a parabola in time, and those of a short time scatter around it by the errors alone.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
import math
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.stats import chi2

from billiard_shot.scene import Noise
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


class CommandedStroke(NamedTuple):
    """A stroke as it was commanded, see `Stroke.offsets`, and the errors of its execution."""

    offsets: tuple[float, ...]
    axis: bool
    noise: Noise


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
        errors. Without it, the stroke tells only where the search of the launch begins.
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
    def command(self) -> CommandedStroke | None:
        """What tells the launch, if anything does."""
        if self.stroke is None or self.noise is None:
            return None
        return CommandedStroke(self.stroke.offsets, self.stroke.axis, self.noise)


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

    """

    name: str
    shots: tuple[RecordedShot, ...]
    frame: Frame = field(default_factory=Frame)
    scene: str | None = None
    ignored: tuple[str, ...] = ()


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
