"""
Local maps of the strike: cubic polynomials in place of solved impacts.

The azimuth of a stroke only turns velocity and spin of the ball. Over the speed of the cue, these
are a function of the offsets a and b, of the elevation, and a little of that speed. A map divides
the four into cells, the speed by its ratio, and fits a polynomial to exact strikes in each cell
that a search needs. A cell is used only if other exact strikes, which had no part in the fit,
agree with it. A cell with miscues, kinks or discontinuities, or in which the tip meets the ball
twice in a strike, is divided into eight by a, b and elevation, and each of these is fitted where a
search needs it. Some corners are solved first: if most of them show a miscue or a second hit, as
in most cells of steep strokes, the cell is neither fitted nor divided. Strokes in such cells, in
cells that are too small to be divided, or that have few strokes, are solved exactly. The sign of a
mirrors a strike. The cue goes on from where its tip touched the ball: the strike would have left
it up to 1.5 mm from there.

Cells that choose strokes may have larger errors than those with which their success is stated.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from functools import lru_cache
import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.strikes import strike_alone
from billiard_shot.records import Array
from billiard_shot.scene.player import A, AZIMUTH, B, SPEED
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.table.mapped_strike import (
    ALL_SOLVED,
    EXPONENTS,
    Mapped,
    MOTION,
    SOLVED,
    TERMS,
    VARIED,
)

SIZES = np.array([0.2, 0.1, 0.08])  # of the largest cells: a and b (ball radii), elevation (rad)
SPEED_RATIO = 2.0  # of the fastest and the slowest stroke of a cell
LEVELS = 4  # sizes of cells, each half of the last
FITTED_STRIKES, HELD_OUT = 40, 14  # exact strikes in a cell
# Their places in the cell, -1 to 1: the first are near its corners, where miscues begin. No two of
# the first half of the corners, which are solved first, are neighbours.
SIGNS = 2.0 * np.array(list(np.ndindex(*(2,) * len(VARIED)))) - 1.0
CORNERS = 0.98 * SIGNS[np.argsort(-SIGNS.prod(axis=1), kind='stable')]
PROBES = len(CORNERS) // 2
INSIDE = 2.0 * quasi_random(FITTED_STRIKES + HELD_OUT - len(CORNERS), len(VARIED)) - 1.0
PLACES = np.concatenate([CORNERS, INSIDE])
TERMS_THERE = np.prod(PLACES[:, np.newaxis] ** EXPONENTS, axis=2)
LEAST_SQUARES = np.linalg.pinv(TERMS_THERE[:FITTED_STRIKES])
FEWEST = 24  # strokes of a search in a cell: with fewer, a fit does not pay
# Errors of a map that do not matter, in standard deviations of the player: in a search, and in the
# trials whose success is stated. A shift by the second changes a success by at most 0.8 points,
# because the density of a normal error is at most 0.4.
DEVIATION_SHARE, STRICT_SHARE = 0.2, 0.02
USUAL_SPEED, FASTEST = 2.0, 18.0  # m/s: faster strokes are not mapped

Cell: TypeAlias = tuple[int, int, int, int, int]
"""Level; how many sizes of a cell of this level its corner is away from zero; its slowest stroke.

