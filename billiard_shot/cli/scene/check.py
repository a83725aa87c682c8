"""`billiard-shot scene check`: the mistakes in scene files."""

import argparse
from dataclasses import dataclass
import sys

from billiard_shot import Scene
from billiard_shot.cli.options import positional


@dataclass(frozen=True)
class OfFiles:
    """
    The files.

    Parameters
    ----------
    files : FILE
        YAML file or bundled scene.

    """

    files: list[str] = positional('+')


OPTIONS = (OfFiles(),)


def run(options: argparse.Namespace) -> int:
    """Print what each file has; 1 if a file has mistakes."""
    good = 0
    for file in options.files:
        try:
            scene = Scene.load(file)
        except ValueError as error:
            print(str(error).removeprefix('scene '), file=sys.stderr)
            continue
        good += 1
        print(f'{file}: no mistakes; {_summary(scene)}')
    return 0 if good == len(options.files) else 1


def _summary(scene: Scene) -> str:
    balls = len({'cue', *scene.balls})
    return f'{balls} ball{"s" * (balls > 1)}, law {scene.law}'
