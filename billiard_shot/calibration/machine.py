"""
Where a machine stands at its table, and how it errs, from strikes that it recorded.

Each strike has its own stroke and places of the balls, which are fitted to the samples of all
balls as those of commanded strokes are, see launch.py, with errors that are wide enough for a
machine that stands elsewhere. A track does not tell all numbers of a stroke. So what it tells is
kept as the information that it gives, without the range in which the stroke was sought.

The strokes that were really played differ from those of the encoders by the alignment, in which
they are nearly linear, and by errors of each strike, which are the robot's. The variances of these
errors are those of the best evidence (MacKay, Neural Comput. 4 (1992)), together with the errors
that the scene states before. The intervals of the numbers are those of Student's t.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from billiard_shot.calibration.estimate import Estimate, write_yaml
from billiard_shot.calibration.fit import even_until, jackknife, Launch, let_go, LEVEL, without_own
from billiard_shot.calibration.launch import (
    calibration_model,
    CalibrationModel,
    compare,
    derivatives_of,
    evaluated,
    FIRST_SCALES,
    PLACES,
    prior_of,
    refined,
    scales_of,
    sigmas_of,
    ways_of,
)
from billiard_shot.calibration.player import estimates_of, with_noise
from billiard_shot.calibration.reader import read_recordings, Recordings
from billiard_shot.calibration.recording import (
    check_enough,
    CommandedStroke,
    Floats,
    Samples,
    usable_shots,
)
from billiard_shot.cue.mechanism import Alignment, EXACT, Mechanism
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene import Bias, Noise, Scene
from billiard_shot.scene.fields import write
from billiard_shot.scene.player import SPEED
from billiard_shot.shot.stroke import Stroke

HORIZONS = 0.4, 0.8, 1.5
"""Times after the strike that count, one after the other [s]."""

RANGES = 0.3, 0.3, math.radians(3.0), math.radians(3.0), 0.15
"""Deviations of the sought strokes: a, b (ball radii), angles [rad], and speed, relative to it."""

MOST_STEPS = 8
"""Most steps of least squares at each horizon."""


class Number(NamedTuple):
    """A number of the alignment: its unit, and the deviation of likely values."""

    unit: str
    width: float


NUMBERS = {
    'machine_x': Number('m', 0.02),
    'machine_y': Number('m', 0.02),
    'machine_angle_deg': Number('degrees', 2.0),
    'tip_right': Number('m', 0.01),
    'tip_up': Number('m', 0.01),
    'speed_scale': Number('', 0.1),
    'speed_bias': Number('m/s', 0.1),
    'elevation_scale': Number('', 0.05),
    'elevation_bias_deg': Number('degrees', 2.0),
}

NEEDED = 'machine_x', 'machine_y', 'machine_angle_deg', 'speed_scale'
"""Numbers without which a machine cannot play."""

UNDECIDED = 0.4
"""A number is not decided if half of its interval is wider than this part of its width."""

STEP = 1e-3
"""Step of a number for differences, relative to its width."""

SHARED = 3
"""Strikes that are used up by what strikes have in common: no kind of error tells more numbers."""

LINEARIZED, ROUNDS = 3, 60
"""How often the alignment is linearized, and rounds in which variances settle."""

BEFORE = 4.0
"""Number of errors for which the errors count that the scene states before."""

LEAST_ERRORS = np.array([1e-3, 1e-3, 1e-4, 1e-4, 1e-3])
"""Smallest deviations of errors that a scene states: a, b (ball radii), rad, rad, m/s."""

LIKELY = 0.995
"""Part of the strikes that are as near to what all have in common as those that count."""

LEAST_STRIKES = 10
"""Number of strikes that tell the numbers of a machine."""

WIDTHS = 1.0, 0.2, 0.2
"""How widely strokes are sought, each time around those of the alignment that was found last."""

MEDIAN = 1.177
"""Median distance of places whose x and y have the deviation 1 (Rayleigh)."""

LEAST_SIGMA = 3e-4
"""Smallest deviation of x and y [m]: pictures are distorted."""

WORST = 4.0
"""A strike does not count if no stroke fits it: its median error relative to that of all."""

ASTRAY = 0.35
"""Cue balls do not start as their strokes say if half of them start so far beside them [rad]."""

CONVENTIONS: dict[str, Callable[[Floats], Floats]] = {
    'y of the tracks or of the strokes is mirrored': lambda azimuth: -azimuth,
    'x of the tracks or of the strokes is mirrored': lambda azimuth: math.pi - azimuth,
    'x and y of the tracks or of the strokes are swapped': lambda azimuth: 0.5 * math.pi - azimuth,
    'the strokes point backwards': lambda azimuth: azimuth + math.pi,
    'the azimuths are in radians, not in degrees': np.degrees,
}
"""Usual mistakes in recordings; the azimuths that were meant for those that were read [rad]."""

LIKELY_SPEEDS = 0.1, 2.0
"""Range of the speed of a cue ball relative to that of the cue."""

LEAST_KNOWN = 4.0
"""Number of known errors that tell their deviation."""


class Strike(NamedTuple):
    """
    A recorded strike, and what its tracks tell about its stroke.

    Attributes
    ----------
    samples : Samples
        With the stroke as the driver measured it.
    place : (2,) float array
        Of the cue ball [m].
    information : (5, 5) float array
        The inverse of the covariance of the stroke.
    moment : (5,) float array
        Information times the stroke that the tracks alone would tell.
    measured : Alignment
        That of the driver.

    """

    samples: Samples
    place: Floats
    information: Floats
    moment: Floats
    measured: Alignment = EXACT

    def stroke(self, alignment: Alignment, scene: Scene) -> Floats:
        """Return the stroke (5,) of the tip, if the encoders differ by an alignment."""
        assert self.samples.shot.stroke is not None
        x, y = self.place.tolist()
        return stroke_on_table(alignment, self.samples.shot.stroke, (x, y), scene, self.measured)


def _commanded(samples: Samples, stroke: Floats, noise: Noise) -> Samples:
    """Return a strike as if a stroke (5,) had been commanded."""
    command = CommandedStroke(tuple(stroke.tolist()), False, noise)
    return replace(samples, command=command).until(HORIZONS[-1])


def _searched(
    model: CalibrationModel,
    strike: Strike,
    likely: Floats,
    width: float,
    scales: Floats,
    sigma: float,
) -> tuple[Strike, Floats]:
    """
    Fit the stroke of a strike to its tracks.

    Parameters
    ----------
    model : CalibrationModel
    strike : Strike
    likely : (5,) float array
        Around which the stroke is sought.
    width : float
        How widely it is sought, relative to `RANGES`.
    scales : (knots,) float array
        Of errors [m], see launch.py.
    sigma : float
        Deviation of x and y of samples from ways that fit [m].

    Returns
    -------
    strike : Strike
    errors : (samples,) float array
        Of samples until the last horizon [m].

    """
    radius = model.scene.ball.radius
    units = np.array([radius, radius, math.degrees(1.0), math.degrees(1.0), likely[SPEED]])
    samples = _commanded(strike.samples, likely, Noise(*(width * units * RANGES).tolist()))
    numbers = prior_of(samples)[0][np.newaxis]
    for horizon in HORIZONS:
        best = refined(model, compare(samples, scales, horizon), numbers, MOST_STEPS)
        numbers = best.launches
    errors = np.linalg.norm(best.places[0] - samples.place, axis=-1)
    if not np.isfinite(errors).all():
        return strike, errors
    # Only samples count that depend on the stroke evenly.
    until = even_until(model, [], Launch(samples, numbers[0]))
    if until.max() < samples.times[0]:
        return strike, errors
    compared = compare(samples, scales, until)
    here = evaluated(model, compared, numbers)
    (errors_here, (slopes,)) = derivatives_of(model, compared, here)
    weights = compared.weights(errors_here)[0]
    # Robust weights say too little: with errors that are normal, all samples count alike.
    more = compared.share.sum() / (sigma**2 * weights[::2].sum())
    prior = compared.precision @ (numbers[0] - compared.mean)
    # Of the stroke, without the places of the balls, which are not asked for.
    information, gradient, _ = without_own(
        slopes[PLACES:],
        slopes[:PLACES],
        weights,
        errors_here.ravel(),
        compared.precision[PLACES:, PLACES:],
        prior[PLACES:],
    )
    moment = information @ numbers[0, :PLACES] - gradient
    assert samples.command is not None
    unit = 1.0 / sigmas_of(samples.command, radius)
    information = more * unit[:, np.newaxis] * information * unit
    moment = more * unit * moment + information @ likely
    return strike._replace(information=information, moment=moment), errors


class Common(NamedTuple):
    """
    What strikes have in common.

    Attributes
    ----------
    names : tuple of str
    values, reach : (names,) float array
        Numbers of the alignment, and half of their intervals.
    variances, known : (5,) float array
        Of the robot's errors of a, b (ball radii), elevation, azimuth [rad] and speed [m/s]; and
        for how many errors that are exactly known these strikes stand.

    """

    names: tuple[str, ...]
    values: Floats
    reach: Floats
    variances: Floats
    known: Floats

    @property
    def alignment(self) -> Alignment:
        """The alignment with these numbers."""
        return Alignment(**dict(zip(self.names, self.values.tolist(), strict=True)))

    @property
    def undecided(self) -> dict[str, float]:
        """Half of the intervals that are too wide, the widest first for its number."""
        parts = {
            name: reach / (UNDECIDED * NUMBERS[name].width)
            for name, reach in zip(self.names, self.reach.tolist(), strict=True)
        }
        wide = sorted((name for name in parts if parts[name] > 1.0), key=lambda name: -parts[name])
        return {name: float(self.reach[self.names.index(name)]) for name in wide}


def decided_pose(scene: Scene, strikes: Sequence[Strike]) -> Common:
    """Find the numbers that strikes decide, and those without which a machine cannot play."""

    def undecided(found: Common) -> list[str]:
        return [name for name in found.undecided if name not in NEEDED]

    def without(found: Common, number: str) -> Common:
        rest = tuple(name for name in found.names if name != number)
        return common_numbers(scene, strikes, rest)

    return let_go(common_numbers(scene, strikes, tuple(NUMBERS)), undecided, without)


def check_decided(found: Common) -> None:
    """Raise ValueError if a number is not decided without which a machine cannot play."""
    if wide := found.undecided:
        said = ', '.join(
            f'{name} only to {reach:.2g} {NUMBERS[name].unit}'.strip()
            for name, reach in wide.items()
        )
        raise ValueError(
            f'strikes must decide {", ".join(NEEDED)}, but decide {said}; record strikes in other '
            'directions, at other places and speeds'
        )


def agreeing(scene: Scene, strikes: Sequence[Strike], least: int) -> tuple[list[Strike], Common]:
    """Leave out strikes, one after the other, that do not fit the others; keep at least some."""
    kept = list(strikes)
    while True:
        found = decided_pose(scene, kept)
        distances = [_distance(scene, found, each) for each in kept]
        worst = int(np.argmax(distances))
        if distances[worst] < chi2.ppf(LIKELY, 5) or len(kept) <= least:
            return kept, found
        del kept[worst]


def _distance(scene: Scene, found: Common, strike: Strike) -> float:
    """Return how far a stroke is from what strikes have in common, squared, in deviations."""
    information = strike.information
    away = strike.moment - information @ strike.stroke(found.alignment, scene)
    spread = information + information * found.variances @ information
    return float(away @ np.linalg.pinv(spread, 1e-10, hermitian=True) @ away)


def common_numbers(scene: Scene, strikes: Sequence[Strike], names: tuple[str, ...]) -> Common:
    """Find numbers of the alignment, while the others are those of an exact machine."""
    widths = np.array([NUMBERS[name].width for name in names])
    values = np.array([getattr(Alignment(), name) for name in names])
    exact, prior = values, np.diag(widths**-2)

    def played(values: Floats) -> Floats:
        alignment = Alignment(**dict(zip(names, values.tolist(), strict=True)))
        return np.array([each.stroke(alignment, scene) for each in strikes])

    information = np.array([each.information for each in strikes])
    moments = np.array([each.moment for each in strikes])
    variances = before = np.maximum(scene.noise.sigmas(scene.ball.radius), LEAST_ERRORS) ** 2
    for _ in range(LINEARIZED):
        strokes = played(values)
        slopes = np.stack(
            [(played(values + step) - strokes) / step.sum() for step in np.diag(STEP * widths)],
            axis=-1,
        )
        change = np.zeros(len(names))
        for _ in range(ROUNDS):
            # The information about the common part of a stroke, whose own error is not known.
            blurred = np.eye(5) + information * variances
            weights = np.linalg.solve(blurred, information)
            away = np.linalg.solve(blurred, moments[..., np.newaxis])[..., 0]
            away -= np.einsum('sij,sj->si', weights, strokes)
            matrix = np.einsum('sik,sij,sjl->kl', slopes, weights, slopes) + prior
            gradient = np.einsum('sik,si->k', slopes, away) - prior @ (values - exact)
            change, covariance = np.linalg.solve(matrix, gradient), np.linalg.inv(matrix)
            left = moments - np.einsum('sij,sj->si', information, strokes + slopes @ change)
            spread = np.linalg.inv(information + np.diag(1.0 / variances))
            errors = np.einsum('sij,sj->si', spread, left)
            turned = spread @ information @ slopes
            unsure = np.einsum('sii->si', spread + turned @ covariance @ turned.swapaxes(1, 2))
            known = np.maximum((1.0 - unsure / variances).sum(axis=0), 0.0)
            variances = ((errors**2).sum(axis=0) + BEFORE * before) / (known + BEFORE)
        values = values + change
    # Each strike left out in turn: if strikes differ more than they say.
    own = np.einsum('sik,sij,sjl->skl', slopes, weights, slopes)
    pulls = np.einsum('sik,si->sk', slopes, away)
    spread_out = jackknife(own, pulls, prior, exact - values + change)
    deviations = np.sqrt(np.maximum(np.diag(covariance), spread_out))
    # For how many strikes those count that decide a number (Satterthwaite, Biom. Bull. 2 (1946)).
    parts = np.einsum('ik,skl,il->si', covariance, own, covariance)
    deciding = parts.sum(axis=0) ** 2 / (parts**2).sum(axis=0)
    freedom = np.maximum(deciding * (1.0 - SHARED / len(strikes)), 1.0)
    reach = student.ppf(0.5 + 0.5 * LEVEL, freedom) * deviations
    return Common(names, values, reach, variances, known)


@dataclass(frozen=True, slots=True, eq=False)
class MachineCalibration:
    """
    A machine that has found its table.

    Attributes
    ----------
    alignment : Alignment
    estimates : tuple of Estimate
        Of the alignment, then of the robot's errors.
    scene : Scene
        With the robot's errors in its section `noise`.
    errors, errors_before : float
        Median error of the cue ball in strikes that were held out [m], with the alignment that the
        other half gives, and without.
    strikes : int
        How many fit the alignment.
    notes : tuple of str
        How exact the recorded places are.
    ignored : tuple of str
        Shots and strikes that were left out, with the reason.

    """

    alignment: Alignment
    estimates: tuple[Estimate, ...]
    scene: Scene
    errors: float
    errors_before: float
    strikes: int
    notes: tuple[str, ...]
    ignored: tuple[str, ...]

    @property
    def about(self) -> tuple[str, ...]:
        """The number of strikes, errors of predictions, and what was left out, in words."""
        return (
            f'Fitted to {self.strikes} strikes.',
            f'Error of the cue ball in the half held out: median {1e3 * self.errors:.1f} mm; '
            f'without the alignment: {1e3 * self.errors_before:.1f} mm.',
            'The reach is not sought: the cue keeps its speed around the contact, so that no '
            'strike depends on it.',
            *self.notes,
            *(f'ignored: {text}' for text in self.ignored),
        )

    def save(self, path: str | Path, mechanism: Mechanism) -> None:
        """Write a mechanism with this alignment as YAML, with a comment for each number."""
        aligned = write(replace(mechanism, alignment=self.alignment))
        write_yaml(path, aligned, self._of('alignment'), self.about)

    def save_scene(self, path: str | Path) -> None:
        """Write the scene with the robot's errors as YAML."""
        write_yaml(path, self.scene.to_dict(), self._of('noise'), self.about)

    def _of(self, section: str) -> list[Estimate]:
        return [each for each in self.estimates if each.name.startswith(section)]


