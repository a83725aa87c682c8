"""`billiard-shot calibrate table`: a scene fitted to recorded shots of a table."""

import argparse
import os
from pathlib import Path
import sys
from typing import Any

from billiard_shot.calibration.calibrate import calibrate, HORIZON
from billiard_shot.calibration.result import Calibration, checks_in_words
from billiard_shot.cli.output import (
    add_format_arguments,
    Column,
    DONE,
    FAILED,
    print_rows,
    reporting,
    wants_text,
)
from billiard_shot.cli.workers import add_work_arguments, working

ESTIMATES = (
    Column('name', 'number'),
    Column('value', 'value', '', '{:.4g}'.format),
    Column('before', 'before', '', '{:.4g}'.format),
    Column('unit', 'unit'),
    Column('low'),
    Column('high'),
    Column('shots'),
    Column('known', '95 % interval'),
    Column('converged'),
)
MOST_IGNORED = 10
"""How many reasons for what is ignored are printed."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for recordings, scene, output and work."""
    parser.add_argument(
        'recordings', nargs='+', type=Path, metavar='RECORDING', help='files .csv or .json'
    )
    parser.add_argument(
        '--scene',
        metavar='SCENE',
        help='where the fit begins (default: the scene that the description FILE.yaml of the '
        'first recording names)',
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE.yaml', help='write the fitted scene'
    )
    parser.add_argument(
        '--anyway', action='store_true', help='write it also if the fit did not converge'
    )
    parser.add_argument('--report', type=Path, metavar='FILE.html', help='write a page about it')
    parser.add_argument(
        '--fit',
        nargs='+',
        metavar='NAME',
        help='numbers to be fitted, such as cloth.sliding_friction, or cloth for all of the cloth',
    )
    parser.add_argument(
        '--held-out',
        type=float,
        default=0.25,
        metavar='PART',
        help='part of the shots that check the scene, and are not fitted (default: %(default)g)',
    )
    parser.add_argument(
        '--horizon',
        type=float,
        default=HORIZON,
        metavar='T',
        help='time after the strike that counts for the fit, in s (default: %(default)g)',
    )
    parser.add_argument('--seed', type=int, default=1, metavar='S', help='of the searches')
    parser.add_argument(
        '--state',
        type=Path,
        metavar='FILE',
        help='keep the state in this file; the same command goes on from it',
    )
    add_format_arguments(parser)
    add_work_arguments(parser, os.cpu_count() or 1)


def run(options: argparse.Namespace) -> int:
    """Fit, print and write; ValueError for a recording or request that makes no sense."""
    with working(options.workers, options.dask) as executor, reporting('', 0) as report:
        result = calibrate(
            options.recordings,
            options.scene,
            names=options.fit,
            held_out=options.held_out,
            horizon=options.horizon,
            seed=options.seed,
            executor=executor,
            progress=lambda at: report(at.done, at.text, at.total),
            checkpoint=options.state,
        )
    state = {'converged': result.converged}
    print_rows(ESTIMATES, [row_of(each) | state for each in result.estimates], options)
    if wants_text(options):
        print(_summary(result))
    if options.output and not (result.converged or options.anyway):
        print(
            f'billiard-shot: {options.output} is not written: {result.state}; --anyway writes it',
            file=sys.stderr,
        )
    elif options.output:
        result.save(options.output)
    if options.report:
        result.report(options.report)
    return DONE if result.converged else FAILED


def row_of(estimate: Any) -> dict[str, Any]:
    """Return the row of an estimate."""
    low, high = estimate.interval or (None, None)
    return {
        'name': estimate.name,
        'value': estimate.value,
        'before': estimate.before,
        'unit': estimate.unit,
        'low': low,
        'high': high,
        'shots': ' '.join(estimate.shots),
        'known': f'{low:.4g} to {high:.4g}' if estimate.interval else 'not identifiable: kept',
    }


def _summary(result: Calibration) -> str:
    """Say how well the fit went, and how well it predicts."""
    lines = ['', f'{len(result.fitted)} shots fitted: {result.state}']
    for name, checks in (
        ('this scene', result.checks),
        ('the scene before', result.checks_before),
    ):
        if checks:
            lines.append(f'{len(checks)} shots held out, by {name}: {checks_in_words(checks)}')
    lines += result.notes
    lines += [f'ignored: {text}' for text in result.ignored[:MOST_IGNORED]]
    if len(result.ignored) > MOST_IGNORED:
        lines.append(f'ignored: {len(result.ignored) - MOST_IGNORED} more')
    return '\n'.join(lines)
