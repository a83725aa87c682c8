"""
The numbers that all shots have in common, fitted together with the launch of each shot.

For any common numbers, each shot has a best launch. The sum of the costs of these launches is
lowered by Gauss-Newton steps. A step needs of each shot only a small matrix: its launch is
eliminated from the normal equations (Schur complement; variable projection, Golub and Pereyra,
SIAM J. Numer. Anal. 10 (1973)).

Intervals: each shot is left out in turn (the jackknife of Tukey, Ann. Math. Stat. 29 (1958); Efron
and Stein, Ann. Stat. 9 (1981)). One Gauss-Newton step from the fit leads to the numbers that the
other shots give. These fits are close to each other, and a step takes no simulation. With few
shots this is more careful than drawing shots with replacement: it undoes that a fit follows each
shot.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import lsq_linear
from scipy.stats import norm
from scipy.stats import t as student

from billiard_shot.calibration.launch import (
    CalibrationModel,
    compare,
    Comparison,
    derivatives_of,
    ENOUGH,
    EXACT,
    PLACES,
    refined,
    scales_of,
    search_launches,
    sigmas_of,
    steps_of,
    ways_of,
)
from billiard_shot.calibration.recording import Floats, Recording, Samples
from billiard_shot.calibration.result import Estimate, USUAL_NAMES
from billiard_shot.scene import Scene
from billiard_shot.scene.scene import Parameter

CUE_NAMES = 'contacts.cue_ball.restitution', 'cue.mass', 'cue.end_mass'
"""Numbers that shots can decide whose strokes were commanded."""

UNPUBLISHED = 0.5
"""Width of the range in which a number without published range is sought, relative to it."""

WIDTHS = {
    'cloth.rolling_rise': 3e-3,
    'contacts.ball_ball.friction_fast': 0.06,
    'contacts.ball_ball.friction_slow': 0.1,
    'table.cushion.early_fading': 0.1,
    'table.cushion.fading': 0.04,
    'table.length': 0.03,
    'table.width': 0.03,
}
"""Widths of ranges that are not relative to the number: it may be 0, or it is measured."""

SQUARED = ('table.cushion.fading',)
"""Numbers that act by their squares: a fit of these moves away from 0 too. So are their widths."""

LEAST = {'cue.end_mass': 5e-4, 'table.cushion.frequency_ratio': 0.3}
"""
Lighter ends of cues meet the ball again and again, and deflect it no less [kg]. A softer spring of
noses hardly acts, but none at all (0) makes them rigid.
"""

STEP = 1e-3
"""Step for differences, relative to the width of the range."""

ALIGNMENT = 'alignment'
"""Section of the numbers of a machine."""

FRAME_WIDTHS = {'x': 0.03, 'y': 0.03, 'angle': 0.02}
"""Ranges in which numbers of frames are sought: m, m and rad."""

RULER = {'table.length': 2e-3, 'table.width': 2e-3}
"""
Deviations of lengths that a person measured [m].

A film measures the table by corners whose distances were measured by hand: it repeats this error.
"""

LAUNCH_STEPS = 8
"""Most steps of least squares by which launches follow the common numbers."""

BETTER = 2.0
"""
A launch elsewhere is taken if its cost is lower by more: it is e times as likely as another. Fits
whose costs differ by less are as good as each other.
"""

PROBES, MOST_BENT = 5.0, 1e-3
"""
A path counts until it bends by more [m] over so many steps for differences of the launch, forward
and back, or over one of a common number. Nearby, balls meet other balls then, or in another order:
the path follows chance, and its derivatives say nothing.
"""

DAMPING = 1e-6
"""Of steps, relative to the diagonal: keeps them short if two numbers act in the same way."""

SHORTER = 1.0, 0.3, 0.1, 0.02
"""Parts of a step that are tried until one of them lowers the cost."""

CLOSE, FLAT = 0.1, 0.02
"""
A fit ends if the next step is shorter than the first part of each standard deviation (Bates and
Watts, Technometrics 23 (1981): what remains to be gained is small beside the errors), or if it
would lower the cost by less than the second number: 1 is a standard deviation of an exact model.
"""

LEVEL = 0.95
"""Part of the intervals that shall hold the truth."""

HELD = 0.1
"""Part of the variance of a number that its range must not explain."""

SHARED = 3
"""Shots that are used up by what all have in common, if intervals are careful."""

DECISIVE = 3
"""How many shots are named that decide a number."""

WORSE = 0.03
"""A number that the shots do not decide may raise the cost by this part if it is not fitted."""

MapFunction = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""What `map` does, and the method `map` of executors: the results of some work on items."""


