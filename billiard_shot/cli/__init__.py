"""
`billiard-shot COMMAND ...`: the library for people without ROS.

Each command is a module of this package, or a `Subcommand` of a module with several, with two
members: `OPTIONS`, see `cli.options`; and `run`, which executes it and returns the exit code.
A module is imported only if its command is requested, so that it does not slow down the others.
In all commands the scene comes first, `--output` names the file, and numbers are also printed as
JSON or CSV.
"""

import argparse
from collections.abc import Callable, Container, Sequence
from concurrent.futures import BrokenExecutor
from pkgutil import resolve_name
import re
import sys
from typing import Any, NoReturn

import billiard_shot
from billiard_shot.cli import output
from billiard_shot.cli.options import add_options, check_files, check_options, PICTURES
from billiard_shot.scene.errors import must_be, must_be_one_of

COMMANDS = {  # and what each does
    'predict': 'predict the motion of all balls after a stroke',
    'plan': 'find the stroke most likely to reach a target, given execution noise and limits',
    'view': 'write a shot as one HTML file (a 3-D table to play on) or as a video',
    'explore': 'write a scene as one HTML file: a table to play on, with chances and drills',
    'play': 'play one rack: agents against each other, or against a person in the terminal',
    'tournament': 'play many racks of a game between two players; count who wins and why',
    'rate': 'play against the ghost in eight-, nine- and ten-ball, beside figures of people',
    'map': 'map the success probability of a pot over the places of the cue ball',
    'scene': 'list the bundled scenes, show a scene with its defaults, or check files',
    'compile': 'compile the library to machine code, once for each version',
    'calibrate': 'fit a scene to recorded shots of a table',
    'study': 'measure what accuracy and effects cost in a scene',
    'export': 'write a scene for pages (JavaScript) or C, with the compiled core',
    'urdf': 'print the mechanical cue as a robot model (URDF)',
    'completion': 'print a script that completes commands and options in bash or zsh',
}
STUDIES = {
    'accuracy': 'compare tolerances: true errors, and the time that each takes',
    'effects': 'measure the cost (us) and the influence (mm, degrees) of each effect',
}
CALIBRATIONS = {
    'table': 'fit cloth, cushions and balls of a scene to recorded shots; say how surely',
    'errors': "estimate a player's errors from measured strokes, or from watched shots",
    'machine': 'find where a robot stands at its table, and how it errs, from its strikes',
    'film': 'write a recording from a film of a table: find table, balls and shots',
    'convert': 'write a recording as CSV',
}
SCENES = {
    'check': 'report every mistake in scene files, with line, key and allowed range',
    'show': 'print a scene with all its default values',
    'list': 'list the bundled scenes',
}
HOMES = {'view': 'pages', 'explore': 'pages'} | dict.fromkeys(
    ('compile', 'export', 'urdf', 'completion'), 'exports'
)
GROUPS = {
    'study': ('STUDY', STUDIES),
    'calibrate': ('WHAT', CALIBRATIONS),
    'scene': ('ACTION', SCENES),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code, see `EXIT_CODES`."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    return run_command(lambda: _parse(words))


def run_command(parse: Callable[[], argparse.Namespace]) -> int:
    """Parse a command line and run what it asks for; return the exit code, see `EXIT_CODES`."""
    try:
        options = parse()
        check_options(options, options.parser)
        check_files(options)  # before the work, not after it
        if any(getattr(options, name, None) for name in PICTURES):
            from billiard_shot.pictures.canvas import require_matplotlib

            require_matplotlib()
        with output.tolerant_output():
            code = int(options.run(options))
    except KeyboardInterrupt:
        print('billiard-shot: interrupted', file=sys.stderr)
        return output.INTERRUPTED
    except BrokenExecutor as error:  # a process of --workers was killed
        print(f'billiard-shot: {error}', file=sys.stderr)
        return output.FAILED
    except OSError as error:  # such as a full disk
        output.discard_output()
        print(f'billiard-shot: {error}', file=sys.stderr)
        return output.FAILED
    except ValueError as error:
        print(f'billiard-shot: {error}', file=sys.stderr)
        return output.WRONG_INPUT
    return code


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(must_be('a number, such as 2.5', text)) from None


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(must_be('a whole number', text)) from None


class Parser(argparse.ArgumentParser):
    """A parser that takes -1e-3 as a number; its errors have two lines, without all options."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.register('type', float, _number)
        self.register('type', int, _whole_number)
        self._negative_number_matcher = re.compile(r'-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$')

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Name the choice that is nearest to a wrong value."""
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, must_be_one_of(action.choices, value))

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and where the help is, and exit."""
        self.exit(output.WRONG_INPUT, f'{self.prog}: {message}\nsee {self.prog} --help\n')


def make_parser(complete: Container[list[str]] | None = None) -> argparse.ArgumentParser:
    """
    Make the parser of all commands.

    Only commands whose words are in `complete` have their options, such as
    `['study', 'effects']`; by default all have.
    """
    parser = Parser(
        prog='billiard-shot',
        description=billiard_shot.__doc__,
        epilog='exit codes: '
        + '; '.join(f'{code}: {text}' for code, text in output.EXIT_CODES.items()),
    )
    parser.add_argument(
        '--version', action='version', version=f'billiard_shot {billiard_shot.__version__}'
    )
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text)
        if name in GROUPS:
            metavar, group = GROUPS[name]
            members = command.add_subparsers(required=True, metavar=metavar)
            for member, about in group.items():
                _complete(
                    members.add_parser(member, help=about, description=about),
                    [name, member],
                    complete,
                )
        else:
            _complete(command, [name], complete)
    return parser


def _parse(words: list[str]) -> argparse.Namespace:
    """Parse the words of a command line; the command itself refuses unknown words."""
    options, unknown = make_parser((words[:1], words[:2])).parse_known_args(words)
    if unknown:
        parser: Parser = options.parser
        parser.error(f'unrecognized arguments: {" ".join(unknown)}')
    return options


def _complete(
    parser: argparse.ArgumentParser, words: list[str], wanted: Container[list[str]] | None
) -> None:
    """Add the options of a command, and what runs it, if it is wanted."""
    if wanted is None or words in wanted:
        home = [HOMES[words[0]]] if words[0] in HOMES else []
        command = resolve_name('.'.join(['billiard_shot.cli', *home, *words]))
        add_options(parser, *command.OPTIONS)
        parser.set_defaults(run=command.run, parser=parser)
        words = [_word(each) for each in parser._get_positional_actions()]
        parser.usage = ' '.join(['%(prog)s', *words, '[options]'])


def _word(action: argparse.Action) -> str:
    """Return what stands for a positional argument in the usage."""
    name = str(action.metavar or action.dest).upper()
    return {'?': f'[{name}]', '*': f'[{name} ...]', '+': f'{name} ...'}.get(
        str(action.nargs), name
    )
