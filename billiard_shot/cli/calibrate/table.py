"""`billiard-shot calibrate table`: a scene fitted to recorded shots of a table."""

import argparse
from dataclasses import dataclass
import os
from pathlib import Path
import sys
from typing import Any

from billiard_shot.calibration.calibrate import calibrate, HORIZON
from billiard_shot.calibration.result import Calibration, checks_in_words
from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import (
    Column,
    DONE,
    FAILED,
    OfFormat,
    print_rows,
    reporting,
    wants_text,
)
from billiard_shot.cli.workers import OfWork, working

ESTIMATES = (
    Column('name', 'number'),
    Column('value', 'value', '', '{:.4g}'.format),
    Column('before', 'before', '', '{:.4g}'.format),
    Column('unit', 'unit'),
    Column('low'),
    Column('high'),
    Column('shots'),
    Column('known', '95 % interval'),
    Column('doubts'),
    Column('converged'),
)
MOST_IGNORED = 10
"""How many reasons for what is ignored are printed."""


@dataclass(frozen=True)
class OfFit:
    """
    The recordings, the scene, and the fit.

    Parameters
    ----------
    recordings : RECORDING
        Files .csv or .json.
    scene : SCENE
        Where the fit begins (default: the scene that the description FILE.yaml of the first
        recording names).
    output : FILE.yaml
        Write the fitted scene.
    anyway : bool
        Write it also if the fit did not converge.
    report : FILE.html
        Write a page about it.
    fit : NAME
        Numbers to be fitted, such as cloth.sliding_friction, or cloth for all of the cloth.
    held_out : PART
        Part of the shots that check the scene, and are not fitted (default: %(default)g).
    horizon : T
        Time after the strike that counts for the fit, in s (default: %(default)g).
    seed : S
        Of the searches.

    """

    recordings: list[Path] = positional('+')
    scene: str | None = None
    output: Path | None = option('-o')
    anyway: bool = False
    report: Path | None = None
    fit: list[str] | None = None
    held_out: float = 0.25
    horizon: float = HORIZON
    seed: int = 1


OPTIONS = OfFit(), OfFormat(), OfWork(os.cpu_count() or 1)


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
        )
    state = {'doubts': '; '.join(result.doubts), 'converged': result.converged}
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
