"""`billiard-shot compile`: build the library of machine code for the sources of this package."""

import argparse
from dataclasses import dataclass
import sys
from typing import ClassVar

from billiard_shot.cli.options import positional
from billiard_shot.compiler.build import missing_tool, provide
from billiard_shot.scene.errors import must_be_one_of

TARGETS = 'linux-x86_64', 'linux-aarch64', 'wasm32', 'darwin-arm64', 'windows-amd64'
UNTESTED = 2  # the last ones


@dataclass(frozen=True)
class OfTargets:
    """
    What to compile for.

    Parameters
    ----------
    targets : TARGET
        %(TESTED)s, or, untested, %(OTHERS)s; by default this machine.

    """

    TESTED: ClassVar = ', '.join(TARGETS[:-UNTESTED])
    OTHERS: ClassVar = ' or '.join(TARGETS[-UNTESTED:])
    targets: list[str] = positional('*')


OPTIONS = (OfTargets(),)


def run(options: argparse.Namespace) -> int:
    """Build, and print the folder of the library."""
    for target in options.targets:
        if target not in TARGETS:
            raise ValueError(f'TARGET {must_be_one_of(TARGETS, target)}')
    if missing_tool():
        print(
            'billiard-shot: numba and ziglang are fetched into an environment of 800 MB, '
            'which is removed after the build',
            file=sys.stderr,
        )
    try:
        folder = provide(*options.targets, install=True)
    except (OSError, RuntimeError) as error:
        print(f'billiard-shot: nothing is compiled: {error}', file=sys.stderr)
        return 1
    print(f'compiled, in {folder}')
    return 0