def calibrate_machine(
    recordings: Recordings, scene: Scene, measured: Alignment = EXACT
) -> MachineCalibration:
    """
    Find where a machine stands at its table, and how it errs.

    Parameters
    ----------
    recordings : Recording, str, Path, or sequence of these
        Of strikes at several places, in several directions, at several speeds and elevations, with
        their strokes as the driver measured them. The node `shot_recorder` writes them.
    scene : Scene
        The table, which is known.
    measured : Alignment
        That of the driver, which is part of these strokes; the one that is found replaces it.

    Raises
    ------
    ValueError
        If a file makes no sense, there are too few strikes, or they do not decide the numbers.

    """
    read = read_recordings(recordings)
    usable, ignored, tracking = usable_shots(scene, read)
    model, nothing = calibration_model(scene, read), np.zeros((PLACES, PLACES))
    recorded = [
        Strike(each, model.frame(each).to_table(each.rest[0]), nothing, nothing[0], measured)
        for each in usable
        if each.shot.stroke is not None
    ]
    check_enough(len(recorded), LEAST_STRIKES, 'strikes with strokes', ignored)
    starts = [
        model.frame(each.samples).vectors_to_table(each.samples.velocity) for each in recorded
    ]
    strokes = [each.samples.shot.stroke for each in recorded if each.samples.shot.stroke]
    check_conventions(np.array(starts), strokes)
    alignment, scales, sigma = Alignment(), FIRST_SCALES, float(FIRST_SCALES[0])
    times = np.concatenate([each.samples.until(HORIZONS[-1]).time for each in recorded])
    for width in WIDTHS:
        strikes, errors = [], []
        for each in recorded:
            likely = each.stroke(alignment, model.scene)
            strike, own = _searched(model, each, likely, width, scales, sigma)
            strikes.append(strike)
            errors.append(own)
        scales = scales_of(times, np.concatenate(errors))
        medians = np.array([np.median(each) for each in errors])
        sigma = max(float(np.median(medians)) / MEDIAN, LEAST_SIGMA)
        fits = medians < WORST * MEDIAN * sigma
        strikes = [each for each, is_fit in zip(strikes, fits.tolist(), strict=True) if is_fit]
        if len(strikes) < LEAST_STRIKES:
            raise ValueError(
                f'recordings must have at least {LEAST_STRIKES} strikes that the scene can '
                f'explain, got {len(strikes)} of {len(recorded)}'
            )
        strikes, found = agreeing(model.scene, strikes, LEAST_STRIKES)
        alignment = found.alignment
    check_decided(found)
    if left := len(recorded) - len(strikes):
        ignored.append(f'{left} strikes that do not fit the others')
    half, held_out = common_numbers(model.scene, strikes[::2], found.names), strikes[1::2]
    own_errors = _robot_errors(scene, found)
    return MachineCalibration(
        alignment,
        (*_numbers(found), *own_errors),
        with_noise(replace(scene, noise=replace(scene.noise, bias=Bias())), own_errors),
        _median_error(model, half.alignment, held_out),
        _median_error(model, Alignment(), held_out),
        len(strikes),
        tuple(tracking),
        tuple(ignored),
    )


