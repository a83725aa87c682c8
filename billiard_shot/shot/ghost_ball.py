"""
The ghost ball: where the cue ball is when it touches another ball.

The cue ball, the other ball and the ghost ball are the corners of a triangle. Its sides are the
distance of the two balls, the path of the cue ball, and the diameter of a ball. Directions are
angles from the line that joins the two balls, counter-clockwise [rad]: of the path of the cue
ball, and of the line of centres, from the ghost ball to the other ball. The cut is the direction
of the line of centres less that of the path.
"""

import math

from billiard_shot.compiled import inner


@inner
def grazing(distance: float, diameter: float) -> float:
    """Return the largest direction of a path that meets a ball at a distance [m]."""
    return math.asin(min(diameter / distance, 1.0))


@inner
def path_of_line(distance: float, diameter: float, line: float) -> float:
    """Find the direction of the path that makes a line of centres."""
    return math.atan2(-diameter * math.sin(line), distance - diameter * math.cos(line))


@inner
def path_of_cut(distance: float, diameter: float, cut: float) -> float:
    """Find the direction of the path that makes a cut, below a right angle."""
    return -math.asin(min(max(diameter * math.sin(cut) / distance, -1.0), 1.0))


@inner
def cut_of_path(distance: float, diameter: float, path: float) -> float:
    """Find the cut that a path makes."""
    return -math.asin(min(max(distance * math.sin(path) / diameter, -1.0), 1.0))
