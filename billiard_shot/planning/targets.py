"""Targets of a plan, as people state them, checked against the scene; reached at rest or not."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)

from __future__ import annotations

from collections.abc import Iterator, Mapping
import dataclasses
from dataclasses import dataclass
import math
from typing import Any, TypeAlias

from billiard_shot.scene import Scene
from billiard_shot.scene.errors import (
    InputError,
    Mistake,
    must_be,
    must_be_one_of,
    refused,
    suggestion,
    unknown,
)
from billiard_shot.scene.fields import (
    check,
    name,
    number,
    one_or_many,
    point,
    read,
    TAKES,
    whole_number,
)
from billiard_shot.scene.placement import CUE_BALL, lying, no_place, Place
from billiard_shot.table.run.results import POCKET_NAMES

ANY = 'any'


def _segment() -> Any:
    ends = point().metadata[TAKES]

    def convert(value: object) -> tuple[Place, Place]:
        try:
            found = tuple(ends(each) for each in value)  # type: ignore[attr-defined]
            begin, end = found
        except (TypeError, ValueError):
            raise refused(value, 'two points, ((x1, y1), (x2, y2))', unit='m') from None
        if begin == end:
            raise refused(value, 'two different points', unit='m')
        return begin, end

    return dataclasses.field(metadata={TAKES: convert})


def pocket_field() -> Any:
    """Make a field for the name of a pocket, a list of names, or `any`; its value is a tuple."""
    allowed = f'{ANY}, or of {", ".join(POCKET_NAMES)} one or a list'

    def convert(value: object) -> tuple[str, ...]:
        names, known = one_or_many(value), (ANY, *POCKET_NAMES)
        wrong = [each for each in names if not isinstance(each, str) or each not in known]
        if wrong or not names:
            hint = suggestion(known, wrong[0]) if wrong else ''
            raise refused(value, allowed, hint=hint)
        return tuple(pocket for pocket in POCKET_NAMES if pocket in names or ANY in names)

    return dataclasses.field(default=ANY, metadata={TAKES: convert})


def balls_field(default: str | None = None) -> Any:
    """Make a field for the name of a ball, a list of names, or `any`; its value is a tuple."""
    one = name().metadata[TAKES]

    def convert(value: object) -> tuple[str, ...]:
        names = one_or_many(value)
        if not names:
            raise refused(value, "a name, such as '8', a list of names, or any")
        return tuple(dict.fromkeys(one(each) for each in names))

    fallback: Any = dataclasses.MISSING if default is None else default
    return dataclasses.field(default=fallback, metadata={TAKES: convert})


@dataclass(frozen=True, slots=True)
class Rest:
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

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Pass:
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

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Gate:
    """
    The centre of the cue ball has to pass between two points.

    Parameters
    ----------
    gate : ((x1, y1), (x2, y2))
        [m]

    """

    gate: tuple[Place, Place] = _segment()

    def __post_init__(self) -> None:
        check(self)


def _one_way_to_hit(hit: Any) -> Iterator[Mistake]:
    if hit.direction is not None and hit.at is not None:
        yield Mistake(('at',), 'must not be given together with direction')
    if hit.direction is not None and math.hypot(*hit.direction) == 0.0:
        yield Mistake(('direction',), f'must not be zero, got {hit.direction!r}')


@dataclass(frozen=True, slots=True)
class Hit:
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

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Pot:
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

    pot: tuple[str, ...] = balls_field()
    pocket: tuple[str, ...] = pocket_field()
    leave: Place | None = point(nullable=True)
    radius: float = number('m', above=0, default=0.1)

    def __post_init__(self) -> None:
        check(self)

    def wants(self, ball: str) -> bool:
        """Whether a ball, other than the cue ball, is one of those to be potted."""
        return ANY in self.pot or ball in self.pot


@dataclass(frozen=True, slots=True)
class Safe:
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

    safe: tuple[str, ...] = balls_field()
    against: tuple[str, ...] = balls_field(default=ANY)
    chance: float = number('', minimum=0, maximum=1, default=0.2)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Break:
    """
    Balls have to fall, and the cue ball has to stay on the table.

    Parameters
    ----------
    breaking : str or sequence of str
        Name of the ball to be met first, or of several, or `any`; `break` in a mapping.
    pots : int
        How many balls have to fall, at least 1.

    """

    breaking: tuple[str, ...] = balls_field()
    pots: int = whole_number(minimum=1, default=1)

    def __post_init__(self) -> None:
        check(self)


Target: TypeAlias = Rest | Pass | Gate | Hit | Pot | Safe | Break
KINDS: dict[str, type[Any]] = {
    'rest': Rest,
    'pass': Pass,
    'gate': Gate,
    'hit': Hit,
    'pot': Pot,
    'safe': Safe,
    'break': Break,
}
FIELDS = {'pass': 'passing', 'break': 'breaking'}  # keys that no field of Python can have


def met_first(target: Target) -> tuple[str, ...]:
    """Return the balls of which the target wants one to be met first; empty if it does not."""
    match target:
        case Hit():
            return (target.hit,)
        case Safe():
            return target.safe
        case Break():
            return target.breaking
    return ()


def target_of(scene: Scene, wanted: Target | Mapping[str, Any]) -> Target:
    """
    Read a target and check it against a scene.

    Raises
    ------
    ValueError
        Naming every field that is wrong, its value and what is allowed.

    """
    target = read_target(wanted)
    if mistakes := list(_not_in(scene, target)):
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


def _not_in(scene: Scene, target: Target) -> Iterator[Mistake]:
    match target:
        case Rest():
            yield from _place(scene, 'rest', target.rest, target.radius)
        case Pass():
            yield from _place(scene, 'pass', target.passing, target.radius)
        case Gate():
            for end in target.gate:
                yield from _on_table(scene, 'gate', end)
        case Hit():
            yield from _ball(scene, 'hit', target.hit)
            if target.at is not None:
                yield from _on_table(scene, 'at', target.at)
                if tuple(target.at) == scene.balls.get(target.hit):
                    allowed = f'beside the middle of ball {target.hit!r}'
                    yield Mistake(('at',), must_be(allowed, list(target.at), 'm'))
        case Safe():
            yield from _balls(scene, 'safe', target.safe)
            yield from _balls(scene, 'against', target.against)
            yield from _without_pockets(scene, 'safe')
        case Break():
            yield from _balls(scene, 'break', target.breaking)
            others = len(scene.object_balls)
            if target.pots > others > 0:
                yield Mistake(('pots',), must_be(f'at most {others}, the balls', target.pots))
            yield from _without_pockets(scene, 'break')
        case Pot():
            yield from _balls(scene, 'pot', target.pot)
            yield from _without_pockets(scene, 'pocket')
            if target.leave is not None:
                yield from _place(scene, 'leave', target.leave, target.radius, target.pot)


def _without_pockets(scene: Scene, key: str) -> Iterator[Mistake]:
    if scene.table is None or not scene.table.pockets:
        yield Mistake((key,), 'needs a table with pockets; the scene has none')


def _balls(scene: Scene, key: str, balls: tuple[str, ...]) -> Iterator[Mistake]:
    if not scene.object_balls:
        yield Mistake((key,), 'needs a ball; the scene has only the cue ball')
        return
    for ball in balls:
        if ball != ANY:
            yield from _ball(scene, key, ball)


def _ball(scene: Scene, key: str, ball: str) -> Iterator[Mistake]:
    if ball == CUE_BALL:
        yield Mistake((key,), f'must be another ball, got {ball!r}')
    elif ball not in scene.object_balls:
        yield Mistake((key,), must_be_one_of(scene.object_balls, ball, 'ball'))


def _on_table(scene: Scene, key: str, place: Place) -> Iterator[Mistake]:
    table = scene.table
    if table is None:
        return
    x, y = 0.5 * table.length, 0.5 * table.width
    if abs(place[0]) > x or abs(place[1]) > y:
        yield Mistake(
            (key,),
            (
                f'must be on the table, x from {-x:g} to {x:g} and y from {-y:g} to {y:g}, got '
                f'{place!r} (m)'
            ),
        )


def _place(
    scene: Scene, key: str, place: Place, radius: float, gone: tuple[str, ...] = ()
) -> Iterator[Mistake]:
    """Mistakes of a point from which the centre of the cue ball may be at most `radius` away."""
    off = list(_on_table(scene, key, place))
    if not off and (why := no_place(scene.table, *place, scene.ball.radius)):
        off = [Mistake((key,), must_be(why, place, 'm'))]
    yield from off
    for other, there in lying(scene).items():
        apart = math.dist(place, there)
        if (
            other not in (CUE_BALL, *gone)
            and ANY not in gone
            and (apart < scene.ball.radius or 2.0 * scene.ball.radius - apart > radius)
        ):
            yield Mistake(
                (key,),
                (
                    f'must be at least {2e3 * scene.ball.radius:.4g} mm from ball {other!r}, got '
                    f'{place!r}, {1e3 * apart:.4g} mm from it'
                ),
            )


def reached_at_rest(target: Target, places: Mapping[str, Place]) -> tuple[bool, str]:
    """Judge by the places [m] of the balls that are left; return whether, and a sentence."""
    if CUE_BALL not in places:
        return False, 'not reached: the cue ball is not on the table'
    wanted = target.pot if isinstance(target, Pot) and ANY not in target.pot else ()
    fallen = sorted(set(wanted) - set(places))
    if wanted and not fallen:
        return False, f'not reached: still on the table: {", ".join(wanted)}'
    match target:
        case Rest(rest=point) | Pot(leave=point) if point is not None:
            apart = math.dist(places[CUE_BALL], point)
            reached = apart <= target.radius
            return reached, (
                f'{"reached" if reached else "not reached"}: the cue ball rests '
                f'{1e3 * apart:.1f} mm from the point, {1e3 * target.radius:g} mm are allowed'
            )
    if fallen:
        return True, f'reached: pocketed: {", ".join(fallen)}'
    return True, 'not judged: the balls at rest do not show whether it was reached'
