"""`billiard-shot study laws`: compare impact laws, and find their discontinuities."""

import argparse
from functools import partial
from pathlib import Path

from billiard_shot import Scene, Stroke
from billiard_shot.cli.progress import progress
from billiard_shot.cli.shots import add_scene_argument, scene_name
from billiard_shot.cli.text_table import add_format_arguments, Column, print_rows, wants_text
from billiard_shot.cli.workers import add_work_arguments, mapped
from billiard_shot.shot.stroke_options import (
    add_stroke_arguments,
    strokes_from_options,
    strokes_given,
)


def _places(found: list[tuple[float, float]], values: int) -> str:
    """Text of places and sizes; a sweep finds only what lies between values that differ."""
    places = ', '.join(f'{place:.6g} ({size:.2g})' for place, size in found)
    return places or f'none found at these {values} values'


LAW_SWEEPS = (
    Column('stroke'),
    Column('varied', 'varied'),
    Column('law', 'law'),
    Column('from', 'from', '', '{:.3g}'.format),
    Column('to', 'to', '', '{:.3g}'.format),
    Column('discontinuities'),
    Column('values'),
    Column('found', 'discontinuous at', '(size / cue speed)'),
)
COUNTS = (
    Column('law', 'law'),
    Column('discontinuities', 'discontinuities'),
    Column('wedging', 'where the tip can wedge'),
    Column('largest', 'largest / cue speed', '', '{:.2g}'.format),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, stroke and picture."""
    add_scene_argument(parser, 'paper')
    parser.add_argument(
        '--count',
        type=int,
        default=201,
        metavar='N',
        help='number of values of each varied parameter (default: %(default)d)',
    )
    parser.add_argument(
        '--random',
        type=int,
        default=0,
        metavar='N',
        help='count the discontinuities around N random strokes instead (--workers, --dask)',
    )
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw the outcomes')
    add_stroke_arguments(parser)
    add_format_arguments(parser)
    add_work_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Compare, print, draw."""
    import numpy as np

    from billiard_shot.study import laws
    from billiard_shot.study.reproduction import PRINTED

    about = scene_name(options)
    scene = Scene.load(about)
    if options.count < 2:
        raise ValueError(f'--count must be at least 2, got {options.count}')
    if options.random < 0:
        raise ValueError(f'--random must be at least 0, got {options.random}')
    if options.random and (strokes_given(options) or options.picture):
        raise ValueError('--random must not be given together with a stroke or --picture')
    if options.random:
        return _count(scene, about, options)
    massé, _ = PRINTED['massé']
    strokes = (
        strokes_from_options(options, scene)
        if strokes_given(options)
        else {'massé at 3 m/s': Stroke(massé.normal, 3.0 / massé.speed * np.array(massé.velocity))}
    )
    if len(strokes) > 1 and options.picture:
        raise ValueError(f'--picture must be given with one stroke, got {len(strokes)}')
    for name, stroke in strokes.items():
        sweeps = list(laws.sweeps(scene, stroke, options.count))
        discontinuities = {
            (sweep.name, way): laws.discontinuities(sweep.outcome(way), sweep.values)
            for sweep, way in progress(
                [(sweep, way) for sweep in sweeps for way in laws.COMPARED_LAWS], 'discontinuities'
            )
        }
        rows = []
        for (varied, way), found in discontinuities.items():
            values = next(sweep.values for sweep in sweeps if sweep.name == varied)
            places = [(each.place, each.size) for each in found]
            rows.append(
                {
                    'stroke': name,
                    'varied': varied,
                    'law': way,
                    'from': values[0],
                    'to': values[-1],
                    'discontinuities': places,
                    'values': len(values),
                }
                | ({'found': _places(places, len(values))} if wants_text(options) else {})
            )
        if wants_text(options):
            print(f'stroke {name}, scene {about}\n')
        print_rows(LAW_SWEEPS, rows, options)
        if options.picture:
            from billiard_shot.pictures.laws import draw_laws

            pairs = [(sweep, way) for sweep in sweeps for way in laws.WAYS]
            distances = {
                (sweep.name, way): sweep.distances(way)
                for sweep, way in progress(pairs, 'outcomes')
            }
            draw_laws(
                sweeps,
                distances,
                discontinuities,
                options.picture,
                f'stroke {name}, scene {about}',
            )
    return 0


def _around(scene: Scene, count: int, stroke: Stroke) -> tuple[int, list[tuple[str, bool, float]]]:
    """Find the discontinuities around a stroke: number of sweeps; law, wedging, size of each."""
    from billiard_shot.study import laws

    sweeps = list(laws.sweeps(scene, stroke, count))
    return len(sweeps), [
        (law, laws.wedges(sweep.problem(each.place, law)), each.size)
        for sweep in sweeps
        for law in laws.COMPARED_LAWS
        for each in laws.discontinuities(sweep.outcome(law), sweep.values)
    ]


def _count(scene: Scene, about: str, options: argparse.Namespace) -> int:
    from billiard_shot.study import laws

    strokes = laws.random_strokes(options.random, seed=1)
    searches = mapped(options, partial(_around, scene, options.count), strokes)
    found = {law: [0, 0, 0.0] for law in laws.COMPARED_LAWS}
    sweeps = 0
    for number, discontinuities in progress(searches, 'discontinuities', len(strokes)):
        sweeps += number
        for law, wedging, size in discontinuities:
            row = found[law]
            row[0] += 1
            row[1] += wedging
            row[2] = max(row[2], size)
    if wants_text(options):
        print(
            f'scene {about}: {sweeps} sweeps through {options.random} random strokes, '
            f'{options.count} values each\n'
        )
    print_rows(
        COUNTS,
        [
            {'law': law, 'discontinuities': row[0], 'wedging': row[1], 'largest': row[2]}
            for law, row in found.items()
        ],
        options,
    )
    return 0
