"""
The table in a picture: its cloth by colour, noses by their edges, sights as small dots.

The cloth of cushions reaches beyond the noses, so that its outline only tells where to look. A
nose hides a strip of the bed and throws a shadow: along it the brightness has its steepest step.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from billiard_shot.film.lens import (
    Bytes,
    Camera,
    camera_of_corners,
    Edges,
    fit_camera,
    Floats,
    NO_SIGHTS,
    SIGHT_AWAY,
    sight_places,
    SIGHT_UP,
    Sights,
)
from billiard_shot.scene import Scene
from billiard_shot.table.run.outline import outline_of

LEAST_COSINE = 0.985
"""Colours at a smaller angle are those of one cloth, in any light."""

LEAST_BRIGHTNESS = 25.0
"""Darker pixels have no colour that counts [of 255]."""

LEAST_PART = 0.06
"""Of the picture that the cloth covers."""

LEAST_FILLED, LEAST_CLOTH = 0.79, 0.69
"""Parts of a four-sided outline that cloth fills: less hides the table, or is no table."""

ROUGH = 0.01
"""Details of an outline that are smaller do not count [of its length]."""

NEAR_SIDE = 0.06, 0.02
"""An outline is that of a side if it is so near to it, in two rounds [length of the side]."""

BRIDGE = 0.08
"""What covers a narrower strip of the cloth does not part it [smaller side of the picture]."""

COLOURS = 3
"""So many frequent colours may be that of the cloth."""

SEARCHES = (0.025, 0.012, 0.012)
"""How far from where it should be an edge is sought, in turn [m]."""

ALONG, MEAN = 90, 15
"""Lines across a nose, and the neighbours that are averaged."""

NEAR_POCKET, NEAR_CORNER = 0.12, 0.04
"""Noses nearer to the middle of a pocket, or to the end of a side, are not used [m]."""

SIGHT_REACH = 0.025
"""A sight is sought so far around its place [m]."""

LEAST_SIGHTS = 6
"""Fewer sights are not used."""

MOST_OFF = 4.0
"""Edges and sights that are off by more median deviations do not fit."""

WORST_FIT = 2.5
"""Median of the errors of noses and sights that is no table [px]."""

SIDES = ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0))
"""Of the table: the coordinate that a nose keeps, and its sign."""


class NoTableError(ValueError):
    """No table is in the picture, or too little of it."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundTable:
    """
    A table in a picture.

    Parameters
    ----------
    camera : Camera
    sights : Sights
        Those that fit.
    error : float
        Root mean square of the errors of noses and sights that fit [px].
    notes : tuple of str
        What was not used, and why.

    """

    camera: Camera
    sights: Sights
    error: float
    notes: tuple[str, ...]


def find_table(picture: Bytes, scene: Scene, corners: Floats | None = None) -> FoundTable:
    """
    Find the table of a scene in a picture.

    Parameters
    ----------
    picture : (height, width, 3) uint8 array
        RGB.
    scene : Scene
    corners : (4, 2) float array, optional
        Where the lines of the noses cross [px]; by default they are found.

    Raises
    ------
    NoTableError
        If there is none, or only a part of one.

    """
    if scene.table is None:
        raise NoTableError('the scene must have a table')
    outline = outline_of(scene)
    half = 0.5 * np.array([scene.table.length, scene.table.width])
    size = picture.shape[1], picture.shape[0]
    if corners is None:
        seen, ends = cloth_corners(picture), outline.back
    else:
        seen, ends = _around(corners), half
    try:
        camera = camera_of_corners(seen, ends, outline.height, size)
        camera = replace(camera, half=half)
    except (ValueError, cv2.error) as error:
        raise NoTableError(f'no camera sees a table with these corners: {error}') from None
    smooth = cv2.GaussianBlur(picture, (0, 0), 0.7).astype(np.float32)
    holes, sights = outline.holes[:, :2], NO_SIGHTS
    for number, reach in enumerate(SEARCHES):
        edges = _noses(smooth, camera, half, outline.height, holes, reach)
        if number > 0:
            sights = _sights(smooth, camera, half, outline.height, len(holes) > 0)
        camera, errors = fit_camera(camera, half, outline.height, edges, sights)
    off = np.abs(errors)
    if not len(off) or np.median(off) > WORST_FIT:
        raise NoTableError('the edges in the picture do not fit a table of this size')
    kept = off < MOST_OFF * max(float(np.median(off)), 0.1)
    count, good = len(edges.at), kept[len(edges.at) :].reshape(-1, 2).all(axis=1)
    note = f'{kept[:count].sum()} of {count} points of noses, {good.sum()} sights fit'
    sights = Sights(sights.at[good], sights.pixel[good])
    return FoundTable(camera, sights, float(np.sqrt((errors[kept] ** 2).mean())), (note,))