def check_conventions(velocities: Floats, strokes: Sequence[Stroke]) -> None:
    """
    Raise ValueError if strikes seem to be mirrored, swapped, or in other units; say which.

    Parameters
    ----------
    velocities : (strikes, 2) float array
        Of the cue balls, as their tracks begin [m/s].
    strokes : sequence of Stroke
        As they were measured.

    """
    headings = np.arctan2(velocities[:, 1], velocities[:, 0])
    azimuths = np.array([each.offsets[3] for each in strokes])

    def astray(meant: Floats) -> float:
        return float(np.median(np.abs(wrapped(headings - meant))))

    found = {mistake: astray(change(azimuths)) for mistake, change in CONVENTIONS.items()}
    likely = min(found, key=lambda mistake: found[mistake])
    stated = astray(azimuths)
    if stated > ASTRAY > found[likely]:
        raise ValueError(
            f'recordings: {likely}: half of the cue balls start {math.degrees(stated):.0f}° '
            f'or more beside their strokes, but {math.degrees(found[likely]):.0f}° if so'
        )
    speeds = [each.speed for each in strokes]
    ratio = float(np.median(np.linalg.norm(velocities, axis=1) / speeds))
    slowest, fastest = LIKELY_SPEEDS
    if not slowest < ratio < fastest:
        raise ValueError(
            f'recordings: the cue balls start at {ratio:.2g} times the speed of the cue, which '
            f'must be {slowest:g} to {fastest:g}; are the units m, s and m/s?'
        )


