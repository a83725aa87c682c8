"""A recording that grows while somebody plays: each strike begins a shot, and rest ends it."""

from collections import deque
import csv
from itertools import chain, count
import math
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from billiard_shot.calibration.reader import LONGEST_SHOT, WRITTEN
from billiard_shot.perception.sightings import Balls
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import LONGEST_NAME
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.stroke import Stroke

BEFORE = 1.0
"""Time before a strike whose sightings belong to the shot [s]."""

REST = 1.0
"""Time for which no ball moves at the end of a shot [s]."""

LEAST_SIGMA = 1e-6
"""Smaller deviations are not written [m]: the positions are said to be exact."""


class Snapshot(NamedTuple):
    """The balls at a time [s]."""

    time: float
    balls: Balls


class Written(NamedTuple):
    """A shot that has been written."""

    shot: str  # its name
    why_early: str  # why it was not followed until the balls rested; '' if it was


class ShotLostError(RuntimeError):
    """A shot cannot be written; the message says which, and why."""


class ShotLog:
    """
    Writes shots to a recording, and their strokes to the description beside it.

    Parameters
    ----------
    path : Path
        A file .csv; shots are added to it.
    scene : str
        Name or path of the scene, for the description.

    Raises
    ------
    ValueError
        If the file is not a recording of this scene, with what it has instead.

    """

    def __init__(self, path: Path, scene: str) -> None:
        self._path, self._about = path, path.with_suffix('.yaml')
        self._names = _names_in(path)
        self._content = _description(self._about, {'scene': scene, 'struck': CUE_BALL})
        self._seen: deque[Snapshot] = deque()
        self._shot = ''
        self._stroke: Stroke
        self._before = 0  # number of pictures before the strike
        self._struck = self._moved = -math.inf  # times of the strike, and of the last motion, s

    @property
    def is_open(self) -> bool:
        """Whether a shot has begun that is not over yet."""
        return bool(self._shot)

    def see(self, time: float, balls: Balls) -> Written | None:
        """Note balls at a time [s]; return the shot if it is over and written."""
        written = None
        if self._seen and time <= (last := self._seen[-1].time):
            if time == last:
                return None  # a repetition
            if len(self._seen) > self._before:
                written = self.finish(f'the clock was set back by {last - time:.3g} s')
            self._seen.clear()
            self._before = 0
        self._seen.append(Snapshot(time, balls))
        if not self._shot:
            while time - self._seen[0].time > BEFORE:
                self._seen.popleft()
            return written
        if any(ball.is_seen and ball.is_moving for ball in balls.values()):
            self._moved = time
        if time - self._struck >= LONGEST_SHOT:
            return self.finish(f'the balls have not rested after {LONGEST_SHOT:g} s')
        return self.finish() if time - max(self._moved, self._struck) >= REST else None

    def seen_before(self, time: float) -> Balls:
        """
        Return the balls as they were seen last before a time [s].

        A strike may be told after a picture in which the ball moves already. If the first picture
        is later, it counts; if there is none, no ball.
        """
        found: Balls = {}
        for each in self._seen:
            if found and each.time > time:
                break
            found = each.balls
        return found

    def strike(self, shot: str, time: float, stroke: Stroke) -> str:
        """
        Begin a shot; return its name, which is another one if the recording has one of this name.

        A shot that is not over yet must be finished before.
        """
        others = (f'{shot[: LONGEST_NAME - 8]}_{number}' for number in count(2))
        name = next(each for each in chain([shot], others) if each not in self._names)
        self._names.add(name)
        self._shot, self._stroke = name, stroke
        self._struck, self._before = time, len(self._seen)
        return name

    def finish(self, why_early: str = '') -> Written | None:
        """Write the shot, and forget it, also after ShotLostError; None if there is none."""
        if not self._shot:
            return None
        shot, rows = self._shot, [row for seen in self._seen for row in self._rows(*seen)]
        self._shot = ''
        while len(self._seen) > 1:
            self._seen.popleft()  # the next strike may come before the next picture
        if not rows:
            raise ShotLostError(f'shot {shot!r} is lost: no picture shows a ball')
        try:
            with self._path.open('a', encoding='utf-8', newline='') as file:
                if not file.tell():
                    rows.insert(0, WRITTEN)
                csv.writer(file).writerows(rows)
            strokes = self._content.setdefault('strokes', {})
            strokes[shot] = self._stroke.in_degrees()
            self._about.write_text(yaml.safe_dump(self._content), encoding='utf-8')
        except OSError as error:
            raise ShotLostError(f'shot {shot!r} is lost: {error}') from None
        return Written(shot, why_early)

    def _rows(self, time: float, balls: Balls) -> list[tuple[object, ...]]:
        """Return the lines of the balls that are seen in a message of a time [s]."""
        rows: list[tuple[object, ...]] = []
        for name, ball in balls.items():
            if ball.is_seen:
                (x, y), (xx, _, yy) = ball.position, ball.covariance
                sigma = math.sqrt(0.5 * (xx + yy))
                shown = f'{sigma:.2e}' if sigma >= LEAST_SIGMA else ''
                after = (ball.time or time) - self._struck
                rows.append((self._shot, f'{after:.4f}', name, f'{x:.5f}', f'{y:.5f}', shown))
        return rows


def _names_in(path: Path) -> set[str]:
    """Names of the shots of a recording; it may not exist yet, but must have the same columns."""
    if not path.exists() or not path.stat().st_size:
        return set()
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            header, *rows = csv.reader(file)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f'{path}: must be a recording in CSV ({error})') from None
    if tuple(header) != WRITTEN:
        raise ValueError(f'{path}: the header {must_be(",".join(WRITTEN), ",".join(header))}')
    return {row[0] for row in rows if row}


def _description(path: Path, own: dict[str, str]) -> dict[str, Any]:
    """Read the description of a recording, and add `own` fields; ValueError if it has others."""
    try:
        content = (yaml.safe_load(path.read_text()) if path.exists() else None) or {}
        for name, value in own.items():
            if content.get(name, value) != value:
                raise ValueError(f'{path}: {name} {must_be(repr(value), content[name])}')
    except (OSError, AttributeError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f'{path}: must be the description of a recording ({error})') from None
    return content | own
