"""
Where a machine stands at its table, and how it errs, from strikes that it recorded.

The numbers of the alignment are sought as those of a table are, see fit.py: each strike is a
commanded stroke, see launch.py, that the alignment turns into the one of the tip. Its five errors
are those of the robot. They are wide at first. Then their variances are those of the best evidence
(MacKay, Neural Comput. 4 (1992)), together with the errors that the scene states before.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from billiard_shot.calibration import launch
from billiard_shot.calibration.fit import (
    ALIGNMENT,
    decided,
    estimates_of,
    fit,
    FitProblem,
    followed,
    interval_bounds,
    JointFit,
    Launch,
    LEVEL,
    undecided,
    Unknown,
    until_bent,
)
from billiard_shot.calibration.player import noise_estimates, with_noise
from billiard_shot.calibration.reader import read_recordings, Recordings
from billiard_shot.calibration.recording import (
    check_enough,
    Floats,
    Samples,
    StrokeErrors,
    usable_shots,
)
from billiard_shot.calibration.result import Estimate, write_yaml
from billiard_shot.cue.mechanism import Alignment, EXACT, Mechanism
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene import Bias, Noise, Scene
from billiard_shot.scene.fields import write
from billiard_shot.shot.stroke import Stroke

FIRST_HORIZON, HORIZON = 0.8, 1.5
"""Time after the strike that counts, first and later [s]."""

WIDE = np.array([0.3, 0.3, math.radians(3.0), math.radians(3.0), 0.3])
"""Deviations of errors at first: a, b (ball radii), rad, rad, m/s."""

FARTHEST = 5.0
"""How many deviations of likely values a number may be off."""


def _sought(name: str, unit: str, width: float) -> Unknown:
    start, far = getattr(EXACT, name), FARTHEST * width
    return Unknown(f'{ALIGNMENT}.{name}', unit, start, start - far, start + far, width)


SOUGHT = (
    _sought('machine_x', 'm', 0.02),
    _sought('machine_y', 'm', 0.02),
    _sought('machine_angle_deg', 'degrees', 2.0),
    _sought('tip_right', 'm', 0.01),
    _sought('tip_up', 'm', 0.01),
    _sought('speed_scale', '', 0.1),
    _sought('speed_bias', 'm/s', 0.1),
    _sought('elevation_scale', '', 0.05),
    _sought('elevation_bias_deg', 'degrees', 2.0),
)
"""Numbers of the alignment, and deviations of likely values."""

NEEDED = 'machine_x', 'machine_y', 'machine_angle_deg', 'speed_scale'
"""Numbers without which a machine cannot play."""

STEPS, ROUNDS = 3, 4
"""Most steps of a fit, and how often the variances of the errors are estimated."""

BEFORE = 4.0
"""Number of errors for which the errors count that the scene states before."""

LEAST_ERRORS = np.array([1e-3, 1e-3, 1e-4, 1e-4, 1e-3])
"""Smallest deviations of errors that a scene states: a, b (ball radii), rad, rad, m/s."""

LIKELY = 0.995
"""Part of the strikes whose errors are as likely as those that count."""

LEAST_STRIKES = 10
"""Number of strikes that tell the numbers of a machine."""

MEDIAN = 1.177
"""Median distance of places whose x and y have the deviation 1 (Rayleigh)."""

NORMAL = 3.354
"""
Factor by which samples count more, if their errors are normal and the scale is their deviation.