def _median_error(
    model: CalibrationModel, alignment: Alignment, strikes: Sequence[Strike]
) -> float:
    """Return the median, over strikes, of the median error of an alignment [m]."""
    medians = []
    for each in strikes:
        samples = _commanded(each.samples, each.stroke(alignment, model.scene), Noise())
        places = ways_of(model, samples, prior_of(samples)[0][np.newaxis])[0]
        medians.append(np.median(np.linalg.norm(places - samples.place, axis=-1)))
    return float(np.median(medians))


def _numbers(found: Common) -> Iterator[Estimate]:
    """Yield the estimates of all numbers, also of those that strikes do not decide."""
    for name, number in NUMBERS.items():
        value = exact = getattr(Alignment(), name)
        interval = None
        if name in found.names:
            k = found.names.index(name)
            value, reach = float(found.values[k]), float(found.reach[k])
            interval = value - reach, value + reach
        yield Estimate(f'alignment.{name}', number.unit, exact, None, value, interval, ())


def _robot_errors(scene: Scene, found: Common) -> tuple[Estimate, ...]:
    """Return the estimates of the robot's errors; those hardly told are the ones of the scene."""
    radius = scene.ball.radius
    units = np.array([radius, radius, math.degrees(1.0), math.degrees(1.0), 1.0])
    sigmas = np.where(found.known < LEAST_KNOWN, np.nan, units * np.sqrt(found.variances))
    freedom, tail = np.maximum(found.known, 1.0), 0.5 - 0.5 * LEVEL
    low, high = sigmas * np.sqrt(freedom / chi2.ppf([[1.0 - tail], [tail]], freedom))
    return tuple(estimates_of('noise', scene.noise, sigmas, low, high))
