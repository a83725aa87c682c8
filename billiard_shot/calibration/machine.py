"""
Where a machine stands at its table, and how it errs, from strikes that it recorded.

What the strokes that were really played differ by from what the encoders say is linear in the
numbers of the alignment, but for errors of each strike, which are the robot's. The variances of
these errors are those of restricted maximum likelihood, found by expectation and maximization
(Laird and Ware, Biometrics 38 (1982)); the intervals of the numbers are those of Student's t.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from billiard_shot.calibration.comparison import FIRST_SCALES, scales_of
from billiard_shot.calibration.errors import estimates_of, with_noise
from billiard_shot.calibration.estimate import Estimate
from billiard_shot.calibration.intervals import LEVEL
from billiard_shot.calibration.machine_strokes import fit_stroke, HORIZONS, Recorded, Told
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.scene_file import scene_text, yaml_text
from billiard_shot.calibration.usable import (
    check_places,
    read_recordings,
    Recordings,
    usable_shots,
)
from billiard_shot.cue.alignment import Alignment
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.scene import Bias, Scene
from billiard_shot.scene.checks import write

LEAST_STRIKES = 10
"""Number of strikes that tell the numbers of a machine."""


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

WIDTHS = 1.0, 0.2, 0.2
"""How widely strokes are sought, each time around those of the alignment that was found last."""

LINEARIZED, ROUNDS = 3, 60
"""How often the alignment is linearized, and rounds of expectation and maximization."""

MEDIAN = 1.177
"""Median distance of places whose x and y have the deviation 1 (Rayleigh)."""

LEAST_SIGMA = 3e-4
"""Smallest deviation of x and y [m]: pictures are distorted."""

WORST = 4.0
"""A strike does not count if no stroke fits it: its median error relative to that of all."""

LEAST_KNOWN = 4.0
"""Number of known errors that tell their deviation."""

BEFORE = 4.0
"""Number of errors for which the errors count that the scene states before."""

LEAST_ERRORS = np.array([1e-3, 1e-3, 1e-4, 1e-4, 1e-3])
"""Smallest deviations of errors that a scene states: a, b (ball radii), rad, rad, m/s."""

LIKELY = 0.995
"""Part of the strikes that are as near to what all have in common as those that count."""


def stroke_in(recorded: Recorded, alignment: Alignment, scene: Scene) -> Floats:
    """Return the stroke (5,) of the tip in a strike, if the encoders differ by an alignment."""
    x, y = recorded.place.tolist()
    return stroke_on_table(alignment, recorded.stroke, (x, y), scene)


class Strike(NamedTuple):
    """A strike as it was recorded, and what its tracks tell."""

    recorded: Recorded
    told: Told


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


def decided(scene: Scene, strikes: Sequence[Strike]) -> Common:
    """
    Let the numbers go, one after the other, that strikes do not decide, and fit the others.

    Raises
    ------
    ValueError
        If a number is not decided without which a machine cannot play.

    """
    found = common_numbers(scene, strikes, tuple(NUMBERS))
    while optional := [name for name in found.undecided if name not in NEEDED]:
        left = tuple(name for name in found.names if name != optional[0])
        found = common_numbers(scene, strikes, left)
    if wide := found.undecided:
        said = ', '.join(
            f'{name} only to {reach:.2g} {NUMBERS[name].unit}'.strip()
            for name, reach in wide.items()
        )
        raise ValueError(
            f'strikes must decide {", ".join(NEEDED)}, but decide {said}; record strikes in other '
            'directions, at other places and speeds'
        )
    return found


def agreeing(scene: Scene, strikes: Sequence[Strike]) -> list[Strike]:
    """Leave out strikes, one after the other, that do not fit the others; see `decided`."""
    kept = list(strikes)
    while True:
        found = decided(scene, kept)
        distances = [_distance(scene, found, each) for each in kept]
        worst = int(np.argmax(distances))
        if distances[worst] < chi2.ppf(LIKELY, 5) or len(kept) <= LEAST_STRIKES:
            return kept
        del kept[worst]


def _distance(scene: Scene, found: Common, strike: Strike) -> float:
    """Return how far a stroke is from what strikes have in common, squared, in deviations."""
    information, moment = strike.told.information, strike.told.moment
    away = moment - information @ stroke_in(strike.recorded, found.alignment, scene)
    spread = information + information * found.variances @ information
    return float(away @ np.linalg.pinv(spread, 1e-10, hermitian=True) @ away)


def common_numbers(scene: Scene, strikes: Sequence[Strike], names: tuple[str, ...]) -> Common:
    """Find numbers of the alignment, while the others are those of an exact machine."""
    widths = np.array([NUMBERS[name].width for name in names])
    values = np.array([getattr(Alignment(), name) for name in names])
    exact, prior = values, np.diag(widths**-2)

    def played(values: Floats) -> Floats:
        alignment = Alignment(**dict(zip(names, values.tolist(), strict=True)))
        return np.array([stroke_in(each.recorded, alignment, scene) for each in strikes])

    information = np.array([each.told.information for each in strikes])
    moments = np.array([each.told.moment for each in strikes])
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
    # Each strike left out in turn, as in intervals.py: if strikes differ more than they say.
    own = np.einsum('sik,sij,sjl->skl', slopes, weights, slopes)
    pulls = np.einsum('sik,si->sk', slopes, away)
    left_out = np.linalg.solve(matrix - own, (gradient - pulls)[..., np.newaxis])[..., 0]
    count = len(strikes)
    spread_out = (count - 1) / count * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0)
    deviations = np.sqrt(np.maximum(np.diag(covariance), spread_out))
    # For how many strikes those count that decide a number (Satterthwaite, Biom. Bull. 2 (1946)).
    parts = np.einsum('ik,skl,il->si', covariance, own, covariance)
    deciding = parts.sum(axis=0) ** 2 / (parts**2).sum(axis=0)
    freedom = np.maximum(deciding * (1.0 - SHARED / count), 1.0)
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
        How many there were.
    ignored : tuple of str
        What was left out, and why.

    """

    alignment: Alignment
    estimates: tuple[Estimate, ...]
    scene: Scene
    errors: float
    errors_before: float
    strikes: int
    ignored: tuple[str, ...]

    @property
    def about(self) -> tuple[str, ...]:
        """What it was found from, and how well it predicts, in words."""
        return (
            f'Fitted to {self.strikes} strikes.',
            f'Error of the cue ball in the half held out: median {1e3 * self.errors:.1f} mm; '
            f'without the alignment: {1e3 * self.errors_before:.1f} mm.',
            'The reach is not sought: the cue keeps its speed around the contact, so that no '
            'strike depends on it.',
        )

    def save(self, path: str | Path, mechanism: Mechanism) -> None:
        """Write a mechanism with this alignment as YAML, with a comment for each number."""
        aligned = write(replace(mechanism, alignment=self.alignment))
        Path(path).write_text(yaml_text(aligned, self._of('alignment'), self.about), 'utf-8')

    def save_scene(self, path: str | Path) -> None:
        """Write the scene with the robot's errors as YAML."""
        text = scene_text(self.scene, self._of('noise'), self.about)
        Path(path).write_text(text, encoding='utf-8')

    def _of(self, section: str) -> list[Estimate]:
        return [each for each in self.estimates if each.name.startswith(section)]


