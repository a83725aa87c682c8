"""`billiard-shot paper`: Table 1 of the paper, as printed, by its model, and under variants."""

import argparse

from billiard_shot.cli.text_table import numbers, table

HELP = 'recompute Table 1 of the paper: as printed, by its model, and under variants'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no options."""


def run(options: argparse.Namespace) -> int:
    """Recompute and print."""
    from billiard_shot.study.reproduction import ATTEMPTS, label, PRINTED, reproduce

    rows = [
        ('shot', 'velocity (m/s)', 'spin (rad/s)', 'off by', '', 'variant'),
        ('', 'x y z', 'x y z', 'velocity', 'spin', ''),
    ]
    for name, variants in ATTEMPTS.items():
        printed = PRINTED[name][1]
        rows.append((name, numbers(printed[:3], 4), numbers(printed[3:], 3), '', '', 'printed'))
        for variant in variants:
            row = reproduce(name, variant)
            rows.append(
                (
                    '',
                    numbers(row.numbers[:3].tolist(), 4),
                    numbers(row.numbers[3:].tolist(), 3),
                    f'{row.velocity:.1g}',
                    f'{row.spin:.1g}',
                    label(variant),
                )
            )
    print(table(rows))
    return 0
