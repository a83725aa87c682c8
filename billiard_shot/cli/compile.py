"""`billiard-shot compile`: compile the library in advance."""

import argparse
import sys

from billiard_shot import machine_code
from billiard_shot.cli.progress import wait_for_machine_code


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add no options."""
    del parser


def run(options: argparse.Namespace) -> int:
    """Compile, and print the folder of the machine code."""
    del options
    if not machine_code.available():
        text = 'nothing is compiled, because numba is missing, or turned off by NUMBA_DISABLE_JIT'
        print(f'billiard-shot: {text}', file=sys.stderr)
        return 1
    if machine_code.is_complete():
        print(f'already compiled, in {machine_code.folder()}')
        return 0
    if not wait_for_machine_code():
        return 1
    print(f'compiled, in {machine_code.folder()}')
    return 0
