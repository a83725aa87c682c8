"""
The numbers that all shots have in common, fitted together with the launch of each shot.

For any common numbers, each shot has a best launch. The sum of the costs of these launches is
lowered by Gauss-Newton steps. A step needs of each shot only a small matrix: its launch is
eliminated from the normal equations (Schur complement; variable projection, Golub and Pereyra,
SIAM J. Numer. Anal. 10 (1973)).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.calibration.comparison import compare, Comparison, scales_of
from billiard_shot.calibration.launch import PLACES, steps_of, ways_of
from billiard_shot.calibration.launch_search import search_launches
from billiard_shot.calibration.model import Model, Sought, STEP, values_of, widths_of, within
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.refine import derivatives_of, evaluated, EXACT, refined
from billiard_shot.calibration.watched import Watched

LAUNCH_STEPS = 8
"""Most steps of least squares by which launches follow the common numbers."""

PROBES, MOST_BENT = 5.0, 1e-3
"""
A path counts until it bends by more [m] over so many steps for differences of the launch, forward
and back, or over one of a common number. Nearby, balls meet other balls then, or in another order:
the path follows chance, and its derivatives say nothing.
"""

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-6, 1e3
"""Damping relative to the diagonal, and its bounds."""

RAISED, LOWERED = 10.0, 0.2
"""Factors of the damping after a worse and a better step."""

CLOSE, FLAT = 0.1, 0.02
"""
A fit ends if the next step is shorter than the first part of each standard deviation (Bates and
Watts, Technometrics 23 (1981): what remains to be gained is small beside the errors), or if it
would lower the cost by less than the second number: 1 is a standard deviation of an exact model.
"""

TINY = 1e-15
"""Least standard deviation: a number that nothing decides has none."""

ROUNDING = 1e-9
"""Part of a step that is only rounding: a number at its bound moves no farther."""

Mapped = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""What `map` does, and the method `map` of executors: the results of some work on items."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """
    A shot of a calibration.

    Attributes
    ----------
    watched : Watched
    recording : int
        Number of its recording.
    launch : (numbers,) float array
        The best one.
    until : float or (balls,) float array
        Times from the strike on until which the path of each ball can be predicted [s].

    """

    watched: Watched
    recording: int
    launch: Floats
    until: float | Floats = np.inf

    def compared(self, scales: Floats, horizon: float) -> Comparison:
        """Compare with the samples until a horizon [s], and while the path can be predicted."""
        return compare(self.watched, scales, np.minimum(horizon, self.until))


class Reduced(NamedTuple):
    """
    The normal equations of a shot, without its launch.

    Attributes
    ----------
    matrix, curvature : (common, common) float array
        With weights of least squares, for steps, and with curvatures, for deviations.
    gradient : (common,) float array
    follow : (numbers, common) float array
        Change of the launch with each common number.

    """

    matrix: Floats
    curvature: Floats
    gradient: Floats
    follow: Floats


class Followed(NamedTuple):
    """A launch that follows the common numbers, its cost, and errors [m] of samples at times."""

    launch: Floats
    cost: float
    times: Floats
    errors: Floats


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """
    Common numbers and launches that fit together.

    Attributes
    ----------
    values : (common,) float array
    shots : tuple of Shot
        With their launches.
    scales : (knots,) float array
        Of errors, see `compare` [m].
    curvatures, gradients : (shots, common, common) and (shots, common) float array
        Of the costs of the shots, but for a factor of 2.
    costs : (shots,) float array
    ahead : float
        Largest change of a number by the next step, in standard deviations; 0 if it gains nothing.

    """

    values: Floats
    shots: tuple[Shot, ...]
    scales: Floats
    curvatures: Floats
    gradients: Floats
    costs: Floats
    ahead: float = np.inf


def search(
    item: tuple[Model, Sequence[Model], Shot, Floats, float, bool, Sequence[int]],
) -> Shot | None:
    """
    Search the launch of a shot until a horizon, from a seed; None if none can be simulated.

    Without stepped models, the path counts as long as before, see `even_until`.
    """
    model, stepped, shot, scales, horizon, near, seed = item
    found = search_launches(
        model.scene,
        model.frames[shot.recording],
        shot.watched,
        scales,
        horizon,
        np.random.default_rng(seed),
        shot.launch[np.newaxis],
        near,
    )
    if not len(found.costs):
        return None
    shot = replace(shot, launch=found.launches[0])
    if not stepped:
        return shot
    return replace(shot, until=np.minimum(shot.until, even_until(model, stepped, shot)))


def even_until(model: Model, stepped: Sequence[Model], shot: Shot) -> Floats:
    """Return until when each path (balls,) can be predicted [s]; models are stepped in pairs."""

    def ways(by: Model, launches: Floats) -> Floats:
        return ways_of(by.scene, by.frames[shot.recording], shot.watched, launches)

    launch, steps = shot.launch[np.newaxis], steps_of(shot.watched)
    # Errors of a commanded stroke have steps that are long already.
    steps[0 if shot.watched.command is None else PLACES :] *= PROBES
    probes = np.diag(steps)
    here = ways(model, launch)
    pairs = [(ways(model, launch + probes), ways(model, launch - probes))]
    pairs += [
        (ways(one, launch), ways(other, launch))
        for one, other in zip(stepped[::2], stepped[1::2], strict=True)
    ]
    with np.errstate(invalid='ignore'):
        bent = np.concatenate([one + other - 2.0 * here for one, other in pairs])
    bent[~np.isfinite(bent)] = 0.0  # a start nearby that cannot be simulated tells nothing
    uneven = np.linalg.norm(bent, axis=-1).max(axis=0) > MOST_BENT
    until = np.full(len(shot.watched.balls), np.inf)
    times = shot.watched.times[shot.watched.at[uneven]]
    np.minimum.at(until, shot.watched.ball[uneven], np.nextafter(times, 0.0))
    return until


def follow(item: tuple[Model, Shot, Floats, float]) -> Followed:
    """Improve the launch of a shot for other common numbers."""
    model, shot, scales, horizon = item
    compared = shot.compared(scales, horizon)
    frame = model.frames[shot.recording]
    launch = shot.launch[np.newaxis]
    best = refined(model.scene, frame, compared, launch, LAUNCH_STEPS, EXACT)
    errors = np.linalg.norm(best.places[0] - compared.watched.place, axis=-1)
    times = compared.watched.times[compared.watched.at]
    return Followed(best.launches[0], float(best.costs[0]), times, errors)


def reduce_equations(
    item: tuple[Model, Sequence[Model], Floats, Shot, Floats, float],
) -> Reduced:
    """Eliminate the launch of a shot from its normal equations, by models with one step each."""
    model, stepped, steps, shot, scales, horizon = item
    compared = shot.compared(scales, horizon)
    frame, launch = model.frames[shot.recording], shot.launch[np.newaxis]
    here = evaluated(model.scene, frame, compared, launch)
    errors, slopes = derivatives_of(model.scene, frame, compared, here)
    own = slopes[0]
    moved = [
        ways_of(each.scene, each.frames[shot.recording], compared.watched, launch)[0]
        for each in stepped
    ]
    with np.errstate(invalid='ignore'):
        differences = np.reshape(moved, (len(steps), *here.places[0].shape)) - here.places
        common = differences.reshape(len(steps), errors.size) / steps[:, np.newaxis]
    common[~np.isfinite(common)] = 0.0
    weights = compared.weights(errors)[0]
    matrix, follows = _without_launch(own, common, weights, compared.precision)
    curvature, _ = _without_launch(own, common, compared.curvatures(errors)[0], compared.precision)
    pull = weights * errors.ravel()
    away = own @ pull + (launch[0] - compared.mean) @ compared.precision
    return Reduced(matrix, curvature, common @ pull + follows.T @ away, follows)


def _without_launch(
    own: Floats, common: Floats, weights: Floats, precision: Floats
) -> tuple[Floats, Floats]:
    """Return the normal matrix of common numbers, and the change of the launch with them."""
    between = (own * weights) @ common.T
    inner = (own * weights) @ own.T + precision
    follows: Floats = np.negative(np.linalg.solve(inner, between))
    return (common * weights) @ common.T + between.T @ follows, follows


class Problem(NamedTuple):
    """The numbers to fit, the horizon until which samples count [s], and a map for the work."""

    model: Model
    sought: tuple[Sought, ...]
    horizon: float
    mapped: Mapped

    def model_at(self, values: Floats) -> Model:
        """Return the model with these numbers."""
        return self.model.with_values(self.sought, values)

    @property
    def start(self) -> Floats:
        """The likely numbers (common,)."""
        return values_of(self.sought)

    @property
    def precision(self) -> Floats:
        """The inverse of their covariance (common, common)."""
        return np.diag(widths_of(self.sought) ** -2.0)


def searched(
    problem: Problem,
    values: Floats,
    shots: Sequence[Shot],
    scales: Floats,
    seed: Sequence[int],
    near: bool = False,
    cut: bool = True,
) -> tuple[Shot, ...]:
    """
    Search the launches of all shots; leave out shots that have none.

    If `near`, they are searched near those known. If `cut`, paths count until they bend.
    """
    model = problem.model_at(values)
    steps = 0.5 * STEP * np.diag(widths_of(problem.sought)) if cut else ()  # within the bounds
    stepped = [problem.model_at(values + by) for step in steps for by in (step, -step)]
    items = [
        (model, stepped, shot, scales, problem.horizon, near, (*seed, number))
        for number, shot in enumerate(shots)
    ]
    return tuple(shot for shot in problem.mapped(search, items) if shot is not None)


def scales_after(
    problem: Problem, values: Floats, shots: Sequence[Shot], scales: Floats
) -> Floats:
    """Return the scales of the errors that launches have which were found with other scales."""
    found, _ = _followed(problem, values, shots, scales)
    return scales_of(*_errors(found))


def fit(
    problem: Problem,
    values: Floats,
    shots: Sequence[Shot],
    scales: Floats,
    steps: int,
    report: Callable[[float], object],
) -> JointFit:
    """
    Lower the cost of all shots.

    Parameters
    ----------
    problem : Problem
    values : (common,) float array
        Where the fit begins.
    shots : sequence of Shot
        With launches for these values.
    scales : (knots,) float array
        Of errors, see `compare` [m].
    steps : int
        Largest number of steps.
    report : callable
        Called after each step with the median error of all samples [m].

    """
    found, cost = _followed(problem, values, shots, scales)
    damping = FIRST_DAMPING
    for step in range(steps + 1):
        shots = [
            replace(shot, launch=each.launch) for shot, each in zip(shots, found, strict=True)
        ]
        report(float(np.median(_errors(found)[1])))
        reduced = _reduced(problem, values, shots, scales)
        reached = JointFit(
            values,
            tuple(shots),
            scales,
            np.stack([each.curvature for each in reduced]),
            np.stack([each.gradient for each in reduced]),
            np.array([each.cost for each in found]),
        )
        move = _move(problem, values, reduced, LEAST_DAMPING)
        ahead = float((np.abs(move) / deviations_of(problem, reached)).max())
        if _gain(problem, reduced, move) < FLAT:
            ahead = 0.0
        if step == steps or ahead < CLOSE:
            break
        lower = np.inf
        while not lower < cost and damping < MOST_DAMPING:
            tried_move = _move(problem, values, reduced, damping)
            moved = [
                replace(shot, launch=shot.launch + each.follow @ tried_move)
                for shot, each in zip(shots, reduced, strict=True)
            ]
            tried, lower = _followed(problem, values + tried_move, moved, scales)
            damping *= LOWERED if lower < cost else RAISED
        if not lower < cost:
            break
        values, found, cost = values + tried_move, tried, lower
        damping = max(damping, LEAST_DAMPING)
    return replace(reached, ahead=ahead)


def _followed(
    problem: Problem, values: Floats, shots: Sequence[Shot], scales: Floats
) -> tuple[list[Followed], float]:
    """Let all launches follow the common numbers; return them and the cost of all."""
    model, away = problem.model_at(values), values - problem.start
    items = [(model, shot, scales, problem.horizon) for shot in shots]
    found = list(problem.mapped(follow, items))
    return found, sum(each.cost for each in found) + float(away @ problem.precision @ away)


def _errors(found: Sequence[Followed]) -> tuple[Floats, Floats]:
    """Return the times [s] and errors [m] of the samples of all shots."""
    times = np.concatenate([each.times for each in found])
    return times, np.concatenate([each.errors for each in found])


def _reduced(
    problem: Problem, values: Floats, shots: Sequence[Shot], scales: Floats
) -> list[Reduced]:
    """Return the normal equations of all shots."""
    steps = STEP * widths_of(problem.sought)
    model = problem.model_at(values)
    stepped = [problem.model_at(values + step) for step in np.diag(steps)]
    items = [(model, stepped, steps, shot, scales, problem.horizon) for shot in shots]
    return list(problem.mapped(reduce_equations, items))


def _move(problem: Problem, values: Floats, reduced: Sequence[Reduced], damping: float) -> Floats:
    """Return the damped step from values; numbers that would leave their bounds stay there."""
    matrix = sum((each.matrix for each in reduced), start=problem.precision)
    gradient = sum((each.gradient for each in reduced), start=np.zeros(len(values)))
    gradient = gradient + problem.precision @ (values - problem.start)
    matrix = matrix + damping * np.diag(np.diag(matrix))
    free = np.ones(len(values), np.bool_)
    while True:
        move = np.zeros(len(values))
        move[free] = -np.linalg.solve(matrix[np.ix_(free, free)], gradient[free])
        allowed = within(problem.sought, values + move) - values
        stuck = free & (move != 0.0) & (np.abs(allowed) < ROUNDING * np.abs(move))
        if not stuck.any():
            return allowed
        free &= ~stuck


def _gain(problem: Problem, reduced: Sequence[Reduced], move: Floats) -> float:
    """Return by how much the full step would lower the cost, if it were a parabola."""
    matrix = sum((each.matrix for each in reduced), start=problem.precision)
    return float(move @ matrix @ move)


def deviations_of(problem: Problem, fit: JointFit) -> Floats:
    """
    Return the standard deviations of the common numbers, from how the shots differ.

    This is the sandwich of Huber (Proc. 5th Berkeley Symp. (1967), vol. 1): the errors of the
    samples of a shot are those of its model, and far from independent.
    """
    return np.maximum(np.linalg.norm(_influences(problem, fit), axis=0), TINY)


def pulls_of(problem: Problem, fit: JointFit) -> dict[str, Floats]:
    """Return by how many standard deviations each shot, by name, moves the common numbers."""
    names = [each.watched.name for each in fit.shots]
    pulls = _influences(problem, fit) / deviations_of(problem, fit)
    return dict(zip(names, pulls, strict=True))


def _influences(problem: Problem, fit: JointFit) -> Floats:
    """Return how far each shot moves the common numbers (shots, common)."""
    matrix = fit.curvatures.sum(axis=0) + problem.precision
    influences: Floats = np.linalg.solve(matrix, fit.gradients.T).T
    return influences
