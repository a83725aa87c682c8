"""What each effect costs and what it changes: shots with it beside the same shots without it."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.shot.effects import GATES
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.effects import Gate, OFF, ON
from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import Trajectory

REPEATS = 40  # of each shot, for the time
AUTO = 'auto'


@dataclass(frozen=True, slots=True)
class Change:
    """What an effect does in one shot: the shot with it, less the shot without it."""

    simulated: bool  # whether the shot calls for it; if not, this is what forcing it on does
    reason: str
    time: float  # s that it costs
    steps: int  # more steps of the impact and pieces of motion
    distance: float  # m between the places of rest; inf if the ball stops in only one of them
    turn: float  # rad by which the ball goes another way, see `heading`


@dataclass(frozen=True, slots=True)
class EffectStudy:
    """An effect in all the shots that were looked at."""

    name: str
    needs: str
    changes: tuple[Change, ...]

    @property
    def simulated(self) -> int:
        """In how many shots it was called for."""
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
    Compare each shot with the same without each of its effects, and with each that it left out.

    Parameters
    ----------
    scene : Scene
        What it forces on or off counts for the other effects, not for the one compared.
    strokes : sequence of Stroke
        Those that cannot be played are left out.
    tolerance : float
        [m].
    repeats : int
        Of each shot. Time is the median of differences between neighbours in time, so that a busy
        machine matters little.
    report : callable
        Called with the number of comparisons done, of strokes times effects.

    """
    studies: dict[str, list[Change]] = {gate.name: [] for gate in GATES}
    done = 0
    for stroke in strokes:
        for gate in GATES:
            shot = predict(_wishing(scene, gate.name, AUTO), stroke, tolerance)
            if not shot.status.refused:
                studies[gate.name].append(_compared(shot, gate, repeats))
            done += 1
            report(done)
    return [EffectStudy(gate.name, gate.needs, tuple(studies[gate.name])) for gate in GATES]


def comparisons(strokes: Sequence[Stroke]) -> int:
    """How many comparisons `study_effects` makes."""
    return len(strokes) * len(GATES)


def strokes_for(scene: Scene, count: int, seed: int = 0) -> list[Stroke]:
    """
    Strokes as people play them, for a scene that comes without any.

    Half of them level; within half a radius of the middle; 0.5 to 5 m/s; at another ball, full or
    thin, where there is one, else in any direction.
    """
    draw = np.random.default_rng(seed)
    x, y, _ = scene.cue_ball
    aims = [(math.atan2(v - y, u - x), math.hypot(u - x, v - y))
            for name, (u, v) in scene.balls.items() if (u, v) != (x, y)]
    strokes = []
    for number in range(count):
        offset, around = 0.5 * math.sqrt(draw.random()), draw.uniform(0.0, 2.0 * math.pi)
        elevation = math.radians(draw.uniform(5.0, 45.0)) if number % 2 else 0.0
        azimuth = draw.uniform(-math.pi, math.pi)
        if aims:
            direction, distance = aims[draw.integers(len(aims))]
            thin = 2.0 * scene.ball.radius / distance
            azimuth = direction + draw.uniform(-1.0, 1.0) * math.asin(min(thin, 1.0))
        speed = 0.5 * 10.0 ** draw.random()
        strokes.append(Stroke.from_offsets(
            offset * math.cos(around), offset * math.sin(around), elevation, azimuth, speed))
    return strokes


def heading(trajectory: Trajectory) -> float:
    """Direction in which the ball moves when it comes to roll, or at the start if never [rad]."""
    rolls = (segment for segment in trajectory.segments if segment.motion == Motion.ROLL)
    first = next(rolls, trajectory.segments[0])
    return math.atan2(first.velocity[1], first.velocity[0])


def _compared(shot: Shot, gate: Gate[Any], repeats: int) -> Change:
    effect = next(effect for effect in shot.effects if effect.name == gate.name)
    wish = OFF if effect.simulated else ON
    if wish not in gate.changes:
        return Change(False, effect.reason, 0.0, 0, 0.0, 0.0)
    other = predict(_wishing(shot.scene, gate.name, wish), shot.stroke, shot.tolerance)
    sign = 1.0 if effect.simulated else -1.0
    times = [_time_of(shot) - _time_of(other) for _ in range(repeats)]
    return Change(
        effect.simulated, effect.reason, sign * float(np.median(times)),
        int(sign) * (_steps(shot) - _steps(other)), _distance(shot, other),
        abs(math.remainder(heading(shot.trajectory) - heading(other.trajectory), math.tau)),
    )


def _wishing(scene: Scene, name: str, wish: str) -> Scene:
    return replace(scene, effects=replace(scene.effects, **{name: wish}))


def _time_of(shot: Shot) -> float:
    return predict(shot.scene, shot.stroke, shot.tolerance).wall_time


def _steps(shot: Shot) -> int:
    return shot.evaluations + len(shot.trajectory.rows)


def _distance(one: Shot, other: Shot) -> float:
    apart = np.linalg.norm(one.trajectory.rest - other.trajectory.rest)
    return float(apart) if _stops(one) == _stops(other) else math.inf


def _stops(shot: Shot) -> bool:
    """Whether the ball's centre comes to a stop; it may spin in place for ever."""
    return shot.trajectory.segments[-1].motion in (Motion.REST, Motion.SPIN)
