"""
The inverse strike: the stroke that gives the ball a wanted velocity and spin.

The azimuth only rotates velocity and spin of the ball (the cloth has no direction). It therefore
has a closed form for given offsets a and b, elevation and speed, which remain as the unknowns of a
least-squares problem (variable projection; Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973).
Velocity and spin are nearly proportional to the speed, which gives the first guess of it.
"""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.within_noise import strike_alone
from billiard_shot.records import Array
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.fields import as_floats
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED
from billiard_shot.shot.effects import model_of, StrikeModel
from billiard_shot.shot.stroke import Stroke

# Elevations of the first guesses [rad]; their offsets are those of a tip that sticks.
START_ELEVATIONS = tuple(math.radians(degrees) for degrees in (0, 5, 15, 30, 45, 60, 75))
GUESSES = 3  # first guesses that are refined
# If no guess leads to an exact solution: number of quasi-random starts, and how many of them are
# refined briefly and thoroughly.
STARTS, PURSUED, FINISHED = 1024, 48, 8
BRIEF, THOROUGH = 12, 40  # evaluations of a refinement
START_SPACING = 0.1  # radii and rad, between starts
RIM = 0.75  # largest a and b: farther out every tip slips
# Of a and b (ball radii), elevation (rad), and speed, relative to the size of the wanted motion.
BOUNDS = (-RIM, -RIM, 0.0, 1e-3), (RIM, RIM, 0.5 * math.pi, 1e3)
EXACT = 1e-8  # relative to the wanted motion: a residual that ends the search
TOLERANCE = 1e-6  # m, of the strikes: the difference quotients need more than the usual one
QUOTIENT_STEP = 1e-6  # of the difference quotients, in the units of `BOUNDS`


class Inverse(NamedTuple):
    """A stroke, and the residual of its velocity and spin."""

    stroke: Stroke
    residual: float  # m/s: norm of the errors in velocity and in spin times radius


def invert_strike(
    scene: SceneLike,
    velocity: Sequence[float] | Array,
    spin: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> Inverse:
    """
    Find the stroke whose velocity and spin of the cue ball are nearest to the wanted ones.

    Only the strike is considered: cushions and balls in the way of the cue are ignored.

    Parameters
    ----------
    scene : Scene, str or Path
    velocity : (3,) array_like
        Of the ball's centre at the end of the strike [m/s], frame `table`; not zero.
    spin : (3,) array_like
        [rad/s], frame `table`.

    Returns
    -------
    stroke : Stroke
    residual : float
        Norm of (dv, r dw) [m/s], where r is the radius of the ball. A stroke has five parameters
        and six numbers are wanted, so that most requests leave a residual.

    Raises
    ------
    ValueError
        If a number is not finite, if the velocity is zero, or if no stroke comes nearer to the
        wanted motion than a ball at rest, for example if the ball should move straight down.

    """
    scene = Scene.load(scene)
    problem = _Problem(scene, model_of(scene), _wanted(scene, velocity, spin))
    residual, found = problem.solve()
    if residual >= problem.size:
        raise ValueError(
            f'velocity must be one to which, with the spin {spin!r}, a stroke comes nearer than '
            f'a ball at rest, got {velocity!r} (m/s)'
        )
    numbers = problem.strokes(found[np.newaxis])[0]
    numbers[AZIMUTH] = problem.project(found[np.newaxis])[1][0]
    return Inverse(Stroke.from_offsets(*numbers.tolist()), residual)


class _Problem(NamedTuple):
    """The least squares problem, whose unknowns are in the order and units of `BOUNDS`."""

    scene: Scene
    model: StrikeModel
    wanted: Array  # (6,) m/s

    @property
    def size(self) -> float:
        """Of the wanted motion [m/s]."""
        return float(np.linalg.norm(self.wanted))

    def strokes(self, unknowns: Array) -> Array:
        """Strokes (n, 5) with azimuth 0."""
        strokes = np.zeros((len(unknowns), 5))
        strokes[:, [A, B, ELEVATION, SPEED]] = unknowns
        strokes[:, SPEED] *= self.size
        return strokes

    def project(self, unknowns: Array) -> tuple[Array, Array, Array]:
        """Errors (n, 6), best azimuths (n,) and best factors (n,) of the motion for n rows."""
        struck = strike_alone(self.model, self.strokes(unknowns), TOLERANCE)
        motion = np.concatenate(struck[:2], axis=1)
        level = motion[:, [0, 3]] + 1j * motion[:, [1, 4]]
        aim = self.wanted[[0, 3]] + 1j * self.wanted[[1, 4]]
        turn = (level.conj() * aim).sum(axis=1)
        azimuth = np.angle(turn)
        upright = motion[:, [2, 5]] @ self.wanted[[2, 5]]
        factor = (np.abs(turn) + upright) / (motion**2).sum(axis=1)
        turned = level * np.exp(1j * azimuth)[:, np.newaxis]
        errors = motion - self.wanted
        errors[:, [0, 3]] = turned.real - self.wanted[[0, 3]]
        errors[:, [1, 4]] = turned.imag - self.wanted[[1, 4]]
        errors[np.isnan(errors).any(axis=1)] = 10.0 * np.abs(self.wanted).max()
        return errors, azimuth, factor

    def moves_towards(self, offsets: Array) -> bool:
        """
        Whether a stroke of offsets and elevations (n, 3) moves the ball towards the wanted motion.

        If none does so, rest is the motion that is nearest to the wanted one. Straight down, the
        cloth stops every ball.
        """
        strokes = np.column_stack([offsets, np.ones(len(offsets))])
        return bool((self.project(strokes)[2] > 0.0).any())

    def with_speeds(self, offsets: Array) -> Array:
        """Add the best speeds to offsets and elevations (n, 3), as far as it scales the motion."""
        unknowns = np.column_stack([offsets, np.ones(len(offsets))])
        factor = np.nan_to_num(self.project(unknowns)[2])
        unknowns[:, 3] = np.clip(factor, 2.0 * BOUNDS[0][3], 0.5 * BOUNDS[1][3])
        return unknowns

    def best_of(self, offsets: Array, count: int) -> Array:
        """Select starts (count, 4) from offsets and elevations (n, 3), apart from each other."""
        starts = self.with_speeds(offsets)
        sizes = np.linalg.norm(self.project(starts)[0], axis=1)
        chosen: list[Array] = []
        for start in starts[np.argsort(sizes, kind='stable')]:
            if all(np.abs(start - other)[:3].max() > START_SPACING for other in chosen):
                chosen.append(start)
            if len(chosen) == count:
                break
        return np.array(chosen)

    def errors(self, x: Array) -> Array:
        """Errors (6,) at one point."""
        return self.project(x[np.newaxis])[0][0]

    def slopes(self, x: Array) -> Array:
        """Approximate the derivatives (6, 4) by differences towards the middle of the bounds."""
        step = np.where(x < 0.5 * np.add(*BOUNDS), QUOTIENT_STEP, -QUOTIENT_STEP)
        errors = self.project(np.concatenate([x[np.newaxis], x + np.diag(step)]))[0]
        rise: Array = (errors[1:] - errors[0]).T / step
        return rise

    def refine(self, starts: Array, evaluations: int) -> list[tuple[float, Array]]:
        """Refine each start until one is exact; return sorted residuals and solutions."""
        from scipy.optimize import least_squares

        found: list[tuple[float, Array]] = []
        for start in starts:
            solved = least_squares(
                self.errors,
                start,
                self.slopes,
                BOUNDS,
                method='dogbox',
                xtol=1e-12,
                ftol=1e-9,
                gtol=1e-15,
                max_nfev=evaluations,
            )
            found.append((math.sqrt(2.0 * solved.cost), solved.x))
            if self.exact(found[-1][0]):
                break
        return sorted(found, key=lambda each: each[0])

    def exact(self, residual: float) -> bool:
        """Whether a residual is mere rounding."""
        return residual <= EXACT * self.size

    def solve(self) -> tuple[float, Array]:
        """
        Find the smallest residual and its solution, from guesses or quasi-random starts.

        The residual is infinite if neither moves the ball towards the wanted motion.
        """
        guesses = _guesses(self.scene, self.wanted)
        if not (self.moves_towards(guesses) or self.moves_towards(_starts())):
            return math.inf, guesses[0]
        found = self.refine(self.best_of(guesses, GUESSES), THOROUGH)
        if not self.exact(found[0][0]):
            nearer = self.refine(self.best_of(_starts(), PURSUED), BRIEF)
            ends = np.array([x for _, x in nearer[:FINISHED]])
            found = sorted(found + self.refine(ends, THOROUGH), key=lambda each: each[0])
        return found[0]


def _starts() -> Array:
    """Quasi-random offsets and elevations (STARTS, 3)."""
    draws = quasi_random(STARTS, 3)
    radius, angle = RIM * np.sqrt(draws[:, 0]), 2.0 * np.pi * draws[:, 1]
    return np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), 0.49 * np.pi * draws[:, 2]]
    )


