"""
The errors of a player, from measured strokes or from watched shots.

Errors of strokes that were commanded beside the same strokes as measured are taken as normal. The
intervals of their means are those of Student's t, the intervals of their standard deviations those
of chi-square, and the intervals of their correlations those of Fisher's z (Casella and Berger,
Statistical Inference, 2nd ed., sections 9.2 and 10.3; Fisher, Metron 1 (1921)). Errors of the
measurement count as errors of the player.

Watched shots tell the scale of the errors although their intention is not known. The player is
taken to try direct shots: to send the cue ball along the middle of the directions that pot a ball.
Which direct shot it tried is not known, and some shots are none. So the direction of the cue ball
has the density of a mixture: a normal density around each direct shot of the layout, with the
deviation that the errors of the scene give, times the unknown scale; and a uniform one. The scale
is the most likely one, and its interval follows from the ratio of likelihoods, with the best part
of the uniform density for each scale (Pawitan, In All Likelihood, section 3.4).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import t as student

from billiard_shot.calibration.fit import LEVEL
from billiard_shot.calibration.launch import (
    calibration_model,
    CalibrationModel,
    DIRECTION,
    states_of,
)
from billiard_shot.calibration.reader import read_recordings, Recordings
from billiard_shot.calibration.recording import (
    check_enough,
    FIT_PERIOD,
    Floats,
    Recording,
    Samples,
    samples_of,
    usable_shots,
)
from billiard_shot.calibration.result import Estimate, searched_check, write_yaml
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.planning.direct_shots import CentralStrikes, side_error
from billiard_shot.planning.shots import shots, strikes_of
from billiard_shot.scene import Bias, Noise, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import A, AZIMUTH, ELEVATION, IN_DEGREES, SPEED
from billiard_shot.shot.effects import model_of as strike_model_of
from billiard_shot.table.run.states import TableStates

UNITS = 'm', 'm', 'degrees', 'degrees', 'm/s'
"""Of the errors `IN_DEGREES`."""

LEAST_STROKES = 5
"""Number of strokes that tell the errors of a player."""


ROLLED = 0.03
"""A ball that stays nearer to its first place is not simulated [m]."""

LEAST_SHOTS = 20
"""Number of watched shots that tell a scale."""

HORIZON = 1.5
"""Time after the strike that tells where the cue ball went [s]."""

LEAST_CHANCE = 0.05
"""Added to the chance of a direct shot, the sum is in proportion to how often it is tried."""

LEFT = 0.4
"""
Part of the deviation of places at rest that remains, across the way, once a shot is fitted.

