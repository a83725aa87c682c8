"""`billiard-shot completion`: completion of commands and options by the shell."""

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the shell."""
    parser.add_argument(
        'shell',
        choices=['bash', 'zsh'],
        help='bash: eval "$(billiard-shot completion bash)"; zsh: write it to _billiard-shot in a '
        'folder of $fpath',
    )


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
