"""A planning problem as arrays, made once; the limits of its strokes, the errors of its places."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import combinations
import math
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.records import Array, ROWS
from billiard_shot.scene import Noise, Robot, Scene
from billiard_shot.scene.errors import found_in, InputError, Mistake, must_be_one_of, unknown
from billiard_shot.scene.fields import check_type, CheckedRecord, one_or_many, read
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED
from billiard_shot.shot.effects import StrikeModel, tip_reach
from billiard_shot.shot.lowest_elevation import first_clear, Margins, margins_for
from billiard_shot.shot.play import prepared_scene, PreparedScene
from billiard_shot.table.model.geometry import POCKETS
from billiard_shot.table.model.motion import BallRule, LEFT_TABLE, NOTHING, POCKETED
from billiard_shot.table.run.layout import layout_of
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates
from billiard_shot.table.run.task import BatchRecording

BALL_CONSTRAINTS = ('first_contact', 'keep')  # constraints that name balls
DIRECTIONS = 72  # in which the clearance of the cue is checked


@dataclass(frozen=True, slots=True)
class Limits:
    """
    Limits of planned strokes.

    Parameters
    ----------
    robot : Robot
    first_contact : tuple of str
        One of these balls must be met before any other, as the rules of many games demand; if
        empty, any ball may be met first.
    keep : tuple of str
        Balls that must not be pocketed.
    margins : Margins
        Of the clearance of the cue.

    """

    robot: Robot
    first_contact: tuple[str, ...]
    keep: tuple[str, ...]
    margins: Margins

    @property
    def elevations(self) -> tuple[float, float]:
        """Smallest and largest elevation [rad]."""
        robot = self.robot
        return math.radians(robot.elevation_min_deg), math.radians(robot.elevation_max_deg)

    def clip(self, strokes: Array) -> Array:
        """Return the nearest strokes (n, 5) within the robot's limits."""
        robot, clipped = self.robot, strokes.copy()
        offset = np.hypot(clipped[:, A], clipped[:, B])
        clipped[:, :2] *= np.minimum(1.0, robot.offset_max / np.maximum(offset, 1e-12))[:, None]
        clipped[:, ELEVATION] = np.clip(clipped[:, ELEVATION], *self.elevations)
        clipped[:, SPEED] = np.clip(clipped[:, SPEED], robot.speed_min, robot.speed_max)
        middle = math.radians(robot.azimuth_deg)
        half_range = math.radians(robot.azimuth_half_range_deg)
        turn = wrapped(clipped[:, AZIMUTH] - middle)
        if half_range < np.pi:
            turn = np.clip(turn, -half_range, half_range)
        clipped[:, AZIMUTH] = wrapped(middle + turn)
        return clipped

    def allows_azimuth(self, azimuths: Array) -> NDArray[np.bool_]:
        """Whether the robot can strike in these directions."""
        away = np.abs(wrapped(azimuths - math.radians(self.robot.azimuth_deg)))
        half_range = math.radians(self.robot.azimuth_half_range_deg)
        allowed: NDArray[np.bool_] = away <= half_range + 1e-12
        return allowed


def limits_of(scene: Scene, constraints: Mapping[str, Any] | Robot | None, noise: Noise) -> Limits:
    """
    Read constraints; the scene's section `robot` supplies those that are missing.

    Raises
    ------
    ValueError
        Naming every wrong field.

    """
    margins = margins_for(noise, scene.ball.radius)
    given = scene.robot if constraints is None else constraints
    if isinstance(given, Robot):
        return Limits(given, (), (), margins)
    check_type('constraints', given, Mapping)
    data = dict(given)
    mistakes: list[Mistake] = []
    chosen = {key: _names(scene, key, data.pop(key, None), mistakes) for key in BALL_CONSTRAINTS}
    robot, known = scene.robot, asdict(scene.robot)
    for key in data:
        if key not in known:
            mistakes.append(Mistake((str(key),), unknown(str(key), [*known, *BALL_CONSTRAINTS])))
    try:
        robot = read(Robot, {**known, **{key: data[key] for key in data if key in known}})
    except InputError as error:
        mistakes += found_in(error)
    if mistakes:
        raise InputError(mistakes, 'constraints')
    return Limits(robot, chosen['first_contact'], chosen['keep'], margins)


