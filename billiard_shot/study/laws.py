"""
The laws of impact compared: how the outcome depends on what is known badly, and where it jumps.

A jump is a parameter at which the outcome changes by a finite amount, however close one looks.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.study.alternatives import newton, NoEndError, pairwise
from billiard_shot.study.problem import Problem, Vector
from billiard_shot.study.rest import place_of_rest

TOLERANCE = 1e-11
CLOSEST = 1e-11  # relative width to which a jump is bracketed
STEEP = 3.0  # times as much change as in the neighbouring intervals: looked at closely
SMALLEST = 1e-6  # jump, in parts of the cue's speed
LAWS = ('bistiffness', 'energetic')
WAYS = (*LAWS, 'pairwise', 'newton')
Outcome = Callable[[float], Vector]


@dataclass(frozen=True, slots=True)
class Jump:
    """Where an outcome jumps, and by how much (largest component, parts of the cue's speed)."""

    place: float
    size: float


@dataclass(frozen=True, slots=True)
class Line:
    """A stroke in a scene, and one number of it that is varied."""

    name: str
    values: Vector
    at: Callable[[float], tuple[Scene, Stroke]]

    def problem(self, value: float, law: str) -> Problem:
        """State the stroke at a value."""
        scene, stroke = self.at(value)
        return Problem.of(replace(scene, law=law), stroke)

    def outcome(self, way: str) -> Outcome:
        """Give motion of ball and cue (7,) after the strike, over the value, by law or way."""
        law = way if way in LAWS else 'bistiffness'  # one contact alone knows no difference

        def motion(value: float) -> Vector:
            problem = self.problem(value, law)
            velocity, spin, cue = problem.motion(_impulses(problem, way))
            parts = (velocity, problem.model.surface.radius * spin, [cue])
            return np.concatenate(parts) / problem.stroke.speed

        return motion

    def distances(self, way: str) -> Vector:
        """How far from its start the ball comes to rest, at all values [m]; NaN if unsolved."""
        found = []
        for value in self.values.tolist():
            problem = self.problem(value, way if way in LAWS else 'bistiffness')
            try:
                velocity, spin, _ = problem.motion(_impulses(problem, way))
                rest = place_of_rest(problem.model, velocity, spin)
                found.append(math.hypot(rest[0], rest[1]))
            except NoEndError:
                found.append(math.nan)
        return np.array(found)


def _impulses(problem: Problem, way: str) -> Vector:
    if way in LAWS:
        return problem.adaptive(TOLERANCE)[0]
    return pairwise(problem) if way == 'pairwise' else newton(problem)


def lines(scene: Scene, stroke: Stroke, count: int = 201) -> Iterator[Line]:
    """Lines through a stroke: stiffness ratio, offset to the side, height, elevation, speed."""
    a, b, elevation, azimuth, speed = stroke.offsets

    def with_ratio(ratio: float) -> tuple[Scene, Stroke]:
        table = replace(scene.contacts.ball_table, stiffness=1.0)
        tip = replace(scene.contacts.cue_ball, stiffness=ratio)
        return replace(scene, contacts=replace(
            scene.contacts, cue_ball=tip, ball_table=table)), stroke

    def varied(index: int) -> Callable[[float], tuple[Scene, Stroke]]:
        def at(value: float) -> tuple[Scene, Stroke]:
            offsets = [a, b, elevation, azimuth, speed]
            offsets[index] = value
            return scene, Stroke.from_offsets(*offsets)

        return at

    room = 0.95 * math.sqrt(max(1.0 - b * b, 0.0)), 0.95 * math.sqrt(max(1.0 - a * a, 0.0))
    yield Line('stiffness ratio', np.geomspace(0.1, 10.0, count), with_ratio)
    yield Line('offset a', np.linspace(-room[0], room[0], count), varied(0))
    yield Line('offset b', np.linspace(-room[1], room[1], count), varied(1))
    yield Line('elevation (rad)', np.linspace(0.0, 1.5, count), varied(2))
    yield Line('speed (m/s)', np.geomspace(0.05, 10.0, count), varied(4))


def jumps(outcome: Outcome, values: Sequence[float] | Vector) -> list[Jump]:
    """Find the jumps of an outcome along a line, each bracketed to rounding."""
    results = [outcome(float(value)) for value in values]
    changes = np.array([np.abs(q - p).max() for p, q in zip(results, results[1:], strict=False)])
    found = []
    for i, change in enumerate(changes):
        around = np.concatenate([changes[max(i - 3, 0):i], changes[i + 1:i + 4]])
        if change > STEEP * np.median(around) + SMALLEST:
            low, high = float(values[i]), float(values[i + 1])
            p, q = results[i], results[i + 1]
            while high - low > CLOSEST * max(abs(low), abs(high)):
                middle = 0.5 * (low + high)
                m = outcome(middle)
                if np.abs(m - p).max() > np.abs(q - m).max():
                    high, q = middle, m
                else:
                    low, p = middle, m
            size = float(np.abs(q - p).max())
            if size > SMALLEST:
                found.append(Jump(0.5 * (low + high), size))
    return found


def random_strokes(count: int, seed: int) -> list[Stroke]:
    """Strokes of all kinds, to look for jumps around them."""
    rng = np.random.default_rng(seed)
    return [Stroke.from_offsets(*rng.uniform(-0.6, 0.6, 2), rng.uniform(0.0, 1.4), 0.0, 2.0)
            for _ in range(count)]
