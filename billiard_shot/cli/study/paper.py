"""`billiard-shot study paper`: Table 1 as printed, by the model, and under variants."""

import argparse
from collections.abc import Iterable
import math
from typing import Any

from billiard_shot.cli.text_table import (
    add_format_arguments,
    Column,
    numbers,
    print_footer,
    print_rows,
)


def _off(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.1g}'


PAPER_COLUMNS = (
    Column('shot'),
    Column('variant'),
    Column('velocity', '  velocity (m/s)', '  x y z', lambda vector: numbers(vector, 4)),
    Column('spin', 'spin (rad/s)', 'x y z', lambda vector: numbers(vector, 3)),
    Column('off_velocity', 'off by', 'velocity', _off),
    Column('off_spin', ' ', 'spin', _off),
)
FOOTER = (
    'velocity and spin: of the ball after the strike. off by: distance from the printed vector, '
    'relative to its length. The law of all rows is energetic, unless the row names another.'
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for the format."""
    add_format_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Recompute and print."""
    from billiard_shot.study.reproduction import ATTEMPTS, PRINTED, reproduce, variant_label

    rows = []
    for name, variants in ATTEMPTS.items():
        rows.append(_row(name, 'printed', PRINTED[name][1], math.nan, math.nan))
        for variant in variants:
            row = reproduce(name, variant)
            rows.append(_row(name, variant_label(variant), row.numbers, row.velocity, row.spin))
    print_rows(PAPER_COLUMNS, rows, options, 'title')
    print_footer(FOOTER, options)
    return 0


def _row(
    shot: str, variant: str, values: Iterable[float], off_velocity: float, off_spin: float
) -> dict[str, Any]:
    numbers = [float(value) for value in values]
    return {
        'title': f'{shot}, {variant}',
        'shot': shot,
        'variant': variant,
        'velocity': numbers[:3],
        'spin': numbers[3:],
        'off_velocity': off_velocity,
        'off_spin': off_spin,
    }