def _names(scene: Scene, key: str, value: Any, mistakes: list[Mistake]) -> tuple[str, ...]:
    """Read the name of a ball, or several names; add the unknown ones to the mistakes."""
    names = () if value is None else one_or_many(value)
    for name in names:
        if str(name) not in scene.object_balls:
            mistakes.append(Mistake((key,), must_be_one_of(scene.object_balls, name, 'ball')))
    return tuple(map(str, names))


def raise_for_clearance(scene: Scene, limits: Limits, strokes: Array) -> Array:
    """
    Raise the cue of strokes (n, 5) until it clears balls, cushions and cloth.

    Strokes with enough clearance are not changed. Strokes without clearance within the limits
    become NaN.
    """
    lowest, highest = limits.elevations
    # with errors, a level cue may point up
    first = max(lowest, min(limits.margins.elevation, highest))
    low = np.maximum(strokes[:, ELEVATION], first)
    found = strokes.copy()
    found[:, ELEVATION] = first_clear(scene, strokes, low, highest, limits.margins)
    found[np.isnan(found[:, ELEVATION])] = np.nan
    return found


def check_clearance(scene: Scene, limits: Limits) -> None:
    """Raise ValueError if the cue has no clearance for any stroke at the centre of the ball."""
    robot = limits.robot
    strokes = np.zeros((DIRECTIONS, 5))
    half_range = math.radians(robot.azimuth_half_range_deg)
    turns = np.linspace(-half_range, half_range, DIRECTIONS)
    strokes[:, AZIMUTH] = math.radians(robot.azimuth_deg) + turns
    strokes[:, SPEED] = robot.speed_min
    free = replace(limits, robot=replace(robot, elevation_max_deg=90.0))
    needed = raise_for_clearance(scene, free, strokes)[:, ELEVATION]
    if np.isnan(needed).all():
        raise ValueError(
            'constraints: azimuth_deg, azimuth_half_range_deg must allow a direction in which the '
            f'cue has clearance, got {robot.azimuth_deg:g} and {robot.azimuth_half_range_deg:g} '
            '(degrees)'
        )
    if np.nanmin(needed) > limits.elevations[1]:
        raise ValueError(
            'constraints: elevation_max_deg must be at least '
            f'{math.degrees(np.nanmin(needed)):.3g} beside the obstacles around the cue ball and '
            f'with the errors of strokes, got {robot.elevation_max_deg:g} (degrees)'
        )


Flags: TypeAlias = NDArray[np.bool_]


