"""
The scale of a player's errors, from watched shots whose intention is not known.

The player is taken to try direct shots: to send the cue ball along the middle of the directions
that pot a ball. Which direct shot it tried is not known, and some shots are none. So the direction
of the cue ball has the density of a mixture: a normal density around each direct shot of the
layout, with the deviation that the errors of the scene give, times the unknown scale; and a
uniform one. The scale is the most likely one, and its interval follows from the ratio of
likelihoods, with the best part of the uniform density for each scale (Pawitan, In All Likelihood,
section 3.4).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, norm

from billiard_shot.calibration.comparison import FIRST_SCALES
from billiard_shot.calibration.errors import estimates_of, PlayerErrors, with_noise
from billiard_shot.calibration.intervals import LEVEL
from billiard_shot.calibration.launch import contacts_of, DIRECTION, states_of
from billiard_shot.calibration.launch_search import search_launches
from billiard_shot.calibration.recording import Floats, Frame, RecordedShot, Recording
from billiard_shot.calibration.usable import (
    check_enough,
    check_places,
    read_recordings,
    Recordings,
    Usable,
    usable_shots,
)
from billiard_shot.calibration.watched import FIT_PERIOD, watch
from billiard_shot.numerics.angles import wrapped
from billiard_shot.planning.direct_shots import CentralStrikes, side_error
from billiard_shot.planning.shots import shots, strikes_of
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import A, AZIMUTH, ELEVATION, IN_DEGREES, SPEED
from billiard_shot.shot.effects import model_of
from billiard_shot.table.table_states import TableStates

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
    usable, ignored = usable_shots(read)
    check_places(scene, usable, read)
    tried = [
        found
        for number, each in enumerate(usable)
        if (found := _tried(scene, read[each.recording].frame, each, (seed, number))) is not None
    ]
    check_enough(len(tried), LEAST_SHOTS, 'shots of layouts with direct shots', ignored)
    scale, (low, high) = most_likely_scale(tried)
    before = np.array([getattr(scene.noise, name) for name in IN_DEGREES])
    estimates = tuple(
        estimates_of('noise', scene.noise, *(factor * before for factor in (scale, low, high)))
    )
    about = (
        f'Errors of a player in {len(tried)} watched shots: {scale:.3g} times those before, 95 %: '
        f'{low:.3g} to {high:.3g}. All have the same scale.'
    )
    covariance = np.diag((scale * before) ** 2)
    said = about, *(f'ignored: {text}' for text in ignored)
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


def _tried(scene: Scene, frame: Frame, each: Usable, seed: Sequence[int]) -> Tried | None:
    """Compare a shot with the direct shots of its layout; None if that is impossible."""
    went = _way(scene, frame, each.shot, np.random.default_rng(seed))
    if went is None:
        return None
    rest = frame.to_table(each.watched.rest)
    for ball, place in went.places.items():
        rest[each.watched.balls.index(ball)] = place
    names = CUE_BALL, *each.watched.balls[1:]
    position = np.append(rest, np.full((len(rest), 1), scene.ball.radius), axis=1)
    direct = shots(scene, TableStates(names, position[np.newaxis]), workers=1)
    if not len(direct):
        return None
    model, sigmas = model_of(scene), scene.noise.sigmas(scene.ball.radius)
    strikes = CentralStrikes(*(np.nan_to_num(column) for column in strikes_of(model)))
    elevations, speeds = direct.offsets[:, [ELEVATION, SPEED]].T.tolist()
    turns = [
        side_error(model.surface, strikes, *stroke)
        for stroke in zip(elevations, speeds, direct.distance.tolist(), strict=True)
    ]
    part = direct.chance + LEAST_CHANCE
    return Tried(
        wrapped(went.direction - direct.offsets[:, AZIMUTH]),
        np.hypot(sigmas[AZIMUTH], sigmas[A] * np.array(turns)),
        LEFT * each.watched.rest_sigma.max() / np.maximum(direct.distance, ROLLED),
        part / part.sum(),
    )


class Way(NamedTuple):
    """In which direction the struck ball went until it met something [rad], and from where."""

    direction: float
    places: Mapping[str, Floats]


def _way(scene: Scene, frame: Frame, shot: RecordedShot, draw: np.random.Generator) -> Way | None:
    """Search the launch of a shot, and the places (2,) [m] of the balls that move."""
    tracks = {
        name: track
        for name, track in shot.tracks.items()
        if (np.linalg.norm(track.place - track.place[0], axis=-1) > ROLLED).any()
    }
    try:
        watched = watch(replace(shot, tracks=tracks), frame.rate, FIT_PERIOD).until(HORIZON)
    except ValueError:
        return None  # it hardly moves
    found = search_launches(scene, frame, watched, FIRST_SCALES, HORIZON, draw)
    if not len(found.costs):
        return None
    launch = found.launches[0]
    starts = states_of(scene, frame, watched, launch[np.newaxis]).position[0, :, :2]
    direction = float(launch[DIRECTION]) - frame.angle
    met = contacts_of(scene, frame, watched, launch).min(initial=HORIZON)
    before = (watched.ball == 0) & (watched.times[watched.at] < met)
    if before.any():
        x, y = frame.to_table(found.places[0][before][-1]) - starts[0]
        direction = math.atan2(y, x)
    return Way(direction, dict(zip(watched.balls, starts, strict=True)))
