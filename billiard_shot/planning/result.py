"""The result of a search: strokes with success and kind, and why they miss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, product
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.notebook import Shown, Tabular
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.planning.problem import as_struck, draw_places, Limits, problem_of, Target
from billiard_shot.planning.runner import evaluate_strokes, penalties_of, simulate_strokes
from billiard_shot.planning.statistics import chance_in_words, estimate_in_words, wilson_interval
from billiard_shot.planning.targets import Hit, Pot
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import offset_columns
from billiard_shot.shot.aim import aim
from billiard_shot.shot.ghost_ball import cut_of_path, grazing
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.motion import POCKETED
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import (
    ball_in_words,
    EventKind,
    NOSE_NAMES,
    place_in_words,
    POCKET_NAMES,
    TableEvent,
)
from billiard_shot.table.run.task import BatchRecording

STRAIGHT = math.radians(10.0)  # of deflection: smaller ones are not a cut
MASSE = math.radians(30.0)  # elevation: above it, a curve is a massé
CURVED = 0.5  # ball radii: deviation from a straight line that makes a path a curve
TOUCH = 1e-4  # ball radii: balls at smaller distances touch
COLLISIONS = (EventKind.BALL, EventKind.CLUSTER)


def kind_of(shot: Shot, target: Target) -> str:
    """Name a shot: first the path of the cue ball, then that of the ball to be potted."""
    events = shot.events
    collision = next((e for e in events if e.kind in COLLISIONS and CUE_BALL in e.balls), None)
    time = min(collision.time if collision else math.inf, _reached(shot, target))
    words = [_path_name(shot, time)]
    if any(_cushion(event, CUE_BALL) and event.time < time for event in events):
        words.append('kick')
    if isinstance(target, Pot) and collision:
        ball = _potted(shot, target, collision)
        touched = _touches(shot, collision, ball)
        if not touched:
            words.append('combination')
        if any(_cushion(event, ball) for event in events):
            words.append('bank')
        elif touched and _deflection(shot, collision, ball) > STRAIGHT:
            words.append('cut')
        if target.leave is not None:
            words.append('position')
    elif (
        isinstance(target, Hit)
        and collision
        and _deflection(shot, collision, target.hit) > STRAIGHT
    ):
        words.append('cut')
    words.append(target.kind)
    return ', '.join(word for word in words if word) or 'direct'


def _potted(shot: Shot, target: Pot, collision: TableEvent) -> str:
    """Find the ball that the stroke pots; if it pots none, the one that is met first."""
    fell = (ball for ball, pocket in shot.pocketed.items() if pocket in target.pocket)
    met = (ball for ball in collision.balls if ball != CUE_BALL)
    return next(
        (ball for ball in (*fell, *met) if ball != CUE_BALL and target.concerns(ball)),
        target.pot[0],
    )


def _touches(shot: Shot, collision: TableEvent, ball: str) -> bool:
    """Say whether the cue ball touches a ball in a collision, or only balls that touch it."""
    apart = math.dist(
        *(shot.run.balls[name].at(collision.time).position for name in (CUE_BALL, ball))
    )
    return ball in collision.balls and (
        ball == shot.first_contact or apart <= (2.0 + TOUCH) * shot.scene.ball.radius
    )


def _reached(shot: Shot, target: Target) -> float:
    """Time at which the cue ball reaches the point or gate that it has to pass; else infinite."""
    point, radius = target.point, target.passing_within
    if point is None or not radius:
        return math.inf
    path = shot.trajectory
    speed = max(float(np.hypot(*segment.velocity[:2])) for segment in path.segments)
    times = np.linspace(0.0, path.duration, 2 + math.ceil(4.0 * speed * path.duration / radius))
    apart = np.hypot(*(path.at(times).position[:, :2] - point).T)
    near = np.flatnonzero(apart <= radius)
    return float(times[near[0]]) if len(near) else math.inf


def _cushion(event: TableEvent, ball: str) -> bool:
    return event.kind == EventKind.CUSHION and event.place in NOSE_NAMES and ball in event.balls


def _path_name(shot: Shot, end: float) -> str:
    """Say whether the cue ball jumps over a ball, or curves around one, before a time."""
    path = shot.trajectory
    stops = EventKind.CUSHION, *COLLISIONS
    end = min(end, path.duration, *(e.time for e in path.events if e.kind in stops))
    places = path.at(np.linspace(0.0, end, 200)).position
    radius = shot.scene.ball.radius
    for name, (x, y) in shot.scene.balls.items():
        beside = np.hypot(places[:, 0] - x, places[:, 1] - y)
        over = (beside < 2.0 * radius) & (places[:, 2] > 1.2 * radius)
        if name != CUE_BALL and over.any() and end > 0.0 and beside[-1] > 2.0 * radius:
            return 'jump'
    chord = places[-1, :2] - places[0, :2]
    length = float(np.hypot(*chord))
    away = places[:, :2] - places[0, :2]
    if length > 0.0:
        aside = np.abs(chord[0] * away[:, 1] - chord[1] * away[:, 0]) / length
        if aside.max() > CURVED * radius:
            return 'massé' if shot.stroke.offsets[2] > MASSE else 'curve'
    return ''


def _deflection(shot: Shot, collision: TableEvent, ball: str) -> float:
    """Angle between the directions of the cue ball before a collision and of the ball after it."""
    before = shot.trajectory.at(max(collision.time - 1e-6, 0.0)).velocity[:2]
    if collision.time == 0.0:  # during the strike
        before = np.array(shot.stroke.velocity[:2])
    after = shot.run.balls[ball].at(collision.time).velocity[:2]
    turn = math.atan2(after[1], after[0]) - math.atan2(before[1], before[0])
    return abs(wrapped(turn))


@dataclass(frozen=True, eq=False)
class RankedStroke:
    """
    A stroke with its success probability under execution noise.

    Attributes
    ----------
    stroke : Stroke
        As it is to be executed.
    command : Stroke
        The stroke to command: the bias of the player's errors is corrected.
    success : float
        Fraction of the trials that reached the target.
    interval : (float, float)
        95 % confidence interval of the success probability (Wilson).
    trials : int
        Number of simulated strokes with random errors that `success` comes from. They are held-out
        trials, which had no part in the choice of the stroke. If the search was cancelled, they
        are the samples of the search itself. Then `success` can be too large, and the errors can
        be larger than the execution noise.
    value : float
        Mean value of the outcomes of these trials, see `plan`; the success, if nothing else is
        asked for.
    value_error : float
        Standard error of that mean.

    """

    scene: Scene = field(repr=False)
    target: Target = field(repr=False)
    limits: Limits = field(repr=False)
    stroke: Stroke
    command: Stroke = field(repr=False)
    successes: int = field(repr=False)
    trials: int
    value: float = field(repr=False)
    value_error: float = field(repr=False)

    def __repr__(self) -> str:
        return f'RankedStroke({self.kind}: success {self.estimate}, {self.stroke!r})'

    @property
    def success(self) -> float:
        """Estimated success probability."""
        return self.successes / self.trials

    @property
    def chance(self) -> str:
        """`success` in words, such as `85 %`; as a count if trials are few or all succeeded."""
        return chance_in_words(self.success, self.trials)

    @property
    def estimate(self) -> str:
        """`chance` with its interval, such as `85 % (95 % CI 79 to 89 %)`."""
        return estimate_in_words(self.success, self.trials, self.interval)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the success probability."""
        return wilson_interval(self.successes, self.trials)

    @property
    def surely(self) -> float:
        """Lower end of the 95 % interval of the value (Wilson)."""
        return wilson_interval(self.value * self.trials, self.trials)[0]

    @property
    def width(self) -> float:
        """Width of the 95 % interval of the value."""
        low, high = wilson_interval(self.value * self.trials, self.trials)
        return high - low

    @cached_property
    def shot(self) -> Shot:
        """Prediction of the stroke without errors; computed when first used."""
        return predict(self.scene, self.stroke)

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the stroke without errors, see `Shot.plot`."""
        return self.shot.plot(path)

    def view(self, path: str | Path | None = None) -> Path:
        """Write the page of the stroke without errors, see `Shot.view`."""
        return self.shot.view(path)

    @cached_property
    def warning(self) -> str:
        """Faults of the stroke even without errors; empty if it reaches its target."""
        problem = problem_of(self.scene, self.target, self.limits, self.scene.noise)
        shot = self.shot
        faults = [
            f'ball {ball!r} falls into a pocket'
            for ball in shot.pocketed
            if problem.rules['must_stay'][problem.names.index(ball)]
        ]
        met = shot.first_contact
        if met is not None and not problem.may_meet(problem.names.index(met)):
            faults.append(f'the cue ball meets ball {met!r} first')
        faults += [f'ball {ball!r} leaves the table' for ball in shot.off_table]
        if shot.miscue:
            faults.append('the tip slides on the cue ball')
        if shot.double_hit is not None:
            faults.append('the cue hits the cue ball again')
        exactly = np.array([self.stroke.offsets])
        if not faults and not evaluate_strokes(problem, exactly).success[0]:
            faults = ['the target is missed']
        return f'without errors {" and ".join(faults)}' if faults else ''

    @cached_property
    def kind(self) -> str:
        """Players' name for the shot: cut, bank, kick, massé ..."""
        return kind_of(self.shot, self.target)