@dataclass(frozen=True, slots=True)
class Unknown:
    """
    A number that is sought.

    Attributes
    ----------
    name : str
    unit : str
    start : float
    low, high : float
        Bounds of allowed values.
    width : float
        Of the range of values that are likely before the calibration, around `start`.
    published : (float, float), optional
        Range of published values.
    recording : int
        Number of the recording whose frame has it, if a frame has it.
    squared : bool
        Whether a fit seeks its square: then start, bounds and width are those of the square.

    """

    name: str
    unit: str
    start: float
    low: float
    high: float
    width: float
    published: tuple[float, float] | None = None
    recording: int = 0
    squared: bool = False

    def stated(self, value: float) -> float:
        """Return the number that a value of the fit stands for."""
        return math.sqrt(value) if self.squared else value


def sought_in(
    scene: Scene, recordings: Sequence[Recording], names: Sequence[str] | None
) -> tuple[Unknown, ...]:
    """
    Return the numbers to seek: those of a scene, and places and angles of the frames.

    A name such as `cloth` stands for all numbers of this section of the scene.

    Raises
    ------
    ValueError
        If a name is unknown.

    """
    known = {each.name: each.value for each in scene.parameters()}
    if names is None:
        commanded = any(shot.command for each in recordings for shot in each.shots)
        usual = (*USUAL_NAMES, *CUE_NAMES) if commanded else USUAL_NAMES
        measured = RULER if all(each.exact for each in recordings) else ()
        names = [
            name
            for name in usual
            if known.get(name, -math.inf) >= LEAST.get(name, 0.0) and name not in measured
        ]
    chosen: dict[str, None] = {}
    for name in names:
        section = [each for each in known if each.startswith(f'{name}.')]
        chosen |= dict.fromkeys(section or [name])
    found = [_of_scene(each) for each in scene.parameters(list(chosen))]
    for number, recording in enumerate(recordings):
        for field, width in FRAME_WIDTHS.items() if not recording.exact else ():
            start = getattr(recording.frame, field)
            name = f'frame.{field}' if len(recordings) == 1 else f'frame.{field}.{number + 1}'
            unit = 'rad' if field == 'angle' else 'm'
            bounds = start - width, start + width
            found.append(Unknown(name, unit, start, *bounds, width, recording=number))
    return tuple(found)


def _of_scene(parameter: Parameter) -> Unknown:
    width = WIDTHS.get(parameter.name, UNPUBLISHED * abs(parameter.value))
    if parameter.published is not None and parameter.name not in WIDTHS:
        width = parameter.published[1] - parameter.published[0]
    power = 2.0 if parameter.name in SQUARED else 1.0
    return Unknown(
        parameter.name,
        parameter.unit,
        parameter.value**power,
        LEAST.get(parameter.name, parameter.low**power),
        parameter.high**power,
        width,
        parameter.published,
        squared=power == 2.0,
    )


