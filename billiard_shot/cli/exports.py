"""What other programs take: machine code, scenes with their core, the cue, a completion script."""

import argparse
from dataclasses import dataclass
import json
from pathlib import Path
import sys
from typing import ClassVar

from billiard_shot.cli.options import option, positional, Subcommand
from billiard_shot.compiler.build import missing_tool, provide
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import urdf_of
from billiard_shot.embed.scenes import c_scene, copy_library, copy_module, export_scene
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


def run_compile(options: argparse.Namespace) -> int:
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


@dataclass(frozen=True)
class OfExport:
    """
    The scene and the files.

    Parameters
    ----------
    scene : SCENE
        Bundled scene or YAML file.
    output : FILE
        NAME.json for the JavaScript module, NAME.h for C.
    core : bool
        Also put the core beside it: module and WebAssembly, or header and library.

    """

    scene: str = positional()
    output: Path = option('-o', required=True)
    core: bool = False


def run_export(options: argparse.Namespace) -> int:
    """Write the files."""
    output, folder = options.output, options.output.absolute().parent
    if output.suffix not in ('.json', '.h'):
        raise ValueError(f'--output must be a file .json or .h, got {output}')
    if output.suffix == '.h':
        text, copy = c_scene(options.scene), copy_library
    else:
        exported = export_scene(options.scene)
        text, copy = json.dumps(exported, separators=(',', ':'), allow_nan=False), copy_module
    if options.core:
        copy(folder)
    output.write_text(text, encoding='utf-8')
    return 0


@dataclass(frozen=True)
class OfModel:
    """
    The mechanism, its frame, and the file.

    Parameters
    ----------
    mechanism : FILE
        YAML file of the mechanism (default: the built-in one).
    frame : str
        Name of the table's frame, such as cell1/table (default: %(default)s).
    output : FILE
        Output file (default: standard output).

    """

    mechanism: str = ''
    frame: str = 'table'
    output: Path | None = option('-o')


def run_urdf(options: argparse.Namespace) -> int:
    """Print or write the model."""
    if not options.frame:
        raise ValueError("--frame must be a name, got ''")
    text = urdf_of(Mechanism.load(options.mechanism), options.frame)
    if options.output:
        options.output.write_text(text, encoding='utf-8')
    else:
        print(text, end='')
    return 0


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


def run_completion(options: argparse.Namespace) -> int:
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


compile = Subcommand((OfTargets(),), run_compile)  # noqa: A001
export = Subcommand((OfExport(),), run_export)
urdf = Subcommand((OfModel(),), run_urdf)
completion = Subcommand((OfShell(),), run_completion)