def calibrate_machine(recordings: Recordings, scene: Scene) -> MachineCalibration:
    """
    Find where a machine stands at its table, and how it errs.

    Parameters
    ----------
    recordings : Recording, str, Path, or sequence of these
        Of strikes at several places, in several directions, at several speeds and elevations, with
        their strokes as the encoders say. The node `shot_recorder` writes them.
    scene : Scene
        The table, which is known.

    Raises
    ------
    ValueError
        If a file makes no sense, there are too few strikes, or they do not decide the numbers.

    """
    read = read_recordings(recordings)
    usable, ignored = usable_shots(read)
    check_places(scene, usable, read)
    recorded = [
        Recorded(read[each.recording].frame, each.watched, each.shot.stroke)
        for each in usable
        if each.shot.stroke is not None
    ]
    if len(recorded) < LEAST_STRIKES:
        raise ValueError(
            f'recordings must have at least {LEAST_STRIKES} strikes with strokes, got '
            + '\n  '.join([str(len(recorded)), *ignored])
        )
    bare, alignment = replace(scene, balls={}), Alignment()
    scales, sigma = FIRST_SCALES, float(FIRST_SCALES[0])
    for width in WIDTHS:
        strikes, errors = [], []
        for each in recorded:
            likely = stroke_in(each, alignment, bare)
            strikes.append(Strike(each, fit_stroke(bare, each, likely, width, scales, sigma)))
            errors.append(_errors(bare, each, strikes[-1].told.row))
        times = [each.watched.until(HORIZONS[-1]) for each in recorded]
        scales = scales_of(
            np.concatenate([each.times[each.at] for each in times]), np.concatenate(errors)
        )
        medians = np.array([np.median(each) for each in errors])
        sigma = max(float(np.median(medians)) / MEDIAN, LEAST_SIGMA)
        fits = medians < WORST * MEDIAN * sigma
        strikes = [each for each, is_fit in zip(strikes, fits.tolist(), strict=True) if is_fit]
        strikes = agreeing(bare, strikes)
        found = decided(bare, strikes)
        alignment = found.alignment
    if left := len(recorded) - len(strikes):
        ignored.append(f'{left} strikes that do not fit the others')
    half, held_out = common_numbers(bare, strikes[::2], found.names).alignment, strikes[1::2]
    own = _robot_errors(scene, found)
    return MachineCalibration(
        alignment,
        (*_numbers(found), *own),
        with_noise(replace(scene, noise=replace(scene.noise, bias=Bias())), own),
        _median_error(bare, half, held_out),
        _median_error(bare, Alignment(), held_out),
        len(strikes),
        tuple(ignored),
    )