class FitProblem(NamedTuple):
    """
    Model and numbers of a fit, and how far it reaches.

    Attributes
    ----------
    model : CalibrationModel
    sought : tuple of Unknown
    horizon : float
        Until which samples count [s].
    mapped : callable
        A map for the work.
    careful : bool
        Whether shots are few beside the numbers: intervals then reach at least as far as the
        curvature of the cost tells, and only shots count that decide a number (Satterthwaite,
        Biom. Bull. 2 (1946)).

    """

    model: CalibrationModel
    sought: tuple[Unknown, ...]
    horizon: float
    mapped: MapFunction
    careful: bool = False

    def model_at(self, values: Floats) -> CalibrationModel:
        """Return the model with these numbers."""
        scene: dict[str, float] = {}
        machine: dict[str, float] = {}
        frames = list(self.model.frames)
        for each, value in zip(self.sought, values.tolist(), strict=True):
            section, field, *_ = each.name.split('.')
            if section == 'frame':
                frames[each.recording] = replace(frames[each.recording], **{field: value})
            elif section == ALIGNMENT:
                machine[field] = value
            else:
                scene[each.name] = each.stated(value)
        model = self.model
        return replace(
            model,
            scene=model.scene.with_parameters([*scene], [*scene.values()])
            if scene
            else model.scene,
            frames=tuple(frames),
            alignment=replace(model.alignment, **machine),
        )

    @property
    def start(self) -> Floats:
        """The likely numbers (common,)."""
        return np.array([each.start for each in self.sought])

    @property
    def widths(self) -> Floats:
        """Widths of their ranges (common,)."""
        return np.array([each.width for each in self.sought])

    @property
    def precision(self) -> Floats:
        """The inverse of their covariance (common, common)."""
        return np.diag(self.widths**-2.0)

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Their bounds, with room for a difference."""
        room = STEP * self.widths
        low, high = np.reshape([(each.low, each.high) for each in self.sought], (-1, 2)).T
        return low + room, high - room


@dataclass(frozen=True, slots=True, eq=False)
class Launch:
    """
    The launch of a shot.

    Attributes
    ----------
    samples : Samples
    numbers : (numbers,) float array
        See launch.py.
    until : float or (balls,) float array
        Times from the strike on until which the path of each ball can be predicted [s].
    known : bool
        Whether fits leave the numbers as they are.

    """

    samples: Samples
    numbers: Floats
    until: float | Floats = np.inf
    known: bool = False

    def compared(self, scales: Floats, horizon: float) -> Comparison:
        """Compare with the samples until a horizon [s], and while the path can be predicted."""
        return compare(self.samples, scales, np.minimum(horizon, self.until))


class ShotFit(NamedTuple):
    """
    A shot at common numbers: its best launch, and its normal equations without this launch.

    Attributes
    ----------
    launch : Launch
    cost : float
    times, errors : (samples,) float array
        Of the samples [s] and [m].
    matrix, curvature : (common, common) float array
        With weights of least squares, for steps, and with curvatures, for deviations.
    gradient : (common,) float array
        Of half the cost, as the matrices are.
    follow : (numbers, common) float array
        Change of the launch with each common number.
    spread : (numbers, numbers) float array
        Covariance of the launch for given common numbers.

    """

    launch: Launch
    cost: float
    times: Floats
    errors: Floats
    matrix: Floats
    curvature: Floats
    gradient: Floats
    follow: Floats
    spread: Floats


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """
    Common numbers (common,), and shots that fit to them with errors of some scales (knots,) [m].

    See `compare` for the scales.
    """

    problem: FitProblem
    values: Floats
    scales: Floats
    shots: tuple[ShotFit, ...]

    @property
    def launches(self) -> tuple[Launch, ...]:
        """The launches of all shots."""
        return tuple(each.launch for each in self.shots)

    @property
    def away(self) -> Floats:
        """The numbers beside likely ones."""
        return self.values - self.problem.start

    @property
    def cost(self) -> float:
        """Of all shots, and of the distance of the numbers from likely ones."""
        return sum(each.cost for each in self.shots) + float(
            self.away @ self.problem.precision @ self.away
        )

    @property
    def error(self) -> float:
        """Median error of all samples [m]."""
        return float(np.median(np.concatenate([each.errors for each in self.shots])))

    @property
    def curvatures(self) -> Floats:
        """Of the costs of the shots (shots, common, common), but for a factor of 2."""
        return np.stack([each.curvature for each in self.shots])

    @property
    def gradients(self) -> Floats:
        """Of the costs of the shots (shots, common), but for a factor of 2."""
        return np.stack([each.gradient for each in self.shots])

    @property
    def covariance(self) -> Floats:
        """Of the common numbers, from the curvature of the cost."""
        inverse: Floats = np.linalg.inv(self.curvatures.sum(axis=0) + self.problem.precision)
        return inverse

    @property
    def shares(self) -> Floats:
        """How much each shot decides of each number (common, shots)."""
        shares: Floats = np.einsum(
            'ki,sij,kj->ks', self.covariance, self.curvatures, self.covariance
        )
        return shares

    @property
    def deviations(self) -> Floats:
        """
        Standard deviations of the common numbers, from how the shots differ.

        This is the sandwich of Huber (Proc. 5th Berkeley Symp. (1967), vol. 1): the errors of the
        samples of a shot are those of its model, and far from independent. Shots that hardly
        depend on a number do not differ: then the curvature of the cost tells its deviation.
        """
        sandwich = np.linalg.norm(self.covariance @ self.gradients.T, axis=1)
        deviations: Floats = np.maximum(sandwich, np.sqrt(np.diag(self.covariance)))
        return deviations

    def next_step(self) -> tuple[Floats, float]:
        """
        Return the step of least squares within the bounds.

        Returns also its largest change of a number, in deviations; 0 if the step gains nothing.
        """
        if not len(self.values):
            return np.zeros(0), 0.0
        matrix = self.problem.precision + sum(each.matrix for each in self.shots)
        gradient = self.gradients.sum(axis=0) + self.problem.precision @ self.away
        size = np.sqrt(np.diag(matrix))  # in such units, all numbers are alike
        root = np.linalg.cholesky(matrix / np.outer(size, size) + DAMPING * np.eye(len(size))).T
        low, high = self.problem.bounds
        room = np.minimum(low - self.values, 0.0), np.maximum(high - self.values, 0.0)
        aim = -np.linalg.solve(root.T, gradient / size)
        bounds = room[0] * size, room[1] * size
        step: Floats = lsq_linear(root, aim, bounds, method='bvls').x / size
        ahead = float((np.abs(step) / self.deviations).max())
        return step, 0.0 if step @ matrix @ step < FLAT else ahead


def search_fit(
    model: CalibrationModel,
    stepped: Sequence[CalibrationModel],
    scales: Floats,
    horizon: float,
    item: tuple[Launch, Sequence[int]],
) -> Launch | None:
    """
    Search the launch of a shot until a horizon, from a seed; None if none can be simulated.

    With models that are stepped in pairs, the path counts until it bends, see `until_bent`.
    Without them, it counts as long as before, and the known launch stays unless another one is
    clearly better.
    """
    launch, seed = item
    known, samples = launch.numbers[np.newaxis], launch.samples
    if launch.known:
        if not np.isfinite(ways_of(model, samples, known)).all():
            return None
    else:
        draw = np.random.default_rng(seed)
        found = search_launches(model, samples, scales, horizon, draw, known)
        tried = np.concatenate([known, found.launches[:1]])
        best = refined(model, compare(samples, scales, horizon), tried, LAUNCH_STEPS, EXACT)
        known_cost, cost = best.costs[[0, -1]].tolist()
        if not min(known_cost, cost) < math.inf:
            return None
        if cost < known_cost - (0.0 if stepped else BETTER):
            launch = Launch(samples, best.launches[-1], np.inf if stepped else launch.until)
    return until_bent(model, stepped, launch) if stepped else launch


def until_bent(
    model: CalibrationModel, stepped: Sequence[CalibrationModel], launch: Launch
) -> Launch:
    """
    Let the path of each ball count while it can be predicted, and no longer than before.

    Models are stepped in pairs, forward and back.
    """
    samples, numbers = launch.samples, launch.numbers[np.newaxis]
    steps = steps_of(samples)
    # Errors of a commanded stroke have steps that are long already.
    steps[0 if samples.command is None else PLACES :] *= PROBES
    probes = np.diag(steps)
    here = ways_of(model, samples, numbers)
    pairs = [
        (ways_of(model, samples, numbers + probes), ways_of(model, samples, numbers - probes))
    ]
    pairs += [
        (ways_of(one, samples, numbers), ways_of(other, samples, numbers))
        for one, other in zip(stepped[::2], stepped[1::2], strict=True)
    ]
    with np.errstate(invalid='ignore'):
        bent = np.concatenate([one + other - 2.0 * here for one, other in pairs])
    bent[~np.isfinite(bent)] = 0.0  # a start nearby that cannot be simulated tells nothing
    uneven = np.linalg.norm(bent, axis=-1).max(axis=0) > MOST_BENT
    until = np.broadcast_to(launch.until, len(samples.balls)).copy()
    np.minimum.at(until, samples.ball[uneven], np.nextafter(samples.time[uneven], 0.0))
    return replace(launch, until=until)


def follow_launch(
    model: CalibrationModel,
    stepped: Sequence[CalibrationModel],
    steps: Floats,
    scales: Floats,
    horizon: float,
    launch: Launch,
) -> ShotFit:
    """Improve the launch of a shot for common numbers, by models with one step of these each."""
    compared = launch.compared(scales, horizon)
    known, command = launch.numbers[np.newaxis], launch.samples.command
    by_machine = command is not None and command.measured
    enough = ENOUGH if by_machine else EXACT
    best = refined(model, compared, known, 0 if launch.known else LAUNCH_STEPS, enough)
    numbers = best.launches[0]
    if launch.known:  # no error follows from its numbers
        errors = best.places - compared.samples.place
        own = np.zeros((len(numbers), errors.size))
    else:
        errors, slopes = derivatives_of(model, compared, best)
        own = slopes[0]
    if command is not None and command.measured:  # the machine turns strokes into others
        sigmas = steps[:, np.newaxis] * sigmas_of(command, model.scene.ball.radius)
        strokes = np.reshape([each.stroke(launch.samples) for each in stepped], (-1, PLACES))
        common = (strokes - model.stroke(launch.samples)) / sigmas @ own[:PLACES]
    else:
        moved = [ways_of(each, compared.samples, best.launches)[0] for each in stepped]
        with np.errstate(invalid='ignore'):
            differences = np.reshape(moved, (len(steps), *best.places[0].shape)) - best.places
            common = differences.reshape(len(steps), errors.size) / steps[:, np.newaxis]
        common[~np.isfinite(common)] = 0.0
    pull = compared.precision @ (numbers - compared.mean)
    matrix, gradient, follow, spread = without_own(
        own, common, compared.weights(errors)[0], errors.ravel(), compared.precision, pull
    )
    curvature, *_ = without_own(
        own, common, compared.curvatures(errors)[0], errors.ravel(), compared.precision, pull
    )
    return ShotFit(
        replace(launch, numbers=numbers),
        float(best.costs[0]),
        compared.samples.time,
        np.linalg.norm(errors[0], axis=-1),
        matrix,
        curvature,
        gradient,
        follow,
        spread,
    )


def without_own(
    own: Floats, common: Floats, weights: Floats, errors: Floats, precision: Floats, pull: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """
    Eliminate the own numbers of a shot from its normal equations.

    Parameters
    ----------
    own, common : (own, errors) and (common, errors) float array
        Derivatives of errors by numbers.
    weights, errors : (errors,) float array
        [1/m^2] and [m]
    precision, pull : (own, own) and (own,) float array
        Of what is known of the own numbers before, and its gradient.

    Returns
    -------
    matrix, gradient : (common, common) and (common,) float array
        Normal equations of the common numbers.
    follow : (own, common) float array
        Change of the own numbers with each of these.
    spread : (own, own) float array
        Covariance of the own numbers for given common ones.

    """
    spread = np.asarray(np.linalg.inv((own * weights) @ own.T + precision), float)
    between = (own * weights) @ common.T
    follow = -spread @ between
    gradient = common @ (weights * errors) + follow.T @ (own @ (weights * errors) + pull)
    return (common * weights) @ common.T + between.T @ follow, gradient, follow, spread


def searched(
    problem: FitProblem,
    values: Floats,
    launches: Sequence[Launch],
    scales: Floats,
    seed: Sequence[int],
    cut: bool = True,
) -> tuple[Launch, ...]:
    """Search all launches, but of shots without any; if `cut`, paths count until they bend."""
    steps = 0.5 * STEP * np.diag(problem.widths) if cut else ()  # within the bounds
    stepped = [problem.model_at(values + by) for step in steps for by in (step, -step)]
    work = partial(search_fit, problem.model_at(values), stepped, scales, problem.horizon)
    items = [(each, (*seed, number)) for number, each in enumerate(launches)]
    return tuple(each for each in problem.mapped(work, items) if each is not None)


def followed(
    problem: FitProblem, values: Floats, launches: Sequence[Launch], scales: Floats
) -> JointFit:
    """Let all launches follow the common numbers."""
    steps = STEP * problem.widths
    stepped = [problem.model_at(values + step) for step in np.diag(steps)]
    work = partial(
        follow_launch, problem.model_at(values), stepped, steps, scales, problem.horizon
    )
    return JointFit(problem, values, scales, tuple(problem.mapped(work, launches)))


def rescaled(found: JointFit) -> JointFit:
    """Let launches follow with the scales of the errors that they have."""
    times, errors = ([getattr(each, name) for each in found.shots] for name in ('times', 'errors'))
    scales = scales_of(np.concatenate(times), np.concatenate(errors))
    return followed(found.problem, found.values, found.launches, scales)


def with_all_samples(launches: Iterable[Launch]) -> tuple[Launch, ...]:
    """Let all samples count, also those after which a path cannot be predicted."""
    return tuple(replace(each, until=np.inf) for each in launches)


def fit(
    found: JointFit, steps: int, report: Callable[[float], object] = lambda _: None
) -> JointFit:
    """
    Lower the cost of all shots.

    Parameters
    ----------
    found : JointFit
        With which the fit begins, see `followed`.
    steps : int
        Largest number of steps.
    report : callable
        Called after each step with the median error of all samples [m].

    """
    for _ in range(steps):
        report(found.error)
        step, ahead = found.next_step()
        if ahead < CLOSE:
            break
        for part in SHORTER:
            move = part * step
            moved = [
                replace(each.launch, numbers=each.launch.numbers + each.follow @ move)
                for each in found.shots
            ]
            tried = followed(found.problem, found.values + move, moved, found.scales)
            if tried.cost < found.cost:
                break
        else:
            break
        found = tried
    return found


def reach_of(found: JointFit) -> Floats:
    """Return half of the intervals of the common numbers (common,): each shot is left out."""
    problem, shots = found.problem, len(found.shots)
    matrices, gradients = found.curvatures, found.gradients
    without = matrices.sum(axis=0) + problem.precision - matrices
    pulls = gradients.sum(axis=0) + problem.precision @ found.away - gradients
    left = np.linalg.solve(without, pulls[..., np.newaxis])[..., 0]
    variances = (shots - 1) / shots * ((left - left.mean(axis=0)) ** 2).sum(axis=0)
    freedom = np.full(len(variances), shots - 1.0)
    if problem.careful:
        variances = np.maximum(variances, np.diag(found.covariance))
        squares = np.maximum((found.shares**2).sum(axis=1), np.finfo(float).tiny)
        deciding = found.shares.sum(axis=1) ** 2 / squares  # 0 if no shot tells the number
        freedom = np.maximum(deciding * (1.0 - SHARED / shots), 1.0)
    reach: Floats = student.ppf(0.5 + 0.5 * LEVEL, freedom) * np.sqrt(variances)
    return reach


def differing(found: JointFit, other: JointFit) -> list[str]:
    """
    Name the numbers whose careful intervals in two fits do not meet, with both values.

    Shots with exact places hardly differ, and other intervals would be too narrow.
    """
    fits = (replace(f, problem=f.problem._replace(careful=True)) for f in (found, other))
    far = np.abs(found.values - other.values) > sum(map(reach_of, fits))
    numbers = zip(found.problem.sought, found.values.tolist(), other.values.tolist(), strict=True)
    return [
        f'{each.name} {each.stated(there):.4g}, not {each.stated(here):.4g}'
        for is_far, (each, here, there) in zip(far.tolist(), numbers, strict=True)
        if is_far
    ]


def interval_bounds(found: JointFit) -> Floats:
    """Return the bounds (2, common) of the intervals of the common numbers."""
    problem, reach = found.problem, reach_of(found)
    ruler = np.array([RULER.get(each.name, 0.0) for each in problem.sought])
    reach = np.hypot(reach, norm.ppf(0.5 + 0.5 * LEVEL) * ruler)
    low, high = np.reshape([(each.low, each.high) for each in problem.sought], (-1, 2)).T
    return np.stack(
        [np.maximum(found.values - reach, low), np.minimum(found.values + reach, high)]
    )


def estimates_of(found: JointFit, sought: Sequence[Unknown]) -> tuple[Estimate, ...]:
    """Return the estimates of all numbers, also of those that the shots do not decide."""
    low, high = interval_bounds(found).tolist()
    decisive = np.argsort(-found.shares, axis=-1, kind='stable')[:, :DECISIVE].tolist()
    known = {each: k for k, each in enumerate(found.problem.sought)}
    estimates = []
    for each in sought:
        value = before = each.stated(each.start)
        interval, shots = None, ()
        if (k := known.get(each)) is not None:
            value = each.stated(float(found.values[k]))
            interval = each.stated(low[k]), each.stated(high[k])
            shots = tuple(found.shots[number].launch.samples.name for number in decisive[k])
        estimates.append(
            Estimate(each.name, each.unit, before, each.published, value, interval, shots)
        )
    return tuple(estimates)


def undecided(found: JointFit) -> list[Unknown]:
    """
    Return the numbers that the shots may not decide, the least decided one first.

    A number is decided if its interval is narrower than the range of likely values, or does not
    hold the value with which the fit began. It is not if its range alone keeps it where it is.
    """
    problem, (low, high) = found.problem, interval_bounds(found)
    inside = (low <= problem.start) & (problem.start <= high)
    held = np.diag(found.covariance) * np.diag(problem.precision)  # 1: only the range is known
    parts = np.maximum(np.where(inside, (high - low) / problem.widths, 0.0), held / HELD)
    order = np.argsort(-parts, kind='stable').tolist()
    return [problem.sought[k] for k in order if parts[k] > 1.0]


def decided(
    found: JointFit,
    steps: int,
    report: Callable[[float], object] = lambda _: None,
    needed: Sequence[str] = (),
) -> JointFit:
    """
    Fit the numbers that the shots decide, and those without which the fit is worse.

    The others are let go, one after the other; needed ones stay.
    """
    kept = list(needed)
    while doubtful := [each for each in undecided(found) if each.name not in kept]:
        k, problem = found.problem.sought.index(doubtful[0]), found.problem
        rest = problem._replace(sought=problem.sought[:k] + problem.sought[k + 1 :])
        start = followed(rest, np.delete(found.values, k), found.launches, found.scales)
        tried = fit(start, steps, report)
        if tried.cost <= (1.0 + WORSE) * found.cost:
            found = tried
        else:
            kept.append(doubtful[0].name)
    return found


def at_bounds(found: JointFit) -> list[str]:
    """Name the numbers that a fit left at one of their bounds."""
    low, high = found.problem.bounds
    room = STEP * found.problem.widths
    near = (found.values < low + room) | (found.values > high - room)
    return [found.problem.sought[k].name for k in np.flatnonzero(near).tolist()]
