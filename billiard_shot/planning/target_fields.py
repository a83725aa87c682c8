"""Fields of targets, and checks of targets against scenes."""

from collections.abc import Iterator
import dataclasses
import math
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.scene.errors import Mistake, must_be, must_be_one_of, refused, suggestion
from billiard_shot.scene.fields import name, one_or_many, point, TAKES
from billiard_shot.scene.placement import CUE_BALL, lying, no_place, Place
from billiard_shot.table.run.results import POCKET_NAMES

ANY = 'any'


def segment_field() -> Any:
    """Make a field for two different points."""
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


def needs_pockets(scene: Scene, key: str) -> Iterator[Mistake]:
    """Yield a mistake if the table of a scene has no pockets."""
    if scene.table is None or not scene.table.pockets:
        yield Mistake((key,), 'needs a table with pockets; the scene has none')


def balls_there(scene: Scene, key: str, balls: tuple[str, ...]) -> Iterator[Mistake]:
    """Yield a mistake for each ball, but `any`, that is not an object ball of a scene."""
    if not scene.object_balls:
        yield Mistake((key,), 'needs a ball; the scene has only the cue ball')
        return
    for ball in balls:
        if ball != ANY:
            yield from ball_there(scene, key, ball)


def ball_there(scene: Scene, key: str, ball: str) -> Iterator[Mistake]:
    """Yield a mistake if a ball is not an object ball of a scene."""
    if ball == CUE_BALL:
        yield Mistake((key,), f'must be another ball, got {ball!r}')
    elif ball not in scene.object_balls:
        yield Mistake((key,), must_be_one_of(scene.object_balls, ball, 'ball'))


def on_table(scene: Scene, key: str, place: Place) -> Iterator[Mistake]:
    """Yield a mistake if a place [m] is not on the table."""
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


def cue_ball_fits(
    scene: Scene, key: str, place: Place, radius: float, gone: tuple[str, ...] = ()
) -> Iterator[Mistake]:
    """Mistakes of a point from which the centre of the cue ball may be at most `radius` away."""
    off = list(on_table(scene, key, place))
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