class Target(ABC, CheckedRecord):
    """
    What a plan has to achieve: a frozen dataclass below this class, see targets.py.

    A target that is judged by outcomes alone needs no more than its fields and `penalties`.

    Attributes
    ----------
    must_meet : bool
        Whether one of the balls that are `concerned` has to be met before any other.
    must_rest : bool
        Whether the cue ball has to rest at `point`.
    least_speed : float
        Of candidates, relative to the largest speed.
    kind : str
        Players' name for such a shot; '' if its path says it.

    """

    __slots__ = ()
    must_meet: ClassVar[bool] = False
    must_rest: ClassVar[bool] = False
    least_speed: ClassVar[float] = 0.0
    kind: ClassVar[str] = ''

    def mistakes(self, scene: Scene) -> Iterator[Mistake]:
        """Yield what does not fit a scene."""
        return iter(())

    @property
    def point(self) -> Place | None:
        """The point that the cue ball has to reach, if there is one [m]."""
        return None

    @property
    def passing_within(self) -> float:
        """Largest distance from `point` in passing [m]; 0 if the cue ball need not pass it."""
        return 0.0

    @property
    def pocket(self) -> tuple[str, ...]:
        """Names of the pockets into which a ball that is `concerned` has to fall."""
        return ()

    @property
    def leave(self) -> Place | None:
        """The point near which the cue ball has to rest after a pot, if there is one [m]."""
        return None

    def concerns(self, ball: str) -> bool:
        """Whether a ball is to be potted, or to be met first."""
        return False

    def push(self, there: Array) -> Array | None:
        """Direction in which a ball at a place (2,) [m] has to be pushed; None: any."""
        return None

    @abstractmethod
    def penalties(self, problem: Problem, played: BatchRecording, fouls: Flags) -> Array:
        """
        Return penalties (n,) of n tables that were played, see `Outcomes`.

        `fouls` (n,) cost `PENALTY_STEP` more; they need no closer look.
        """

    def miss_in_words(self, penalty: float) -> str:
        """Say how far a stroke with a penalty below 1 misses."""
        return f'{1e3 * penalty:.0f} mm'

    def judged_at_rest(self, places: Mapping[str, Place]) -> tuple[bool, str]:
        """Judge by the places [m] of the balls that are left; return whether, and a sentence."""
        if CUE_BALL not in places:
            return False, 'not reached: the cue ball is not on the table'
        return self.judge(places)

    def judge(self, places: Mapping[str, Place]) -> tuple[bool, str]:
        """Judge by the places [m] of the cue ball and others."""
        return True, 'not judged: the balls at rest do not show whether it was reached'


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Scene, target and limits, in the form that batches of strokes need."""

    scene: Scene
    target: Target
    limits: Limits
    noise: Noise
    prepared: PreparedScene
    half_sizes: tuple[float, float]  # m, of the area of ball centres, along and across
    places: Array  # (balls, 2) m
    balls: tuple[int, ...]  # indices of the balls to be potted, or of those to be met first
    pockets: NDArray[np.int64]  # pockets into which the balls may fall
    rules: NDArray[np.void]  # (balls,) BallRule; none is `sought`
    holes: Array  # (POCKETS, 2) m
    sigmas: Array  # (5,) of a, b (ball radii), elevation, azimuth (rad), speed (m/s)

    @property
    def model(self) -> StrikeModel:
        """The numbers that a strike depends on."""
        return self.prepared.model

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all balls, the cue ball first."""
        return self.prepared.names

    @property
    def radius(self) -> float:
        """Radius of the balls [m]."""
        return self.model.surface.radius

    @property
    def cue_ball(self) -> Array:
        """Position of the cue ball (2,) [m]."""
        return self.places[0]

    def may_meet(self, ball: int) -> bool:
        """Whether the cue ball may meet a ball before any other."""
        return not self.rules['barred'][ball]

    def fouls(self, played: BatchRecording) -> Flags:
        """
        Find the tables (n,) with a foul.

        A ball left the table, one that must stay fell, the wrong ball or none was met first, or
        the cue hit the cue ball twice (WPA, Rules of Play, 6.7).
        """
        motion, met = played.balls['motion'], played.balls['first_contact'][:, 0]
        gone = (motion == LEFT_TABLE) | ((motion == POCKETED) & self.rules['must_stay'])
        nothing_is_foul = self.target.must_meet or bool(self.limits.first_contact)
        wrong = np.where(met == NOTHING, nothing_is_foul, self.rules['barred'][met])
        found: Flags = played.tables['double_hit'] | gone.any(axis=1) | wrong
        return found


def problem_of(scene: Scene, target: Target, limits: Limits, noise: Noise) -> Problem:
    """Make the planning problem of a scene and a target."""
    prepared = prepared_scene(scene)
    names, places = prepared.names, prepared.starts['position'][0, :, :2].copy()
    layout = layout_of(prepared.model.surface, prepared.table)
    rules: NDArray[np.void] = ROWS.records(BallRule, len(names))
    rules['must_stay'] = [name == names[0] or name in limits.keep for name in names]
    if limits.first_contact:
        rules['barred'] = [name not in limits.first_contact for name in names]
    kept = limits.keep if target.pocket else ()
    concerned = [each != names[0] and each not in kept and target.concerns(each) for each in names]
    if target.must_meet:
        rules['barred'][~np.array(concerned)] = True
    holes = np.zeros((POCKETS, 2))
    if layout.pockets:
        holes[:] = [(hole.hole_x, hole.hole_y) for hole in layout.pockets]
    return Problem(
        scene,
        target,
        limits,
        noise,
        prepared,
        (layout.numbers.centre_half_length, layout.numbers.centre_half_width),
        places=places,
        balls=tuple(np.flatnonzero(concerned).tolist()),
        pockets=np.array([POCKET_NAMES.index(each) for each in target.pocket], np.int64),
        rules=rules,
        holes=holes,
        sigmas=noise.sigmas(scene.ball.radius),
    )


