"""
The strokes that a machine really played, as far as the tracks of the balls tell them.

Each strike has its own stroke and place of the cue ball, which are fitted to the samples of all
balls until a horizon by damped least squares, weighted as in comparison.py. A track does not tell
all numbers of a stroke. So what it tells is kept as the information that it gives, without the
wide range in which the stroke was sought.
"""

import math
from typing import NamedTuple

import numpy as np

from billiard_shot.calibration.comparison import compare, Comparison
from billiard_shot.calibration.launch import apart, LEAST_PLACE_SIGMA, MAX_EVENTS
from billiard_shot.calibration.recording import Floats, Frame
from billiard_shot.calibration.watched import START_SIGMA, Watched
from billiard_shot.cue.alignment import Alignment, EXACT
from billiard_shot.planning.strikes import strike_alone
from billiard_shot.scene import Scene
from billiard_shot.scene.player import SPEED
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.simulate import simulate_batch
from billiard_shot.table.table_states import TableStates

HORIZONS = 0.4, 0.8, 1.5
"""Times after the strike that count, one after the other [s]."""

RANGES = np.array([0.3, 0.3, math.radians(3.0), math.radians(3.0), 0.15])
"""Deviations of the sought strokes: a, b (ball radii), angles [rad], and speed, relative to it."""

PLACE, LATE = slice(5, 7), 7  # columns after those of the stroke

STEPS = np.array([5e-3, 5e-3, 5e-3, 1e-3, 5e-3, 1e-4, 1e-4, 1e-4])
"""Steps of the numbers of a strike for differences; that of the speed is relative to it."""

DAMPINGS = np.array([1e-6, 1e-2, 1.0, 100.0])
"""Relative dampings, all of which are tried in each step."""

MOST_STEPS = 8

SMOOTH, LEAST_BEND = 0.2, 2e-5
"""A sample is linear if steps ahead and back differ by less than this part, and this [m]."""

ENOUGH = 1e-4
"""A stroke is fitted if a step lowers its cost by less than this part."""

SHORTLY = 1e-3
"""Time over which velocities are taken [s]."""

FAR = 1.0
"""Distance that counts for samples of strokes that cannot be simulated [m]."""


class Recorded(NamedTuple):
    """
    A strike as it was recorded.

    Attributes
    ----------
    frame : Frame
    watched : Watched
    stroke : Stroke
        As the driver measured it.
    measured : Alignment
        That of the driver.

    """

    frame: Frame
    watched: Watched
    stroke: Stroke
    measured: Alignment = EXACT

    @property
    def place(self) -> Floats:
        """Place of the cue ball (2,) [m]."""
        return self.frame.to_table(self.watched.rest[0])

    def ways(self, scene: Scene, rows: Floats) -> Floats:
        """
        Return where the samples would lie, (n, samples, 2) [m].

        Parameters
        ----------
        scene : Scene
        rows : (n, 8) float array
            Strokes, how far the cue ball lies from its place [m], and how late the samples are
            after the strike, beside what their times say [s].

        """
        radius, watched = scene.ball.radius, self.watched
        struck = strike_alone(model_of(scene), rows[:, :5])
        played = np.isfinite(struck.velocity).all(axis=1)
        position = np.full((len(rows), len(watched.balls), 3), radius)
        position[..., :2] = self.frame.to_table(watched.rest)
        position[:, 0, :2] += rows[:, PLACE]
        position[..., :2] = apart(scene, position[..., :2])
        velocity, spin = np.zeros_like(position), np.zeros_like(position)
        velocity[played, 0] = struck.velocity[played]
        spin[played, 0] = struck.surface[played] / radius
        times = np.union1d(watched.times, watched.times + SHORTLY)
        batch = simulate_batch(
            scene,
            TableStates(watched.balls, position, velocity, spin),
            max_events=MAX_EVENTS,
            workers=1,
            until=float(times[-1]) + SHORTLY,
            at=times,
        )
        seen_at = watched.times[watched.at]
        now, later = (
            batch.position_at[:, watched.ball, np.searchsorted(times, at), :2]
            for at in (seen_at, seen_at + SHORTLY)
        )
        moved = now + (later - now) * (rows[:, LATE] / SHORTLY)[:, np.newaxis, np.newaxis]
        places = self.frame.to_recording(moved)
        places[~played] = np.nan
        return np.where(np.isfinite(places), places, watched.place + FAR)


