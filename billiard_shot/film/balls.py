"""
Balls in a picture: outlines of the size and at the place that the camera gives.

Spots that differ from the cloth propose centres. Each proposed ball is then moved until its
outline lies on edges, all around: rays cross the outline, and each finds where the difference from
the cloth falls. Rays towards another ball do not count, so that balls that touch do not
disturb each other. What has no such outline, as a hand, a cue or a shadow, is no ball.
"""

from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from billiard_shot.film.cloth import apart, Cloth, Pixels
from billiard_shot.film.lens import Bytes, Camera, Floats

RAYS, SAMPLES = 40, 29
"""Around an outline, and along a ray."""

LEVEL = 0.3
"""
An edge is where the difference from the cloth falls to this part of that inside.

Less than a half, as the dark side of a ball differs less than its middle.
"""

INSIDE, OUTSIDE = 0.5, 0.45
"""How far a ray begins inside and ends outside of the outline [radii]."""

ROUNDS = 4
"""How often the outlines are moved at most."""

SETTLED = 2e-3
"""Outlines that move by less are at their places [radii]."""

LEAST_APART, NOISES = 16.0, 5.0
"""How far a colour must be from that of the cloth [of 255], and in deviations of its pixels."""

LEAST_RADIUS = 5.0
"""Pictures are reduced as long as balls keep this radius [px]."""

LEAST_RAYS, MOST_SCATTER = 0.5, 0.12
"""Of the rays, that must find an edge, and how far these scatter at most [radii]."""

SAME, APART = 0.7, 1.6
"""Proposals, and balls in the end, that are nearer to each other are one ball [radii]."""

CLOSE = 1.26
"""A ray whose outline is within so many radii of another centre sees the other ball."""

SIZE_SPREAD = 0.06
"""Deviation of the radius of an outline, by blur and light [radii]."""

FLOOR = 0.06
"""Deviation of a place that all rays share [px]."""

MOST_PROPOSED = 60
"""Spots of a picture that are looked at."""

LEAST_COLOURED = 4
"""So many coloured spots of a core tell the colour of a ball with white."""

CORE = 0.6
"""Within this part of the radius lies the colour of a ball."""


SEEN = np.dtype([
    ('time', float),  # s
    ('place', float, 2),  # m
    ('sigma', float),  # standard deviation of x and y, the larger one, m
    ('pixel', float, 2),  # of the centre
    ('colour', float, 3),  # as seen in the mean light of the cloth, of 255
    ('white', float),  # share of the core
])  # fmt: skip
"""A ball in a picture."""

Seen: TypeAlias = NDArray[np.void]
"""Balls of a picture in no order, or a ball in successive pictures."""


