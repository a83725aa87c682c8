"""
Comparison of impact laws: influence of uncertain parameters, and discontinuities.

At a discontinuity, an arbitrarily small change of a parameter changes the outcome by a finite
amount.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.study.classical_laws import newton, NoEndError, pairwise
from billiard_shot.study.problem import ContactProblem
from billiard_shot.study.resting_place import resting_place

LAWS_TOLERANCE = 1e-11
CLOSEST = 1e-11  # relative width to which a discontinuity is bracketed
BEND_RATIO = 3.0  # an interval that bends this many times as much as those around is examined
SMALLEST = 1e-6  # discontinuity that is reported, relative to the cue speed
COMPARED_LAWS = ('bistiffness', 'energetic')
WAYS = (*COMPARED_LAWS, 'pairwise', 'newton')
StrokeOutcome = Callable[[float], Array]


@dataclass(frozen=True, slots=True)
class Discontinuity:
    """Place and size (largest component, relative to the cue speed) of a discontinuity."""

    place: float
    size: float


@dataclass(frozen=True, slots=True)
class ParameterSweep:
    """A stroke in a scene, of which one parameter is varied."""

    name: str
    values: Array
    at: Callable[[float], tuple[Scene, Stroke]]

    def problem(self, value: float, law: str) -> ContactProblem:
        """State the stroke at a value."""
        scene, stroke = self.at(value)
        return ContactProblem.of(replace(scene, law=law), stroke)

    def solved(self, value: float, way: str) -> tuple[ContactProblem, Array]:
        """State the stroke at a value, and find its impulses (6,) [N s] by law or way."""
        if way in COMPARED_LAWS:
            problem = self.problem(value, way)
            return problem, problem.adaptive(LAWS_TOLERANCE)[0]
        problem = self.problem(value, 'bistiffness')  # the laws agree for one contact alone
        return problem, pairwise(problem) if way == 'pairwise' else newton(problem)

    def outcome(self, way: str) -> StrokeOutcome:
        """Return a function from the value to the motion (7,) of ball and cue after the strike."""

        def motion(value: float) -> Array:
            problem, impulses = self.solved(value, way)
            velocity, spin, cue = problem.motion(impulses)
            parts = (velocity, problem.model.surface.radius * spin, [cue])
            return np.concatenate(parts) / problem.stroke.speed

        return motion

    def distances(self, way: str) -> Array:
        """Distances from the ball's start to its place of rest, at all values [m]; or NaN."""
        found = []
        for value in self.values.tolist():
            try:
                problem, impulses = self.solved(value, way)
                velocity, spin, _ = problem.motion(impulses)
                rest = resting_place(problem.scene, velocity, spin)
                found.append(math.hypot(rest[0], rest[1]))
            except NoEndError:
                found.append(math.nan)
        return np.array(found)


def sweeps(scene: Scene, stroke: Stroke, count: int = 201) -> Iterator[ParameterSweep]:
    """Sweeps through a stroke: stiffness ratio, offsets a and b, elevation, speed."""
    a, b, elevation, azimuth, speed = stroke.offsets

    def with_ratio(ratio: float) -> tuple[Scene, Stroke]:
        table = replace(scene.contacts.ball_table, stiffness=1.0, duration=None)
        tip = replace(scene.contacts.cue_ball, stiffness=ratio, duration=None)
        return replace(
            scene, contacts=replace(scene.contacts, cue_ball=tip, ball_table=table)
        ), stroke

    def varied(index: int, unit: float = 1.0) -> Callable[[float], tuple[Scene, Stroke]]:
        def at(value: float) -> tuple[Scene, Stroke]:
            offsets = [a, b, elevation, azimuth, speed]
            offsets[index] = unit * value
            return scene, Stroke.from_offsets(*offsets)

        return at

    limits = 0.95 * math.sqrt(max(1.0 - b * b, 0.0)), 0.95 * math.sqrt(max(1.0 - a * a, 0.0))
    yield ParameterSweep('stiffness ratio', np.geomspace(0.1, 10.0, count), with_ratio)
    yield ParameterSweep('offset a (radii)', np.linspace(-limits[0], limits[0], count), varied(0))
    yield ParameterSweep('offset b (radii)', np.linspace(-limits[1], limits[1], count), varied(1))
    degree = math.radians(1.0)
    yield ParameterSweep('elevation (degrees)', np.linspace(0.0, 86.0, count), varied(2, degree))
    yield ParameterSweep('speed (m/s)', np.geomspace(0.05, 10.0, count), varied(4))


def discontinuities(
    outcome: StrokeOutcome, values: Sequence[float] | Array
) -> list[Discontinuity]:
    """
    Find the discontinuities of an outcome over sorted values, each bracketed to rounding.

    An interval is examined if its change differs from the mean of its neighbours' by more than is
    usual around it. At most one discontinuity is found in each interval.
    """
    x = np.asarray(values, float)
    results = np.array([outcome(value) for value in x.tolist()])
    slopes = np.diff(results, axis=0) / np.diff(x)[:, np.newaxis]
    padded = np.concatenate([slopes[1:2], slopes, slopes[-2:-1]])
    usual = 0.5 * (padded[:-2] + padded[2:])
    bends = np.abs(slopes - usual).max(axis=1) * np.diff(x)
    found = []
    for i, bend in enumerate(bends):
        around = np.concatenate([bends[max(i - 4, 0) : max(i - 1, 0)], bends[i + 2 : i + 5]])
        if bend > BEND_RATIO * np.median(around) + SMALLEST:
            discontinuity = _bracketed(outcome, float(x[i]), float(x[i + 1]), usual[i])
            found += [discontinuity] if discontinuity.size > SMALLEST else []
    return found


def _bracketed(outcome: StrokeOutcome, low: float, high: float, slope: Array) -> Discontinuity:
    """Halve an interval, keeping the half whose change is further from the usual slope's."""
    p, q = outcome(low), outcome(high)
    while high - low > CLOSEST * max(abs(low), abs(high)):
        middle = 0.5 * (low + high)
        m = outcome(middle)
        step = slope * (middle - low)
        if np.abs(m - p - step).max() > np.abs(q - m - step).max():
            high, q = middle, m
        else:
            low, p = middle, m
    return Discontinuity(0.5 * (low + high), float(np.abs(q - p).max()))


def wedges(problem: ContactProblem) -> bool:
    """
    Whether the tip can wedge: W_nn < mu |W_nt| (Painleve 1895).

    The friction of a sliding tip then presses it against the ball more than the spring parts them.
    """
    w, mu = problem.response, float(problem.friction[0])
    return bool(w[0, 0] < mu * math.hypot(w[0, 1], w[0, 2]))


def random_strokes(count: int, seed: int) -> list[Stroke]:
    """Strokes of all kinds, to look for discontinuities around them."""
    rng = np.random.default_rng(seed)
    return [
        Stroke.from_offsets(a, b, elevation, 0.0, 2.0)
        for a, b, elevation in rng.uniform((-0.6, -0.6, 0.0), (0.6, 0.6, 1.4), (count, 3))
    ]
