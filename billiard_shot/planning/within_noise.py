"""Many strokes, as accurate as the errors of the player call for; with maps of the strike."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import chain
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.planning.statistics import quasi_random
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.errors import InputError
from billiard_shot.scene.fields import read
from billiard_shot.scene.player import A, AZIMUTH, B, NOISES, SPEED
from billiard_shot.shot import play
from billiard_shot.shot.effects import StrikeModel
from billiard_shot.shot.stroke import playable_offsets, read_rows, vectors_of
from billiard_shot.status import MISS, OK
from billiard_shot.table.run.states import TableStates
from billiard_shot.table.run.task import in_threads
from billiard_shot.table.strike.placement import (
    ALL_SOLVED,
    EXPONENTS,
    MOTION,
    SOLVED,
    StrikePolynomials,
    TERMS,
    VARIED,
)

TRIALS = play.Accuracy(1e-3, checked=False)  # of the trials of finished plans
# m: while strokes are compared, trajectories may err by the displacement that the standard error
# of the azimuth causes over this distance
ORDINARY_PATH = 2.0


def accuracy_within(sigmas: Array) -> play.Accuracy:
    """
    Find the accuracy that the errors of a player call for.

    Parameters
    ----------
    sigmas : (5,) float array
        Standard deviations of a, b (ball radii), elevation, azimuth (rad) and speed (m/s).

    """
    tolerance = max(TRIALS.tolerance, ORDINARY_PATH * float(sigmas[AZIMUTH]))
    return TRIALS._replace(tolerance=tolerance, fast_rebounds=True)


def noise_of(scene: Scene, noise: str | Noise | Mapping[str, Any] | None) -> Noise:
    """
    Read the execution noise of a request, by default that of the scene, with its model's error.

    Raises
    ------
    ValueError
        If it is none of `NOISES`, or a mapping with mistakes.

    """
    if noise is None:
        return scene.planned_noise
    if isinstance(noise, str) and noise in NOISES:
        noise = NOISES[noise]
    elif isinstance(noise, Mapping):
        try:
            noise = read(Noise, noise)
        except InputError as error:
            raise InputError(error.mistakes, 'noise') from None
    if isinstance(noise, Noise):
        return noise.beside(scene.model_error)
    raise ValueError(
        f'noise must be {", ".join(NOISES)} or a mapping of standard deviations, got {noise!r}'
    )


STRIKE_TOLERANCE = 1e-4  # m, of the trajectories


class StrikeOutcomes(NamedTuple):
    """
    Ball and cue after n strikes.

    Attributes
    ----------
    velocity, surface : (n, 3) float arrays
        Velocity of the ball, and its spin times its radius [m/s]; NaN if the stroke cannot be
        played.
    cue_speed : (n,) float array
        [m/s]
    regular : (n,) bool array
        Whether the strike was solved, with one hit and without a miscue.
    fails : (n,) bool array
        Whether the stroke cannot be played, or is a miscue or a double hit.

    """

    velocity: Array
    surface: Array
    cue_speed: Array
    regular: NDArray[np.bool_]
    fails: NDArray[np.bool_]


def strike_alone(
    model: StrikeModel, strokes: Array, tolerance: float = STRIKE_TOLERANCE
) -> StrikeOutcomes:
    """Strike the ball with strokes (n, 5), see `vectors_of`."""
    cues = play.solve_strikes(model, *vectors_of(strokes), tolerance)
    refused = cues['status'] >= MISS
    played = np.where(refused, np.nan, 1.0)
    regular = (cues['status'] == OK) & ~cues['miscue'] & (cues['hits'] == 1)
    velocity, spin = (played[:, np.newaxis] * cues[name] for name in ('velocity', 'spin'))
    fails = refused | cues['miscue'] | (cues['double_hit'] == 0.0)
    return StrikeOutcomes(
        velocity, model.surface.radius * spin, played * cues['speed'], regular, fails
    )


def along_azimuth(model: StrikeModel, strokes: Array) -> Array:
    """Turn strokes (n, 5) so that the ball, not the cue, starts along their azimuth."""
    along_x = strokes.copy()
    along_x[:, AZIMUTH] = 0.0
    different, which = np.unique(along_x.round(6), axis=0, return_inverse=True)
    x, y, _ = strike_alone(model, different).velocity[which.ravel()].T
    turned = strokes.copy()
    turned[:, AZIMUTH] -= np.nan_to_num(np.arctan2(y, x))
    return turned


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
FEWEST = 24  # strokes of a search in a cell: with fewer, a fit does not pay
LEAST_HALF = 1e-9  # of the half sizes of a box, if errors vanish
# Quadratic terms fit the strikes of a cloud, which is small. Strikes that fail or deviate are left
# out; strokes of which the nearest strike was left out are solved.
CLOUD_STRIKES, FEWEST_REGULAR = 36, 24  # exact strikes in a cloud; of these, without deviations
FEWEST_IN_CLOUD = 2 * CLOUD_STRIKES
QUADRATIC = EXPONENTS.sum(axis=1) <= 2
DEVIATION = 0.3  # from the other strikes of a cloud: as a share of their scatter
# Errors of a map that do not matter, in standard deviations of the player: in a search, and in the
# trials whose success is stated. A shift by the second changes a success by at most 0.8 points,
# because the density of a normal error is at most 0.4.
DEVIATION_SHARE, STRICT_SHARE = 0.2, 0.02
USUAL_SPEED, FASTEST = 2.0, 18.0  # m/s: faster strokes are not mapped

Cell: TypeAlias = tuple[int, int, int, int, int]
"""Level; how many sizes of a cell of this level its corner is away from zero; its slowest stroke.

