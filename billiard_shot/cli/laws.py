"""`billiard-shot laws`: how the outcome depends on the law of impact, and where it jumps."""

import argparse
from pathlib import Path

from billiard_shot import Scene, Stroke
from billiard_shot.cli.layout import table
from billiard_shot.cli.progress import progress, wait_for_machine_code
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of

HELP = 'how the outcome depends on the law of impact, and where it jumps'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Scene, stroke, picture."""
    parser.add_argument(
        'scene',
        nargs='?',
        default='paper',
        metavar='SCENE',
        help='bundled scene or YAML file (%(default)s)',
    )
    parser.add_argument(
        '--count',
        type=int,
        default=201,
        metavar='N',
        help='values of each number that is varied (%(default)d)',
    )
    parser.add_argument(
        '--random',
        type=int,
        default=0,
        metavar='N',
        help='count the jumps around N random strokes instead',
    )
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw the outcomes')
    add_stroke_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Study, print, draw."""
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
        raise ValueError('--picture: shows one stroke; state one')
    for name, stroke in strokes.items():
        lines = list(laws.lines(scene, stroke, options.count))
        jumps = {
            (line.name, way): laws.jumps(line.outcome(way), line.values)
            for line, way in progress(
                [(line, way) for line in lines for way in laws.LAWS], 'jumps'
            )
        }
        rows = [('varied', 'law', 'from', 'to', 'jumps at', 'by (parts of the cue speed)')]
        for (varied, way), found in jumps.items():
            values = next(line.values for line in lines if line.name == varied)
            rows.append(
                (
                    varied,
                    way,
                    f'{values[0]:.3g}',
                    f'{values[-1]:.3g}',
                    ' '.join(f'{jump.place:.6g}' for jump in found) or 'none',
                    ' '.join(f'{jump.size:.2g}' for jump in found),
                )
            )
        print(f'stroke {name}, scene {options.scene}\n')
        print(table(rows))
        if options.picture:
            from billiard_shot.pictures.laws import draw

            pairs = [(line, way) for line in lines for way in laws.WAYS]
            distances = {
                (line.name, way): line.distances(way) for line, way in progress(pairs, 'outcomes')
            }
            draw(lines, distances, jumps, f'stroke {name}, scene {options.scene}', options.picture)
    return 0


def _count(scene: Scene, options: argparse.Namespace) -> int:
    from billiard_shot.study import laws

    pairs = [
        (line, law)
        for stroke in laws.random_strokes(options.random, seed=1)
        for line in laws.lines(scene, stroke, options.count)
        for law in laws.LAWS
    ]
    found = {law: [0, 0, 0.0] for law in laws.LAWS}
    for line, law in progress(pairs, 'jumps'):
        for jump in laws.jumps(line.outcome(law), line.values):
            row = found[law]
            row[0] += 1
            row[1] += laws.wedges(line.problem(jump.place, law))
            row[2] = max(row[2], jump.size)
    lines = len(pairs) // len(laws.LAWS)
    print(
        f'scene {options.scene}: {lines} lines through {options.random} random strokes, '
        f'{options.count} values each\n'
    )
    rows = [('law', 'jumps', 'where the tip can wedge', 'largest (parts of the cue speed)')]
    rows += [(law, str(row[0]), str(row[1]), f'{row[2]:.2g}') for law, row in found.items()]
    print(table(rows))
    return 0
