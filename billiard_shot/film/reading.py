"""Films as phones write them: pictures with their times, the right way up, and held still."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from billiard_shot.film.lens import Bytes, Floats

SAMPLES = 16
"""At most twice as many pictures stand for the film while its table is sought."""

STILL, LARGEST_MOVE = 0.3, 0.04
"""Moves of the camera that do not matter [px], and that are too large [width of the picture]."""

LEAST_MARKS = 8
"""Marks outside of the bed that tell how the camera moves."""


class FilmError(ValueError):
    """A film that cannot be read, or that cannot be used."""


@dataclass(frozen=True, slots=True)
class Film:
    """
    A film.

    Parameters
    ----------
    path : Path
    readout : float
        Time from the first to the last row of a picture [s].

    """

    path: Path
    readout: float = 0.0

    def pictures(self) -> Iterator[tuple[float, int, Bytes]]:
        """
        Yield the time [s], the quarter turns, and RGB, turned, of each picture.

        Raises
        ------
        FilmError
            If there is no video, or one that is not of 8 bits.

        """
        try:
            import av
        except ImportError:
            raise FilmError("films need PyAV: pip install 'billiard_shot[film]'") from None
        try:
            with av.open(str(self.path)) as container:
                if not container.streams.video:
                    raise FilmError(f'{self.path}: has no video')
                stream = container.streams.video[0]
                stream.thread_type = 'AUTO'
                for frame in container.decode(stream):
                    yield self._picture(frame)
        except (OSError, av.FFmpegError) as error:
            raise FilmError(f'{self.path}: cannot be read as a film: {error}') from None

    def _picture(self, frame: Any) -> tuple[float, int, Bytes]:
        bits = max(component.bits for component in frame.format.components)
        if bits > 8:
            raise FilmError(
                f'{self.path}: must have 8 bits a colour, got {bits}: turn HDR off in the camera'
            )
        if frame.time is None:
            raise FilmError(f'{self.path}: its pictures have no times')
        turns = round(float(frame.rotation) / 90.0) % 4
        picture: Bytes = np.ascontiguousarray(np.rot90(frame.to_ndarray(format='rgb24'), turns))
        return float(frame.time), turns, picture

    def samples(self) -> list[tuple[float, Bytes]]:
        """Return pictures of all parts of the film; FilmError if it has none."""
        kept: list[tuple[float, Bytes]] = []
        every, last = 1, -np.inf
        for number, (time, _, picture) in enumerate(self.pictures()):
            if time < last:
                raise FilmError(f'{self.path}: the times of its pictures go back at {time:g} s')
            last = time
            if number % every == 0:
                kept.append((time, picture))
                if len(kept) > 2 * SAMPLES:
                    kept, every = kept[::2], 2 * every
        if not kept:
            raise FilmError(f'{self.path}: has no pictures')
        return kept

    def row_time(self, pixels: Floats, turns: int, size: tuple[int, int]) -> Floats:
        """Return how long after the first row pixels (n, 2) of a turned picture were read [s]."""
        across = pixels / np.array(size)
        part = (across[:, 1], across[:, 0], 1.0 - across[:, 1], 1.0 - across[:, 0])[turns]
        return self.readout * part


LEAST_HELD = 0.75
"""Of the pictures, whose marks must be seen."""


class Steady:
    """
    Holds pictures still: finds how marks outside of the bed have moved since a picture.

    Parameters
    ----------
    picture : (height, width, 3) uint8 array
    bed : (height, width) uint8 array
        1 where balls move.

    """

    def __init__(self, picture: Bytes, bed: Bytes) -> None:
        self._first = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        outside = cv2.dilate(bed, np.ones((9, 9), np.uint8)) == 0
        marks = cv2.goodFeaturesToTrack(self._first, 80, 0.05, 12.0, mask=outside.astype(np.uint8))
        self._marks = np.empty((0, 1, 2), np.float32) if marks is None else marks

    def move(self, picture: Bytes) -> Floats | None:
        """Return the affine map (2, 3) from the first picture to this one, if it is seen."""
        if len(self._marks) < LEAST_MARKS:
            return None
        grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        seen, found, _ = cv2.calcOpticalFlowPyrLK(self._first, grey, self._marks, None)
        good = found.ravel() > 0
        if good.sum() < LEAST_MARKS:
            return None
        move, fits = cv2.estimateAffinePartial2D(
            self._marks[good], seen[good], method=cv2.RANSAC, ransacReprojThreshold=0.7
        )
        return move if np.count_nonzero(fits) >= LEAST_MARKS else None

    def held(self, picture: Bytes) -> Bytes | None:
        """Return a picture, moved back onto the first one."""
        move = self.move(picture)
        if move is None:
            return None
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(picture, move, picture.shape[1::-1], flags=flags)

    def largest(self, pictures: list[Bytes]) -> float:
        """Return the largest move of pictures [px]; infinite if too many of them are lost."""
        height, width = self._first.shape
        corners = np.array([[0, 0, 1], [width, 0, 1], [0, height, 1], [width, height, 1]], float)
        if len(self._marks) < LEAST_MARKS:
            return 0.0
        moves = [move for move in map(self.move, pictures) if move is not None]
        if len(moves) < LEAST_HELD * len(pictures):
            return np.inf
        return max(float(np.abs(corners @ move.T - corners[:, :2]).max()) for move in moves)
