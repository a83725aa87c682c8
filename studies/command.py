"""The command line of a study; refusals and exit codes are those of `billiard-shot`."""

import argparse
from collections.abc import Callable, Sequence

from billiard_shot.cli import Parser, run_command


def run_study(
    about: str | None,
    add_arguments: Callable[[argparse.ArgumentParser], None],
    run: Callable[[argparse.Namespace], int],
    words: Sequence[str] | None,
) -> int:
    """Parse the words of a command line, by default of this process, and run the study."""

    def parsed() -> argparse.Namespace:
        parser = Parser(description=(about or '').strip().partition('\n')[0])
        add_arguments(parser)
        parser.set_defaults(run=run, parser=parser)
        return parser.parse_args(words)

    return run_command(parsed)