def cloth_corners(picture: Bytes) -> Floats:
    """
    Find the corners (4, 2) [px] of the cloth, with that of the cushions.

    Raises
    ------
    NoTableError
        If no even colour fills a rectangle, or if it reaches beyond the picture.

    """
    scale = max(1.0, max(picture.shape) / 640.0)
    small = cv2.resize(picture, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)
    last = np.array([small.shape[1], small.shape[0]]) - 1.0
    bridge = round(BRIDGE * min(small.shape[:2]))
    best, outline, filled, rank = None, np.empty((0, 2)), 0.0, (-5, 0.0)
    for mask in _even_colours(cv2.GaussianBlur(small, (0, 0), 1.0).astype(np.float32)):
        wide = np.pad(mask, bridge)  # else the edges of the picture are bridged, too
        wide = cv2.morphologyEx(wide, cv2.MORPH_CLOSE, np.ones((bridge, bridge), np.uint8))
        whole = wide[bridge:-bridge, bridge:-bridge].copy()
        count, labels, stats, _ = cv2.connectedComponentsWithStats(whole)
        if count < 2:
            continue
        largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
        part = (labels == largest).astype(np.uint8)
        contours = cv2.findContours(part, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        edge = max(contours, key=cv2.contourArea)
        quad = _four_sided(cv2.convexHull(edge))
        if quad is None or part.sum() < LEAST_PART * mask.size:
            continue
        covered = float((part & mask).sum()) / max(cv2.contourArea(quad.astype(np.float32)), 1.0)
        reach = np.concatenate([edge.min(axis=(0, 1)) < 2.0, edge.max(axis=(0, 1)) > last - 2.0])
        # A floor reaches beyond more edges of the picture than a table.
        if covered > LEAST_CLOTH and (-int(reach.sum()), float(part.sum())) > rank:
            best, filled, beyond = quad, covered, reach
            outline, rank = edge[:, 0].astype(np.float64), (-int(reach.sum()), float(part.sum()))
    if best is None:
        raise NoTableError('no table is in sight: no even colour fills a rectangle')
    if beyond.any():
        names = np.array(['left', 'upper', 'right', 'lower'])[beyond]
        raise NoTableError(
            f'the cloth reaches beyond the {" and ".join(names)} edge of the picture: the whole '
            'table must be in sight'
        )
    if filled < LEAST_FILLED:
        raise NoTableError(f'something hides a part of the table: {100 * filled:.0f} % is cloth')
    return scale * (_crossings(_around(best), outline) + 0.5) - 0.5


def _four_sided(hull: NDArray[np.int32]) -> Floats | None:
    """
    Return where the four longest sides of an outline cross (4, 2) [px]; None if it has fewer.

    Pockets and people cut the corners off, so that these tell nothing.
    """
    corners = cv2.approxPolyDP(hull, ROUGH * cv2.arcLength(hull, True), True)[:, 0]
    ends = np.roll(corners, -1, axis=0)
    longest = np.sort(np.argsort(-np.linalg.norm(ends - corners, axis=1))[:4])
    if len(longest) < 4:
        return None
    ones = np.ones((4, 1))
    return _crossed(np.cross(np.c_[corners[longest], ones], np.c_[ends[longest], ones]))


def _crossed(lines: Floats) -> Floats:
    """Return where each of the lines (4, 3) crosses the next one (4, 2) [px]."""
    points = np.cross(lines, np.roll(lines, -1, axis=0))
    pixels: Floats = points[:, :2] / np.where(points[:, 2:], points[:, 2:], 1e-9)
    return pixels


def _crossings(corners: Floats, outline: Floats) -> Floats:
    """Return where lines cross that fit the sides of an outline better than its corners do."""
    for reach in NEAR_SIDE:
        lines = []
        for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            way, away = end - begin, outline - begin
            along = away @ way / (way @ way)
            aside = np.abs(away @ np.array([-way[1], way[0]])) / (way @ way)
            near = outline[(along > 0.08) & (along < 0.92) & (aside < reach)]
            if len(near) < 10:
                return corners
            line = cv2.fitLine(near.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01).ravel()
            lines.append(np.cross([*line[2:], 1.0], [*(line[2:] + line[:2]), 1.0]))
        corners = np.roll(_crossed(np.array(lines)), 1, axis=0)
    return corners


def _around(corners: Floats) -> Floats:
    """Sort corners counter-clockwise as seen; v points down."""
    away = corners - corners.mean(axis=0)
    return corners[np.argsort(np.arctan2(-away[:, 1], away[:, 0]))]


def _even_colours(picture: Floats) -> Iterator[Bytes]:
    """Yield masks of the most frequent colours, whatever their brightness."""
    far = np.linalg.norm(picture, axis=-1)
    colour = picture / np.maximum(far, 1.0)[..., np.newaxis]
    left = far > LEAST_BRIGHTNESS
    for _ in range(COLOURS):
        if left.sum() < LEAST_PART * left.size:
            return
        bins = (colour[left][:, :2] * 40).astype(int)
        counts = np.bincount(bins[:, 0] * 41 + bins[:, 1], minlength=41 * 41)
        common = bins[:, 0] * 41 + bins[:, 1] == counts.argmax()
        mean = np.median(colour[left][common], axis=0)
        alike = (colour @ (mean / np.linalg.norm(mean)) > LEAST_COSINE) & (far > LEAST_BRIGHTNESS)
        left &= ~alike
        mask = cv2.morphologyEx(alike.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        yield mask


def _sampled(picture: Floats, pixels: Floats) -> Floats:
    """Return the colours (..., 3) at pixels (n, m, 2)."""
    maps = pixels.astype(np.float32)
    return cv2.remap(picture, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)


def _noses(
    picture: Floats,
    camera: Camera,
    half: Floats,
    height: float,
    holes: Floats,
    reach: float,
) -> Edges:
    """Find the steepest step along lines across the noses, each the mean of neighbours."""
    found = []
    for axis, sign in SIDES:
        other = 1 - axis
        free = 1.0 - NEAR_CORNER / half[other]
        along = np.linspace(-free, free, ALONG)
        at = np.full((ALONG, 2), sign)
        at[:, other] = along
        if len(holes):
            nearest = np.linalg.norm((at * half)[:, np.newaxis] - holes, axis=-1).min(axis=1)
            at = at[nearest > NEAR_POCKET]
        here = at * camera.half
        ends = np.zeros((2, len(at), 2)) + here
        ends[:, :, axis] += np.array([[-reach], [reach]])
        lift = np.full((*ends.shape[:2], 1), height)
        first, last = camera.project(np.concatenate([ends, lift], axis=-1))
        length = np.linalg.norm(last - first, axis=1).max()
        steps = np.linspace(0.0, 1.0, max(int(4.0 * length), 12))[:, np.newaxis]
        lines = first[:, np.newaxis] + steps * (last - first)[:, np.newaxis]
        seen = _sampled(picture, lines)
        seen = cv2.blur(seen, (3, MEAN))
        slope = np.linalg.norm(np.diff(seen, axis=1), axis=-1)
        apart = slice(MEAN // 2, -(MEAN // 2), MEAN // 2)
        slope, at, lines = slope[apart], at[apart], lines[apart]
        inside = ((lines > 1.0) & (lines < np.array(camera.size) - 2.0)).all(axis=(1, 2))
        k = np.clip(slope.argmax(axis=1), 4, slope.shape[1] - 5)
        window = np.arange(-4, 5)  # 2 px
        around = slope[np.arange(len(k))[:, np.newaxis], k[:, np.newaxis] + window]
        offset = (around * window).sum(axis=1) / np.maximum(around.sum(axis=1), 1e-9)
        part = (k + 0.5 + offset)[:, np.newaxis] / (len(steps) - 1)
        way = lines[:, -1] - lines[:, 0]
        along_picture = np.gradient(lines[:, 0], axis=0)
        across = np.column_stack([-along_picture[:, 1], along_picture[:, 0]])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        found.append((at[inside], (lines[:, 0] + part * way)[inside], across[inside]))
    return Edges(*(np.concatenate(each) for each in zip(*found, strict=True)))


def _sights(picture: Floats, camera: Camera, half: Floats, height: float, pockets: bool) -> Sights:
    """Find the dots of the rails near their places; dots that stand elsewhere are left out."""
    at = [(x, y) for x in np.arange(-3, 4) / 4 for y in (-1.0, 1.0) if x or not pockets]
    at += [(x, y) for x in (-1.0, 1.0) for y in np.arange(-1, 2) / 2]
    parts = np.array(at)
    places = sight_places(parts, camera.half, SIGHT_AWAY, height + SIGHT_UP)
    fine = np.linspace(-SIGHT_REACH, SIGHT_REACH, 51)
    grid = np.stack(np.meshgrid(fine, fine), axis=-1)
    seen, offsets = [], []
    for part, place in zip(parts, places, strict=True):
        lift = np.full((*grid.shape[:2], 1), place[2])
        pixels = camera.project(np.concatenate([place[:2] + grid, lift], axis=-1))
        if (pixels < 1.0).any() or (pixels > np.array(camera.size) - 2.0).any():
            continue
        patch = _sampled(picture, pixels)
        apart = np.linalg.norm(patch - np.median(patch, axis=(0, 1)), axis=-1)
        row, column = np.unravel_index(apart.argmax(), apart.shape)
        far = np.hypot(grid[..., 0] - fine[column], grid[..., 1] - fine[row])
        dot = np.where(far < 0.012, np.maximum(apart - 0.4 * apart.max(), 0.0), 0.0)
        ring = apart[(far > 0.012) & (far < 0.016)]
        if apart.max() < 20.0 or (len(ring) and np.median(ring) > 0.4 * apart.max()):
            continue
        offset = (dot[..., np.newaxis] * grid).sum(axis=(0, 1)) / dot.sum()
        seen.append((part, offset, place))
        outwards = np.where(np.abs(part) == 1.0, part, 0.0)
        offsets.append((offset @ outwards, np.abs(offset[outwards == 0.0]).sum()))
    if len(seen) < LEAST_SIGHTS:
        return NO_SIGHTS
    away = np.array(offsets)
    good = (np.abs(away[:, 0] - np.median(away[:, 0])) < 0.006) & (away[:, 1] < 0.008)
    kept = [each for each, fits in zip(seen, good, strict=True) if fits]
    if len(kept) < LEAST_SIGHTS:
        return NO_SIGHTS
    there = np.array([(*(place[:2] + offset), place[2]) for _, offset, place in kept])
    return Sights(np.array([part for part, _, _ in kept]), camera.project(there))
