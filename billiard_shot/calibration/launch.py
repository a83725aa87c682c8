"""
Launches: the start of a shot as numbers that can be fitted, and how well they explain its samples.

The numbers of a launch: the speed of the struck ball [m/s]; its direction [rad]; its spin times
its radius [m/s] about the axes by which it rolls (follow), turns about the vertical (side), and
curves (masse); and for each ball the distance (x, y) [m] from where it was seen to lie. The struck
ball may lie farther off along its way: this stands for an error of the time of the strike.

If the stroke was commanded, the first five numbers are its errors, in standard deviations: of a,
b, elevation, azimuth and speed. The scene then tells velocity and spin, so that shots decide
numbers of the cue, too.

A sample that errs by r counts log(1 + (r / s)^2), as if errors had the distribution of Cauchy
with the scale s: a path that leaves the recorded one after a collision does not outweigh all
others. The scale grows with time, as the errors of predictions do.

Launches are improved by Gauss-Newton steps with the damping of Levenberg and Marquardt (Nocedal
and Wright, Numerical Optimization, 2nd ed., section 10.3), weighted again in each step (Holland
and Welsch, Commun. Stat. A 6 (1977)). All launches of a shot and all steps of differences are
simulated in one batch.

Nothing is seen of the spin that the cue gives, and after a few collisions the smallest change of a
launch leads elsewhere. So a search compares the first half second, then longer parts; at each
horizon the best launches, and some drawn around them, go on.

The first samples alone do not tell the spin, and the launch that explains them best may have any
spin. So likely spins are those of other strokes of the player, as far as they are known, with left
side as likely as right side.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.calibration.recording import (
    Floats,
    Frame,
    Recording,
    Samples,
    StrokeErrors,
    USUAL_SPINS,
)
from billiard_shot.cue.mechanism import Alignment
from billiard_shot.cue.mechanism import EXACT as EXACT_MACHINE
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.planning.within_noise import strike_alone
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import nose_standoff
from billiard_shot.scene.player import A, B, with_errors
from billiard_shot.shot.effects import model_of as strike_model_of
from billiard_shot.status import OFF_TABLE, OK
from billiard_shot.table.model.geometry import BallClothParams, TableParams
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.run.simulate import simulate
from billiard_shot.table.run.states import in_cushions, TableStates, VECTORS
from billiard_shot.table.run.task import DEFAULT_TOLERANCE as TOLERANCE
from billiard_shot.table.run.task import run_tables, TableTask

SPEED, DIRECTION, FOLLOW, SIDE, MASSE = range(5)
PLACES = 5  # number of the first place; all before it are those of the strike

ERROR_STEP = 0.02
"""Step of the errors of a stroke for differences, in standard deviations."""

LEAST_ERRORS = np.array([3e-3, 3e-3, 2e-3, 1e-3, 1e-2])
"""
Deviations of a commanded stroke, at least (ball radii, rad, m/s): strikes of scenes are not exact.