@dataclass(frozen=True, eq=False)
class PlanResult(Shown, Tabular):
    """
    Result of a search.

    Attributes
    ----------
    status : Status
        OK, NO_PLAN, or CANCELLED (with the best so far, if any).
    message : str
        The same in one line.
    ranking : tuple of RankedStroke
        The first one wins a race under common errors: it is the slowest of the strokes that have
        at most 1 point less than the best; if `plan` has a `value`, the best. Held-out trials
        have no part in that. The others follow by the lower end of their intervals.
    simulations : int
        Number of simulated strokes.
    wall_time : float
        [s]
    noise : Noise
        Execution noise under which the success was estimated.
    converged : bool
        Whether the best success is nearly 1, or a search from other candidates found none that is
        surely larger; and its interval is not wider than 0.1.
    place : (x, y), optional
        Where to put a cue ball in hand [m], if the plan was asked for that.

    """

    status: Status
    message: str
    ranking: tuple[RankedStroke, ...]
    simulations: int
    wall_time: float
    noise: Noise
    converged: bool = False
    place: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return f'PlanResult({self.status.name}: {self.message}; strokes: {len(self.ranking)})'

    @property
    def best(self) -> RankedStroke | None:
        """The best stroke, None if no stroke was found."""
        return self.ranking[0] if self.ranking else None

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame`, with a row for each stroke, the best first."""
        return {
            'kind': [each.kind for each in self.ranking],
            'success': [each.success for each in self.ranking],
            'low': [each.interval[0] for each in self.ranking],
            'high': [each.interval[1] for each in self.ranking],
            'trials': [each.trials for each in self.ranking],
            'warning': [each.warning for each in self.ranking],
            **offset_columns([each.stroke.offsets for each in self.ranking]),
        }


PIECES = 6  # straight lines by which a segment is approximated


class Dispersion(NamedTuple):
    """Outcomes of n noisy executions of one planned stroke."""

    names: tuple[str, ...]  # of the balls, the cue ball first
    final_positions: Array  # (n, balls, 2) m; NaN if the ball is in a pocket or off the table
    moved: NDArray[np.bool_]  # (n, balls) whether the ball moved
    paths: tuple[Array, ...]  # n paths of the cue ball (., 2) [m]
    success: NDArray[np.bool_]  # (n,) whether the target was reached


def sample_outcomes(planned: RankedStroke, noise: Noise, count: int, seed: int = 1) -> Dispersion:
    """
    Simulate a planned stroke with execution noise.

    Parameters
    ----------
    planned : RankedStroke
    noise : Noise
    count : int
        Number of executions.
    seed : int
        Of the random errors.

    """
    problem = problem_of(planned.scene, planned.target, planned.limits, noise)
    stroke = np.array(planned.stroke.offsets)
    draw = np.random.default_rng(seed)
    strokes = stroke + draw.standard_normal((count, 5)) * problem.sigmas
    places = draw_places(problem, draw, count)
    if places is not None:
        strokes = as_struck(problem, strokes, places)
    recording, usable = simulate_strokes(problem, strokes, places=places)
    penalties = penalties_of(problem, recording)
    final = recording.balls['position'][:, :, :2].copy()
    final[recording.balls['motion'] >= POCKETED] = np.nan
    moved, paths = _motions(recording)
    return Dispersion(problem.names, final, moved, paths, (penalties == 0.0) & usable)


def _motions(recording: BatchRecording) -> tuple[NDArray[np.bool_], tuple[Array, ...]]:
    """Find which balls moved (n, balls), and the paths of n cue balls (., 2) [m] as lines."""
    counts = np.diff(recording.tables['segments'], prepend=0)
    table = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((recording.segments['ball'], table))  # stable: in the order of time
    rows, table = recording.segments[order], table[order]
    owner, time = rows['ball'], rows['time']
    duration = np.zeros(len(rows))
    goes_on = (table[1:] == table[:-1]) & (owner[1:] == owner[:-1])
    duration[:-1] = np.where(goes_on, time[1:] - time[:-1], 0.0)
    moved = np.zeros(recording.balls.shape, np.bool_)
    moved[table[duration > 0.0], owner[duration > 0.0]] = True
    cue = owner == 0
    rows, table = rows[cue], table[cue]
    dt = duration[cue, np.newaxis, np.newaxis] * np.linspace(0.0, 1.0, PIECES + 1)[:, np.newaxis]
    corners = rows['position'][:, np.newaxis, :2] + dt * (
        rows['velocity'][:, np.newaxis, :2] + 0.5 * dt * rows['acceleration'][:, np.newaxis, :2]
    )
    return moved, tuple(corners[table == i].reshape(-1, 2) for i in range(len(counts)))


LEAST = math.radians(0.05)  # smaller deviations are not reported
FIRM = 2.0  # m/s, speed of a straight attempt


@dataclass(frozen=True, slots=True)
class Deviation:
    """
    Deviation of a ball from the direction to a pocket, and its causes.

    Angles are in radians. They are positive if they make the cut thicker, that is, turn the ball
    towards the path of the cue ball. The causes add up to `thick`.

    Attributes
    ----------
    ball, pocket : str
    thick : float
        Angle between the ideal direction, to the middle of the pocket, and the real one.
    aim : float
        Deviation if the cue ball went along the stroke, and the balls had no friction.
    squirt : float
        Part because the cue ball does not leave along the stroke.
    swerve : float
        Part because the path of the cue ball is not straight.
    throw : float
        Part because the balls have friction.

    """

    ball: str
    pocket: str
    thick: float
    aim: float
    squirt: float
    swerve: float
    throw: float

    def __str__(self) -> str:
        causes = {name: getattr(self, name) for name in ('aim', 'squirt', 'swerve', 'throw')}
        told = sorted((c for c in causes.items() if abs(c[1]) >= LEAST), key=lambda c: -abs(c[1]))
        why = ', '.join(f'{name} {_side(angle)}' for name, angle in told)
        where = f'{ball_in_words(self.ball)} beside {place_in_words(self.pocket)}'
        return f'{where}: {_side(self.thick)}' + (f' ({why})' if why else '')


def why_missed(shot: Shot, ball: str, pockets: Sequence[str] = POCKET_NAMES) -> str:
    """
    Say why a shot does not pot a ball; '' if it does.

    Parameters
    ----------
    shot : Shot
    ball : str
        The ball that was meant to fall.
    pockets : sequence of str
        Pockets into which it was meant to fall.

    """
    if shot.status.refused:
        return shot.message
    if shot.pocketed.get(ball) in pockets:
        return ''
    if shot.first_contact is None:
        return f'the cue ball passes {ball} at {1e3 * _gap(shot, ball):.0f} mm'
    if shot.first_contact != ball:
        return f'the cue ball meets {shot.first_contact} before {ball}'
    found = deviation_of(shot, ball, pockets)
    return str(found) if found else f'{ball} is not potted'


def deviation_of(shot: Shot, ball: str, pockets: Sequence[str]) -> Deviation | None:
    """
    Compare the direction of a ball after its first contact with the ideal one.

    Returns None if the cue ball never meets that ball, or meets it during the strike, after a
    cushion, or together with other balls. Also None if a straight cue ball would miss the ball, or
    if the nearest pocket is behind.
    """
    event = next((e for e in shot.events if {CUE_BALL, ball} <= {*e.balls}), None)
    if event is None or event.time == 0.0:  # during the strike
        return None
    earlier = (e.kind for e in shot.events if e.time < event.time and CUE_BALL in e.balls)
    if event.kind != EventKind.BALL or EventKind.CUSHION in earlier:
        return None
    start = shot.trajectory.at(0.0)
    before = shot.trajectory.at(np.nextafter(event.time, 0.0))
    state = shot.run.at(event.time)[ball]
    there, touch = state.position[:2], shot.trajectory.at(event.time).position[:2]
    real = _angle(state.velocity)
    holes = outline_of(shot.scene).holes
    ideal = {pocket: _angle(holes[POCKET_NAMES.index(pocket), :2] - there) for pocket in pockets}
    pocket = min(ideal, key=lambda name: abs(wrapped(real - ideal[name])))
    way = _angle(before.velocity)
    # the side on which the ball leaves the path of the cue ball: turning away from it is thin
    side = math.copysign(1.0, wrapped(ideal[pocket] - way))
    lines = [
        _line_of_centres(place[:2], _angle(velocity), there, 2.0 * shot.scene.ball.radius)
        for place, velocity in (
            (shot.position, np.array(shot.stroke.velocity)),
            (start.position, start.velocity),
        )
    ]
    steps = [ideal[pocket], *lines, _angle(there - touch), real]
    if None in steps or abs(wrapped(ideal[pocket] - way)) > 0.5 * math.pi:
        return None
    aim, squirt, swerve, throw = (
        -side * wrapped(other - one)  # type: ignore[operator]
        for one, other in pairwise(steps)
    )
    return Deviation(ball, pocket, aim + squirt + swerve + throw, aim, squirt, swerve, throw=throw)


def why_not_straight(scene: Scene, target: Pot, keep: Sequence[str] = ()) -> str:
    """Say what prevents the best straight pot of a ball outside `keep`; '' if a pot succeeds."""
    reasons = []
    wanted = [each for each in scene.object_balls if target.concerns(each) and each not in keep]
    for ball, pocket in product(wanted, target.pocket):
        try:
            shot = predict(scene, aim(scene, ball, pocket=pocket, speed=FIRM))
        except ValueError:  # the pot needs a cut of 90 degrees or more
            continue
        reason = why_missed(shot, ball, [pocket])
        if not reason:
            return ''
        if shot.first_contact == ball:
            found = deviation_of(shot, ball, [pocket])
            if found:
                reasons.append((abs(found.thick), f'a straight shot sends {found}'))
        else:
            reasons.append((math.pi, f'straight at {place_in_words(pocket)}, {reason}'))
    return min(reasons)[1] if reasons else 'no pocket can be reached straight'


def _line_of_centres(start: Array, way: float, there: Array, apart: float) -> float | None:
    """Direction from a ball that goes straight to one that it touches [rad]; None if it misses."""
    away = there - start
    distance, path = math.hypot(*away), wrapped(way - _angle(away))
    if abs(path) >= grazing(distance, apart):
        return None
    return way + cut_of_path(distance, apart, path)


def _gap(shot: Shot, ball: str) -> float:
    """Smallest distance between the surfaces of the cue ball and another one [m]."""
    path = shot.trajectory
    places = path.at(np.linspace(0.0, path.duration, 2000)).position
    return float(
        np.hypot(*(places[:, :2] - shot.scene.balls[ball]).T).min() - 2.0 * shot.scene.ball.radius
    )


def _angle(vector: Array) -> float:
    return math.atan2(vector[1], vector[0])


def _side(angle: float) -> str:
    return f'{"thick" if angle > 0.0 else "thin"} by {math.degrees(abs(angle)):.1f}°'
