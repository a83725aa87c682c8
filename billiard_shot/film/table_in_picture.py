"""
The table in a picture: its cloth by colour, noses by their edges, sights as small dots.

The cloth of cushions reaches beyond the noses, so that its outline only tells where to look. A
nose hides a strip of the bed and throws a shadow: along it the brightness has its steepest step.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from billiard_shot.film.cloth import Pixels
from billiard_shot.film.lens import (
    Bytes,
    Camera,
    camera_of_corners,
    Edges,
    fit_camera,
    Floats,
    NO_EDGES,
    NO_SIGHTS,
    SIGHT_AWAY,
    sight_places,
    SIGHT_UP,
    Sights,
    SIGNS,
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

EDGES_FIRST = (0.025, 0.0), (0.012, 0.025), (0.012, 0.025)
SIGHTS_FIRST = (0.0, 0.15), (0.025, 0.06), (0.012, 0.025), (0.012, 0.025)
"""
How far from their places edges of noses, and sights along the rails, are sought, in turn [m].

If something hides a side, edges fit a wrong table, and only sights tell the right one.
"""

ALONG, MEAN = 90, 15
"""Lines across a nose, and the neighbours that are averaged."""

NEAR_POCKET, NEAR_CORNER = 0.12, 0.04
"""Noses nearer to the middle of a pocket, or to the end of a side, are not used [m]."""

SIGHT_REACH = 0.025
"""A sight is sought so far across the rail [m]."""

LEAST_SIGHTS, SURE_SIGHTS, MANY_SIGHTS = 6, 8, 16
"""
Fewer sights are not used; do not tell a table by themselves; leave a doubt.

Of rendered pictures with a body or an arm over the table, 104 of 168 in which fewer than 16 sights
fitted gave places that were off by more than 5 mm, 3 of 755 with more sights, by 8 mm at most.
"""

MOST_OFF = 4.0
"""Edges and sights that are off by more median deviations do not fit."""

MOST_MOVED = 0.02
"""
The corners of a table without sights are so near to those of the cloth [diagonal].

Of rendered tables, within 0.011; if something hides a side, mostly 0.02 to 0.2.
"""

WORST_FIT = 2.5
"""Median of the errors of noses and sights that is no table [px]."""

NO_FIT = 'the edges in the picture do not fit a table of this size'

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
    height, radius : float
        Of the noses, and of the balls [m].
    error : float
        Root mean square of the errors of noses and sights that fit [px].
    note : str
        How many noses and sights fit.

    """

    camera: Camera
    sights: Sights
    height: float
    radius: float
    error: float
    note: str

    @property
    def has_sights(self) -> bool:
        """Whether so many sights fit that they are used."""
        return len(self.sights.at) >= LEAST_SIGHTS


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
    colours = picture.astype(np.float32)
    table = first_with_sights(
        partial(_fitted, colours, camera, scene, half, *how)
        for how in ((EDGES_FIRST, 0), (SIGHTS_FIRST, SURE_SIGHTS))
    )
    if corners is None and not table.has_sights:
        _check_without_sights(colours, table, scene, half, seen, ends)
    return table


def _check_without_sights(
    picture: Pixels, table: FoundTable, scene: Scene, half: Floats, seen: Floats, back: Floats
) -> None:
    """
    Check that corners of the cloth, and dots of the rails, do not contradict a found table.

    Raises
    ------
    NoTableError
        If they do.

    """
    camera, has_pockets = table.camera, len(outline_of(scene).holes) > 0
    corners = camera.project(np.insert(SIGNS * back, 2, table.height, axis=1))
    moved = cdist(seen, corners).min(axis=1).max() / np.linalg.norm(seen[2] - seen[0])
    dots = _sights(picture, camera, half, table.height, has_pockets, SIGHTS_FIRST[0][1])
    off = 0.0
    if len(dots.at):
        places = sight_places(dots.at, camera.half, SIGHT_AWAY, 0.0)[:, :2]
        seen_at = camera.to_plane(dots.pixel, table.height + SIGHT_UP)
        off = float(np.median(np.linalg.norm(seen_at - places, axis=1)))
    if moved > MOST_MOVED or off > SIGHT_REACH:
        raise NoTableError(
            'the noses do not fit the sights of the rails, or the corners of the cloth: something '
            'hides a side of the table, or its length and width are not those of the scene'
        )


def first_with_sights(attempts: Iterable[Callable[[], FoundTable]]) -> FoundTable:
    """
    Return the table of the first attempt whose sights fit, else of the first that finds one.

    Raises
    ------
    NoTableError
        Of the first attempt, if none finds a table.

    """
    found, errors = [], []
    for attempt in attempts:
        try:
            found.append(attempt())
        except NoTableError as error:
            errors.append(error)
            continue
        if found[-1].has_sights:
            return found[-1]
    if not found:
        raise errors[0]
    return found[0]


