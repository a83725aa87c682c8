"""
`billiard-shot COMMAND ...`: the library for people without ROS.

Each command is a module of this package with three members: `HELP`, one line; `add_arguments`,
which adds its options to a parser; and `run`, which executes it and returns the exit code. A
module is imported only if its command or the help is requested, so that it does not slow down the
others. In all commands the scene comes first, `--output` names the file, and numbers are also
printed as JSON or CSV.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from importlib import import_module
import os
import sys

import billiard_shot
from billiard_shot.cli.exit_codes import EXIT_CODES, FAILED, INTERRUPTED, WRONG_INPUT
from billiard_shot.pictures.canvas import require_matplotlib

COMMANDS = (
    'predict',
    'plan',
    'atlas',
    'view',
    'figures',
    'scene',
    'effects',
    'accuracy',
    'tolerance',
    'laws',
    'paper',
    'measured',
    'hard-cases',
    'urdf',
    'compile',
    'completion',
)
PICTURES = ('picture', 'history', 'close_up')  # options that name a file to draw
FILES = (*PICTURES, 'output', 'view', 'video')  # options that name a file to write


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code, see `EXIT_CODES`."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        options = make_parser(words).parse_args(words)
        _check_files(options)  # before the work, not after it
        if any(getattr(options, name, None) for name in PICTURES):
            require_matplotlib()
        code = int(options.run(options))
        if sys.stdout is not None:  # Python sets None if the shell has closed the output
            sys.stdout.flush()
    except KeyboardInterrupt:
        print('billiard-shot: interrupted', file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # `... | head` has closed the pipe
        _discard_output()
        return FAILED
    except BrokenExecutor as error:  # a process of --workers was killed
        print(f'billiard-shot: {error}', file=sys.stderr)
        return FAILED
    except OSError as error:  # such as a full disk
        _discard_output()
        print(f'billiard-shot: {error}', file=sys.stderr)
        return FAILED
    except ValueError as error:
        print(f'billiard-shot: {error}', file=sys.stderr)
        return WRONG_INPUT
    return code


def make_parser(words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Make the parser of the command that `words` begin with, or of all commands."""
    parser = argparse.ArgumentParser(
        prog='billiard-shot',
        description=billiard_shot.__doc__,
        epilog='exit codes: ' + '; '.join(f'{code}: {text}' for code, text in EXIT_CODES.items()),
    )
    parser.add_argument(
        '--version', action='version', version=f'billiard_shot {billiard_shot.__version__}'
    )
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    wanted = [name for name in COMMANDS if name in words[:1]] or COMMANDS
    for name in wanted:
        module = import_module(f'billiard_shot.cli.{name.replace("-", "_")}')
        command = commands.add_parser(name, help=module.HELP, description=module.HELP)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser


def _check_files(options: argparse.Namespace) -> None:
    """Raise ValueError if a file to write is a folder, or if its folder does not exist."""
    for name in FILES:
        path = getattr(options, name, None)
        option = f'--{name.replace("_", "-")}'
        if path and path.is_dir():
            raise ValueError(f'{option}: {path} is not allowed; it must be a file, not a folder')
        if path and not path.absolute().parent.is_dir():
            raise ValueError(f'{option}: {path}: there is no such folder')


def _discard_output() -> None:
    """Keep Python from writing the rest of the output at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
