"""`billiard-shot study accuracy`: error and work of several methods."""

import argparse
import csv
from dataclasses import asdict
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.progress import progress
from billiard_shot.cli.shots import add_scene_argument, scene_name
from billiard_shot.cli.text_table import add_format_arguments, Column, print_rows, wants_text
from billiard_shot.cli.workers import add_work_arguments, mapped
from billiard_shot.scene.errors import reason
from billiard_shot.shot.stroke_options import (
    add_stroke_arguments,
    strokes_from_options,
    strokes_given,
)

ACCURACY_COLUMNS = (
    Column('method'),
    Column('parameter'),
    Column('setting'),
    Column('at', 'method, at'),
    Column('velocity', 'velocity', '(m/s)', '{:.1e}'.format),
    Column('spin', 'spin', '(rad/s)', '{:.1e}'.format),
    Column('rest', 'rests', '(mm)', '{:.1e}'.format),
    Column('evaluations', 'evals', '', '{:.0f}'.format),
    Column('seconds', 'time', '(us)', lambda seconds: f'{1e6 * seconds:.0f}'),
    Column('memory', 'memory', '(kB)', '{:.0f}'.format),
    Column('of', 'solved'),
    Column('answered'),
    Column('strokes'),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, strokes and files."""
    add_scene_argument(parser, 'paper')
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE.csv', help='write every measurement'
    )
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw errors over work')
    add_stroke_arguments(parser)
    add_format_arguments(parser)
    add_work_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    from billiard_shot.study import accuracy

    name = scene_name(options)
    scene = Scene.load(name)
    strokes = (
        strokes_from_options(options, scene) if strokes_given(options) else accuracy.PAPER_STROKES
    )
    tasks, left_out = accuracy.tasks(scene, strokes)
    measuring = mapped(options, type(tasks[0]).measure, tasks)
    measurements = list(progress(measuring, 'accuracy', len(tasks)))
    curves = {
        method.name: accuracy.curve(measurements, method.name) for method in accuracy.methods()
    }
    curves = {name: points for name, points in curves.items() if points}
    about = f'scene {name}, {len(strokes)} stroke{"s" * (len(strokes) > 1)}'
    settings = {method.name: method.setting for method in accuracy.methods()}
    ratios = {rest: accuracy.speed_up(measurements, rest) for rest in (0.1, 0.001)}
    findings = [
        f'at {rest:g} mm the impulse scheme takes {ratio:,.0f} times as long'
        for rest, ratio in ratios.items()
        if ratio == ratio
    ]
    rows = [
        {'method': method, 'parameter': settings[method], 'strokes': len(strokes)} | asdict(point)
        for method, points in curves.items()
        for point in points
    ]
    if wants_text(options):
        print(f'{about}: worst error, mean work\n')
        for row in rows:
            row['at'] = f'{row["parameter"]} {row["setting"]:.0e}' if row['parameter'] else ''
            row['of'] = f'{row["answered"]} of {len(strokes)}'
    print_rows(ACCURACY_COLUMNS, rows, options, 'method')
    if wants_text(options):
        _explain(accuracy.FLOOR)
        for finding in findings:
            print(finding)
        for line in left_out:
            print(f'left out: {line}')
    if options.output:
        _write(options.output, [asdict(m) for m in measurements])
    if options.picture:
        from billiard_shot.pictures.accuracy import draw_accuracy

        title = '; '.join([*findings[:1], about])
        draw_accuracy(curves, options.picture, title[0].upper() + title[1:])
    return 0


def _explain(floor: float) -> None:
    print(
        '\nstep: relative to ball mass times cue speed; tolerance: to the approach speed;\n'
        'memory: growth of the process at its peak (VmHWM), in pages; errors: against\n'
        f'this library at {floor:g}'
    )


def _write(path: Path, rows: list[dict[str, object]]) -> None:
    try:
        with path.open('w', newline='') as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise ValueError(f'--output: {reason(error)}') from None