class BallFinder:
    """
    Finds balls in pictures of one camera.

    Parameters
    ----------
    camera : Camera
    cloth : Cloth
    radius : float
        Of the balls [m].

    """

    def __init__(self, camera: Camera, cloth: Cloth, radius: float) -> None:
        self.camera, self.cloth, self.radius = camera, cloth, radius
        self._scale = max(1, int(self._radii(np.zeros((1, 2)))[0] / LEAST_RADIUS))
        high, wide = cloth.bed.shape
        size = wide // self._scale, high // self._scale
        self._colour = cv2.resize(cloth.colour, size, interpolation=cv2.INTER_AREA)
        self._bed = cv2.resize(cloth.bed, size, interpolation=cv2.INTER_NEAREST)
        self._least = max(LEAST_APART, NOISES * cloth.noise)
        self._light = cloth.colour[cloth.bed > 0].mean()

    def _lifted(self, places: Floats) -> Floats:
        return np.insert(places, 2, self.radius, axis=1)

    def _radii(self, places: Floats) -> Floats:
        """Return the radii [px] of balls at places (n, 2) [m]."""
        far = np.linalg.norm(self._lifted(places) - self.camera.place, axis=1)
        return self.camera.focal * self.radius / far

    def find(self, picture: Bytes) -> Seen:
        """
        Find the balls of a picture, without times.

        Parameters
        ----------
        picture : (height, width, 3) uint8 array
            RGB.

        """
        gain = self.cloth.gain(picture)
        places = self._propose(picture, gain)
        places = places[self._distinct(places, SAME)]
        sigma = np.empty(len(places))
        for k in range(ROUNDS):
            if not len(places):
                break
            moved, sigma, good = self._settle(picture, gain, places)
            moves = np.abs(moved - places).max(axis=1)
            places = moved
            if k > 0:  # a spot that is no ball must not hide its neighbours
                good &= (np.abs(places) < self.camera.half + self.radius).all(axis=1)
                order = np.flatnonzero(good)[np.argsort(sigma[good])]
                kept = order[self._distinct(places[order], APART)]
                places, sigma = places[kept], sigma[kept]
                if (moves[kept] < SETTLED * self.radius).all():
                    break
        seen = np.zeros(len(places), SEEN)
        if len(places):
            seen['place'], seen['sigma'] = places, sigma
            seen['pixel'] = self.camera.project(self._lifted(places))
            seen['colour'], seen['white'] = self._colours(picture, gain, seen['pixel'], places)
        return seen

    def _propose(self, picture: Bytes, gain: float) -> Floats:
        """Return the places of spots that are as wide as balls."""
        size = self._colour.shape[1::-1]
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        spots = (apart(small, self._colour, gain) > self._least) & (self._bed > 0)
        depth = cv2.distanceTransform(spots.astype(np.uint8), cv2.DIST_L2, 5)
        around = cv2.dilate(depth, np.ones((5, 5), np.uint8))
        v, u = np.nonzero((depth >= around) & (depth > 0.3 * LEAST_RADIUS))
        pixels = self._scale * np.column_stack([u, v]).astype(np.float64)
        places = self.camera.to_plane(pixels + 0.5 * (self._scale - 1), self.radius)
        ratio = np.abs(np.log2(depth[v, u] * self._scale / self._radii(places)))
        order = np.argsort(ratio)[:MOST_PROPOSED]
        return places[order[ratio[order] < 1.0]]

    def _distinct(self, places: Floats, least: float) -> list[int]:
        """Return the places that are so many radii away from all before them."""
        near = cdist(places, places) <= least * self.radius
        kept: list[int] = []
        for k, others in enumerate(near):
            if not others[kept].any():
                kept.append(k)
        return kept

    def _settle(
        self, picture: Bytes, gain: float, places: Floats
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """
        Move outlines onto edges; return places, their deviations, and which are balls.

        Shifts and a radius are fitted to the edges of clear rays, with little weight to outliers.
        """
        lifted = self._lifted(places)
        outline = self.camera.outlines(lifted, self.radius, RAYS)
        away = outline - outline.mean(axis=1, keepdims=True)
        radii = np.linalg.norm(away, axis=-1)
        away /= radii[..., np.newaxis]
        edge, clear = self._edges(picture, gain, outline, away, radii)
        mean, slopes = radii.mean(axis=1), self.camera.slopes(lifted)
        terms = np.concatenate([away @ slopes, np.ones((*radii.shape, 1))], axis=-1)
        prior = np.zeros((len(places), 3, 3))
        prior[:, 2, 2] = 1.0 / (SIZE_SPREAD * mean) ** 2
        prior[:, 0, 0] = prior[:, 1, 1] = 1.0 / (0.5 * self.radius) ** 2
        weight, scale = clear.astype(np.float64), 0.25 * mean[:, np.newaxis]
        for _ in range(6):
            noise = weight / (0.3 * scale) ** 2
            normal = np.einsum('brk,br,brl->bkl', terms, noise, terms) + prior
            right = np.einsum('brk,br->bk', terms, noise * edge)
            step = np.linalg.solve(normal, right[..., np.newaxis])[..., 0]
            off = edge - np.einsum('brk,bk->br', terms, step)
            spread = np.median(np.where(clear, np.abs(off), np.inf), axis=1, keepdims=True)
            scale = np.clip(4.5 * spread, 0.5, 0.5 * mean[:, np.newaxis])
            weight = clear * np.clip(1.0 - (off / scale) ** 2, 0.0, 1.0) ** 2
        total = np.maximum(weight.sum(axis=1), 1e-9)
        scatter = np.sqrt((weight * off**2).sum(axis=1) / total)
        good = ((weight > 0.2).mean(axis=1) > LEAST_RAYS) & (scatter < MOST_SCATTER * mean)
        good &= np.abs(step[:, 2]) < 2.5 * SIZE_SPREAD * mean
        normal = np.einsum('brk,br,brl->bkl', terms, weight, terms) + 1e-9 * prior
        # neighbouring rays share pixels: a half of them counts
        variance = 2.0 * scatter**2 * np.linalg.norm(np.linalg.inv(normal)[:, :2, :2], 2, (1, 2))
        metres = 1.0 / np.linalg.norm(slopes, -2, (1, 2))  # of a pixel, its longer side
        return places + step[:, :2], np.sqrt(variance + (FLOOR * metres) ** 2), good

    def _edges(
        self, picture: Bytes, gain: float, outline: Floats, away: Floats, radii: Floats
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Return how far outside of outlines rays find edges [px], and which find one clearly."""
        parts = np.linspace(-INSIDE, OUTSIDE, SAMPLES)
        steps = radii[..., np.newaxis] * parts  # (balls, rays, samples) [px]
        pixels = outline[:, :, np.newaxis] + steps[..., np.newaxis] * away[:, :, np.newaxis]
        flat = pixels.reshape(len(pixels), -1, 2).astype(np.float32)
        seen = cv2.remap(picture, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR)
        differs = apart(seen.astype(np.float32), self._cloth_at(flat), gain).reshape(steps.shape)
        inner = differs[..., (parts > -0.4) & (parts < -0.15)].mean(axis=-1)
        level = LEVEL * inner
        below = differs < level[..., np.newaxis]
        first = np.clip(below.argmax(axis=-1), 1, SAMPLES - 1)[..., np.newaxis]
        high = np.take_along_axis(differs, first - 1, -1)[..., 0]
        low = np.take_along_axis(differs, first, -1)[..., 0]
        part = np.clip((high - level) / np.maximum(high - low, 1e-6), 0.0, 1.0)
        edge = radii * (parts[first[..., 0] - 1] + part * (parts[1] - parts[0]))
        clear = below.any(axis=-1) & ~below[..., 0] & (inner > self._least)
        # rays towards another ball see that one; two proposals for one ball are no others
        middle, mean = outline.mean(axis=1), radii.mean(axis=1)
        others = cdist(middle, middle) >= 1.2 * mean
        near = np.linalg.norm(outline[:, :, np.newaxis] - middle, axis=-1) < CLOSE * mean
        return edge, clear & ~(near & others[:, np.newaxis]).any(axis=-1)

    def _cloth_at(self, pixels: NDArray[np.floating]) -> Pixels:
        """Return the colours of the cloth at the pixels (..., 2) of the picture."""
        nearest = np.clip(np.round(pixels).astype(int), 0, np.array(self.camera.size) - 1)
        return self.cloth.colour[nearest[..., 1], nearest[..., 0]]

    def _colours(
        self, picture: Bytes, gain: float, centres: Floats, places: Floats
    ) -> tuple[Floats, Floats]:
        """Return the colours of the cores, and how much of each is white."""
        lifted = self._lifted(places)
        rings = [self.camera.outlines(lifted, k * CORE * self.radius, 12) for k in (0.5, 1.0)]
        maps = np.concatenate([centres[:, np.newaxis], *rings], axis=1).astype(np.float32)
        seen = cv2.remap(picture, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
        local = self._cloth_at(centres).mean(axis=-1)
        light = np.maximum(gain * local / self._light, 0.2)
        seen = seen.astype(np.float64) / light[:, np.newaxis, np.newaxis]
        bright = seen.max(axis=-1)
        white = (seen.min(axis=-1) > 0.72 * bright) & (bright > 110.0)
        counted = ~white | (white.sum(axis=1) > white.shape[1] - LEAST_COLOURED)[:, np.newaxis]
        kept = np.where(counted[..., np.newaxis], seen, np.nan)
        return np.nanmedian(kept, axis=1), white.mean(axis=1)
