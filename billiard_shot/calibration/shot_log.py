"""A recording that grows while somebody plays: each strike begins a shot, and rest ends it."""

from collections import deque
import csv
import math
from pathlib import Path
from typing import NamedTuple

import yaml

from billiard_shot.calibration.reader import LONGEST_SHOT, WRITTEN
from billiard_shot.perception.sightings import Balls
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.stroke import Stroke

BEFORE = 1.0
"""Time before a strike whose sightings belong to the shot [s]."""

REST = 1.0
"""Time for which no ball moves at the end of a shot [s]."""


LEAST_SIGMA = 1e-6
"""Smaller deviations are not written [m]: the positions are said to be exact."""


class Seen(NamedTuple):
    """The balls at a time [s]."""

    time: float
    balls: Balls


class ShotLog:
    """
    Writes shots to a recording, and their strokes to the description beside it.

    Parameters
    ----------
    path : Path
        A file .csv; shots are added to it.
    scene : str
        Name or path of the scene, for the description.

    """

    def __init__(self, path: Path, scene: str) -> None:
        self._path, self._about = path, path.with_suffix('.yaml')
        self._content = yaml.safe_load(self._about.read_text()) if self._about.exists() else {}
        self._content |= {'scene': scene, 'struck': CUE_BALL}
        self._seen: deque[Seen] = deque()
        self._shot = ''
        self._struck = self._moved = -math.inf  # times of the strike, and of the last motion, s

    def see(self, time: float, balls: Balls) -> str:
        """Note balls at a time [s]; return the name of the shot if it is over and written."""
        if self._seen and not time > self._seen[-1].time:
            return ''  # a repetition
        self._seen.append(Seen(time, balls))
        if not self._shot:
            while time - self._seen[0].time > BEFORE:
                self._seen.popleft()
            return ''
        if any(ball.is_moving for ball in balls.values()):
            self._moved = time
        if time - max(self._moved, self._struck) < REST and time - self._struck < LONGEST_SHOT:
            return ''
        return self._write()

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

    def strike(self, shot: str, time: float, stroke: Stroke) -> None:
        """Begin a shot; one that is not over yet ends."""
        if self._shot:
            self._write()
        self._shot, self._struck = shot, time
        self._content.setdefault('strokes', {})[shot] = stroke.in_degrees()

    def _write(self) -> str:
        """Write the shot, and forget it; return its name."""
        new = not self._path.exists()
        with self._path.open('a', encoding='utf-8', newline='') as file:
            writer = csv.writer(file)
            if new:
                writer.writerow(WRITTEN)
            for time, balls in self._seen:
                writer.writerows(self._rows(time, balls))
        self._about.write_text(yaml.safe_dump(self._content), encoding='utf-8')
        shot, self._shot = self._shot, ''
        while len(self._seen) > 1:
            self._seen.popleft()  # the next strike may come before the next picture
        return shot

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
