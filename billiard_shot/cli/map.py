"""`billiard-shot map`: success probability of a pot from everywhere on the table."""

import argparse
from dataclasses import dataclass, replace
import os
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from billiard_shot import Scene
from billiard_shot.cli.options import option
from billiard_shot.cli.output import Column, OfFormat, print_rows, reporting, wants_text
from billiard_shot.cli.shots import OfNoise, OfScene, scene_name, selected_noise
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.pictures.plan import draw_success_map, map_in_words
from billiard_shot.planning.success_map import MAP_BUDGET, success_map, USUAL_GRID
from billiard_shot.scene.fields import whole_number
from billiard_shot.table.run.results import POCKET_NAMES

MAP_COLUMNS = tuple(map(Column, ('x', 'y', 'success', 'low', 'high')))


def _grid(text: str) -> tuple[int, int]:
    try:
        along, across = (int(each) for each in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'must be two whole numbers, such as 24x12, got {text!r}'
        ) from None
    return along, across


@dataclass(frozen=True)
class OfMap:
    """
    The ball, and the places of the cue ball.

    Parameters
    ----------
    ball : NAME
        Ball to be potted.
    ball_at : X Y
        Its place in metres.
    pocket : str
        Pocket for the ball, may be repeated (default: any).
    grid : NxM
        Places of the cue ball along length and width of the table (default: %(USUAL)s).
    picture : FILE.png
        Draw the map.

    """

    USUAL: ClassVar = 'x'.join(map(str, USUAL_GRID))
    ball: str = option(required=True)
    ball_at: tuple[float, float] | None = None
    pocket: list[str] | None = option(action='append', nargs=None, choices=['any', *POCKET_NAMES])
    grid: Any = option(default=USUAL_GRID, type=_grid)
    picture: Path | None = None


@dataclass(frozen=True)
class OfPlaceSearch(OfNoise):
    """
    The search from each place.

    Parameters
    ----------
    budget : N
        Largest number of simulated strokes for each place (default: %(default)d).

    """

    TITLE: ClassVar = 'search'
    budget: int = whole_number(minimum=1, default=MAP_BUDGET)


OPTIONS = OfScene(), OfMap(), OfPlaceSearch(), OfWork(os.cpu_count() or 1), OfFormat()


def run(options: argparse.Namespace) -> int:
    """Plan from all places; print what came out, or a row for each place."""
    scene = Scene.load(scene_name(options))
    if options.ball_at:
        balls = {**scene.balls, options.ball: tuple(options.ball_at)}
        scene = replace(scene, balls=balls, rack=None)
    with (
        working(options.workers, options.dask) as executor,
        reporting('places', options.grid[0] * options.grid[1]) as report,
    ):
        made = success_map(
            scene,
            options.ball,
            options.grid,
            pocket=options.pocket or 'any',
            noise=selected_noise(options, scene),
            budget=options.budget,
            seed=options.seed,
            executor=executor,
            report=report,
        )
    if wants_text(options):
        print(map_in_words(made))
    else:
        x, y = np.meshgrid(made.x, made.y)
        columns = (each.ravel().tolist() for each in (x, y, made.success, made.low, made.high))
        keys = [column.key for column in MAP_COLUMNS]
        rows = [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)]
        print_rows(MAP_COLUMNS, [row for row in rows if row['success'] >= 0.0], options)
    if options.picture:
        draw_success_map(made, options.picture)
    return 0
