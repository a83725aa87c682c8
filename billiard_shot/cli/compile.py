"""`billiard-shot compile`: build the library of machine code for the sources of this package."""

import argparse
import sys

from billiard_shot.compiler.build import provide


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no options."""
    del parser


def run(options: argparse.Namespace) -> int:
    """Build, and print the folder of the library."""
    del options
    try:
        folder = provide()
    except ModuleNotFoundError as error:
        print(
            f'billiard-shot: nothing is compiled, because {error.name} is not installed: '
            "pip install 'billiard_shot[build]'",
            file=sys.stderr,
        )
        return 1
    except (OSError, RuntimeError, ValueError) as error:
        print(f'billiard-shot: nothing is compiled: {error}', file=sys.stderr)
        return 1
    print(f'compiled, in {folder}')
    return 0
