"""`billiard-shot study measured`: published values beside computed ones."""

import argparse
import json
import textwrap
from typing import Any

from billiard_shot.cli.progress import progress
from billiard_shot.cli.text_table import add_format_arguments, print_csv, table
from billiard_shot.cli.workers import add_work_arguments, mapped
from billiard_shot.study.measured.comparison import compare, Comparison, comparisons, Group
from billiard_shot.study.measured.published import SOURCES
from billiard_shot.table.words import rounded

LINE_WIDTH = 80  # characters of a line
LABEL_WIDTH = 40  # characters of the name of a row


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for formats and workers."""
    add_format_arguments(parser)
    add_work_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Compute and print."""
    work = comparisons()
    groups = list(progress(mapped(options, compare, work), 'measured', len(work)))
    if options.json:
        print(json.dumps(_as_json(groups), allow_nan=False))
        return 0
    if options.csv:
        rows = [row for group in _as_json(groups)['groups'] for row in group['rows']]
        print_csv(rows, list(rows[0]))
        return 0
    keys = list(SOURCES)
    for group in groups:
        numbers = ' '.join(f'[{keys.index(key) + 1}]' for key in group.sources)
        print(textwrap.fill(f'{group.title} {numbers}', LINE_WIDTH))
        print(f'{_as_table(group)}\n')
    for number, text in enumerate(SOURCES.values(), 1):
        print(textwrap.fill(f'[{number}] {text}', LINE_WIDTH, subsequent_indent='    '))
    return 0


def _as_table(group: Group) -> str:
    rows = [('', 'published', '   +-', 'computed', 'deviation')]
    case = ''
    for row in group.rows:
        rows.append(
            (
                _label(row, row.case == case).ljust(LABEL_WIDTH),
                _number(row.published, row.digits, 9),
                _number(row.uncertainty, row.digits, 6),
                _number(row.computed, row.digits, 8),
                _number(row.deviation, row.digits, 9, '+'),
            )
        )
        case = row.case
    return table(rows)


def _label(row: Comparison, again: bool) -> str:
    """Name a row; its case only in the first row of that case."""
    case = '' if not row.case else '  ' if again else f'{row.case}: '
    return f'{case}{row.quantity}' + (f' ({row.unit})' if row.unit else '')


def _number(value: float | None, digits: int, width: int, sign: str = '') -> str:
    return ('' if value is None else rounded(value, digits, sign)).rjust(width)


def _as_json(groups: list[Group]) -> dict[str, Any]:
    return {
        'groups': [
            {
                'title': group.title,
                'sources': list(group.sources),
                'rows': [
                    {
                        'title': group.title,
                        'case': row.case,
                        'quantity': row.quantity,
                        'unit': row.unit,
                        'published': row.published,
                        'uncertainty': row.uncertainty,
                        'computed': row.computed,
                        'deviation': row.deviation,
                    }
                    for row in group.rows
                ],
            }
            for group in groups
        ],
        'sources': SOURCES,
    }
