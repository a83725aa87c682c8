"""`billiard-shot laws`: compare impact laws, and find their discontinuities."""

import argparse
from pathlib import Path

from billiard_shot import Scene, Stroke
from billiard_shot.cli.progress import progress, wait_for_machine_code
from billiard_shot.cli.text_table import table
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of

HELP = 'compare the outcomes of impact laws, and find where they are discontinuous'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, stroke and picture."""
    parser.add_argument(
        'scene',
        nargs='?',
        default='paper',
        metavar='SCENE',
        help='bundled scene or YAML file (default: %(default)s)',
    )
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
        help='count the discontinuities around N random strokes instead',
    )
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw the outcomes')
    add_stroke_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Compare, print, draw."""
    wait_for_machine_code()
    import numpy as np

    from billiard_shot.study import laws
    from billiard_shot.study.accuracy import PAPER_STROKES

    scene = Scene.load(options.scene)
    if options.count < 2:
        raise ValueError(f'--count: {options.count} is not allowed; it must be at least 2')
    if options.random:
        return _count(scene, options)
    massé = PAPER_STROKES['massé']
    strokes = (
        strokes_of(options, scene)
        if strokes_given(options)
        else {'massé at 3 m/s': Stroke(massé.normal, 3.0 / massé.speed * np.array(massé.velocity))}
    )
    if len(strokes) > 1 and options.picture:
        raise ValueError('--picture: is not allowed with several strokes; give one')
    for name, stroke in strokes.items():
        sweeps = list(laws.sweeps(scene, stroke, options.count))
        discontinuities = {
            (sweep.name, way): laws.discontinuities(sweep.outcome(way), sweep.values)
            for sweep, way in progress(
                [(sweep, way) for sweep in sweeps for way in laws.LAWS], 'discontinuities'
            )
        }
        rows = [('varied', 'law', 'from', 'to', 'discontinuous at', 'size / cue speed')]
        for (varied, way), found in discontinuities.items():
            values = next(sweep.values for sweep in sweeps if sweep.name == varied)
            rows.append(
                (
                    varied,
                    way,
                    f'{values[0]:.3g}',
                    f'{values[-1]:.3g}',
                    ' '.join(f'{discontinuity.place:.6g}' for discontinuity in found) or 'none',
                    ' '.join(f'{discontinuity.size:.2g}' for discontinuity in found),
                )
            )
        print(f'stroke {name}, scene {options.scene}\n')
        print(table(rows))
        if options.picture:
            from billiard_shot.pictures.laws import draw

            pairs = [(sweep, way) for sweep in sweeps for way in laws.WAYS]
            distances = {
                (sweep.name, way): sweep.distances(way)
                for sweep, way in progress(pairs, 'outcomes')
            }
            draw(
                sweeps,
                distances,
                discontinuities,
                f'stroke {name}, scene {options.scene}',
                options.picture,
            )
    return 0


def _count(scene: Scene, options: argparse.Namespace) -> int:
    from billiard_shot.study import laws

    pairs = [
        (sweep, law)
        for stroke in laws.random_strokes(options.random, seed=1)
        for sweep in laws.sweeps(scene, stroke, options.count)
        for law in laws.LAWS
    ]
    found = {law: [0, 0, 0.0] for law in laws.LAWS}
    for sweep, law in progress(pairs, 'discontinuities'):
        for discontinuity in laws.discontinuities(sweep.outcome(law), sweep.values):
            row = found[law]
            row[0] += 1
            row[1] += laws.wedges(sweep.problem(discontinuity.place, law))
            row[2] = max(row[2], discontinuity.size)
    sweeps = len(pairs) // len(laws.LAWS)
    print(
        f'scene {options.scene}: {sweeps} sweeps through {options.random} random strokes, '
        f'{options.count} values each\n'
    )
    rows = [('law', 'discontinuities', 'where the tip can wedge', 'largest / cue speed')]
    rows += [(law, str(row[0]), str(row[1]), f'{row[2]:.2g}') for law, row in found.items()]
    print(table(rows))
    return 0
