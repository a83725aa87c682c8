"""What accuracy and effects cost in a scene, measured with random strokes."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math
from time import process_time

import numpy as np

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.effects import GATES
from billiard_shot.shot.lowest_elevation import lowest_elevation
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.predict import effects_of, predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.motion import Cause, Motion
from billiard_shot.table.run.effects import AUTO, EffectGate, OFF, ON
from billiard_shot.table.run.results import Trajectory


def sample_strokes(scene: Scene, count: int, seed: int = 0) -> list[Stroke]:
    """
    Draw random strokes as people play them.

    Half of them are as level as cushions and other balls allow. Offsets are within half a radius
    of the middle, speeds 0.5 to 5 m/s. The aim is another ball, full or thin, if there is one,
    else any direction.
    """
    draw = np.random.default_rng(seed)
    x, y, _ = scene.cue_ball
    aims = [
        (math.atan2(v - y, u - x), math.hypot(u - x, v - y))
        for name, (u, v) in scene.balls.items()
        if (u, v) != (x, y)
    ]
    strokes = []
    for number in range(count):
        offset, around = 0.5 * math.sqrt(draw.random()), draw.uniform(0.0, 2.0 * math.pi)
        steep = math.radians(draw.uniform(5.0, 45.0)) if number % 2 else 0.0
        azimuth = draw.uniform(-math.pi, math.pi)
        if aims:
            direction, distance = aims[draw.integers(len(aims))]
            thin = 2.0 * scene.ball.radius / distance
            azimuth = direction + draw.uniform(-1.0, 1.0) * math.asin(min(thin, 1.0))
        speed = 0.5 * 10.0 ** draw.random()
        a, b = offset * math.cos(around), offset * math.sin(around)
        lowest = float(lowest_elevation(scene, [[a, b, 0.0, azimuth, speed]])[0])
        elevation = max(steep, min(lowest, math.radians(60.0)))
        strokes.append(Stroke.from_offsets(a, b, elevation, azimuth, speed))
    return strokes


SHOT_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)  # m
REFERENCE_TOLERANCE = 1e-11  # m, tolerance of the shots that errors are measured against


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Error and cost of one tolerance.

    Times are processor times, medians of all strokes. Each is the smallest of several runs, in
    which the tolerances take turns, so that other work of the computer changes their ratios
    little.

    Attributes
    ----------
    tolerance : float
        [m].
    typical_error, largest_error : float
        Of the place of rest of the cue ball without the other balls [m].
    strike, alone, shot : float
        Time of a strike on endless cloth, of a shot without the other balls, and of a shot with
        all balls [s].

    """

    tolerance: float
    typical_error: float
    largest_error: float
    strike: float
    alone: float
    shot: float


def study_accuracy(
    scene: Scene, tolerances: Sequence[float] = SHOT_TOLERANCES, count: int = 100, repeats: int = 5
) -> Iterator[Tolerance]:
    """
    Measure error and time of each tolerance with random strokes.

    Parameters
    ----------
    scene : Scene
    tolerances : sequence of float
        [m].
    count : int
        Number of strokes, 0.5 to 5 m/s, that aim at the balls of the scene. Those whose cue hits
        the ball again are left out: errors are unbounded after it.
    repeats : int
        Runs of each shot.

    Raises
    ------
    ValueError
        If none of the strokes can be played.

    """
    shots = [predict(scene, stroke) for stroke in sample_strokes(scene, count)]
    strokes = [s.stroke for s in shots if not s.status.refused and s.double_hit is None]
    if not strokes:
        raise ValueError(f'scene: none of {count} random strokes can be played')
    alone = replace(scene, balls={CUE_BALL: scene.cue_ball[:2]})
    strikes = _times(replace(alone, table=None), strokes, tolerances, repeats)
    without = _times(alone, strokes, tolerances, repeats)
    all_balls = _times(scene, strokes, tolerances, repeats)
    exact = _places(alone, strokes, REFERENCE_TOLERANCE)
    for tolerance, *times in zip(tolerances, strikes, without, all_balls, strict=True):
        errors = np.linalg.norm(_places(alone, strokes, tolerance) - exact, axis=1)
        yield Tolerance(tolerance, float(np.median(errors)), float(errors.max()), *times)


def cost_of_accuracy(studied: Sequence[Tolerance]) -> str:
    """Say how much longer a shot within the last tolerance takes than one within the default."""
    usual = min(studied, key=lambda each: abs(np.log(each.tolerance / DEFAULT_SHOT_TOLERANCE)))
    finest = studied[-1]
    ratio = finest.alone / usual.alone
    return (
        f'a shot within {1e9 * finest.tolerance:g} nm takes {ratio:.1f} times the processor time '
        f'of one within {1e3 * usual.tolerance:g} mm'
    )


def _times(
    scene: Scene, strokes: Sequence[Stroke], tolerances: Sequence[float], repeats: int
) -> list[float]:
    """Measure processor times (tolerances,) [s]; the tolerances take turns."""
    smallest = np.full((len(tolerances), len(strokes)), np.inf)
    for _ in range(repeats):
        for j, stroke in enumerate(strokes):
            for i, tolerance in enumerate(tolerances):
                started = process_time()
                predict(scene, stroke, tolerance)
                smallest[i, j] = min(smallest[i, j], process_time() - started)
    return np.median(smallest, axis=1).tolist()


def _places(scene: Scene, strokes: Sequence[Stroke], tolerance: float) -> Array:
    return np.array([predict(scene, s, tolerance).final_position[CUE_BALL] for s in strokes])


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


def _compared(shot: Shot, gate: EffectGate, repeats: int) -> Change:
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
