"""The request of an atlas: balls to be potted, positions of the balls, and the player."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from __future__ import annotations

from collections.abc import Iterator
import dataclasses
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, ClassVar

from billiard_shot.planning.targets import pocket_field
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.checks import check
from billiard_shot.scene.errors import InputError, Mistake, must_be, must_be_one_of, refused
from billiard_shot.scene.fields import point, section, TAKES, whole_number
from billiard_shot.scene.placement import CUE_BALL, no_place, too_near
from billiard_shot.scene.rack import Place
from billiard_shot.scene.values import whole

LAYOUT_BUDGET = 2000  # simulations of each layout
NORMAL_GRID = (24, 12)


def _names() -> Any:
    allowed = "the name of a ball, such as '8', or a list of different ones, without the cue ball"

    def convert(value: object) -> tuple[str, ...]:
        given = (value,) if isinstance(value, str) else value
        if (
            not isinstance(given, tuple | list)
            or not all(isinstance(each, str) and each not in ('', CUE_BALL) for each in given)
            or len(set(given)) < len(given)
        ):
            raise refused(value, allowed)
        return tuple(given)

    return dataclasses.field(default=(), metadata={TAKES: convert})


def _grid(default: tuple[int, int] | None) -> Any:
    allowed = 'two whole numbers, at least 1: along the length and along the width'

    def convert(value: object) -> tuple[int, int] | None:
        if value is None and default is None:
            return None
        if not isinstance(value, tuple | list) or len(value) != 2:
            raise refused(value, allowed)
        return whole('', value[0], 1), whole('', value[1], 1)

    return dataclasses.field(default=default, metadata={TAKES: convert})


def _points() -> Any:
    place = point().metadata[TAKES]

    def convert(value: object) -> tuple[Place, ...]:
        if not isinstance(value, tuple | list):
            raise refused(value, 'a list of points, [[x, y], ...]', unit='m')
        return tuple(place(each) for each in value)

    return dataclasses.field(default=(), metadata={TAKES: convert})


def _one_or_the_other(request: Any) -> Iterator[Mistake]:
    if request.ball_at and request.ball_grid:
        yield Mistake(('ball_grid',), 'must not be given together with ball_at')


@dataclass(frozen=True, slots=True)
class AtlasRequest:
    """
    Request of an atlas.

    Parameters
    ----------
    ball : str or sequence of str
        Balls to be potted, each in its own map; by default the only object ball of the scene.
        `ball_at` or `ball_grid` can add a ball that is not in the scene.
    pocket : str or sequence of str
        Names of the pockets into which they may fall, or `any`.
    cue_grid : (int, int)
        Number of positions of the cue ball along the length and along the width of the table:
        the centres of equal cells that fill the area of ball centres.
    ball_grid : (int, int), optional
        Number of positions of the ball to be potted, in the same way.
    ball_at : sequence of (x, y)
        Positions of the ball to be potted [m]. Without `ball_grid` and `ball_at` it has its
        position in the scene.
    noise : Noise, optional
        By default the scene's.
    budget : int
        Largest number of simulated strokes for each layout, at least 1. The search needs some
        hundreds.
    seed : int
        At least 0. The random numbers of a layout depend only on the seed and the layout.

    Raises
    ------
    ValueError
        Naming every wrong field, its value and what is allowed.

    """

    RULES: ClassVar = (_one_or_the_other,)
    ball: tuple[str, ...] = _names()
    pocket: tuple[str, ...] = pocket_field()
    cue_grid: tuple[int, int] = _grid(NORMAL_GRID)
    ball_grid: tuple[int, int] | None = _grid(None)
    ball_at: tuple[Place, ...] = _points()
    noise: Noise | None = section(Noise, nullable=True)
    budget: int = whole_number(minimum=1, default=LAYOUT_BUDGET)
    seed: int = whole_number(minimum=0, default=1)

    def __post_init__(self) -> None:
        check(self)


def with_defaults(scene: Scene, request: AtlasRequest) -> AtlasRequest:
    """
    Complete a request with the defaults of the scene.

    Raises
    ------
    ValueError
        If the request does not fit the scene.

    """
    full = replace(
        request,
        ball=request.ball or tuple(scene.object_balls),
        noise=request.noise or scene.noise,
    )
    mistakes = [*_no_pockets(scene), *_wrong_balls(scene, request), *_wrong_positions(scene, full)]
    if mistakes:
        raise InputError(mistakes, 'atlas')
    return full


def _no_pockets(scene: Scene) -> Iterator[Mistake]:
    if scene.table is None or not scene.table.pockets:
        yield Mistake(('pocket',), 'needs a table with pockets; the scene has none')


def _wrong_balls(scene: Scene, request: AtlasRequest) -> Iterator[Mistake]:
    there = scene.object_balls
    if not request.ball and len(there) != 1:
        scene_has = ', '.join(there) or 'only the cue ball; ball_at or ball_grid put one there'
        yield Mistake(('ball',), f'is missing; the scene has {scene_has}')
    if not request.ball_at and not request.ball_grid:
        for name in request.ball:
            if name not in there:
                text = must_be_one_of(there, name, 'ball')
                yield Mistake(('ball',), f'{text}; ball_at or ball_grid put one there')


def _wrong_positions(scene: Scene, request: AtlasRequest) -> Iterator[Mistake]:
    for place in request.ball_at if scene.table else ():
        if why := no_place(scene.table, *place, scene.ball.radius):
            yield Mistake(('ball_at',), must_be(why, place, 'm'))
        for ball, (other, there) in product(request.ball, scene.balls.items()):
            why = too_near(place, other, there, scene.ball.radius)
            if why and other not in (ball, CUE_BALL):
                yield Mistake(('ball_at',), f'must put ball {ball!r} {why}, got {place} (m)')
