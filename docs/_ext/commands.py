"""The page of all commands, made of their own help."""

import argparse
from collections.abc import Iterator
import os

from billiard_shot.cli import make_parser
from billiard_shot.cli.output import EXIT_CODES


def page() -> str:
    """The page, in Markdown."""
    os.environ['COLUMNS'] = '80'  # argparse wraps at the width of the terminal
    lines = [
        '# Commands',
        '',
        '`python -m billiard_shot` is the same as `billiard-shot`. In every command the scene '
        'comes first. `--output` names the file. Numbers are also printed as JSON (`--json`) or '
        'CSV (`--csv`).',
        '',
        '| exit code | meaning |',
        '|---|---|',
        *(f'| {code} | {text} |' for code, text in EXIT_CODES.items()),
        '',
    ]
    for parser in _commands(make_parser()):
        lines += [f'## {parser.prog}', '', '```text', parser.format_help().rstrip(), '```', '']
    return '\n'.join(lines)


def _commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """Yield the parser of each command, and those of its actions."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield command
                yield from _commands(command)
