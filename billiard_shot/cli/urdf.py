"""`billiard-shot urdf`: the mechanical cue as a robot model."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from billiard_shot.cli.options import option
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import urdf_of


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


OPTIONS = (OfModel(),)


def run(options: argparse.Namespace) -> int:
    """Print or write the model."""
    if not options.frame:
        raise ValueError("--frame must be a name, got ''")
    text = urdf_of(Mechanism.load(options.mechanism), options.frame)
    if options.output:
        options.output.write_text(text, encoding='utf-8')
    else:
        print(text, end='')
    return 0