def _guesses(scene: Scene, wanted: Array) -> Array:
    """
    Offsets and elevations (n, 3) if the tip sticks, pushes along the cue, and there is no cloth.

    The impulse J gives m v = J c and I w = r n x J c. The offset is the part of I w / (r J) that
    is normal to c.
    """
    ball = scene.ball
    along = math.hypot(wanted[0], wanted[1])
    heading = math.atan2(wanted[1], wanted[0])
    arm = ball.inertia / (ball.mass * ball.radius**2)
    guesses = [(0.0, 0.0, math.atan2(max(-wanted[2], 0.0), along))]
    for elevation in START_ELEVATIONS:
        level = np.array([math.cos(heading), math.sin(heading), 0.0])
        right = np.array([math.sin(heading), -math.cos(heading), 0.0])
        c = math.cos(elevation) * level - math.sin(elevation) * np.array([0.0, 0.0, 1.0])
        up = np.cross(right, c)
        push = max(along / math.cos(elevation), 1e-9)
        offset = arm / push * np.cross(c, wanted[3:])
        a, b = float(offset @ right), float(offset @ up)
        size = max(1.0, math.hypot(a, b) / 0.6)  # farther out tips slide
        guesses.append((a / size, b / size, elevation))
    return np.array(guesses)


def _wanted(scene: Scene, velocity: ArrayLike, spin: ArrayLike) -> Array:
    """Velocity and spin times radius (6,) [m/s], checked."""
    parts = []
    for name, values, unit in (('velocity', velocity, 'm/s'), ('spin', spin, 'rad/s')):
        part = as_floats(values)
        if part.shape != (3,) or not np.isfinite(part).all():
            raise refused(values, 'three finite numbers', name, unit)
        parts.append(part)
    if not parts[0].any():
        raise ValueError(f'velocity must not be zero, got {velocity!r} (m/s)')
    return np.concatenate([parts[0], scene.ball.radius * parts[1]])