Without them, launches could not follow while other numbers are far from those of the table.
"""

LEAST_PLACE_SIGMA = 0.5e-3
"""Places before the strike are known no better [m]: pictures are distorted."""

GAP = 1e-7
"""Gap that is left between balls, and to a nose, if they were seen to overlap [m]."""

PUSHES = 4
"""How often balls that overlap are moved apart: three that touch need two."""

MAX_EVENTS = 2000

CONTACTS = EventKind.BALL, EventKind.CUSHION, EventKind.CLUSTER

FASTEST = 100.0
"""Faster balls are not simulated [m/s]."""

SAMPLE_TIME = 0.1
"""Errors within this time are alike [s]: samples of one ball within it count as one."""

KNOTS = np.array([0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0])
"""Times between which scales are interpolated [s]."""

FIRST_SCALES = np.array([1e-3, 1.5e-3, 3e-3, 7e-3, 18e-3, 40e-3, 80e-3])
"""Scales at these times before anything is known [m]: those of a table that is not known well."""

LEAST_SCALE = 1e-3
"""Smallest scale [m]."""

DAMPINGS = np.array([1e-3, 1e-1, 10.0])
"""Factors of the last damping, all of which are tried."""

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING, RAISED = 1.0, 1e-4, 1e4, 30.0
"""Damping relative to the diagonal, its bounds, and its factor if no step was better."""

ENOUGH, EXACT = 1e-3, 1e-5
"""A launch is done if a step lowers its cost by less than this part: in searches, and in fits."""

STARTS = 24
"""Launches with which a search begins."""

KEPT = 16
"""How many different launches go on to the next horizon."""

DRAWN = 100
"""How many are drawn around them; the `KEPT` best of these are improved, too."""

FIRST_HORIZON, GROWTH = 0.5, 1.7
"""First horizon [s], and the factor from each horizon to the next."""

STEPS = 3
"""Steps of least squares at each horizon."""

FOLLOWS, SIDES = (-0.8, 1.2), (-1.0, 1.0)
"""Between which spins, relative to the speed, the first launches lie."""

SPEED_SIGMA, DIRECTION_SIGMA = 0.02, 0.01
"""Deviations of the first launches, relative and in rad."""

SPREAD = 3.0
"""How many standard deviations around the best launches others are drawn."""

APART = 2e-3
"""Launches whose paths differ by less are alike [m]."""

SPINS = slice(FOLLOW, MASSE + 1)


@dataclass(frozen=True)
class CalibrationModel:
    """
    A scene without balls, the frames of the recordings, and the machine that played.

    Measured strokes are those of the driver with its alignment `measured`.
    """

    scene: Scene
    frames: tuple[Frame, ...]
    alignment: Alignment = EXACT_MACHINE
    measured: Alignment = EXACT_MACHINE

    @cached_property
    def params(self) -> tuple[BallClothParams, TableParams]:
        """The numbers of balls, cloth and table for `TableTask`."""
        return params_on_table(self.scene)

    def frame(self, samples: Samples) -> Frame:
        """Return the frame of the recording of a shot."""
        return self.frames[samples.recording]

    def stroke(self, samples: Samples) -> Floats:
        """Return the stroke (5,) of a shot without errors, if it was commanded."""
        command, stroke = samples.command, samples.shot.stroke
        assert command is not None
        assert stroke is not None
        if not command.measured:
            return np.array(stroke.offsets)
        x, y = self.frame(samples).to_table(samples.rest[0]).tolist()
        return stroke_on_table(self.alignment, stroke, (x, y), self.scene, self.measured)


def calibration_model(scene: Scene, recordings: Sequence[Recording]) -> CalibrationModel:
    """Return the model with which a calibration begins."""
    return CalibrationModel(replace(scene, balls={}), tuple(each.frame for each in recordings))


def prior_of(samples: Samples) -> tuple[Floats, Floats]:
    """Return the likely numbers of a launch, and the inverse of their covariance."""
    n = PLACES + 2 * len(samples.balls)
    speed, direction = math.hypot(*samples.velocity), math.atan2(*samples.velocity[::-1])
    mean, precision, sigmas = np.zeros(n), np.zeros((n, n)), np.ones(PLACES)
    if samples.command is None:
        mean[SPEED], mean[DIRECTION] = speed, direction
        sigmas[: SPINS.start] = 0.5 * speed, 0.2
        mean[SPINS], sigmas[SPINS] = speed * samples.spins
    precision[range(PLACES), range(PLACES)] = sigmas**-2
    across = np.maximum(samples.rest_sigma, LEAST_PLACE_SIGMA) ** -2
    precision[range(PLACES, n), range(PLACES, n)] = np.repeat(across, 2)
    along = 1.0 / (1.0 / across[0] + (speed * samples.start_sigma) ** 2)
    way = samples.velocity / speed
    struck = slice(PLACES, PLACES + 2)
    precision[struck, struck] += (along - across[0]) * np.outer(way, way)
    return mean, precision


def steps_of(samples: Samples) -> Floats:
    """Return the steps of the numbers of a launch for differences."""
    speed = math.hypot(*samples.velocity)
    steps = np.full(PLACES + 2 * len(samples.balls), 2e-6)
    steps[:PLACES] = ERROR_STEP
    if samples.command is None:
        steps[:PLACES] = 1e-5 * speed, 1e-5, 1e-4 * speed, 1e-4 * speed, 1e-4 * speed
    return steps


def states_of(model: CalibrationModel, samples: Samples, launches: Floats) -> TableStates:
    """Return the states of the balls after the strikes of (n, numbers) launches."""
    scene, frame = model.scene, model.frame(samples)
    radius, count = scene.ball.radius, len(samples.balls)
    position = np.full((len(launches), count, 3), radius)
    moved = samples.rest + launches[:, PLACES:].reshape(-1, count, 2)
    position[..., :2] = moved_apart(scene, frame.to_table(moved))
    velocity, spin = np.zeros_like(position), np.zeros_like(position)
    if samples.command is not None:
        velocity[:, 0], spin[:, 0] = _strike(model, samples, launches[:, :PLACES])
        return TableStates(samples.balls, position, velocity, spin)
    direction = launches[:, DIRECTION] - frame.angle
    ahead = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    left = ahead[:, ::-1] * np.array([-1.0, 1.0])
    velocity[:, 0, :2] = launches[:, SPEED, np.newaxis] * ahead
    follow, side, masse = (launches[:, k, np.newaxis] / radius for k in (FOLLOW, SIDE, MASSE))
    spin[:, 0, :2] = follow * left + masse * ahead
    spin[:, 0, 2:] = side
    return TableStates(samples.balls, position, velocity / frame.scale, spin / frame.scale)


def sigmas_of(command: StrokeErrors, radius: float) -> Floats:
    """Return the deviations (5,) of a commanded stroke (ball radii, rad, m/s)."""
    return np.hypot(command.noise.sigmas(radius), 0.0 if command.measured else LEAST_ERRORS)


def units(radius: float) -> Floats:
    """Return the units of errors of strokes (5,) in those of `Noise`."""
    return np.array([radius, radius, math.degrees(1.0), math.degrees(1.0), 1.0])


def _strike(model: CalibrationModel, samples: Samples, errors: Floats) -> tuple[Floats, Floats]:
    """
    Strike the ball with errors (n, 5) of a commanded stroke, in standard deviations.

    Returns
    -------
    velocity, spin : (n, 3) float arrays
        Of the ball [m/s] and [rad/s]; NaN if the stroke cannot be played.

    """
    command, stroke, radius = samples.command, samples.shot.stroke, model.scene.ball.radius
    assert command is not None
    assert stroke is not None
    strikes = strike_model_of(model.scene)
    # Launches that differ in the places of the balls alone have the same strike.
    different, which = np.unique(errors, axis=0, return_inverse=True)
    away = command.noise.means(radius) + different * sigmas_of(command, radius)
    strokes = with_errors(model.stroke(samples), away)
    if stroke.axis and not command.measured:
        strokes[:, [A, B]] /= 1.0 + strikes.tip_curvature  # where the tip touches
    played = strike_alone(strikes, strokes)
    which = which.ravel()  # of another shape in some versions of NumPy
    return played.velocity[which], played.surface[which] / radius


def ways_of(model: CalibrationModel, samples: Samples, launches: Floats) -> Floats:
    """
    Return where the samples of a shot would lie after (n, numbers) launches.

    Returns
    -------
    (n, samples, 2) float array
        [m], in the frame of the recording; infinite for launches that cannot be simulated.

    """
    starts = states_of(model, samples, launches).starts()
    starts['velocity'][np.abs(starts['velocity']) > FASTEST] = np.nan  # is refused
    for table, ball, _ in in_cushions(model.scene, starts):
        starts['position'][table, ball] = np.nan
    until, times = samples.duration + GAP, tuple(samples.times.tolist())
    task = TableTask(*model.params, starts, TOLERANCE, TOLERANCE, MAX_EVENTS, until=until)
    played = run_tables(task._replace(times=times))
    places = model.frame(samples).to_recording(played.places[:, samples.ball, samples.at, :2])
    status = played.tables['status']
    places[(status != OK) & (status != OFF_TABLE)] = np.inf
    return places


def contacts_of(model: CalibrationModel, samples: Samples, launch: Floats) -> Floats:
    """Return the times [s] at which balls meet balls and cushions after a launch (numbers,)."""
    states = states_of(model, samples, launch[np.newaxis])
    balls = {
        name: BallState(*(getattr(states, field)[0, i] for field in VECTORS))
        for i, name in enumerate(samples.balls)
    }
    run = simulate(model.scene, balls, until=samples.duration)
    return np.array([event.time for event in run.events if event.kind in CONTACTS])


def moved_apart(scene: Scene, places: Floats) -> Floats:
    """Move balls (n, balls, 2) [m] out of each other, and out of the noses of a carom table."""
    diameter = 2.0 * scene.ball.radius + GAP
    one, other = np.triu_indices(places.shape[1], 1)
    for _ in range(PUSHES):
        square = ((places[:, other] - places[:, one]) ** 2).sum(axis=-1)
        near = (square < diameter**2).any(axis=0)
        if not near.any():
            break
        for i, j in zip(one[near].tolist(), other[near].tolist(), strict=True):
            between = places[:, j] - places[:, i]
            distance = np.linalg.norm(between, axis=-1, keepdims=True)
            push = np.maximum(0.5 * (diameter - distance), 0.0) / np.maximum(distance, GAP)
            places[:, i] -= push * between
            places[:, j] += push * between
        if scene.table is not None and not scene.table.pockets:
            nose = nose_standoff(diameter * scene.table.cushion.height, scene.ball.radius) + GAP
            half = np.array([scene.table.length, scene.table.width]) / 2.0 - nose
            places = np.clip(places, -half, half)
    return places


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """
    What launches of a shot are compared with.

    Attributes
    ----------
    samples : Samples
    mean, precision : (numbers,) and (numbers, numbers) float array
        Likely numbers of the launch, and the inverse of their covariance.
    square : (samples,) float array
        Squares of the scales [m^2].
    share : (samples,) float array
        For how many independent samples each one stands.

    """

    samples: Samples
    mean: Floats
    precision: Floats
    square: Floats
    share: Floats

    def costs(self, launches: Floats, places: Floats) -> Floats:
        """Return the costs (n,) of launches, after which samples lie at places (n, samples, 2)."""
        with np.errstate(invalid='ignore', over='ignore'):
            errors = np.log1p(((places - self.samples.place) ** 2).sum(axis=-1) / self.square)
        away = launches - self.mean
        costs: Floats = errors @ self.share + np.einsum('ni,ij,nj->n', away, self.precision, away)
        return costs

    def weights(self, errors: Floats) -> Floats:
        """
        Return the weights (n, 2 samples) [1/m^2] of errors (n, samples, 2) in least squares.

        With them, the gradient is that of the cost, but for a factor of 2.
        """
        weights: Floats = self.share / (self.square + (errors**2).sum(axis=-1))
        return np.repeat(weights, 2, axis=-1)

    def curvatures(self, errors: Floats) -> Floats:
        """
        Return the curvatures (n, 2 samples) [1/m^2] of the cost, but for a factor of 2.

        They are means over all directions of an error. Weights are larger: deviations that follow
        from them are too small.
        """
        both = self.square + (errors**2).sum(axis=-1)
        return np.repeat(self.share * self.square / both**2, 2, axis=-1)


def compare(samples: Samples, scales: Floats, horizon: float | Floats = np.inf) -> Comparison:
    """Compare with samples until a horizon, see `Samples.until`; scales (knots,) [m]."""
    seen = samples.until(horizon)
    square = np.interp(seen.time, KNOTS, scales) ** 2 + seen.sigma**2
    return Comparison(seen, *prior_of(samples), square, seen.share / SAMPLE_TIME)


def scales_of(times: Floats, errors: Floats) -> Floats:
    """
    Return the scales (knots,) [m] of errors (n,) [m] of samples at times (n,) [s].

    After the last sample, the first scales stand.
    """
    scales, last = np.zeros(len(KNOTS)), LEAST_SCALE
    edges = np.concatenate([[0.0], 0.5 * (KNOTS[1:] + KNOTS[:-1]), [np.inf]])
    for k in range(len(KNOTS)):
        inside = (times >= edges[k]) & (times < edges[k + 1])
        if inside.any():
            last = max(float(np.median(errors[inside])), last)
        elif not (times > edges[k]).any():
            last = max(FIRST_SCALES[k], last)
        scales[k] = last
    return scales


class Fitted(NamedTuple):
    """
    Launches of a shot.

    Attributes
    ----------
    launches : (n, numbers) float array
    costs : (n,) float array
        Infinite for a launch that cannot be simulated.
    places : (n, samples, 2) float array
        Where the samples would lie [m].

    """

    launches: Floats
    costs: Floats
    places: Floats

    def take(self, which: NDArray[np.integer]) -> 'Fitted':
        """Return some of the launches."""
        return Fitted(*(each[which] for each in self))


def derivatives_of(
    model: CalibrationModel, compared: Comparison, fitted: Fitted
) -> tuple[Floats, Floats]:
    """
    Return the errors (n, samples, 2) of launches, and their derivatives (n, numbers, 2 samples).

    Derivatives that do not exist, because a launch nearby cannot be simulated, are zero.
    """
    steps = steps_of(compared.samples)
    n, numbers = fitted.launches.shape
    rows = (fitted.launches[:, np.newaxis] + np.diag(steps)).reshape(n * numbers, numbers)
    moved = ways_of(model, compared.samples, rows).reshape(n, numbers, -1, 2)
    with np.errstate(invalid='ignore'):
        slopes = (moved - fitted.places[:, np.newaxis]) / steps[:, np.newaxis, np.newaxis]
    slopes[~np.isfinite(slopes)] = 0.0
    errors = fitted.places - compared.samples.place
    return errors, slopes.reshape(n, numbers, -1)


def normal_equations(
    model: CalibrationModel, compared: Comparison, fitted: Fitted
) -> tuple[Floats, Floats]:
    """Return the matrices (n, numbers, numbers) and gradients (n, numbers) of launches."""
    errors, slopes = derivatives_of(model, compared, fitted)
    weighted = slopes * compared.weights(errors)[:, np.newaxis]
    matrix = weighted @ slopes.transpose(0, 2, 1) + compared.precision
    gradient = np.einsum('nks,ns->nk', weighted, errors.reshape(len(errors), -1))
    return matrix, gradient + (fitted.launches - compared.mean) @ compared.precision


def evaluated(model: CalibrationModel, compared: Comparison, launches: Floats) -> Fitted:
    """Simulate launches (n, numbers), and compare."""
    places = ways_of(model, compared.samples, launches)
    return Fitted(launches, compared.costs(launches, places), places)


def refined(
    model: CalibrationModel,
    compared: Comparison,
    launches: Floats,
    steps: int,
    enough: float = ENOUGH,
) -> Fitted:
    """Improve launches (n, numbers) by a number of steps; those that are impossible stay."""
    fitted = evaluated(model, compared, np.array(launches))
    n, numbers = fitted.launches.shape
    damping = np.full(n, FIRST_DAMPING)
    left = np.flatnonzero(np.isfinite(fitted.costs))
    for _ in range(steps):
        if not len(left):
            break
        matrix, gradient = normal_equations(model, compared, fitted.take(left))
        factors = damping[left, np.newaxis] * DAMPINGS  # (left, tries)
        diagonal = np.einsum('nkk->nk', matrix)[:, np.newaxis, :, np.newaxis] * np.eye(numbers)
        damped = matrix[:, np.newaxis] + factors[..., np.newaxis, np.newaxis] * diagonal
        moves = np.linalg.solve(damped, gradient[:, np.newaxis, :, np.newaxis])[..., 0]
        tried = (fitted.launches[left, np.newaxis] - moves).reshape(-1, numbers)
        found = evaluated(model, compared, tried)
        best = found.costs.reshape(len(left), -1).argmin(axis=-1)
        rows = np.arange(len(left)) * len(DAMPINGS) + best
        gain = fitted.costs[left] - found.costs[rows]
        better = gain > 0.0
        for kept, new in zip(fitted, found.take(rows), strict=True):
            kept[left[better]] = new[better]
        damping[left] *= np.where(better, DAMPINGS[best], RAISED)
        damping = np.maximum(damping, LEAST_DAMPING)
        done = np.where(better, gain < enough * fitted.costs[left], damping[left] > MOST_DAMPING)
        left = left[~done]
    return fitted


def horizons(last: float) -> Iterator[float]:
    """Yield horizons up to the last one [s]."""
    horizon = FIRST_HORIZON
    while horizon < last / GROWTH**0.5:
        yield horizon
        horizon *= GROWTH
    yield last


def search_launches(
    model: CalibrationModel,
    samples: Samples,
    scales: Floats,
    horizon: float,
    draw: np.random.Generator,
    known: Floats | None = None,
) -> Fitted:
    """
    Search the launches of a shot.

    Parameters
    ----------
    model : CalibrationModel
    samples : Samples
    scales : (knots,) float array
        Of errors [m], see `compare`.
    horizon : float
        Until which samples count [s].
    draw : numpy.random.Generator
    known : (n, numbers) float array, optional
        Launches that may be near the best one.

    Returns
    -------
    Fitted
        The best launches first, all different; none if none can be simulated.

    """
    last = min(horizon, samples.duration)
    launches = _starts(compare(samples, scales), draw)
    for until in horizons(last):
        compared = compare(samples, scales, until)
        if known is not None:
            launches = np.concatenate([known, launches])
        best = _distinct(refined(model, compared, launches, STEPS))
        launches = _drawn_around(model, compared, best, draw)
    return _distinct(refined(model, compared, launches, STEPS))


def _starts(compared: Comparison, draw: np.random.Generator) -> Floats:
    """Draw launches with all spins; if the stroke was commanded, take that without errors."""
    if compared.samples.command is not None:
        return compared.mean[np.newaxis]
    launches = np.repeat(compared.mean[np.newaxis], STARTS, axis=0)
    speed = compared.mean[SPEED]
    launches[:, FOLLOW] = speed * draw.uniform(*FOLLOWS, STARTS)
    launches[:, SIDE] = speed * draw.uniform(*SIDES, STARTS)
    launches[:, SPEED] *= draw.normal(1.0, SPEED_SIGMA, STARTS)
    launches[:, DIRECTION] += draw.normal(0.0, DIRECTION_SIGMA, STARTS)
    return launches


def _drawn_around(
    model: CalibrationModel, compared: Comparison, best: Fitted, draw: np.random.Generator
) -> Floats:
    """Return the best launches and others around them, more around better ones."""
    if not len(best.costs):
        return _starts(compared, draw)
    if compared.samples.command is not None:
        return best.launches  # the best one is near
    matrix, _ = normal_equations(model, compared, best)
    ranks = 1.0 / np.arange(1, len(best.costs) + 1)
    chosen = draw.choice(len(ranks), DRAWN, p=ranks / ranks.sum())
    # The rows of a matrix of directions, each with the inverse of the root of its curvature.
    curvature, directions = np.linalg.eigh(matrix)
    lengths = SPREAD / np.sqrt(np.maximum(curvature, curvature[:, -1:] * 1e-12))
    free = draw.normal(size=(len(chosen), matrix.shape[-1]))
    moves = np.einsum('nik,nk->ni', directions[chosen], lengths[chosen] * free)
    drawn = evaluated(model, compared, best.launches[chosen] + moves)
    return np.concatenate([best.launches, drawn.launches[np.argsort(drawn.costs)[:KEPT]]])


def _distinct(fitted: Fitted) -> Fitted:
    """Return the best launches whose paths differ, the best one first."""
    chosen: list[int] = []
    for k in np.argsort(fitted.costs, kind='stable').tolist():
        if not np.isfinite(fitted.costs[k]) or len(chosen) == KEPT:
            break
        apart = np.abs(fitted.places[chosen] - fitted.places[k]).max(axis=(1, 2), initial=0.0)
        if (apart > APART).all():
            chosen.append(k)
    return fitted.take(np.array(chosen, np.int64))


def spins_of(launches: Sequence[Floats]) -> Floats:
    """Return follow, side and masse (n, 3) relative to the speed, of launches (numbers,)."""
    strikes = np.reshape([each[:PLACES] for each in launches], (-1, PLACES))
    spins: Floats = strikes[:, SPINS] / strikes[:, SPEED, np.newaxis]
    return spins


def likely_spins(spins: Floats) -> Floats:
    """Return the mean and the deviations (2, 3) of spins of a player, see `spins_of`."""
    count = 1 + len(spins)  # the usual deviations stand for a stroke
    mean = spins.sum(axis=0) / count * (1.0, 0.0, 0.0)  # side and masse: as likely left as right
    squares = USUAL_SPINS[1] ** 2 + ((spins - mean) ** 2).sum(axis=0)
    return np.stack([mean, np.sqrt(squares / count)])
