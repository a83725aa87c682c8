"""The execution noise that a request states, and how accurate strokes with it must be."""

from collections.abc import Mapping
from typing import Any

from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.checks import read
from billiard_shot.scene.errors import InputError
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.shot.accuracy import Accuracy

# Noise of the computer pool tournaments, see `Noise`; no noise at all.
NOISES = {'tournament': Noise(), 'none': Noise(0.0, 0.0, 0.0, 0.0, 0.0)}
TRIALS = Accuracy(1e-3, checked=False)  # of the trials of finished plans
# m: while strokes are compared, trajectories may err by the displacement that the standard error
# of the azimuth causes over this distance
ORDINARY_PATH = 2.0


def accuracy_within(sigmas: Array) -> Accuracy:
    """
    Find the accuracy that the errors of a player call for.

    Parameters
    ----------
    sigmas : (5,) float array
        Standard deviations of a, b (ball radii), elevation, azimuth (rad) and speed (m/s).

    """
    tolerance = max(TRIALS.tolerance, ORDINARY_PATH * float(sigmas[AZIMUTH]))
    return TRIALS._replace(tolerance=tolerance, fast_rebounds=True)


def noise_of(scene: Scene, noise: str | Noise | Mapping[str, Any] | None) -> Noise:
    """
    Read the execution noise of a request; by default that of the scene.

    Raises
    ------
    ValueError
        If it is none of `NOISES`, or a mapping with mistakes.

    """
    if noise is None:
        return scene.noise
    if isinstance(noise, Noise):
        return noise
    if isinstance(noise, str) and noise in NOISES:
        return NOISES[noise]
    if isinstance(noise, Mapping):
        try:
            return read(Noise, noise)
        except InputError as error:
            raise InputError(error.mistakes, 'noise') from None
    raise ValueError(
        f'noise must be {", ".join(NOISES)} or a mapping of standard deviations, got {noise!r}'
    )
