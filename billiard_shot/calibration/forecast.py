"""
The path to expect of a shot of which only the beginning was seen.

The first samples do not tell the spin that the cue gave, and the launch that explains them best
may have any spin. So launches are drawn as likely as they are, and the one in the middle is taken:
its path has the least mean distance from those of the others, relative to usual errors.

Spins are drawn as other strokes of the player had them, and mirrored ones: from the density of
Silverman (Density Estimation, 1986, section 4.3). Each draw is the mean of a launch before its
samples count, and is then fitted to them (Oliver, He and Reynolds, Conditioning permeability
fields to pressure data, 5th European Conf. on the Mathematics of Oil Recovery (1996)).
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from billiard_shot.calibration.comparison import compare, FIRST_SCALES, KNOTS
from billiard_shot.calibration.joint_fit import Shot
from billiard_shot.calibration.launch import FOLLOW, MASSE, PLACES, SPEED, ways_of
from billiard_shot.calibration.recording import Floats, Frame
from billiard_shot.calibration.refine import refined
from billiard_shot.calibration.watched import Watched
from billiard_shot.scene import Scene

SHORT = 0.5
"""If no more than this was seen [s], the errors of samples are those of the tracker."""

DRAWS = 100
"""How many launches are drawn."""

STEPS = 8
"""Steps of least squares for each of them."""

UNLIKELY = 8.0
"""A draw whose cost exceeds the least one by more has not found the samples."""

SPINS = slice(FOLLOW, MASSE + 1)
MIRRORED = np.array([1.0, -1.0, -1.0])


def spins_of(shots: Iterable[Shot]) -> Floats:
    """Return follow, side and masse (n, 3) relative to the speed, if no stroke was commanded."""
    free = [each.launch[:PLACES] for each in shots if each.watched.command is None]
    launches = np.reshape(free, (-1, PLACES))
    spins: Floats = launches[:, SPINS] / launches[:, SPEED, np.newaxis]
    return spins


def middle_launch(
    scene: Scene,
    frame: Frame,
    watched: Watched,
    seen: float,
    spins: Floats,
    draw: np.random.Generator,
) -> Floats | None:
    """
    Return the launch whose path is to be expected; None if none can be simulated.

    Parameters
    ----------
    scene : Scene
    frame : Frame
    watched : Watched
        Of samples after `seen`, only the times count.
    seen : float
        Until which samples count [s].
    spins : (n, 3) float array
        Of other strokes, see `spins_of`.
    draw : numpy.random.Generator

    """
    compared = compare(watched, FIRST_SCALES, seen)
    speed = compared.mean[SPEED]
    width = spins.std(axis=0) * len(spins) ** (-1.0 / (spins.shape[1] + 4.0))
    width = speed * np.maximum(width, 1e-3)
    means = np.repeat(compared.mean[np.newaxis], DRAWS, axis=0)
    precision = compared.precision.copy()
    mirrored = np.where(draw.random((DRAWS, 1)) < 0.5, 1.0, MIRRORED)
    means[:, SPINS] = speed * mirrored * spins[draw.integers(len(spins), size=DRAWS)]
    means[:, SPINS] += width * draw.normal(size=(DRAWS, len(width)))
    precision[SPINS, SPINS] = np.diag(width**-2.0)
    likely = replace(
        compared,
        mean=means,
        precision=precision,
        square=compared.watched.sigma**2,
        share=np.ones_like(compared.share),
    )
    found = refined(scene, frame, likely, means, STEPS)
    possible = np.isfinite(found.costs)
    if not possible.any():
        return None
    launches = found.launches[found.costs < found.costs[possible].min() + UNLIKELY]
    places = ways_of(scene, frame, watched, launches)
    simulated = np.isfinite(places).all(axis=(1, 2))
    if not simulated.any():
        return None
    launches, places = launches[simulated], places[simulated]
    usual = np.interp(watched.times[watched.at], KNOTS, FIRST_SCALES)
    apart = [np.linalg.norm(places - each, axis=-1) @ (watched.share / usual) for each in places]
    best: Floats = launches[np.sum(apart, axis=0).argmin()]
    return best
