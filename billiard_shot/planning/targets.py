"""Targets of a plan: what people state of each, its check, its way points and its penalties."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
# ruff: noqa: D102 (what the methods return is told in `Target`)

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import math
from typing import Any

import numpy as np

from billiard_shot.planning import target_fields
from billiard_shot.planning.problem import Flags, Problem, Target
from billiard_shot.planning.score import (
    distance_penalty,
    Measure,
    measured,
    miss_penalty,
    PENALTY_STEP,
)
from billiard_shot.planning.shots import shots
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import InputError, Mistake, must_be, refused, unknown
from billiard_shot.scene.fields import name, number, point, read, whole_number
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.table.model.geometry import POCKETS
from billiard_shot.table.model.motion import NOTHING
from billiard_shot.table.run.simulate import TableBatch
from billiard_shot.table.run.task import BatchRecording


@dataclass(frozen=True, slots=True)
class Rest(Target):
    """
    The cue ball has to rest near a point.

    Parameters
    ----------
    rest : (x, y)
        [m]
    radius : float
        Largest distance from the point [m], above 0.

    """

    rest: Place = point()
    radius: float = number('m', above=0, default=0.1)
    must_rest = True

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.cue_ball_fits(scene, 'rest', self.rest, self.radius)

    @property
    def point(self) -> Place:
        return self.rest

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        return distance_penalty(_distance_at_rest(played, self.rest) - self.radius)

    def judge(self, places: Mapping[str, Place]) -> tuple[bool, str]:
        return _judged_by_distance(places, self.rest, self.radius)


@dataclass(frozen=True, slots=True)
class Pass(Target):
    """
    The cue ball has to pass near a point.

    Parameters
    ----------
    passing : (x, y)
        [m]; `pass` in a mapping.
    radius : float
        Largest distance of the centre of the ball from the point [m], above 0.

    """

    passing: Place = point()
    radius: float = number('m', above=0, default=0.02)

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.cue_ball_fits(scene, 'pass', self.passing, self.radius)

    @property
    def point(self) -> Place:
        return self.passing

    @property
    def passing_within(self) -> float:
        return self.radius

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        near = measured(Measure.APPROACH, played, [self.passing])
        return distance_penalty(near - self.radius)


@dataclass(frozen=True, slots=True)
class Gate(Target):
    """
    The centre of the cue ball has to pass between two points.

    Parameters
    ----------
    gate : ((x1, y1), (x2, y2))
        [m]

    """

    gate: tuple[Place, Place] = target_fields.segment_field()

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        for end in self.gate:
            yield from target_fields.on_table(scene, 'gate', end)

    @property
    def point(self) -> Place:
        (x, y), (u, v) = self.gate
        return 0.5 * (x + u), 0.5 * (y + v)

    @property
    def passing_within(self) -> float:
        return 0.5 * math.dist(*self.gate)

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        missed = measured(Measure.CROSSING, played, self.gate) > 0.0
        near = measured(Measure.APPROACH, played, [self.point], which=missed)
        return np.where(missed, miss_penalty(near), 0.0)


def _one_way_to_hit(hit: Any) -> Iterator[Mistake]:
    if hit.direction is not None and hit.at is not None:
        yield Mistake(('at',), 'must not be given together with direction')
    if hit.direction is not None and math.hypot(*hit.direction) == 0.0:
        yield Mistake(('direction',), f'must not be zero, got {hit.direction!r}')


@dataclass(frozen=True, slots=True)
class Hit(Target):
    """
    The cue ball has to meet a ball before any other.

    Parameters
    ----------
    hit : str
        Name of the ball.
    direction : (x, y), optional
        Direction in which that ball has to leave, of any length.
    direction_tolerance_deg : float
        Largest deviation from that direction [degrees], above 0.
    at : (x, y), optional
        Point [m]. The cue ball has to touch the ball where its circumference is nearest to it.
    radius : float
        Largest distance from that point [m], above 0.

    """

    RULES = (_one_way_to_hit,)
    hit: str = name()
    direction: Place | None = point(nullable=True)
    direction_tolerance_deg: float = number('degrees', above=0, maximum=180, default=5.0)
    at: Place | None = point(nullable=True)
    radius: float = number('m', above=0, default=0.005)

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.ball_there(scene, 'hit', self.hit)
        if self.at is not None:
            yield from target_fields.on_table(scene, 'at', self.at)
            if tuple(self.at) == scene.balls.get(self.hit):
                allowed = f'beside the middle of ball {self.hit!r}'
                yield Mistake(('at',), must_be(allowed, list(self.at), 'm'))

    def concerns(self, ball: str) -> bool:
        return ball == self.hit

    def push(self, there: Array) -> Array | None:
        if self.at is not None:
            return there - self.at
        return None if self.direction is None else np.array(self.direction)

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        (ball,) = problem.balls
        there, hit = problem.places[ball], played.balls['first_contact'][:, 0] == ball
        near = measured(Measure.APPROACH_BEFORE_HIT, played, [there], which=~hit)
        missed = PENALTY_STEP + miss_penalty(near - 2.0 * problem.radius)
        if self.direction is not None:
            turn = measured(Measure.DIRECTION, played, [self.direction], ball=ball, which=hit)
            away = (turn - math.radians(self.direction_tolerance_deg)) / math.pi
        elif self.at is not None:
            beside = measured(Measure.PLACE, played, [there, self.at], ball=ball, which=hit)
            away = problem.radius * beside - self.radius
        else:
            return np.where(hit, 0.0, missed)
        return np.where(hit, distance_penalty(away), PENALTY_STEP + missed)

    def miss_in_words(self, penalty: float) -> str:
        if self.direction is not None:
            return f'{180.0 * penalty:.3g} degrees'
        return Target.miss_in_words(self, penalty)


@dataclass(frozen=True, slots=True)
class Pot(Target):
    """
    One of the named balls has to fall into a pocket, and the cue ball has to stay on the table.

    Parameters
    ----------
    pot : str or sequence of str
        Name of the ball, or of several; `any`: all but the cue ball and the balls to be kept.
    pocket : str or sequence of str
        `any`, or one or several names from `POCKET_NAMES`.
    leave : (x, y), optional
        Point near which the cue ball has to rest [m].
    radius : float
        Largest distance from that point [m], above 0.

    """

    pot: tuple[str, ...] = target_fields.balls_field()
    pocket: tuple[str, ...] = target_fields.pocket_field()
    leave: Place | None = point(nullable=True)
    radius: float = number('m', above=0, default=0.1)

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.balls_there(scene, 'pot', self.pot)
        yield from target_fields.needs_pockets(scene, 'pocket')
        if self.leave is not None:
            yield from target_fields.cue_ball_fits(
                scene, 'leave', self.leave, self.radius, self.pot
            )

    def concerns(self, ball: str) -> bool:
        return target_fields.ANY in self.pot or ball in self.pot

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        balls, pocket = np.array(problem.balls), played.balls['pocket']
        may_fall = np.zeros((len(problem.places), POCKETS))
        may_fall[np.ix_(balls, problem.pockets)] = 1.0
        every = np.arange(len(problem.places))
        fell = ((pocket != NOTHING) & (may_fall[every, pocket] > 0.0)).any(axis=1)
        met = (played.balls['first_contact'][:, balls] != NOTHING).any(axis=1)
        to_pocket = measured(
            Measure.APPROACH, played, problem.holes, seeking=may_fall, which=met & ~fell
        )
        to_ball = measured(
            Measure.APPROACH,
            played,
            problem.places[balls],
            seeking=np.not_equal.outer(every, balls).astype(float),
            apart=2.0 * problem.radius,
            which=~met & ~fell,
        )
        missed = np.where(met, miss_penalty(to_pocket), PENALTY_STEP + distance_penalty(to_ball))
        if self.leave is None:
            return np.where(fell, 0.0, missed)
        left = distance_penalty(_distance_at_rest(played, self.leave) - self.radius)
        return np.where(fell, left, missed + PENALTY_STEP)

    def judge(self, places: Mapping[str, Place]) -> tuple[bool, str]:
        wanted = () if target_fields.ANY in self.pot else self.pot
        fallen = sorted(set(wanted) - set(places))
        if wanted and not fallen:
            return False, f'not reached: still on the table: {", ".join(wanted)}'
        if self.leave is not None:
            return _judged_by_distance(places, self.leave, self.radius)
        if fallen:
            return True, f'reached: pocketed: {", ".join(fallen)}'
        return Target.judge(self, places)


@dataclass(frozen=True, slots=True)
class Safe(Target):
    """
    A legal stroke that leaves the other player no good direct shot.

    The cue ball has to meet one of the named balls first. After that a ball has to meet a cushion
    or to fall, but not the cue ball.

    Parameters
    ----------
    safe : str or sequence of str
        Name of the ball to be met first, or of several, or `any`.
    against : str or sequence of str
        Balls that the other player may pot, or `any`.
    chance : float
        Largest chance of the best direct shot that is left, see `shots`: 0 to 1.

    """

    safe: tuple[str, ...] = target_fields.balls_field()
    against: tuple[str, ...] = target_fields.balls_field(default=target_fields.ANY)
    chance: float = number('', minimum=0, maximum=1, default=0.2)
    must_meet = True
    kind = 'safety'

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.balls_there(scene, 'safe', self.safe)
        yield from target_fields.balls_there(scene, 'against', self.against)
        yield from target_fields.needs_pockets(scene, 'safe')

    def concerns(self, ball: str) -> bool:
        return target_fields.ANY in self.safe or ball in self.safe

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        outcomes = TableBatch(problem.names, played)
        penalties = np.zeros(len(fouls))
        quiet = ~outcomes.to_cushion.any(axis=1) & (_fallen(problem, played) == 0)
        penalties[quiet] = PENALTY_STEP
        legal = np.flatnonzero(~fouls & ~quiet)
        wanted = None if target_fields.ANY in self.against else self.against
        left = shots(problem.scene, outcomes.states.take(legal), wanted, problem.noise, workers=1)
        penalties[legal] = distance_penalty(left.best - self.chance)
        return penalties


@dataclass(frozen=True, slots=True)
class Break(Target):
    """
    Balls have to fall, and the cue ball has to stay on the table.

    Parameters
    ----------
    breaking : str or sequence of str
        Name of the ball to be met first, or of several, or `any`; `break` in a mapping.
    pots : int
        How many balls have to fall, at least 1.

    """

    breaking: tuple[str, ...] = target_fields.balls_field()
    pots: int = whole_number(minimum=1, default=1)
    must_meet = True
    least_speed = 0.7  # slower breaks are not candidates
    kind = 'break'

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        yield from target_fields.balls_there(scene, 'break', self.breaking)
        others = len(scene.object_balls)
        if self.pots > others > 0:
            yield Mistake(('pots',), must_be(f'at most {others}, the balls', self.pots))
        yield from target_fields.needs_pockets(scene, 'break')

    def concerns(self, ball: str) -> bool:
        return target_fields.ANY in self.breaking or ball in self.breaking

    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        return PENALTY_STEP * np.maximum(self.pots - _fallen(problem, played), 0)


def _distance_at_rest(played: BatchRecording, point: Place) -> Array:
    """Distances (n,) of cue balls at the end from a point [m]."""
    x, y = (played.balls['position'][:, 0, :2] - point).T
    distances: Array = np.sqrt(x * x + y * y)
    return distances


def _fallen(problem: Problem, played: BatchRecording) -> Array:
    """Count the balls (n,) that fell, without those that must stay."""
    may_fall = ~problem.rules['must_stay']
    fallen: Array = (may_fall & (played.balls['pocket'] != NOTHING)).sum(axis=1)
    return fallen


def _judged_by_distance(
    places: Mapping[str, Place], point: Place, radius: float
) -> tuple[bool, str]:
    """Judge whether the cue ball rests near a point."""
    apart = math.dist(places[CUE_BALL], point)
    reached = apart <= radius
    return reached, (
        f'{"reached" if reached else "not reached"}: the cue ball rests '
        f'{1e3 * apart:.1f} mm from the point, {1e3 * radius:g} mm are allowed'
    )


KINDS: dict[str, type[Target]] = {
    'rest': Rest,
    'pass': Pass,
    'gate': Gate,
    'hit': Hit,
    'pot': Pot,
    'safe': Safe,
    'break': Break,
}
FIELDS = {'pass': 'passing', 'break': 'breaking'}  # keys that no field of Python can have


def target_of(scene: Scene, wanted: Target | Mapping[str, Any]) -> Target:
    """
    Read a target and check it against a scene.

    Raises
    ------
    ValueError
        Naming every field that is wrong, its value and what is allowed.

    """
    target = read_target(wanted)
    if mistakes := list(target.mistakes(scene)):
        raise InputError(mistakes, 'target')
    return target


def read_target(wanted: Target | Mapping[str, Any]) -> Target:
    """
    Read a target without a scene.

    Raises
    ------
    ValueError
        Naming every field that is wrong, its value and what is allowed.

    """
    if isinstance(wanted, Target):
        return wanted
    if not isinstance(wanted, Mapping):
        raise refused(wanted, f'a mapping with one of the keys {", ".join(KINDS)}', 'target')
    for key, field in FIELDS.items():
        if field in wanted:
            raise InputError([Mistake((field,), unknown(field, [key]))], 'target')
    kinds = [kind for kind in KINDS if kind in wanted]
    if len(kinds) != 1:
        allowed = f'a mapping with one of the keys {", ".join(KINDS)}'
        raise refused(dict(wanted), allowed, 'target')
    data = {FIELDS.get(str(key), key): value for key, value in wanted.items()}
    try:
        target: Target = read(KINDS[kinds[0]], data)
    except InputError as error:
        keys = {field: key for key, field in FIELDS.items()}
        mistakes = [
            each._replace(path=tuple(keys.get(str(part), part) for part in each.path))
            for each in error.mistakes
        ]
        raise InputError(mistakes, 'target') from None
    return target
