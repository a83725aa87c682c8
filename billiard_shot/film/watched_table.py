"""
Balls in the pictures of a fixed camera, as the pictures come.

The first pictures tell the table and the light on its cloth. Then each picture is searched for
balls where it differs from the cloth; the colours of the last seconds tell their names.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from billiard_shot.film.balls import BallFinder
from billiard_shot.film.cloth import fit_cloth
from billiard_shot.film.drawing import outlined
from billiard_shot.film.kinds import likely_names
from billiard_shot.film.lens import Bytes, Camera, Floats
from billiard_shot.film.reading import Steady
from billiard_shot.film.table_in_picture import find_table, first_with_sights
from billiard_shot.film.tracks import Tracker
from billiard_shot.scene import Scene

MEMORY = 2.0
"""Time for which sights of balls are kept [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundBall:
    """
    A ball in a picture.

    Parameters
    ----------
    name : str
    likeness : float
        From 1, if colour and share of white are those of the name, to 0.
    place : (2,) float array
        [m]
    sigma : float
        Standard deviation of x and of y [m].

    """

    name: str
    likeness: float
    place: Floats
    sigma: float


class WatchedTable:
    """
    The table and the balls of one camera.

    Parameters
    ----------
    pictures : sequence of (height, width, 3) uint8 arrays
        RGB. Their median shows the table: the more balls and hands move, the better.
    scene : Scene
        Its table and the radius of its balls.
    names : sequence of str
        Of the balls that may be on the table.
    corners : (4, 2) float array, optional
        Where the lines of the noses cross [px]; by default they are found.
    turned : bool
        Whether the x axis of the table points to the left in the picture.

    Attributes
    ----------
    table : FoundTable
    cloth : Cloth
    tracker : Tracker

    Raises
    ------
    ValueError
        If the pictures show no table, or too little of one.

    """

    def __init__(
        self,
        pictures: Sequence[Bytes],
        scene: Scene,
        names: Sequence[str],
        corners: Floats | None = None,
        turned: bool = False,
    ) -> None:
        middle = np.median(pictures, axis=0).astype(np.uint8)
        self.table = first_with_sights(
            partial(find_table, picture, scene, corners) for picture in (middle, *pictures)
        )
        if turned:
            self.table = replace(self.table, camera=self.table.camera.turned)
        self._names, self.tracker = names, Tracker()
        self.cloth = fit_cloth(middle, self.table.camera, self.table.height)
        self._finder = BallFinder(self.table.camera, self.cloth, self.table.radius)
        self._steady = Steady(middle, self.cloth.bed)

    @property
    def camera(self) -> Camera:
        """The camera, in the frame of the table."""
        return self.table.camera

    def see(
        self, picture: Bytes, time: float, delays: Callable[[Floats], Any] = lambda pixels: 0.0
    ) -> None:
        """Track the balls of a picture of a time [s]; pixels (n, 2) are so much later (n,) [s]."""
        seen = self._finder.find(picture)
        seen['time'] = time + delays(seen['pixel'])
        self.tracker.add(seen, time)

    def balls(self, picture: Bytes, time: float) -> list[FoundBall]:
        """Find the balls of a picture that was taken at a time [s], later than those before."""
        self.see(picture, time)
        self.tracker.forget(time - MEMORY)
        paths = [path for path in self.tracker.paths if path.seen[-1]['time'] == time]
        return [
            FoundBall(name, likeness, path.seen[-1]['place'], float(path.seen[-1]['sigma']))
            for path, name, likeness in likely_names(paths, self._names)
        ]

    def move(self, picture: Bytes) -> float:
        """Return how far the camera has moved [px]: inf if its marks are hidden, 0 without any."""
        return self._steady.largest([picture])

    def outlined(self, picture: Bytes, balls: Sequence[FoundBall]) -> Bytes:
        """Return a picture with the outlines and names of balls."""
        return outlined(picture, self.table, {ball.name: ball.place for ball in balls})
