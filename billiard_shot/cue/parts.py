"""The moving parts of the mechanical cue: their masses and sizes, for models of the robot."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number, section


@dataclass(frozen=True, slots=True)
class MovingPart:
    """One moving part, as a box of uniform density."""

    mass: float = number('kg', above=0)
    length: float = number('m', above=0)  # along the axis x of the part's frame
    width: float = number('m', above=0)  # along y
    height: float = number('m', above=0)  # along z

    def __post_init__(self) -> None:
        check(self)

    @property
    def size(self) -> NDArray[np.float64]:
        """Length, width and height (3,) [m]."""
        return np.array([self.length, self.width, self.height])

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Moments of inertia about the axes through its centre (3,) [kg m^2]."""
        squares = self.size**2
        moments: NDArray[np.float64] = self.mass / 12 * (np.roll(squares, 1) + np.roll(squares, 2))
        return moments


def section_of(kind: Any, *numbers: float) -> Any:
    """Section whose default has these numbers."""
    return dataclasses.field(
        default_factory=lambda: kind(*numbers), metadata=section(kind).metadata
    )


@dataclass(frozen=True, slots=True)
class Parts:
    """
    The moving parts, each named after the joint that moves it.

    Parameters
    ----------
    base_x : MovingPart
        The bridge across the table, above the trolley.
    base_y : MovingPart
        The trolley on the bridge, above the highest position of the pivot.
    base_z : MovingPart
        The column through the trolley, with the turntable at its lower end.
    azimuth : MovingPart
        The turntable, centred on the pivot.
    incline : MovingPart
        The box with the linear bearings and the drive of the stroke. The cue lies in its lower
        side, because a box around a level cue would touch the cloth.
    stroke : MovingPart
        The cue, which ends at the tip.

    """

    base_x: MovingPart = section_of(MovingPart, 60.0, 0.2, 4.2, 0.2)
    base_y: MovingPart = section_of(MovingPart, 15.0, 0.3, 0.3, 0.15)
    base_z: MovingPart = section_of(MovingPart, 10.0, 0.1, 0.1, 1.3)
    azimuth: MovingPart = section_of(MovingPart, 3.0, 0.2, 0.2, 0.04)
    incline: MovingPart = section_of(MovingPart, 6.0, 0.5, 0.1, 0.1)
    stroke: MovingPart = section_of(MovingPart, 0.5018, 1.0, 0.02, 0.02)

    def __post_init__(self) -> None:
        check(self)
