"""The execution noise that a request states: by a name, or by its standard deviations."""

from collections.abc import Mapping
from typing import Any

from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.checks import read
from billiard_shot.scene.errors import InputError

# Noise of the computer pool tournaments, see `Noise`; no noise at all.
NOISES = {'tournament': Noise(), 'none': Noise(0.0, 0.0, 0.0, 0.0, 0.0)}


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
