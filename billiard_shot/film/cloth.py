"""
The cloth, as a picture without balls would show it, and what differs from it.

Light is uneven: each channel is a polynomial of the place in the picture. A shadow scales a
colour, so that the cloth has the colours of a segment, from deep shadow to full light; how far a
pixel is from it tells what is no cloth.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from billiard_shot.film.lens import Bytes, Camera, Floats

Pixels = NDArray[np.float32]

DEGREE = 4
"""Of the polynomials."""

DARKEST, BRIGHTEST = 0.5, 1.12
"""Of cloth, as parts of its usual brightness."""

ROUNDS, MOST_OFF = 4, 3.0
"""Fits, and the deviations beyond which a pixel is left out of the next one."""

LEAST_CLOTH = 0.4
"""Of the bed that must be cloth."""


@dataclass(frozen=True, slots=True, eq=False)
class Cloth:
    """
    Colours of a bed in a picture.

    Parameters
    ----------
    colour : (height, width, 3) float array
        Of the cloth [of 255].
    bed : (height, width) uint8 array
        1 where balls and cushions' noses may be seen, else 0.
    noise : float
        Deviation of a pixel of cloth from the segment of its colours [of 255].

    """

    colour: Pixels
    bed: Bytes
    noise: float

    def gain(self, picture: Bytes) -> float:
        """Return how much brighter a picture is than the one of the fit, as phones change it."""
        step = max(1, self.bed.shape[1] // 60)
        part = (slice(step // 2, None, step),) * 2
        cloth, seen = self.colour[part].sum(-1), picture[part].sum(-1)
        return float(np.median((seen / np.maximum(cloth, 1.0))[self.bed[part] > 0]))


def apart(picture: Pixels, cloth: Pixels, gain: float = 1.0) -> Pixels:
    """Return how far colours (n, m, 3) are from the segments of the colours of cloth."""
    part = _sums(picture * cloth) / np.maximum(_sums(cloth * cloth), 1.0)
    rest = picture - np.clip(part, DARKEST * gain, BRIGHTEST * gain)[..., np.newaxis] * cloth
    return np.sqrt(_sums(rest * rest))


def _sums(colours: NDArray[np.floating]) -> Pixels:
    """Return the sums over channels of colours (n, m, 3), as `sum(-1)`, but ten times faster."""
    return cv2.transform(colours, np.ones((1, 3), np.float32))


def fit_cloth(picture: Bytes, camera: Camera, height: float) -> Cloth:
    """
    Fit the light on the cloth.

    Parameters
    ----------
    picture : (height, width, 3) uint8 array
        A picture or, better, the median of several ones, in which balls have moved.
    camera : Camera
    height : float
        Of the noses [m].

    Raises
    ------
    ValueError
        If too little of the bed has one colour.

    """
    high, wide = picture.shape[:2]
    bed = np.zeros((high, wide), np.uint8)
    cv2.fillPoly(bed, [np.round(camera.rim(height, 0.3 * height)).astype(np.int32)], 1)
    step = max(1, wide // 320)
    inner = cv2.erode(bed, np.ones((5, 5), np.uint8))[::step, ::step] > 0
    v, u = np.mgrid[0:high:step, 0:wide:step]
    terms = _terms(u / wide - 0.5, v / high - 0.5)
    seen = picture[::step, ::step].astype(np.float64)
    middle = np.median(seen[inner], axis=0)
    kept = inner & (np.abs(seen - middle).sum(-1) < 0.6 * middle.sum())
    for _ in range(ROUNDS):
        if kept.sum() < LEAST_CLOTH * inner.sum():
            raise ValueError('too little of the bed has one colour')
        factors = np.linalg.lstsq(terms[kept], seen[kept], rcond=None)[0]
        off = np.linalg.norm(seen - terms @ factors, axis=-1)
        kept = inner & (off < MOST_OFF * max(1.5 * float(np.median(off[inner])), 2.0))
    across = ((np.arange(n) + 0.5) / n - 0.5 for n in (64, 36))
    field = (_terms(*np.meshgrid(*across)) @ factors).astype(np.float32)
    colour = cv2.resize(field, (wide, high), interpolation=cv2.INTER_CUBIC).clip(1.0, 255.0)
    rest = apart(picture.astype(np.float32), colour)[bed > 0]
    return Cloth(colour, bed, max(float(np.median(rest)) * 1.5, 1.0))


def _terms(u: Floats, v: Floats) -> Floats:
    """Return the terms (..., n) of a polynomial."""
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    return np.stack([u**i * v**j for i, j in powers], axis=-1)