def _errors(scene: Scene, recorded: Recorded, row: Floats) -> Floats:
    """Return the errors (samples,) [m] of a strike (8,), until the horizon."""
    seen = recorded._replace(watched=recorded.watched.until(HORIZONS[-1]))
    away = seen.ways(scene, row[np.newaxis])[0] - seen.watched.place
    errors: Floats = np.linalg.norm(away, axis=-1)
    return errors


def _median_error(scene: Scene, alignment: Alignment, strikes: Sequence[Strike]) -> float:
    """Return the median, over strikes, of the median error of an alignment [m]."""
    rows = [np.append(stroke_in(each.recorded, alignment, scene), np.zeros(3)) for each in strikes]
    errors = [
        np.median(_errors(scene, each.recorded, row))
        for each, row in zip(strikes, rows, strict=True)
    ]
    return float(np.median(errors))


def _numbers(found: Common) -> Iterator[Estimate]:
    """Yield the estimates of all numbers, also of those that strikes do not decide."""
    for name, number in NUMBERS.items():
        value, interval = getattr(Alignment(), name), None
        if name in found.names:
            k = found.names.index(name)
            value, reach = float(found.values[k]), float(found.reach[k])
            interval = value - reach, value + reach
        exact = getattr(Alignment(), name)
        yield Estimate(f'alignment.{name}', number.unit, exact, None, value, interval, ())


def _robot_errors(scene: Scene, found: Common) -> tuple[Estimate, ...]:
    """Return the estimates of the robot's errors; those hardly told are the ones of the scene."""
    radius = scene.ball.radius
    units = np.array([radius, radius, math.degrees(1.0), math.degrees(1.0), 1.0])
    sigmas = np.where(found.known < LEAST_KNOWN, np.nan, units * np.sqrt(found.variances))
    freedom, tail = np.maximum(found.known, 1.0), 0.5 - 0.5 * LEVEL
    low, high = sigmas * np.sqrt(freedom / chi2.ppf([[1.0 - tail], [tail]], freedom))
    return tuple(estimates_of('noise', scene.noise, sigmas, low, high))