Robust weights alone say too little: their mean is 0.298 = 1 / 3.354 of what these samples tell.
"""

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


class RobotErrors(NamedTuple):
    """
    How strikes err.

    Attributes
    ----------
    variances : (5,) float array
        Of a, b (ball radii), elevation, azimuth [rad] and speed [m/s].
    known : (5,) float array
        For how many errors that are exactly known the strikes stand.

    """

    variances: Floats
    known: Floats

    def command(self, radius: float) -> StrokeErrors:
        """Return a measured stroke with these errors."""
        noise = Noise(*(launch.units(radius) * np.sqrt(self.variances)).tolist())
        return StrokeErrors(noise, measured=True)


def fitted_machine(
    model: launch.CalibrationModel, recorded: Sequence[Samples]
) -> tuple[JointFit, RobotErrors]:
    """
    Find the numbers that strikes decide, and the robot's errors.

    Strikes that do not fit the others are left out, one after the other. ValueError if the scene
    explains too few of them.
    """
    radius = model.scene.ball.radius
    before = np.maximum(model.scene.noise.sigmas(radius), LEAST_ERRORS) ** 2
    errors = RobotErrors(WIDE**2, np.zeros(launch.PLACES))
    problem = FitProblem(model, SOUGHT, FIRST_HORIZON, map, careful=True)
    launches, draw = [], np.random.default_rng(0)  # nothing is drawn around commanded strokes
    for strike in recorded:
        samples = replace(strike.until(HORIZON), command=errors.command(radius))
        best = launch.search_launches(model, samples, launch.FIRST_SCALES, FIRST_HORIZON, draw)
        if len(best.costs):
            launches.append(until_bent(model, [], Launch(samples, best.launches[0])))
    shares = {each.samples.key: each.samples.share for each in launches}
    found = fit(followed(problem, problem.start, launches, launch.FIRST_SCALES), STEPS)
    for number in range(ROUNDS):
        if number == ROUNDS - 2:
            found = decided(found, 1, needed=[f'{ALIGNMENT}.{name}' for name in NEEDED])
        medians = np.array([np.median(each.errors) for each in found.shots])
        sigma = max(float(np.median(medians)) / MEDIAN, LEAST_SIGMA)
        if number:
            launches = _fitting(found, medians < WORST * MEDIAN * sigma)
        else:  # strokes are nearly those of the alignment: each fit begins there
            there = found.problem.model_at(found.values)
            nothing = [Launch(each.samples, 0.0 * each.numbers) for each in launches]
            launches = [until_bent(there, [], each) for each in nothing]
        if len(launches) < LEAST_STRIKES:
            raise ValueError(
                f'recordings must have at least {LEAST_STRIKES} strikes that the scene can '
                f'explain, got {len(launches)} of {len(recorded)}'
            )
        old, errors = errors, robot_errors(found, errors, before)
        command, launches = errors.command(radius), list(launches)
        for k, each in enumerate(launches):
            share = NORMAL * shares[each.samples.key]
            seen = replace(each.samples, command=command, sigma=sigma + 0.0 * share, share=share)
            numbers = each.numbers.copy()
            numbers[: launch.PLACES] *= np.sqrt(old.variances / errors.variances)
            launches[k] = Launch(seen, numbers, each.until)
        problem = found.problem._replace(horizon=HORIZON if number else FIRST_HORIZON)
        found = followed(problem, found.values, launches, np.full(len(launch.FIRST_SCALES), sigma))
        found = fit(found, STEPS if number == ROUNDS - 1 else 1)
    return found, robot_errors(found, errors, before)


def _fitting(found: JointFit, fits: NDArray[np.bool_]) -> list[Launch]:
    """Leave out strikes that no stroke fits, and that with the least likely errors."""
    squares = np.array([(each.numbers[: launch.PLACES] ** 2).sum() for each in found.launches])
    if squares.max() > chi2.ppf(LIKELY, launch.PLACES) and fits.sum() > LEAST_STRIKES:
        fits[squares.argmax()] = False
    return [each for each, is_fit in zip(found.launches, fits.tolist(), strict=True) if is_fit]


def robot_errors(found: JointFit, errors: RobotErrors, before: Floats) -> RobotErrors:
    """Estimate the variances of errors anew, from those of the launches and those before."""
    unsure = [
        np.diag(each.spread + each.follow @ found.covariance @ each.follow.T)[: launch.PLACES]
        for each in found.shots
    ]
    known = np.maximum((1.0 - np.array(unsure)).sum(axis=0), 0.0)
    squares = sum(each.numbers[: launch.PLACES] ** 2 for each in found.launches) * errors.variances
    return RobotErrors((squares + BEFORE * before) / (known + BEFORE), known)


def check_decided(found: JointFit) -> None:
    """Raise ValueError if a number is not decided without which a machine cannot play."""
    low, high = interval_bounds(found)
    reach = dict(zip(found.problem.sought, (0.5 * (high - low)).tolist(), strict=True))
    wide = {each.name.split('.')[1]: each for each in undecided(found)}
    if said := [
        f'{name} only to {reach[wide[name]]:.2g} {wide[name].unit}'.strip()
        for name in NEEDED
        if name in wide
    ]:
        raise ValueError(
            f'strikes must decide {", ".join(NEEDED)}, but decide {", ".join(said)}; record '
            'strikes in other directions, at other places and speeds'
        )


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
    model = replace(launch.calibration_model(scene, read), measured=measured)
    recorded = [each for each in usable if each.shot.stroke is not None]
    check_enough(len(recorded), LEAST_STRIKES, 'strikes with strokes', ignored)
    starts = [model.frame(each).vectors_to_table(each.velocity) for each in recorded]
    strokes = [each.shot.stroke for each in recorded if each.shot.stroke]
    check_conventions(np.array(starts), strokes)
    found, errors = fitted_machine(model, recorded)
    check_decided(found)
    if left := len(recorded) - len(found.shots):
        ignored.append(f'{left} strikes that do not fit the others')
    half = followed(found.problem, found.values, found.launches[::2], found.scales)
    half, held_out = fit(half, STEPS), found.launches[1::2]
    own_errors = _robot_errors(scene, errors)
    return MachineCalibration(
        found.problem.model_at(found.values).alignment,
        (*estimates_of(found, SOUGHT), *own_errors),
        with_noise(replace(scene, noise=replace(scene.noise, bias=Bias())), own_errors),
        _median_error(half.problem.model_at(half.values), held_out),
        _median_error(model, held_out),
        len(found.shots),
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


def _median_error(model: launch.CalibrationModel, strikes: Sequence[Launch]) -> float:
    """Return the median, over strikes, of the median error of strokes without errors [m]."""
    medians = []
    for each in strikes:
        samples = each.samples
        places = launch.ways_of(model, samples, launch.prior_of(samples)[0][np.newaxis])[0]
        medians.append(np.median(np.linalg.norm(places - samples.place, axis=-1)))
    return float(np.median(medians))


def _robot_errors(scene: Scene, errors: RobotErrors) -> tuple[Estimate, ...]:
    """Return the estimates of the robot's errors; those hardly told are the ones of the scene."""
    sigmas = launch.units(scene.ball.radius) * np.sqrt(errors.variances)
    sigmas = np.where(errors.known < LEAST_KNOWN, np.nan, sigmas)
    freedom, tail = np.maximum(errors.known, 1.0), 0.5 - 0.5 * LEVEL
    low, high = sigmas * np.sqrt(freedom / chi2.ppf([[1.0 - tail], [tail]], freedom))
    return tuple(noise_estimates('noise', scene.noise, sigmas, low, high))