It was measured with strokes without errors.
"""

SCALES = np.geomspace(0.05, 20.0, 400)
"""Scales that are compared."""

UNIFORM = np.linspace(0.02, 0.98, 25)
"""Parts of the uniform density that are compared."""


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
        write_yaml(path, self.scene.to_dict(), self.estimates, self.about)


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
        *noise_estimates('noise.bias', scene.noise.bias, means, means - reach, means + reach),
        *noise_estimates('noise', scene.noise, sigmas, low, high),
    )
    about = f'Errors of a player in {count} strokes, measured minus commanded.'
    alike = correlated(covariance, count)
    return PlayerErrors(with_noise(scene, estimates), estimates, covariance, (about, *alike))


def noise_estimates(
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


class Tried(NamedTuple):
    """
    How a watched shot may have been meant: a number for each direct shot of its layout.

    Attributes
    ----------
    away : (n,) float array
        How far the cue ball went beside it, to the left [rad].
    sigma : (n,) float array
        Deviation to expect from the errors of the scene [rad].
    unsure : (n,) float array
        Deviation to expect from the places, which are not known exactly [rad].
    part : (n,) float array
        How likely it was to be tried; the sum is 1.

    """

    away: Floats
    sigma: Floats
    unsure: Floats
    part: Floats


def scale_of_errors(scene: Scene, recordings: Recordings, seed: int = 1) -> PlayerErrors:
    """
    Estimate the scale of a player's errors from watched shots.

    Parameters
    ----------
    scene : Scene
        With pockets. Its section `noise` has the errors whose scale is sought.
    recordings : Recording, str, Path, or sequence of these
    seed : int
        Of the searches of launches.

    Raises
    ------
    ValueError
        If a file makes no sense, too few shots can be used, or the shots do not tell a scale.

    """
    read = [_of_the_cue_ball(each) for each in read_recordings(recordings)]
    usable, ignored, tracking = usable_shots(scene, read)
    model = replace(calibration_model(scene, read), scene=scene)
    tried = [
        found
        for number, each in enumerate(usable)
        if (found := _tried(model, each, (seed, number))) is not None
    ]
    check_enough(len(tried), LEAST_SHOTS, 'shots of layouts with direct shots', ignored)
    scale, (low, high) = most_likely_scale(tried)
    before = np.array([getattr(scene.noise, name) for name in IN_DEGREES])
    estimates = tuple(
        noise_estimates('noise', scene.noise, *(factor * before for factor in (scale, low, high)))
    )
    about = (
        f'Errors of a player in {len(tried)} watched shots: {scale:.3g} times those before, 95 %: '
        f'{low:.3g} to {high:.3g}. All have the same scale.'
    )
    covariance = np.diag((scale * before) ** 2)
    said = about, *tracking, *(f'ignored: {text}' for text in ignored)
    return PlayerErrors(with_noise(scene, estimates), estimates, covariance, said)


def _of_the_cue_ball(recording: Recording) -> Recording:
    """Let the cue hit the cue ball in all shots of which the recording does not say more."""
    shots = (replace(shot, struck=shot.struck or CUE_BALL) for shot in recording.shots)
    return replace(recording, shots=tuple(shots))


def most_likely_scale(tried: Sequence[Tried]) -> tuple[float, tuple[float, float]]:
    """Return the scale of the errors and its interval; ValueError if the shots tell none."""
    parts, likely = UNIFORM[:, np.newaxis], np.zeros((len(UNIFORM), len(SCALES)))
    for each in tried:
        sigmas = np.hypot(each.sigma[:, np.newaxis] * SCALES, each.unsure[:, np.newaxis])
        density = each.part @ (norm.pdf(each.away[:, np.newaxis] / sigmas) / sigmas)
        likely += np.log(parts / math.tau + (1.0 - parts) * density)
    profile = likely.max(axis=0)
    inside = np.flatnonzero(profile > profile.max() - 0.5 * chi2.ppf(LEVEL, 1))
    if inside[0] == 0 or inside[-1] == len(SCALES) - 1:
        raise ValueError(
            f'recordings must have shots that tell a scale from {SCALES[0]:g} to {SCALES[-1]:g}, '
            'got shots that are not near direct shots'
        )
    low, high = SCALES[inside[[0, -1]]].tolist()
    return float(SCALES[profile.argmax()]), (low, high)


def _tried(model: CalibrationModel, samples: Samples, seed: Sequence[int]) -> Tried | None:
    """Compare a shot with the direct shots of its layout; None if that is impossible."""
    scene = model.scene
    went = _way(model, samples, seed)
    if went is None:
        return None
    direction, places = went
    rest = model.frame(samples).to_table(samples.rest)
    for ball, place in places.items():
        rest[samples.balls.index(ball)] = place
    names = CUE_BALL, *samples.balls[1:]
    position = np.append(rest, np.full((len(rest), 1), scene.ball.radius), axis=1)
    direct = shots(scene, TableStates(names, position[np.newaxis]), workers=1)
    if not len(direct):
        return None
    strikes, sigmas = strike_model_of(scene), scene.noise.sigmas(scene.ball.radius)
    central = CentralStrikes(*(np.nan_to_num(column) for column in strikes_of(strikes)))
    elevations, speeds = direct.offsets[:, [ELEVATION, SPEED]].T.tolist()
    turns = [
        side_error(strikes.surface, central, *stroke)
        for stroke in zip(elevations, speeds, direct.distance.tolist(), strict=True)
    ]
    part = direct.chance + LEAST_CHANCE
    return Tried(
        wrapped(direction - direct.offsets[:, AZIMUTH]),
        np.hypot(sigmas[AZIMUTH], sigmas[A] * np.array(turns)),
        LEFT * samples.rest_sigma.max() / np.maximum(direct.distance, ROLLED),
        part / part.sum(),
    )


def _way(
    model: CalibrationModel, samples: Samples, seed: Sequence[int]
) -> tuple[float, dict[str, Floats]] | None:
    """
    Return in which direction the struck ball went until it met something [rad].

    Returns also from where the balls that move started, (2,) [m]. None if that is not known.
    """
    tracks = {
        name: track
        for name, track in samples.shot.tracks.items()
        if (np.linalg.norm(track.place - track.place[0], axis=-1) > ROLLED).any()
    }
    frame, moving = model.frame(samples), replace(samples.shot, tracks=tracks)
    try:
        seen = samples_of(moving, frame.rate, FIT_PERIOD, samples.recording).until(HORIZON)
    except ValueError:
        return None  # it hardly moves
    found = searched_check(model, HORIZON, (seen, seed))
    if found is None:
        return None
    starts = states_of(model, seen, found.launch[np.newaxis]).position[0, :, :2]
    direction = float(found.launch[DIRECTION]) - frame.angle
    before = (found.samples.ball == 0) & (found.times < found.contacts.min(initial=HORIZON))
    if before.any():
        x, y = frame.to_table(found.places[before][-1]) - starts[0]
        direction = math.atan2(y, x)
    return direction, dict(zip(seen.balls, starts, strict=True))
