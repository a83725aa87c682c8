"""Recordings: where balls were seen during shots, and what else is known of these shots."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Noise
from billiard_shot.shot.stroke import Stroke

Floats = NDArray[np.float64]
USUAL_SIGMA = 1e-3
"""Standard deviation of a seen coordinate if a recording states none [m]."""


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
        return (seen - np.array([self.x, self.y])) @ self._turn / self.scale

    def to_recording(self, places: Floats) -> Floats:
        """Return where the recording has places on the table (..., 2) [m]."""
        return self.scale * places @ self._turn.T + np.array([self.x, self.y])

    @property
    def _turn(self) -> Floats:
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return np.array([[cosine, -sine], [sine, cosine]])


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where a ball was seen: times (n,) [s] ascending, places (n, 2) and deviations (n,) [m]."""

    time: Floats
    place: Floats
    sigma: Floats


class Command(NamedTuple):
    """A stroke as it was commanded, and the errors with which it was played."""

    stroke: Stroke
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
    def command(self) -> Command | None:
        """What tells the launch, if anything does."""
        if self.stroke is None or self.noise is None:
            return None
        return Command(self.stroke, self.noise)


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
