"""`billiard-shot atlas`: how surely a target is reached from where."""
import argparse
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
import os
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot import Scene
from billiard_shot.cli.layout import table
from billiard_shot.cli.progress import reporting
from billiard_shot.planning.atlas import Chart, compute_atlas
from billiard_shot.planning.plan import NOISES
from billiard_shot.study.atlas_picture import draw_atlas
from billiard_shot.study.pictures import require_matplotlib

HELP = 'how surely a ball is potted, over a grid of places of the cue ball and of the ball'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Scene, ball, grid, work."""
    parser.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    parser.add_argument('--pot', default='8', metavar='BALL',
                        help='ball that is put everywhere and to be potted (%(default)s)')
    parser.add_argument('--pocket', default='any', help='(%(default)s)')
    parser.add_argument('--grid', type=int, nargs=2, default=(6, 3), metavar=('COLUMNS', 'ROWS'),
                        help='places along and across the table, for each of the balls (6 3)')
    parser.add_argument('--noise', default='tournament', choices=[*NOISES], help='(%(default)s)')
    parser.add_argument('--budget', type=int, default=3000, metavar='N',
                        help='most strokes simulated for each pair of places (%(default)d)')
    parser.add_argument('--seed', type=int, default=1, metavar='N', help='(%(default)d)')
    parser.add_argument('--file', type=Path, default=Path('atlas.jsonl'), metavar='FILE',
                        help='keeps what is done; an atlas that is there already goes on '
                             '(%(default)s)')
    parser.add_argument('--dask', metavar='ADDRESS',
                        help='of the scheduler of a Dask cluster that does the work; `local` '
                             'starts one here (needs the extra dask)')
    parser.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                        help='processes here (%(default)d)')
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw it')


def run(options: argparse.Namespace) -> int:
    """Compute, print, draw."""
    if options.picture:
        require_matplotlib()  # before the work, not after it
    scene = Scene.load(options.scene)
    balls = {options.pot: (0.0, 0.0), **scene.balls}
    scene = Scene.from_dict({**scene.to_dict(), 'balls': balls})
    chart = Chart(
        scene, {'pot': options.pot, 'pocket': options.pocket}, options.pot, options.grid[0],
        options.grid[1], NOISES[options.noise], options.budget, options.seed,
    )
    total = len(chart.places) ** 2
    with _executor(options) as executor, reporting('places', total) as report:
        chances = compute_atlas(chart, executor, options.file, report)
    by_ball = np.array([_mean(row) for row in chances]).reshape(options.grid)
    print('Mean chance in %, over the places of the cue ball, with the ball at')
    x = [place[0] for place in chart.places[:: options.grid[1]]]
    y = [place[1] for place in chart.places[: options.grid[1]]]
    rows = [('y (m)', 'x (m)', *(f'{each:+.2f}' for each in x))]
    rows += [(f'{y[j]:+.2f}', '', *(f'{100.0 * each:5.1f}' for each in by_ball[:, j]))
             for j in reversed(range(len(y)))]
    print(table(rows))
    print(f'{np.isfinite(chances).sum()} pairs of places, in {options.file}')
    if options.picture:
        draw_atlas(chart, chances, options.picture)
    return 0


def _mean(chances: Any) -> float:
    known = chances[np.isfinite(chances)]
    return float(known.mean()) if len(known) else float('nan')


def _executor(options: argparse.Namespace) -> AbstractContextManager[Any]:
    """Start processes here, or a Dask cluster, or find one."""
    if options.workers < 1:
        raise ValueError(f'--workers: {options.workers} is not allowed; it must be at least 1')
    if options.dask is None:
        return ProcessPoolExecutor(options.workers)
    try:
        import distributed
    except ImportError:
        raise ValueError(
            "--dask: needs an extra: pip install 'billiard_shot[dask]'"
        ) from None
    library: Any = distributed  # it has no types
    where: Any = options.dask
    if where == 'local':
        where = library.LocalCluster(
            n_workers=options.workers, threads_per_worker=1, dashboard_address=None
        )
    client: AbstractContextManager[Any] = library.Client(where)
    return client
