"""
The camera: a pinhole with two radial terms, fitted to what is seen of a table.

Pixels (u, v) count from the centre of the first one, u to the right and v down. Radial terms as in
Brown (1971), Close-range camera calibration, Photogrammetric Engineering 37: a direction at the
distance r from the axis is seen at r (1 + k1 r^2 + k2 r^4).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]

USUAL_FOCAL, FOCAL_SPREAD = 0.9, 0.35
"""Of phones: focal length [larger side of the picture], and the deviation of its logarithm."""

RADIAL_SPREAD = 0.1, 0.05
"""Deviations of k1 and k2 that lenses have."""

RULER = 0.002
"""Standard deviation of a stated length or width [m]."""

SIGHT_AWAY, AWAY_SPREAD = 0.094, 0.015
"""
How far sights are from the noses, and the deviation of that among tables [m].

3 11/16 in: WPA, Tables & Equipment Specifications, article 5.
"""

SIGHT_UP, UP_SPREAD = 0.004, 0.004
"""How far sights are above the noses, and the deviation of that [m]."""

PIXEL = 0.3
"""Deviation of a nose or a sight in a picture, before outliers are left out [px]."""

CORNER, FOCALS = 3.0, (0.4, 2.5, 32)
"""Deviation of a corner that lines make [px]; focal lengths that are tried [larger side]."""

SIGNS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
"""Of x and y at the corners of the table, counter-clockwise as seen from above."""

STEPS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-9)
"""Of the iteration for directions: their number, and the change at its end [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """
    A camera in the frame of the table.

    Parameters
    ----------
    focal : float
        [px]
    radial : (2,) float array
        k1 and k2.
    rotation : (3, 3) float array
        Its rows: the directions right, down and ahead.
    place : (3,) float array
        [m]
    size : (int, int)
        Width and height of its pictures [px].
    half : (2,) float array
        Half the length and half the width between the noses, as far as they fit the picture [m].

    """

    focal: float
    radial: Floats
    rotation: Floats
    place: Floats
    size: tuple[int, int]
    half: Floats

    @property
    def middle(self) -> Floats:
        """The pixel on the axis."""
        return 0.5 * (np.array(self.size) - 1.0)

    @property
    def matrix(self) -> Floats:
        """Maps directions to pixels, without the radial terms."""
        u, v = self.middle
        return np.array([[self.focal, 0.0, u], [0.0, self.focal, v], [0.0, 0.0, 1.0]])

    @property
    def turned(self) -> 'Camera':
        """The same camera in the frame that is turned by half a turn."""
        back = np.array([-1.0, -1.0, 1.0])
        return replace(self, rotation=self.rotation * back, place=self.place * back)

    def project(self, points: Floats) -> Floats:
        """Return the pixels (..., 2) of points (..., 3) [m]."""
        seen = (points - self.place) @ self.rotation.T
        flat = seen[..., :2] / seen[..., 2:]
        square = (flat**2).sum(-1, keepdims=True)
        bent: Floats = 1.0 + self.radial[0] * square + self.radial[1] * square**2
        return self.focal * bent * flat + self.middle

    def to_plane(self, pixels: Floats, height: float) -> Floats:
        """Return the places (..., 2) [m] that pixels (..., 2) see at a height [m]."""
        flat = np.ascontiguousarray(pixels, np.float64).reshape(-1, 1, 2)
        terms = np.array([*self.radial, 0.0, 0.0])
        ahead = cv2.undistortPoints(flat, self.matrix, terms, criteria=STEPS).reshape(pixels.shape)
        ray = np.insert(ahead, 2, 1.0, axis=-1) @ self.rotation
        down = (height - self.place[2]) / ray[..., 2:]
        places: Floats = self.place[:2] + down * ray[..., :2]
        return places

    def outlines(self, places: Floats, radius: float, count: int) -> Floats:
        """
        Return the outlines (balls, count, 2) [px] of balls whose centres are (balls, 3) [m].

        A camera sees a sphere up to the circle at which its rays touch it.
        """
        ahead = places - self.place
        far = np.linalg.norm(ahead, axis=-1, keepdims=True)
        ahead = ahead / far
        right = np.cross(ahead, self.rotation[1])
        right /= np.linalg.norm(right, axis=-1, keepdims=True)
        down = np.cross(ahead, right)
        nearer = radius**2 / far
        wide = radius * np.sqrt(1.0 - (radius / far) ** 2)
        angle = np.arange(count)[:, np.newaxis] * (2.0 * math.pi / count)
        middle, reach = (places - nearer * ahead)[:, np.newaxis], wide[:, np.newaxis]
        across = np.cos(angle) * right[:, np.newaxis] + np.sin(angle) * down[:, np.newaxis]
        return self.project(middle + reach * across)

    def rim(self, height: float, beyond: float = 0.0) -> Floats:
        """Return the pixels (n, 2) of the noses at a height, or of lines that far behind [m]."""
        corners = np.linspace(SIGNS, np.roll(SIGNS, -1, axis=0), 30, axis=1).reshape(-1, 2)
        return self.project(np.insert(corners * (self.half + beyond), 2, height, axis=1))

    def slopes(self, places: Floats) -> Floats:
        """Return how pixels move (n, 2, 2) [px/m] with x and y of points (n, 3) [m]."""
        step = 1e-4 * np.eye(3)[:2]
        ends = self.project(places[:, np.newaxis] + step) - self.project(places)[:, np.newaxis]
        return ends.swapaxes(1, 2) / 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """
    Where noses are seen.

    Parameters
    ----------
    at : (n, 2) float array
        Points of the noses, as parts of half the length and half the width.
    pixel, across : (n, 2) float array
        Where the edge is seen [px], and the direction in which that is known.

    """

    at: Floats
    pixel: Floats
    across: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Sights:
    """
    Where sights are seen.

    Parameters
    ----------
    at : (n, 2) float array
        Their places, as parts of half the length and half the width: +-1 is the rail of a side.
    pixel : (n, 2) float array
        [px]

    """

    at: Floats
    pixel: Floats


NO_SIGHTS = Sights(np.empty((0, 2)), np.empty((0, 2)))
NO_EDGES = Edges(np.empty((0, 2)), np.empty((0, 2)), np.empty((0, 2)))


def sight_places(at: Floats, half: Floats, away: float, height: float) -> Floats:
    """Return the places (n, 3) [m] of sights at parts (n, 2), that far behind the noses."""
    flat = at * half + away * np.where(np.abs(at) == 1.0, at, 0.0)
    return np.column_stack([flat, np.full(len(at), height)])


def camera_of_corners(corners: Floats, half: Floats, height: float, size: Sequence[int]) -> Camera:
    """
    Find the camera that sees four corners.

    Parameters
    ----------
    corners : (4, 2) float array
        Counter-clockwise around the table as seen from above, the first one anywhere [px].
    half : (2,) float array
        Half the length and half the width of the rectangle that they make [m].
    height : float
        Of the rectangle above the cloth [m].
    size : (int, int)
        Width and height of the picture [px].

    """
    places, nowhere = np.insert(SIGNS * half, 2, height, axis=1), np.zeros(3)
    best, least = None, np.inf
    for turn in range(2):
        seen = np.ascontiguousarray(np.roll(corners, turn, axis=0), np.float64)
        for focal in np.geomspace(*FOCALS):
            camera = Camera(
                focal * max(size), np.zeros(2), np.eye(3), nowhere, (size[0], size[1]), half
            )
            _, turned, away = cv2.solvePnP(places, seen, camera.matrix, np.zeros(4))
            rotation = cv2.Rodrigues(turned)[0]
            camera = replace(camera, rotation=rotation, place=-rotation.T @ away.ravel())
            unusual = math.log(focal / USUAL_FOCAL) / FOCAL_SPREAD
            off = float(((camera.project(places) - seen) ** 2).sum()) / CORNER**2 + unusual**2
            if camera.place[2] > height and off < least:
                best, least = camera, off
    if best is None:
        raise ValueError('the corners make no rectangle that a camera above it sees')
    # the length of the table points to the right
    return best.turned if best.rotation[0, 0] < 0.0 else best


def fit_camera(
    begin: Camera,
    half: Floats,
    height: float,
    edges: Edges,
    sights: Sights,
) -> tuple[Camera, Floats]:
    """
    Fit a camera to noses and sights.

    Parameters
    ----------
    begin : Camera
        Where the fit begins.
    half : (2,) float array
        Half the stated length and width [m]; their errors are those of a ruler.
    height : float
        Of the noses [m].
    edges : Edges
    sights : Sights

    Returns
    -------
    camera : Camera
    errors : float array
        Of the edges, then of u and v of the sights, in turn [px].

    """

    def camera_at(x: Floats) -> Camera:
        rotation = cv2.Rodrigues(x[3:6])[0]
        fitted = half * (1.0 + x[9:11])
        return replace(
            begin, focal=math.exp(x[0]), radial=x[1:3], rotation=rotation,
            place=-rotation.T @ x[6:9], half=fitted,
        )  # fmt: skip

    def errors(x: Floats) -> Floats:
        camera = camera_at(x)
        noses = np.column_stack([edges.at * camera.half, np.full(len(edges.at), height)])
        off = ((edges.pixel - camera.project(noses)) * edges.across).sum(-1)
        up = height + SIGHT_UP + x[12]
        there = sight_places(sights.at, camera.half, SIGHT_AWAY + x[11], up)
        return np.concatenate([off, (sights.pixel - camera.project(there)).ravel()])

    spreads = np.array([FOCAL_SPREAD, *RADIAL_SPREAD, *0.5 * RULER / half, AWAY_SPREAD, UP_SPREAD])
    usual = np.array([math.log(USUAL_FOCAL * max(begin.size)), 0, 0, 0, 0, 0, 0])
    known = [0, 1, 2, 9, 10, 11, 12]

    def residuals(x: Floats) -> Floats:
        return np.concatenate([errors(x) / PIXEL, (x[known] - usual) / spreads])

    start = np.concatenate([
        [math.log(begin.focal)], begin.radial, cv2.Rodrigues(begin.rotation)[0].ravel(),
        -begin.rotation @ begin.place, begin.half / half - 1.0, [0.0, 0.0],
    ])  # fmt: skip
    found = least_squares(residuals, start, loss='soft_l1', f_scale=2.0, x_scale='jac', ftol=1e-6)
    return camera_at(found.x), errors(found.x)
