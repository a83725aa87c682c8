"""Cost and influence of each effect: shots with it beside the same shots without it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from billiard_shot.numerics.angles import wrapped
from billiard_shot.scene import Scene
from billiard_shot.shot.analysis import effects_of
from billiard_shot.shot.effects import GATES
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.effects import AUTO, EffectGate, OFF, ON
from billiard_shot.table.motion import Cause, Motion
from billiard_shot.table.trajectory import Trajectory

REPEATS = 40  # of each shot, for the time
STANDS = (Motion.REST, Motion.SPIN, Motion.POCKETED, Motion.OFF_TABLE)


@dataclass(frozen=True, slots=True)
class Change:
    """Influence of an effect on one shot: the shot with it minus the shot without it."""

    simulated: bool  # whether the shot calls for it; if not, it is forced on
    reason: str
    time: float  # s that it costs
    steps: int  # more steps of the impact, pieces of motion, and contacts looked for
    distance: float  # m between the places of rest of the ball that is moved most
    turn: float  # rad, between the directions of the struck ball


@dataclass(frozen=True, slots=True)
class EffectStudy:
    """An effect in all the shots that were looked at."""

    name: str
    needs: str
    changes: tuple[Change, ...]

    @property
    def simulated(self) -> int:
        """Number of shots that call for it."""
        return sum(change.simulated for change in self.changes)

    def median(self, quantity: str) -> float:
        """Median over the shots that call for it or, if none does, over all."""
        called = [change for change in self.changes if change.simulated] or self.changes
        return float(np.median([getattr(change, quantity) for change in called]))

    def largest(self, quantity: str) -> float:
        """Largest over the shots."""
        return float(max(getattr(change, quantity) for change in self.changes))


def study_effects(
    scene: Scene,
    strokes: Sequence[Stroke],
    tolerance: float = 1e-4,
    repeats: int = REPEATS,
    report: Callable[[int], None] = lambda done: None,
) -> list[EffectStudy]:
    """
    Compare each shot with the same shot without one of its effects, or with one that it lacks.

    Parameters
    ----------
    scene : Scene
        Its settings of effects hold for all effects but the one that is compared.
    strokes : sequence of Stroke
        Strokes that cannot be played are skipped.
    tolerance : float
        [m].
    repeats : int
        Runs of each shot. The time is the median difference between consecutive runs, so that the
        load of the machine matters little.
    report : callable
        Called with the number of comparisons done, of strokes times effects.

    """
    studies: dict[str, list[Change]] = {gate.name: [] for gate in GATES}
    done = 0
    for stroke in strokes:
        for gate in GATES:
            shot = predict(_with_effect(scene, gate.name, AUTO), stroke, tolerance)
            if not shot.status.refused:
                studies[gate.name].append(_compared(shot, gate, repeats))
            done += 1
            report(done)
    return [EffectStudy(gate.name, gate.condition, tuple(studies[gate.name])) for gate in GATES]


def comparison_count(strokes: Sequence[Stroke]) -> int:
    """Count the comparisons that `study_effects` makes."""
    return len(strokes) * len(GATES)


def _compared(shot: Shot, gate: EffectGate[Any], repeats: int) -> Change:
    effect = next(effect for effect in effects_of(shot) if effect.name == gate.name)
    setting = OFF if effect.simulated else ON
    if setting == ON and gate.on is None:
        return Change(False, effect.reason, 0.0, 0, 0.0, 0.0)
    other = predict(_with_effect(shot.scene, gate.name, setting), shot.stroke, shot.tolerance)
    times = [_time_of(shot) - _time_of(other) for _ in range(repeats)]
    sign = 1 if effect.simulated else -1
    return Change(
        effect.simulated,
        effect.reason,
        sign * float(np.median(times)),
        sign * (steps(shot) - steps(other)),
        distance(shot, other),
        turn(shot, other),
    )


def _time_of(shot: Shot) -> float:
    return predict(shot.scene, shot.stroke, shot.tolerance).wall_time


def _with_effect(scene: Scene, name: str, setting: str) -> Scene:
    return replace(scene, effects=replace(scene.effects, **{name: setting}))


def steps(shot: Shot) -> int:
    """Count the steps of the impact, the pieces of motion, and the contacts looked for."""
    pieces = sum(len(ball.rows) for ball in shot.run.balls.values())
    return shot.evaluations + pieces + shot.run.searches


def heading(trajectory: Trajectory) -> float:
    """Direction of a ball when it comes to roll, or before it meets something else [rad]."""
    way = trajectory.segments[0]
    causes = trajectory.rows['cause']
    for segment, cause in zip(trajectory.segments, causes, strict=True):
        if cause not in (Cause.START, Cause.OWN) or segment.motion in STANDS:
            break
        way = segment
        if segment.motion == Motion.ROLL:
            break
    return math.atan2(way.velocity[1], way.velocity[0])


def distance(one: Shot, other: Shot) -> float:
    """
    Largest distance between the places where a ball comes to rest in two shots [m].

    Infinite if a ball stops in only one of them. A ball that spins in place has stopped.
    """
    apart = 0.0
    for name, ball in one.run.balls.items():
        twin = other.run.balls[name]
        if _stops(ball) != _stops(twin):
            return math.inf
        apart = max(apart, float(np.linalg.norm(ball.final_position - twin.final_position)))
    return apart


def turn(one: Shot, other: Shot) -> float:
    """Angle between the directions in which the struck ball goes in two shots [rad]."""
    angle = heading(one.trajectory) - heading(other.trajectory)
    return abs(wrapped(angle))


def _stops(ball: Trajectory) -> bool:
    return ball.segments[-1].motion in STANDS
