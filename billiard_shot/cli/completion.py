"""`billiard-shot completion`: completion of commands and options by the shell."""

import argparse
from dataclasses import dataclass

from billiard_shot.cli.options import positional


@dataclass(frozen=True)
class OfShell:
    """
    The shell.

    Parameters
    ----------
    shell : str
        bash: eval "$(billiard-shot completion bash)"; zsh: write it to _billiard-shot in a folder
        of $fpath.

    """

    shell: str = positional(choices=['bash', 'zsh'])


OPTIONS = (OfShell(),)


def run(options: argparse.Namespace) -> int:
    """Print the script."""
    try:
        import shtab
    except ImportError:
        raise ValueError(
            "completion: needs shtab, an extra: pip install 'billiard_shot[completion]'"
        ) from None
    from billiard_shot.cli import make_parser

    print(shtab.complete(make_parser(), shell=options.shell))
    return 0
