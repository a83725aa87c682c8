"""The command line of a study; refusals and exit codes are those of `billiard-shot`."""

import argparse
from collections.abc import Callable, Sequence
from typing import Any

from billiard_shot.cli import Parser, run_command
from billiard_shot.cli.options import add_options


def run_study(
    about: str | None,
    groups: Sequence[Any],
    run: Callable[[argparse.Namespace], int],
    words: Sequence[str] | None,
) -> int:
    """
    Parse the words of a command line, by default of this process, and run the study.

    `groups` are its options, as `billiard_shot.cli.options.add_options` takes them.
    """

    def parsed() -> argparse.Namespace:
        parser = Parser(description=(about or '').strip().partition('\n')[0])
        add_options(parser, *groups)
        parser.set_defaults(run=run, parser=parser)
        return parser.parse_args(words)

    return run_command(parsed)