The last one is a power of SPEED_RATIO, in m/s.
"""


def extent_of(cell: Cell) -> tuple[Array, Array]:
    """Return the middle (4,) of a cell, and half of its sizes, in the units of `Mapped`."""
    level, *corner, power = cell
    slowest, sizes = SPEED_RATIO**power, SIZES / 2**level
    half = 0.5 * np.append(sizes, (SPEED_RATIO - 1.0) * slowest)
    return np.append(corner * sizes, slowest) + half, half


class Fit(NamedTuple):
    """The strikes of a cell along +x, over the speed of the cue."""

    coefficients: Array  # (TERMS, MOTION), see `Mapped`
    # (MOTION,) root mean square in held-out strikes, spins times radius; or infinite
    errors: Array
    divides: bool  # whether smaller cells of it may be fitted


class Maps:
    """
    The cells that one search uses.

    Parameters
    ----------
    model : StrikeModel
    bounds : (MOTION,) float array
        Errors of velocity, of spin times radius, and of cue speed, that do not matter, see
        `bounds_of`.
    slower_than : float
        Speed of the cue from which on strokes are not mapped [m/s], see `reaching_speeds`.

    """

    def __init__(self, model: StrikeModel, bounds: Array, slower_than: float = math.inf) -> None:
        self.model, self.bounds, self.slower_than = model, bounds, min(slower_than, FASTEST)
        # Without errors of the player, every error of a map matters.
        self.applies = bool(bounds.any())
        self.fits = fits_of(model)
        self._strokes: Counter[Cell] = Counter()  # of this search so far

    def mapped(
        self,
        strokes: Array,
        fit: Callable[[list[Cell]], Iterable[Fit]],
        *,
        strict: bool = False,
    ) -> Mapped:
        """
        Choose the cells by which strokes (n, 5) are mapped, and fit those that are missing.

        A stroke that is NaN is not mapped; none is if the player makes no errors.

        Parameters
        ----------
        strokes : (n, 5) float array
        fit : callable
            Of a list of cells: what `fit_cell` returns for each.
        strict : bool
            Whether errors must be within `STRICT_SHARE`, not only within `DEVIATION_SHARE`.

        """
        if not self.applies:
            return ALL_SOLVED
        number = np.full(len(strokes), SOLVED)
        bounds = self.bounds * (STRICT_SHARE / DEVIATION_SHARE if strict else 1.0)
        left = np.flatnonzero(strokes[:, SPEED] < self.slower_than)
        used: list[Cell] = []
        for level in range(LEVELS):
            if not len(left):
                break
            cells, owner, counts = _cells_of(strokes[left], level)
            self._strokes.update(dict(zip(cells, counts, strict=True)))
            # Whether a fit pays depends only on this search, not on cells that are fitted.
            pays = [self._strokes[cell] >= FEWEST for cell in cells]
            missing = [
                cell
                for cell, each in zip(cells, pays, strict=True)
                if each and cell not in self.fits
            ]
            self.fits.update(zip(missing, fit(missing), strict=True))
            numbers = np.full(len(cells), SOLVED)
            divided = np.zeros(len(cells), np.bool_)
            for i in np.flatnonzero(pays).tolist():
                divided[i] = self.fits[cells[i]].divides
                if (self.fits[cells[i]].errors <= bounds).all():
                    numbers[i], divided[i] = len(used), False
                    used.append(cells[i])
            number[left] = numbers[owner]
            left = left[divided[owner]]
        extents = np.array([extent_of(cell) for cell in used]).reshape(-1, 2, len(VARIED))
        coefficients = [self.fits[cell].coefficients for cell in used]
        stacked = np.array(coefficients).reshape(-1, TERMS, MOTION)
        return Mapped(strokes, number, extents[:, 0], extents[:, 1], stacked)


@lru_cache(maxsize=8)
def fits_of(model: StrikeModel) -> dict[Cell, Fit]:
    """Return the fits that searches of this process have made so far."""
    return {}


def bounds_of(sigmas: Array) -> Array:
    """
    Find errors of a map that do not matter beside the errors of the player.

    Parameters
    ----------
    sigmas : (5,) float array
        Standard deviations of a, b (ball radii), elevation, azimuth (rad) and speed (m/s).

    Returns
    -------
    (MOTION,) float array
        Errors of velocity, of spin times radius, and of cue speed, relative to the cue speed. An
        offset changes the spin of a solid ball by 5/2 of the velocity.

    """
    along, spin = sigmas[SPEED] / USUAL_SPEED, 2.5 * min(sigmas[A], sigmas[B])
    return DEVIATION_SHARE * np.array([along, sigmas[AZIMUTH], along, spin, spin, spin, along])


def fit_cell(model: StrikeModel, cell: Cell) -> Fit:
    """Fit a polynomial to exact strikes in a cell, and find its error in others."""
    strokes, (middle, half) = np.zeros((len(PLACES), 5)), extent_of(cell)
    strokes[:, VARIED] = middle + half * PLACES
    regular = strike_alone(model, strokes[:PROBES]).regular
    if regular.all():
        struck = strike_alone(model, strokes)
        regular = struck.regular
    if not regular.all():
        return Fit(np.zeros((TERMS, MOTION)), np.full(MOTION, np.inf), bool(regular.mean() > 0.5))
    exact = np.column_stack(struck[:3]) / strokes[:, [SPEED]]
    found: Array = LEAST_SQUARES @ exact[:FITTED_STRIKES]
    errors: Array = TERMS_THERE[FITTED_STRIKES:] @ found - exact[FITTED_STRIKES:]
    found[:, 3:6] /= model.surface.radius
    return Fit(found, np.sqrt((errors**2).mean(axis=0)), divides=True)


def _cells_of(strokes: Array, level: int) -> tuple[list[Cell], NDArray[np.int64], list[int]]:
    """Find the cells of a level, the number of the cell of each stroke, and strokes in each."""
    places = strokes[:, VARIED]
    places[:, :3] /= SIZES / 2**level
    places[:, 0] = np.abs(places[:, 0])
    places[:, 3] = np.log(places[:, 3]) / math.log(SPEED_RATIO)
    indices = np.floor(places).astype(np.int64)
    a, b, elevation, speed = indices.T
    keys = ((a * 4096 + b + 2048) * 4096 + elevation + 2048) * 4096 + speed + 2048
    _, first, owner, counts = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    cells: list[Cell] = [(level, *corner) for corner in indices[first].tolist()]
    return cells, owner, counts.tolist()
