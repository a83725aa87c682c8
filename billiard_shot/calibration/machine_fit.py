"""
What the strikes of a machine have in common: numbers of its alignment, and the robot's errors.

The strokes that were really played differ from those of the encoders by the alignment, in which
they are linear, and by errors of each strike, which are the robot's. The variances of these errors
are those of the best evidence (MacKay, Neural Comput. 4 (1992)), together with the errors that the
scene states before. The intervals of the numbers are those of Student's t.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from billiard_shot.calibration.intervals import LEVEL
from billiard_shot.calibration.machine_strokes import Recorded, Told
from billiard_shot.calibration.recording import Floats
from billiard_shot.cue.alignment import Alignment
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.scene import Scene


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


def stroke_in(recorded: Recorded, alignment: Alignment, scene: Scene) -> Floats:
    """Return the stroke (5,) of the tip in a strike, if the encoders differ by an alignment."""
    x, y = recorded.place.tolist()
    return stroke_on_table(alignment, recorded.stroke, (x, y), scene, recorded.measured)


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
    """Let the numbers go, one after the other, that strikes do not decide; fit the others."""
    found = common_numbers(scene, strikes, tuple(NUMBERS))
    while optional := [name for name in found.undecided if name not in NEEDED]:
        left = tuple(name for name in found.names if name != optional[0])
        found = common_numbers(scene, strikes, left)
    return found


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
        found = decided(scene, kept)
        distances = [_distance(scene, found, each) for each in kept]
        worst = int(np.argmax(distances))
        if distances[worst] < chi2.ppf(LIKELY, 5) or len(kept) <= least:
            return kept, found
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
