"""
`billiard-shot COMMAND ...`: the library for people without ROS.

Each command is a module of this package with three members: `HELP`, one line; `add_arguments`,
which adds its options to a parser; and `run`, which executes it and returns the exit code. A
module is imported only if its command or the help is requested, so that it does not slow down the
others.
"""

import argparse
from collections.abc import Sequence
from importlib import import_module
import os
import sys

import billiard_shot

COMMANDS = (
    'predict',
    'plan',
    'atlas',
    'view',
    'figures',
    'scene',
    'effects',
    'accuracy',
    'laws',
    'paper',
    'measured',
    'hard-cases',
    'urdf',
    'compile',
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code: 0, 1 if it failed, 2 if the input is wrong."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser(words).parse_args(words)
    try:
        return int(options.run(options))
    except BrokenPipeError:  # `... | head` has closed the pipe; Python must not flush the rest
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except ValueError as error:
        print(f'billiard-shot: {error}', file=sys.stderr)
        return 2


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='billiard-shot', description=billiard_shot.__doc__)
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    wanted = [name for name in COMMANDS if name in words[:1]] or COMMANDS
    for name in wanted:
        module = import_module(f'billiard_shot.cli.{name.replace("-", "_")}')
        command = commands.add_parser(name, help=module.HELP, description=module.HELP)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser
