"""Where a machine stands at its table, and how it errs, from strikes that it recorded."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from billiard_shot.calibration.comparison import FIRST_SCALES, scales_of
from billiard_shot.calibration.errors import estimates_of, with_noise
from billiard_shot.calibration.estimate import Estimate
from billiard_shot.calibration.intervals import LEVEL
from billiard_shot.calibration.machine_fit import (
    agreeing,
    check_decided,
    Common,
    common_numbers,
    NUMBERS,
    Strike,
    stroke_in,
)
from billiard_shot.calibration.machine_strokes import fit_stroke, HORIZONS, Recorded
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.scene_file import scene_text, yaml_text
from billiard_shot.calibration.usable import (
    check_enough,
    check_places,
    read_recordings,
    Recordings,
    usable_shots,
)
from billiard_shot.cue.alignment import Alignment, EXACT
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.numerics.angles import wrapped
from billiard_shot.scene import Bias, Scene
from billiard_shot.scene.checks import write

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
    ignored : tuple of str
        Shots and strikes that were left out, with the reason.

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
        """The number of strikes, errors of predictions, and what was left out, in words."""
        return (
            f'Fitted to {self.strikes} strikes.',
            f'Error of the cue ball in the half held out: median {1e3 * self.errors:.1f} mm; '
            f'without the alignment: {1e3 * self.errors_before:.1f} mm.',
            'The reach is not sought: the cue keeps its speed around the contact, so that no '
            'strike depends on it.',
            *(f'ignored: {text}' for text in self.ignored),
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
    usable, ignored = usable_shots(read)
    check_places(scene, usable, read)
    recorded = [
        Recorded(read[each.recording].frame, each.watched, each.shot.stroke, measured)
        for each in usable
        if each.shot.stroke is not None
    ]
    check_enough(len(recorded), LEAST_STRIKES, 'strikes with strokes', ignored)
    check_conventions(recorded)
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
        if len(strikes) < LEAST_STRIKES:
            raise ValueError(
                f'recordings must have at least {LEAST_STRIKES} strikes that the scene can '
                f'explain, got {len(strikes)} of {len(recorded)}'
            )
        strikes, found = agreeing(bare, strikes, LEAST_STRIKES)
        alignment = found.alignment
    check_decided(found)
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


def check_conventions(recorded: Sequence[Recorded]) -> None:
    """Raise ValueError if strikes seem to be mirrored, swapped, or in other units; say which."""
    starts = np.array(
        [
            each.frame.to_table(each.watched.velocity) - each.frame.to_table(np.zeros(2))
            for each in recorded
        ]
    )
    headings = np.arctan2(starts[:, 1], starts[:, 0])
    azimuths = np.array([each.stroke.offsets[3] for each in recorded])

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
    speeds = [each.stroke.speed for each in recorded]
    ratio = float(np.median(np.linalg.norm(starts, axis=1) / speeds))
    slowest, fastest = LIKELY_SPEEDS
    if not slowest < ratio < fastest:
        raise ValueError(
            f'recordings: the cue balls start at {ratio:.2g} times the speed of the cue, which '
            f'must be {slowest:g} to {fastest:g}; are the units m, s and m/s?'
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