class Told(NamedTuple):
    """
    What the tracks of a strike tell about its stroke.

    Attributes
    ----------
    row : (8,) float array
        The stroke that explains the tracks best, with place and time, see `Recorded.ways`.
    information : (5, 5) float array
        The inverse of the covariance of the stroke.
    moment : (5,) float array
        Information times the stroke that the tracks alone would tell.

    """

    row: Floats
    information: Floats
    moment: Floats


def fit_stroke(
    scene: Scene, recorded: Recorded, likely: Floats, width: float, scales: Floats, sigma: float
) -> Told:
    """
    Fit the stroke of a strike to its tracks.

    Parameters
    ----------
    scene : Scene
    recorded : Recorded
    likely : (5,) float array
        Around which the stroke is sought.
    width : float
        How widely it is sought, relative to `RANGES`.
    scales : (knots,) float array
        Of errors [m], see comparison.py.
    sigma : float
        Deviation of x and y of samples from ways that fit [m].

    """
    middle = np.append(likely, np.zeros(3))
    precision = _precision(recorded.watched, likely, width)
    steps = STEPS * np.where(np.arange(8) == SPEED, likely[SPEED], 1.0)
    row = middle
    for horizon in HORIZONS:
        compared = compare(recorded.watched, scales, horizon)
        seen = recorded._replace(watched=compared.watched)
        cost = np.inf
        for _ in range(MOST_STEPS):
            matrix, gradient = _equations(scene, seen, compared, row, steps)
            full, slope = matrix + precision, gradient + precision @ (row - middle)
            damped = full + DAMPINGS[:, np.newaxis, np.newaxis] * np.diag(np.diag(full))
            moves = np.linalg.solve(damped, slope[np.newaxis, :, np.newaxis])[..., 0]
            tried = row - np.vstack([moves, np.zeros(8)])
            away = tried - middle
            costs = compared.sums(seen.ways(scene, tried))
            costs += np.einsum('ni,ij,nj->n', away, precision, away)
            row, before, cost = tried[costs.argmin()], cost, costs.min()
            if not cost < (1.0 - ENOUGH) * before:
                break
    matrix, gradient = _equations(scene, seen, compared, row, steps, linear=True)
    # Place and time are not asked for: the information that is left if they are fitted (Schur).
    gradient[5:] += precision[5:, 5:] @ (row - middle)[5:]
    share = matrix[:5, 5:] @ np.linalg.inv(matrix[5:, 5:] + precision[5:, 5:])
    information = matrix[:5, :5] - share @ matrix[5:, :5]
    moment = information @ row[:5] - gradient[:5] + share @ gradient[5:]
    # Robust weights say too little: with errors that are normal, all samples count alike.
    errors = seen.ways(scene, row[np.newaxis]) - seen.watched.place
    more = compared.share.sum() / (sigma**2 * compared.weights(errors)[0, ::2].sum())
    return Told(row, more * information, more * moment)


def _equations(
    scene: Scene,
    seen: Recorded,
    compared: Comparison,
    row: Floats,
    steps: Floats,
    *,
    linear: bool = False,
) -> tuple[Floats, Floats]:
    """
    Return the matrix (8, 8) and the gradient (8,) of the tracks at a row (8,).

    If `linear`, samples do not count that are not linear in all numbers.
    """
    moves = np.diag(steps)
    places = seen.ways(scene, row + np.vstack([np.zeros(8), moves, -moves]))
    here, ahead, behind = places[:1], places[1:9], places[9:]
    slopes = (ahead - behind) / (2.0 * steps[:, np.newaxis, np.newaxis])
    errors, flat = here - seen.watched.place, slopes.reshape(8, -1)
    weighted = flat * compared.weights(errors)
    if linear:
        bent = np.linalg.norm(ahead + behind - 2.0 * here, axis=-1)
        straight = np.linalg.norm(ahead - behind, axis=-1)
        weighted *= np.repeat((bent < SMOOTH * straight + LEAST_BEND).all(axis=0), 2)
    return weighted @ flat.T, weighted @ errors.ravel()


def _precision(watched: Watched, likely: Floats, width: float) -> Floats:
    """Return the inverse of the covariance (8, 8) of a strike before its tracks count."""
    ranges = width * RANGES * np.where(np.arange(5) == SPEED, likely[SPEED], 1.0)
    place = max(float(watched.rest_sigma[0]), LEAST_PLACE_SIGMA)
    return np.diag(np.array([*ranges, place, place, START_SIGMA]) ** -2)
