"""`billiard-shot atlas`: how surely balls are potted, from everywhere on the table."""

import argparse
from concurrent.futures import BrokenExecutor
import os
from pathlib import Path
import sys
from time import perf_counter

import numpy as np

from billiard_shot import Scene
from billiard_shot.cli.layout import numbers, table
from billiard_shot.cli.progress import progress, wait_for_machine_code
from billiard_shot.cli.search import add_search_arguments, noise_of
from billiard_shot.cli.workers import LOCAL, working
from billiard_shot.pictures.atlas import draw_atlas
from billiard_shot.pictures.canvas import require_matplotlib
from billiard_shot.planning.atlas import (
    append,
    Atlas,
    atlas,
    AtlasRequest,
    begin,
    places_of,
)
from billiard_shot.planning.atlas.request import NORMAL_BUDGET, NORMAL_GRID
from billiard_shot.table.run import POCKET_NAMES

HELP = 'how surely balls are potted from where, on a map'
INTERRUPTED = 130  # exit code, as shells have it for Ctrl-C
SURE, EVEN = 0.9, 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Scene, balls, places, player, search, workers, output."""
    parser.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    what = parser.add_argument_group('what')
    what.add_argument(
        '--ball',
        action='append',
        metavar='NAME',
        default=[],
        help='to be potted, may be repeated (the only one of the scene)',
    )
    what.add_argument(
        '--pocket', action='append', choices=['any', *POCKET_NAMES], help='may be repeated (any)'
    )
    where = parser.add_argument_group('where')
    where.add_argument(
        '--cue-grid',
        type=_grid,
        default=NORMAL_GRID,
        metavar='NxM',
        help='places of the cue ball along length and width of the table '
        f'({"x".join(map(str, NORMAL_GRID))})',
    )
    where.add_argument(
        '--ball-grid',
        type=_grid,
        metavar='NxM',
        help='places of the ball that is to be potted (where the scene has it)',
    )
    where.add_argument(
        '--ball-at',
        action='append',
        type=float,
        nargs=2,
        metavar=('X', 'Y'),
        default=[],
        help='one such place, may be repeated (m)',
    )
    add_search_arguments(parser, NORMAL_BUDGET, ' for each place')
    work = parser.add_argument_group('work')
    work.add_argument(
        '--workers',
        type=int,
        default=os.cpu_count() or 1,
        metavar='N',
        help='processes that share it (%(default)d); the result is the same',
    )
    work.add_argument(
        '--dask',
        metavar='ADDRESS',
        help=f'of a Dask scheduler that has it done, or {LOCAL}: one for this run',
    )
    output = parser.add_argument_group('output')
    output.add_argument(
        '--output',
        type=Path,
        metavar='FILE.jsonl',
        help='a line of JSON for each place; what is there is not done again',
    )
    output.add_argument('--picture', type=Path, metavar='FILE.png', help='the maps')


def run(options: argparse.Namespace) -> int:
    """Plan everywhere, print a line for each map; 2 if the request makes no sense."""
    wait_for_machine_code()
    if options.picture:
        require_matplotlib()  # before the work, not after it
        if not options.picture.absolute().parent.is_dir():
            raise ValueError(f'--picture: {options.picture}: there is no such folder')
    if options.workers < 1:
        raise ValueError(f'--workers: {options.workers} is not allowed; it must be at least 1')
    scene = Scene.load(options.scene)
    request = _request(options, scene)
    places = places_of(scene, request)
    chances = begin(options.output, scene, request) if options.output else []
    done = {chance.place for chance in chances}
    missing = [place for place in places if place not in done]
    start = perf_counter()
    try:
        with working(options.workers, options.dask) as executor:
            results = atlas(scene, request, missing, executor)
            for chance in progress(results, 'places', len(missing)):
                chances.append(chance)
                if options.output:
                    append(options.output, chance)
    except KeyboardInterrupt:
        return _stopped('interrupted', options, len(chances), len(places), INTERRUPTED)
    except BrokenExecutor as error:
        return _stopped(f'a worker died ({error})', options, len(chances), len(places), 1)
    made = Atlas(scene, request, chances)
    print(_as_text(made))
    again = f', {len(done)} of them from {options.output}' if done else ''
    new = sum(chance.simulations for chance in chances[len(done) :])
    print(
        f'{len(places)} places{again}; {new} strokes simulated in {perf_counter() - start:.1f} s'
    )
    if options.picture:
        draw_atlas(made, options.picture)
    return 0


def _request(options: argparse.Namespace, scene: Scene) -> AtlasRequest:
    pockets = options.pocket or ['any']
    return AtlasRequest(
        ball=tuple(options.ball),
        pocket=POCKET_NAMES if 'any' in pockets else tuple(pockets),
        cue_grid=options.cue_grid,
        ball_grid=options.ball_grid,
        ball_at=tuple((x, y) for x, y in options.ball_at),
        noise=noise_of(options, scene),
        budget=options.budget,
        seed=options.seed,
    )


def _stopped(why: str, options: argparse.Namespace, done: int, places: int, code: int) -> int:
    """Say what is left of a run that did not come to its end."""
    kept = f'; the same command goes on with {options.output}' if options.output else ''
    print(f'{why}: {done} of {places} places are done{kept}', file=sys.stderr)
    return code


def _as_text(made: Atlas) -> str:
    rows: list[tuple[str, ...]] = [
        (
            'ball',
            'at x y',
            'places',
            'succeeds',
            '95 % sure',
            f'at least {SURE:.0%}',
            f'at least {EVEN:.0%}',
            'no stroke',
        ),
        ('', '(m)', '', '(%, mean)', '(±, mean)', *3 * ('(% of places)',)),
    ]
    for each in made.maps:
        success = np.array([chance.success for chance in each.chances])
        rows.append(
            (
                each.ball,
                numbers(each.ball_place, 3),
                str(len(success)),
                *(
                    '-' if part != part else f'{100.0 * part:.1f}'
                    for part in (
                        each.mean,
                        each.doubt,
                        (success >= SURE).mean(),
                        (success >= EVEN).mean(),
                        (success == 0.0).mean(),
                    )
                ),
            )
        )
    return table(rows)


def _grid(text: str) -> tuple[int, int]:
    try:
        along, across = (int(each) for each in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'{text!r} is not allowed; it must be two whole numbers, such as 24x12'
        ) from None
    return along, across
