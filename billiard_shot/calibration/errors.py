"""
The errors of a player, from strokes that were commanded beside the same strokes as measured.

Errors are taken as normal. The intervals of their means are those of Student's t, the intervals of
their standard deviations those of chi-square, and the intervals of their correlations those of
Fisher's z (Casella and Berger, Statistical Inference, 2nd ed., sections 9.2 and 10.3; Fisher,
Metron 1 (1921)). Errors of the measurement count as errors of the player.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import t as student

from billiard_shot.calibration.estimate import Estimate
from billiard_shot.calibration.intervals import LEVEL
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.scene_file import scene_text
from billiard_shot.scene import Bias, Noise, Scene
from billiard_shot.scene.player import IN_DEGREES

UNITS = 'm', 'm', 'degrees', 'degrees', 'm/s'
"""Of the errors `IN_DEGREES`."""

LEAST_STROKES = 5
"""Number of strokes that tell the errors of a player."""


@dataclass(frozen=True, slots=True, eq=False)
class PlayerErrors:
    """
    Errors of a player.

    Attributes
    ----------
    scene : Scene
        With these errors in its section `noise`.
    estimates : tuple of Estimate
    covariance : (5, 5) float array
        Of a, b [m], elevation, azimuth [degrees] and speed [m/s]; NaN for those not measured.
    about : tuple of str
        From which data they come, and what the scene does not say.

    """

    scene: Scene
    estimates: tuple[Estimate, ...]
    covariance: Floats
    about: tuple[str, ...]

    def save(self, path: str | Path) -> None:
        """Write the scene as YAML, with a comment for each number that was sought."""
        text = scene_text(self.scene, self.estimates, self.about)
        Path(path).write_text(text, encoding='utf-8')


def errors_of(scene: Scene, errors: Floats) -> PlayerErrors:
    """
    Estimate the errors of a player from those of its strokes.

    Parameters
    ----------
    scene : Scene
    errors : (strokes, 5) float array
        Of a, b [m], elevation, azimuth [degrees] and speed [m/s], measured minus commanded. A
        column of NaN was not measured, and keeps what the scene has.

    Raises
    ------
    ValueError
        If there are too few strokes, or a scene cannot have such errors.

    """
    count = len(errors)
    if count < LEAST_STROKES:
        raise ValueError(f'strokes must be at least {LEAST_STROKES}, got {count}')
    covariance = np.cov(errors, rowvar=False)
    means, sigmas = errors.mean(axis=0), np.sqrt(np.diag(covariance))
    tail = 0.5 - 0.5 * LEVEL
    reach = student.ppf(1.0 - tail, count - 1) * sigmas / math.sqrt(count)
    low, high = np.sqrt((count - 1) / chi2.ppf([[1.0 - tail], [tail]], count - 1)) * sigmas
    estimates = (
        *estimates_of('noise.bias', scene.noise.bias, means, means - reach, means + reach),
        *estimates_of('noise', scene.noise, sigmas, low, high),
    )
    about = f'Errors of a player in {count} strokes, measured minus commanded.'
    alike = correlated(covariance, count)
    return PlayerErrors(with_noise(scene, estimates), estimates, covariance, (about, *alike))


def estimates_of(
    section: str, before: Noise | Bias, values: Floats, low: Floats, high: Floats
) -> Iterator[Estimate]:
    """Yield the estimates of a section of the scene; a value of NaN keeps the scene's number."""
    columns = (each.tolist() for each in (values, low, high))
    for name, unit, value, *bounds in zip(IN_DEGREES, UNITS, *columns, strict=True):
        old, known = float(getattr(before, name)), math.isfinite(value)
        interval = (bounds[0], bounds[1]) if known else None
        yield Estimate(f'{section}.{name}', unit, old, None, value if known else old, interval, ())


def with_noise(scene: Scene, estimates: Sequence[Estimate]) -> Scene:
    """Return the scene with estimated errors, which have names such as `noise.bias.a`."""
    own: dict[str, float] = {}
    bias: dict[str, float] = {}
    for each in estimates:
        *_, section, name = each.name.split('.')
        (bias if section == 'bias' else own)[name] = each.value
    noise = scene.noise
    return replace(scene, noise=replace(noise, **own, bias=replace(noise.bias, **bias)))


def correlated(covariance: Floats, count: int) -> Iterator[str]:
    """Yield the errors, of a number of strokes, that are surely correlated, in words."""
    sigmas = np.sqrt(np.diag(covariance))
    reach = norm.ppf(0.5 + 0.5 * LEVEL) / math.sqrt(count - 3)
    for i, k in zip(*np.triu_indices(len(IN_DEGREES), 1), strict=True):
        if sigmas[i] * sigmas[k] > 0.0:
            found = np.clip(covariance[i, k] / (sigmas[i] * sigmas[k]), 1e-12 - 1.0, 1.0 - 1e-12)
            low, high = np.tanh(np.arctanh(found) + np.array([-reach, reach]))
            if low > 0.0 or high < 0.0:
                yield (
                    f'Errors of {IN_DEGREES[i]} and {IN_DEGREES[k]} are correlated: {found:.2f}, '
                    f'95 %: {low:.2f} to {high:.2f}. The scene takes them as independent.'
                )
