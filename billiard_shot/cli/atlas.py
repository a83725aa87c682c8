"""`billiard-shot atlas`: success probability of pots from everywhere on the table."""

import argparse
from concurrent.futures import BrokenExecutor
import math
import os
from pathlib import Path
import sys
from time import perf_counter
from typing import Any

import numpy as np

from billiard_shot import Scene
from billiard_shot.cli.exit_codes import INTERRUPTED
from billiard_shot.cli.progress import progress
from billiard_shot.cli.search import add_search_arguments, selected_noise
from billiard_shot.cli.shots import add_scene_argument, scene_name
from billiard_shot.cli.text_table import (
    add_format_arguments,
    Column,
    numbers,
    print_rows,
    wants_text,
)
from billiard_shot.cli.workers import add_work_arguments, working
from billiard_shot.pictures.atlas import draw_atlas
from billiard_shot.planning.atlas import (
    append,
    Atlas,
    atlas,
    AtlasRequest,
    layouts_of,
    Map,
    start_file,
)
from billiard_shot.planning.atlas.request import LAYOUT_BUDGET, NORMAL_GRID
from billiard_shot.table.run import POCKET_NAMES

HIGH_SUCCESS, EVEN_SUCCESS = 0.9, 0.5


def _percent(part: float) -> str:
    return '-' if math.isnan(part) else f'{100.0 * part:.1f}'


ATLAS_COLUMNS = (
    Column('ball', 'ball'),
    Column('place', 'at x y', '(m)', lambda place: numbers(place, 3)),
    Column('layouts', 'layouts'),
    Column('success', 'success', '(%, mean)', _percent),
    Column('half_width', '95 % CI', '(±, mean)', _percent),
    Column('sure', f'>= {HIGH_SUCCESS:.0%}', '(%)', _percent),
    Column('even', f'>= {EVEN_SUCCESS:.0%}', '(%)', _percent),
    Column('none', 'no stroke', '(%)', _percent),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, balls, positions, player, search, workers and output."""
    add_scene_argument(parser)
    what = parser.add_argument_group('what')
    what.add_argument(
        '--ball',
        action='append',
        metavar='NAME',
        default=[],
        help='ball to be potted, may be repeated (default: the only one of the scene)',
    )
    what.add_argument(
        '--pocket',
        action='append',
        choices=['any', *POCKET_NAMES],
        help='pocket for the ball, may be repeated (default: any)',
    )
    where = parser.add_argument_group('where')
    where.add_argument(
        '--cue-grid',
        type=_grid,
        default=NORMAL_GRID,
        metavar='NxM',
        help='positions of the cue ball along length and width of the table '
        f'(default: {"x".join(map(str, NORMAL_GRID))})',
    )
    where.add_argument(
        '--ball-grid',
        type=_grid,
        metavar='NxM',
        help='positions of the ball to be potted (default: its position in the scene)',
    )
    where.add_argument(
        '--ball-at',
        action='append',
        type=float,
        nargs=2,
        metavar=('X', 'Y'),
        default=[],
        help='one such position, may be repeated (m)',
    )
    add_search_arguments(parser, LAYOUT_BUDGET, ' for each layout')
    add_work_arguments(parser, os.cpu_count() or 1)
    output = parser.add_argument_group('output')
    add_format_arguments(parser)
    output.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.jsonl',
        help='write a line of JSON for each layout; an existing file is continued',
    )
    output.add_argument('--picture', type=Path, metavar='FILE.png', help='draw the maps')


def run(options: argparse.Namespace) -> int:
    """Plan from all layouts and print a line for each map; ValueError for an invalid request."""
    scene = Scene.load(scene_name(options))
    request = _request(options, scene)
    layouts = layouts_of(scene, request)
    results = start_file(options.output, scene, request) if options.output else []
    done = {result.layout for result in results}
    missing = [layout for layout in layouts if layout not in done]
    start = perf_counter()
    try:
        with working(options.workers, options.dask) as executor:
            new = atlas(scene, request, missing, executor)
            for result in progress(new, 'layouts', len(missing)):
                results.append(result)
                if options.output:
                    append(options.output, result)
    except KeyboardInterrupt:
        return _stopped('interrupted', options, len(results), len(layouts), INTERRUPTED)
    except BrokenExecutor as error:
        return _stopped(f'a worker died ({error})', options, len(results), len(layouts), 1)
    made = Atlas(scene, request, results)
    print_rows(ATLAS_COLUMNS, [_row(each) for each in made.maps], options)
    again = f', {len(done)} of them from {options.output}' if done else ''
    seconds = perf_counter() - start
    simulations = sum(result.simulations for result in results[len(done) :])
    if wants_text(options):
        print(f'{len(layouts)} layouts{again}; {simulations} strokes simulated in {seconds:.1f} s')
    if options.picture:
        draw_atlas(made, options.picture)
    return 0


def _request(options: argparse.Namespace, scene: Scene) -> AtlasRequest:
    return AtlasRequest(
        ball=tuple(options.ball),
        pocket=tuple(options.pocket or ['any']),
        cue_grid=options.cue_grid,
        ball_grid=options.ball_grid,
        ball_at=tuple((x, y) for x, y in options.ball_at),
        noise=selected_noise(options, scene),
        budget=options.budget,
        seed=options.seed,
    )


def _stopped(why: str, options: argparse.Namespace, done: int, layouts: int, code: int) -> int:
    """Report an unfinished run; return its exit code."""
    kept = f'; the same command continues {options.output}' if options.output else ''
    print(f'{why}: {done} of {layouts} layouts are done{kept}', file=sys.stderr)
    return code


def _row(each: Map) -> dict[str, Any]:
    success = np.array([result.success for result in each.results])
    return {
        'ball': each.ball,
        'place': list(each.ball_place),
        'layouts': len(success),
        'success': each.mean,
        'half_width': each.mean_half_width,
        'sure': (success >= HIGH_SUCCESS).mean(),
        'even': (success >= EVEN_SUCCESS).mean(),
        'none': (success == 0.0).mean(),
    }


def _grid(text: str) -> tuple[int, int]:
    try:
        along, across = (int(each) for each in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'must be two whole numbers, such as 24x12, got {text!r}'
        ) from None
    return along, across
