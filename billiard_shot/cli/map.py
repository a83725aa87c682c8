"""`billiard-shot map`: success probability of a pot from everywhere on the table."""

import argparse
from dataclasses import replace
import os
from pathlib import Path

import numpy as np

from billiard_shot import Scene
from billiard_shot.cli.output import (
    add_format_arguments,
    Column,
    print_rows,
    reporting,
    wants_text,
)
from billiard_shot.cli.shots import (
    add_scene_argument,
    add_search_arguments,
    scene_name,
    selected_noise,
)
from billiard_shot.cli.workers import add_work_arguments, working
from billiard_shot.pictures.plan import draw_success_map, map_in_words
from billiard_shot.planning.success_map import MAP_BUDGET, success_map, USUAL_GRID
from billiard_shot.table.run.results import POCKET_NAMES

MAP_COLUMNS = tuple(map(Column, ('x', 'y', 'success', 'low', 'high')))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, ball, places, search, workers and output."""
    add_scene_argument(parser)
    add = parser.add_argument
    add('--ball', required=True, metavar='NAME', help='ball to be potted')
    add('--ball-at', type=float, nargs=2, metavar=('X', 'Y'), help='its place in metres')
    pockets = 'pocket for the ball, may be repeated (default: any)'
    add('--pocket', action='append', choices=['any', *POCKET_NAMES], help=pockets)
    usual = 'x'.join(map(str, USUAL_GRID))
    places = f'places of the cue ball along length and width of the table (default: {usual})'
    add('--grid', type=_grid, default=USUAL_GRID, metavar='NxM', help=places)
    add('--picture', type=Path, metavar='FILE.png', help='draw the map')
    add_search_arguments(parser, MAP_BUDGET, ' for each place')
    add_work_arguments(parser, os.cpu_count() or 1)
    add_format_arguments(parser)


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


def _grid(text: str) -> tuple[int, int]:
    try:
        along, across = (int(each) for each in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'must be two whole numbers, such as 24x12, got {text!r}'
        ) from None
    return along, across