def _fitted(
    picture: Pixels,
    camera: Camera,
    scene: Scene,
    half: Floats,
    searches: Sequence[tuple[float, float]],
    least: int,
) -> FoundTable:
    """
    Fit a camera, which begins at an estimate, to noses and sights that are sought in turn.

    Raises
    ------
    NoTableError
        If they do not fit, or fewer than the `least` number of sights.

    """
    outline = outline_of(scene)
    holes, sights = outline.holes[:, :2], NO_SIGHTS
    for reach, along in searches:
        edges = NO_EDGES
        if reach:
            edges = _noses(picture, camera, half, outline.height, holes, reach)
        if along:
            sights = _sights(picture, camera, half, outline.height, len(holes) > 0, along)
        if not len(edges.at) and not len(sights.at):
            raise NoTableError(NO_FIT)
        camera, errors = fit_camera(camera, half, outline.height, edges, sights)
    off = np.abs(errors)
    if np.median(off) > WORST_FIT:
        raise NoTableError(NO_FIT)
    kept = off < MOST_OFF * max(float(np.median(off)), 0.1)
    count, good = len(edges.at), kept[len(edges.at) :].reshape(-1, 2).all(axis=1)
    note = f'{kept[:count].sum()} of {count} points of noses, {good.sum()} sights fit'
    if good.sum() < MANY_SIGHTS:
        note += '; if something hides a part of the table, places may be off by centimetres'
    sights = Sights(sights.at[good], sights.pixel[good])
    if good.sum() < least:
        raise NoTableError(NO_FIT)
    mean = float(np.sqrt((errors[kept] ** 2).mean()))
    return FoundTable(camera, sights, outline.height, scene.ball.radius, mean, note)


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
    found = []
    for mask in _even_colours(cv2.GaussianBlur(small, (0, 0), 1.0).astype(np.float32)):
        wide = np.pad(mask, bridge)  # else the edges of the picture are bridged, too
        wide = cv2.morphologyEx(wide, cv2.MORPH_CLOSE, np.ones((bridge, bridge), np.uint8))
        whole = wide[bridge:-bridge, bridge:-bridge].copy()
        edges = cv2.findContours(whole, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        if not edges:
            continue
        edge = max(edges, key=cv2.contourArea)
        quad = _four_sided(cv2.convexHull(edge))
        if quad is None or cv2.contourArea(edge) < LEAST_PART * mask.size:
            continue
        part = cv2.drawContours(np.zeros_like(mask), [edge], 0, 1, cv2.FILLED)
        covered = float((part & mask).sum()) / max(cv2.contourArea(quad.astype(np.float32)), 1.0)
        reach = np.concatenate([edge.min(axis=(0, 1)) < 2.0, edge.max(axis=(0, 1)) > last - 2.0])
        if covered > LEAST_CLOTH:
            found.append((reach, float(part.sum()), covered, quad, edge[:, 0].astype(np.float64)))
    if not found:
        raise NoTableError('no table is in sight: no even colour fills a rectangle')
    # A floor reaches beyond more edges of the picture than a table.
    beyond, _, filled, corners, outline = max(found, key=lambda each: (-each[0].sum(), each[1]))
    if beyond.any():
        names = np.array(['left', 'upper', 'right', 'lower'])[beyond]
        raise NoTableError(
            f'the cloth reaches beyond the {" and ".join(names)} edge of the picture: the whole '
            'table must be in sight'
        )
    if filled < LEAST_FILLED:
        raise NoTableError(f'something hides a part of the table: {100 * filled:.0f} % is cloth')
    return scale * (_crossings(_around(corners), outline) + 0.5) - 0.5


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
        bins = (colour[left][:, :2] * 40).astype(int) @ [41, 1]
        mean = np.median(colour[left][bins == np.bincount(bins).argmax()], axis=0)
        alike = (colour @ (mean / np.linalg.norm(mean)) > LEAST_COSINE) & (far > LEAST_BRIGHTNESS)
        left &= ~alike
        mask = cv2.morphologyEx(alike.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        yield mask


def _sampled(picture: Pixels, pixels: Floats) -> Floats:
    """Return the colours (..., 3) at pixels (n, m, 2)."""
    maps = pixels.astype(np.float32)
    return cv2.remap(picture, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)


def _noses(
    picture: Pixels,
    camera: Camera,
    half: Floats,
    height: float,
    holes: Floats,
    reach: float,
) -> Edges:
    """Find the steepest step along lines across the noses, each the mean of neighbours."""
    found, window = [], np.arange(-4, 5)  # 2 px
    for axis, sign in SIDES:
        at = np.full((ALONG, 2), sign)
        at[:, 1 - axis] = np.linspace(-1.0, 1.0, ALONG) * (1.0 - NEAR_CORNER / half[1 - axis])
        at = at[cdist(at * half, holes).min(axis=1, initial=np.inf) > NEAR_POCKET]
        ends = np.stack([np.insert(at * camera.half, 2, height, axis=1)] * 2)
        ends[:, :, axis] += np.array([[-reach], [reach]])
        first, last = camera.project(ends)
        longest = float(np.linalg.norm(last - first, axis=1).max())
        if not longest < 0.25 * max(camera.size):
            raise NoTableError(NO_FIT)
        count = max(int(4.0 * longest), 12)
        lines = np.linspace(first, last, count, axis=1)
        seen = cv2.blur(_sampled(picture, lines), (3, MEAN))
        some = slice(MEAN // 2, -(MEAN // 2), MEAN // 2)
        at, lines, slope = (
            at[some],
            lines[some],
            np.linalg.norm(np.diff(seen[some], axis=1), axis=-1),
        )
        k = np.clip(slope.argmax(axis=1), 4, count - 6)[:, np.newaxis]
        around = np.take_along_axis(slope, k + window, axis=1)
        offset = (around @ window) / np.maximum(around.sum(axis=1), 1e-9)
        part = (k + 0.5 + offset[:, np.newaxis]) / (count - 1)
        along = np.gradient(lines[:, 0], axis=0)
        across = np.column_stack([-along[:, 1], along[:, 0]])
        across /= np.linalg.norm(along, axis=1, keepdims=True)
        inside = ((lines > 1.0) & (lines < np.array(camera.size) - 2.0)).all(axis=(1, 2))
        pixels = lines[:, 0] + part * (lines[:, -1] - lines[:, 0])
        found.append((at[inside], pixels[inside], across[inside]))
    return Edges(*(np.concatenate(each) for each in zip(*found, strict=True)))


def _sights(
    picture: Pixels, camera: Camera, half: Floats, height: float, pockets: bool, along: float
) -> Sights:
    """Find the dots of the rails near their places; dots that stand elsewhere are left out."""
    at = [(x, y) for x in np.arange(-3, 4) / 4 for y in (-1.0, 1.0) if x or not pockets]
    at += [(x, y) for x in (-1.0, 1.0) for y in np.arange(-1, 2) / 2]
    parts = np.array(at)
    places = sight_places(parts, camera.half, SIGHT_AWAY, height + SIGHT_UP)
    fine = [np.linspace(-reach, reach, round(2e3 * reach) + 1) for reach in (along, SIGHT_REACH)]
    flat = np.stack(np.meshgrid(*fine), axis=-1).reshape(-1, 2)
    is_end = np.abs(parts[:, :1, np.newaxis]) == 1.0
    grid = np.insert(np.where(is_end, flat[:, ::-1], flat), 2, 0.0, axis=2)
    pixels = camera.project(places[:, np.newaxis] + grid)
    inside = ((pixels > 1.0) & (pixels < np.array(camera.size) - 2.0)).all(axis=(1, 2))
    if inside.sum() < LEAST_SIGHTS:
        return NO_SIGHTS
    parts, places, grid = parts[inside], places[inside], grid[inside]
    patch = _sampled(picture, pixels[inside])
    apart = np.linalg.norm(patch - np.median(patch, axis=1, keepdims=True), axis=-1)
    top = apart.max(axis=1, keepdims=True)
    peak = np.take_along_axis(grid, apart.argmax(axis=1)[:, np.newaxis, np.newaxis], axis=1)
    far = np.linalg.norm(grid - peak, axis=2)
    dots = np.where(far < 0.012, np.maximum(apart - 0.4 * top, 1e-9), 0.0)
    rings = np.where((far > 0.012) & (far < 0.016), apart, np.nan)
    offsets = (dots[..., np.newaxis] * grid).sum(axis=1) / dots.sum(axis=1, keepdims=True)
    outwards = (offsets[:, :2] * parts)[np.abs(parts) == 1.0]
    sideways = np.abs(offsets[:, :2][np.abs(parts) < 1.0])
    good = (top.ravel() > 20.0) & (np.nanmedian(rings, axis=1) < 0.4 * top.ravel())
    usual = np.median(outwards[good]) if good.any() else 0.0
    if along == SIGHT_REACH:
        good &= (np.abs(outwards - usual) < 0.006) & (sideways < 0.008)
    if good.sum() < LEAST_SIGHTS:
        return NO_SIGHTS
    return Sights(parts[good], camera.project((places + offsets)[good]))
