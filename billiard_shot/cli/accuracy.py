"""`billiard-shot accuracy`: error and work of several methods."""

import argparse
import csv
import dataclasses
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.progress import progress, wait_for_machine_code
from billiard_shot.cli.text_table import table
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of

HELP = 'compare the errors and the work of several methods for the same strokes'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, strokes and files."""
    parser.add_argument(
        'scene',
        nargs='?',
        default='paper',
        metavar='SCENE',
        help='bundled scene or YAML file (default: %(default)s)',
    )
    parser.add_argument('--csv', type=Path, metavar='FILE.csv', help='write every measurement')
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw errors over work')
    add_stroke_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    wait_for_machine_code()
    from billiard_shot.study import accuracy

    scene = Scene.load(options.scene)
    strokes = strokes_of(options, scene) if strokes_given(options) else accuracy.PAPER_STROKES
    tasks, left_out = accuracy.tasks(scene, strokes)
    measurements = [task.measure() for task in progress(tasks, 'accuracy')]
    curves = {
        method.name: accuracy.curve(measurements, method.name) for method in accuracy.methods()
    }
    curves = {name: points for name, points in curves.items() if points}
    about = f'scene {options.scene}, {len(strokes)} stroke{"s" * (len(strokes) > 1)}'
    print(f'{about}: worst error, mean work\n')
    rows = [
        (
            'method',
            'at',
            'velocity',
            'spin',
            'resting place',
            'evaluations',
            'time',
            'memory',
            'answered',
        ),
        ('', '', '(m/s)', '(rad/s)', '(mm)', '', '(us)', '(kB)', ''),
    ]
    settings = {method.name: method.setting for method in accuracy.methods()}
    for name, points in curves.items():
        for p in points:
            at = f'{settings[name]} {p.setting:.0e}' if settings[name] else ''
            rows.append(
                (
                    name,
                    at,
                    f'{p.velocity:.1e}',
                    f'{p.spin:.1e}',
                    f'{p.rest:.1e}',
                    f'{p.evaluations:.0f}',
                    f'{1e6 * p.seconds:.0f}',
                    f'{p.memory:.0f}',
                    f'{p.answered} of {len(strokes)}',
                )
            )
    print(table(rows))
    print(
        '\nstep: relative to ball mass times cue speed; tolerance: to the approach speed;\n'
        'memory: growth of the process at its peak (VmHWM), in pages; errors: against this\n'
        f'library at {accuracy.FLOOR:g}'
    )
    ratios = {rest: accuracy.speed_up(measurements, rest) for rest in (0.1, 0.001)}
    findings = [
        f'at {rest:g} mm the impulse scheme takes {ratio:,.0f} times as long'
        for rest, ratio in ratios.items()
        if ratio == ratio
    ]
    for finding in findings:
        print(finding)
    for line in left_out:
        print(f'left out: {line}')
    if options.csv:
        _write(options.csv, [dataclasses.asdict(m) for m in measurements])
    if options.picture:
        from billiard_shot.pictures.accuracy import draw

        title = '; '.join([*findings[:1], about])
        draw(curves, title[0].upper() + title[1:], options.picture)
    return 0


def _write(path: Path, rows: list[dict[str, object]]) -> None:
    try:
        with path.open('w', newline='') as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise ValueError(f'--csv: {error}') from None