The last one is a power of SPEED_RATIO, in m/s.
"""


class Box(NamedTuple):
    """A cell, or the cloud of errors around a stroke, in which strikes are fitted."""

    middle: Array  # (4,) of a, b (ball radii), elevation (rad), speed (m/s)
    half: Array  # (4,) half of its sizes
    places: Array = PLACES  # (n, 4) of the strikes, from -1 to 1
    # (MOTION,) deviations of a cloud's strikes that do not matter; None: this is a cell
    bounds: Array | None = None


class BoxFit(NamedTuple):
    """The strikes in a box along +x, over the speed of the cue; spins times radius."""

    coefficients: Array  # (TERMS, MOTION), see `StrikePolynomials`
    errors: Array  # (MOTION,) root mean square in held-out strikes, or infinite
    regular: NDArray[np.bool_]  # (n,) the strikes that were fitted
    divides: bool  # whether smaller cells of it may be fitted

    def near_regular(self, box: Box, strokes: Array) -> NDArray[np.bool_]:
        """Find the strokes (k, 5) of which the nearest strike of the box was fitted."""
        away = _varied(box, strokes)[:, np.newaxis] - box.places
        nearest = np.square(away).sum(axis=2).argmin(axis=1)
        return self.regular[nearest]


def box_of(cell: Cell) -> Box:
    """Return the box of a cell."""
    level, *corner, power = cell
    slowest, sizes = SPEED_RATIO**power, SIZES / 2**level
    half = 0.5 * np.append(sizes, (SPEED_RATIO - 1.0) * slowest)
    return Box(np.append(corner * sizes, slowest) + half, half)


def cloud_around(strokes: Array, bounds: Array) -> Box:
    """Return the box of strokes (n, 5), of which the first are its strikes, see `Box`."""
    varied = _varied(Box(np.zeros(4), np.ones(4)), strokes)
    low, high = varied.min(axis=0), varied.max(axis=0)
    box = Box(0.5 * (low + high), np.maximum(0.5 * (high - low), LEAST_HALF))
    return box._replace(places=_varied(box, strokes[:CLOUD_STRIKES]), bounds=bounds)


def _varied(box: Box, strokes: Array) -> Array:
    """Find the places (n, 4) of strokes in a box, from -1 to 1; those of a < 0 are mirrored."""
    varied = strokes[:, VARIED]
    varied[:, 0] = np.abs(varied[:, 0])
    places: Array = (varied - box.middle) / box.half
    return places


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
        fit: Callable[[list[Box]], Iterable[BoxFit]],
        *,
        strict: bool = False,
        each: int = 1,
    ) -> StrikePolynomials:
        """
        Choose the boxes by which strokes (n, 5) are mapped, and fit those that are missing.

        These are cells. Where cells do not serve, unless `strict`, a cloud has a box of its own. A
        stroke that is NaN is not mapped; none is if the player makes no errors.

        Parameters
        ----------
        strokes : (n, 5) float array
        fit : callable
            Of a list of boxes: what `fit_box` returns for each.
        strict : bool
            Whether errors must be within `STRICT_SHARE`, not only within `DEVIATION_SHARE`.
        each : int
            So many strokes, one after the other, are a cloud: one stroke with different errors.

        """
        if not self.applies:
            return ALL_SOLVED
        number = np.full(len(strokes), SOLVED)
        bounds = self.bounds * (STRICT_SHARE / DEVIATION_SHARE if strict else 1.0)
        slow = strokes[:, SPEED] < self.slower_than
        left, used = np.flatnonzero(slow), list[tuple[Box, BoxFit]]()
        for level in range(LEVELS):
            if not len(left):
                break
            cells, owner, counts = _cells_of(strokes[left], level)
            self._strokes.update(dict(zip(cells, counts, strict=True)))
            # Whether a fit pays depends only on this search, not on cells that are fitted.
            due = [i for i, cell in enumerate(cells) if self._strokes[cell] >= FEWEST]
            missing = [cells[i] for i in due if cells[i] not in self.fits]
            self.fits.update(zip(missing, fit(list(map(box_of, missing))), strict=True))
            numbers = np.full(len(cells), SOLVED)
            divided = np.zeros(len(cells), np.bool_)
            for i in due:
                found = self.fits[cells[i]]
                divided[i] = found.divides
                if (found.errors <= bounds).all():
                    numbers[i], divided[i] = len(used), False
                    used.append((box_of(cells[i]), found))
            number[left] = numbers[owner]
            left = left[divided[owner]]
        clouds: list[NDArray[np.int64]] = []
        if each >= FEWEST_IN_CLOUD and not strict:
            rows = np.flatnonzero(slow & (number == SOLVED))
            parts = np.split(rows, np.searchsorted(rows, np.arange(each, len(strokes), each)))
            clouds = [part for part in parts if len(part) >= FEWEST_IN_CLOUD]
        boxes = [cloud_around(strokes[cloud], bounds) for cloud in clouds]
        for cloud, box, found in zip(clouds, boxes, fit(boxes), strict=True):
            number[cloud[found.near_regular(box, strokes[cloud])]] = len(used)
            used.append((box, found))
        extents = np.array([box[:2] for box, _ in used]).reshape(-1, 2, len(VARIED))
        coefficients = np.array([found.coefficients for _, found in used])
        stacked = coefficients.reshape(-1, TERMS, MOTION)
        return StrikePolynomials(strokes, number, extents[:, 0], extents[:, 1], stacked)


@lru_cache(maxsize=8)
def fits_of(model: StrikeModel) -> dict[Cell, BoxFit]:
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


def fit_box(model: StrikeModel, box: Box) -> BoxFit:
    """Fit a polynomial to exact strikes in a box, and find its error in others."""
    strokes = np.zeros((len(box.places), 5))
    strokes[:, VARIED] = box.middle + box.half * box.places
    terms = np.prod(box.places[:, np.newaxis] ** EXPONENTS, axis=2)
    if box.bounds is not None:
        return _fit_cloud(model, strokes, terms, box.bounds)
    parts = [strike_alone(model, strokes[:PROBES])]
    if parts[0].regular.all():
        parts.append(strike_alone(model, strokes[PROBES:]))
    struck = StrikeOutcomes(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    regular = struck.regular
    if not regular.all():
        divides = bool(regular.mean() > 0.5)
        return BoxFit(np.zeros((TERMS, MOTION)), np.full(MOTION, np.inf), regular, divides)
    exact = np.column_stack(struck[:3]) / strokes[:, [SPEED]]
    found: Array = np.linalg.pinv(terms[:FITTED_STRIKES]) @ exact[:FITTED_STRIKES]
    errors: Array = terms[FITTED_STRIKES:] @ found - exact[FITTED_STRIKES:]
    found[:, 3:6] /= model.surface.radius
    return BoxFit(found, np.sqrt((errors**2).mean(axis=0)), regular, divides=True)


def _fit_cloud(model: StrikeModel, strokes: Array, terms: Array, bounds: Array) -> BoxFit:
    """
    Fit a polynomial to the strikes of a cloud that agree with each other.

    A tip may touch the ball again, unless that is a double hit. The strike that deviates most from
    a fit of the others is left out, until none deviates by more than `DEVIATION` of their scatter,
    or `bounds`. If few are left, none is regular.
    """
    struck = strike_alone(model, strokes)
    exact = np.column_stack(struck[:3]) / strokes[:, [SPEED]]
    rows, found = np.flatnonzero(~struck.fails), np.zeros((TERMS, MOTION))
    regular = np.zeros(len(strokes), np.bool_)
    while len(rows) >= FEWEST_REGULAR:
        part = terms[np.ix_(rows, QUADRATIC)]
        inverse = np.linalg.pinv(part)
        found[QUADRATIC] = inverse @ exact[rows]
        # the errors if each strike in turn were not fitted
        own = np.einsum('ij,ji->i', part, inverse).clip(max=0.99)
        errors = (part @ found[QUADRATIC] - exact[rows]) / (1.0 - own)[:, np.newaxis]
        allowed = np.maximum(bounds, DEVIATION * exact[rows].std(axis=0))
        deviation = (np.abs(errors) / allowed).max(axis=1)
        worst = deviation.argmax()
        if deviation[worst] <= 1.0:
            regular[rows] = True
            break
        rows = np.delete(rows, worst)
    found[:, 3:6] /= model.surface.radius
    return BoxFit(found, np.zeros(MOTION), regular, divides=False)


def _cells_of(strokes: Array, level: int) -> tuple[list[Cell], NDArray[np.int64], list[int]]:
    """Find the cells of a level, the number of the cell of each stroke, and strokes in each."""
    a, b, elevation, speed = strokes[:, VARIED].T
    sizes, power = SIZES / 2**level, np.log(speed) / math.log(SPEED_RATIO)
    places = np.column_stack([np.stack([np.abs(a), b, elevation], axis=1) / sizes, power])
    indices = np.floor(places).astype(np.int64)
    # np.unique of rows takes ten times as long
    order = np.lexsort(indices.T[::-1])
    begins = np.append(True, (np.diff(indices[order], axis=0) != 0).any(axis=1))
    owner = np.empty(len(order), np.int64)
    owner[order] = np.cumsum(begins) - 1
    cells: list[Cell] = [(level, *corner) for corner in indices[order[begins]].tolist()]
    return cells, owner, np.bincount(owner).tolist()


def predict_within_noise(
    scene: SceneLike,
    offsets: ArrayLike,
    noise: str | Noise | Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> play.StrokeBatch:
    """
    Predict many strokes at once, as accurately as the errors of the player call for.

    Where at least 24 strokes are alike, their strikes come from a polynomial that was fitted to
    exact strikes, if held-out strikes agree with it within a fifth of the player's errors. Other
    strikes are solved. Rebounds of lying balls are interpolated: 95 % of them err by less than
    0.5 % of the ball's speed. Trajectories err by at most the displacement that the error of the
    azimuth causes over 2 m, or 1 mm. Single strokes can differ from `predict`, whose answer is
    exact; shares of many strokes agree, see docs/batches.md.

    Parameters
    ----------
    scene : Scene, str or Path
    offsets : (n, 5) array_like
        As of `predict_batch`.
    noise : str, Noise or mapping, optional
        As of `plan`.
    workers : int, optional
        Threads; by default as many as there are cores.

    Raises
    ------
    ValueError
        If an argument makes no sense.

    """
    scene = Scene.load(scene)
    strokes = playable_offsets(read_rows('offsets', offsets, 5))
    sigmas = noise_of(scene, noise).sigmas(scene.ball.radius)
    return play_within_noise(scene, strokes, sigmas, workers=workers)


def play_within_noise(
    scene: Scene,
    strokes: Array,
    sigmas: Array,
    tables: TableStates | None = None,
    workers: int | None = None,
) -> play.StrokeBatch:
    """
    Play strokes, mapping their strikes where maps are accurate enough.

    Parameters
    ----------
    scene : Scene
    strokes : (n, 5) float array
        See `vectors_of`; NaN where there is no stroke.
    sigmas : (5,) float array
        Standard deviations of a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
    tables, workers
        As of `play_strokes`.

    """
    prepared = play.prepared_scene(scene)
    slower_than = math.inf if tables is not None else prepared.reaching
    maps = Maps(prepared.model, bounds_of(sigmas), slower_than)

    def fitted(boxes: list[Box]) -> Iterator[BoxFit]:
        def fit(part: slice) -> list[BoxFit]:
            return [fit_box(prepared.model, box) for box in boxes[part]]

        return chain.from_iterable(in_threads(fit, len(boxes), workers))

    mapped, accuracy = maps.mapped(strokes, fitted), accuracy_within(sigmas)
    return play.play_strokes(scene, *vectors_of(strokes), tables, accuracy, mapped, workers)