NEAR_SIGMAS = 12.0
"""Balls that are farther apart than this number of standard deviations never overlap."""


def draw_places(problem: Problem, draw: np.random.Generator, count: int) -> Array | None:
    """Draw where the balls really lie, see `places_around`; None if their places are exact."""
    sigma = problem.noise.balls
    if not sigma:
        return None
    half = np.array(problem.half_sizes)
    return places_around(problem.places, sigma, half, problem.radius, draw, count)


def places_around(
    believed: Array,
    sigma: float,
    half: Array,
    radius: float,
    draw: np.random.Generator,
    count: int,
) -> Array:
    """
    Draw where balls really lie.

    Balls that overlap are moved apart along the line of their centres, by the same distance each.
    If some overlap even then, all balls of that table lie where they are believed to lie.

    Parameters
    ----------
    believed : (balls, 2) float array
        Where they are believed to lie [m].
    sigma : float
        Standard deviation in each direction [m].
    half : (2,) float array
        Largest coordinates [m].
    radius : float
        Of the balls [m].
    draw : numpy.random.Generator
    count : int
        Number of tables.

    Returns
    -------
    (count, balls, 2) float array

    """
    places = believed + sigma * draw.standard_normal((count, *believed.shape))
    places = np.clip(places, -half, half)
    apart = 2.0 * radius
    near = [
        (i, k)
        for i, k in combinations(range(len(believed)), 2)
        if np.hypot(*(believed[i] - believed[k])) < apart + NEAR_SIGMAS * sigma
    ]
    for i, k in near:
        way = places[:, k] - places[:, i]
        distance = np.hypot(way[:, 0], way[:, 1])
        push = 0.5 * np.maximum(apart - distance, 0.0) / np.maximum(distance, 1e-9)
        places[:, i] -= push[:, np.newaxis] * way
        places[:, k] += push[:, np.newaxis] * way
    for i, k in near:
        way = places[:, k] - places[:, i]
        places[np.hypot(way[:, 0], way[:, 1]) < apart - 1e-9] = believed
    return places


def for_each(strokes: int, places: Array | None) -> Array | None:
    """Repeat drawn places for each of a number of strokes."""
    return None if places is None else np.tile(places, (strokes, 1, 1))


def as_struck(problem: Problem, strokes: Array, places: Array) -> Array:
    """
    Find strokes (n, 5) relative to the cue balls that they meet.

    The contact point moves less than the cue ball does, because the tip is round.

    Parameters
    ----------
    problem : Problem
    strokes : (n, 5) float array
        Relative to the place where the cue ball is believed to be.
    places : (n, balls, 2) float array
        Of the balls [m].

    """
    met = strokes.copy()
    _, _, elevation, azimuth, _ = strokes.T
    x, y = (places[:, 0] - problem.cue_ball).T / tip_reach(problem.model)
    met[:, 0] -= x * np.sin(azimuth) - y * np.cos(azimuth)
    met[:, 1] -= (x * np.cos(azimuth) + y * np.sin(azimuth)) * np.sin(elevation)
    return met


def tables_at(problem: Problem, places: Array) -> TableStates:
    """Make tables whose balls lie at places (n, balls, 2) [m]."""
    height = np.full((*places.shape[:2], 1), problem.radius)
    return TableStates(problem.names, np.concatenate([places, height], axis=2))
