"""`billiard-shot scene ACTION`: bundled scenes and scene files."""

import argparse
from dataclasses import dataclass
import sys

import yaml

from billiard_shot import Scene
from billiard_shot.cli.options import positional, Subcommand
from billiard_shot.cli.output import table
from billiard_shot.scene.files import scene_names, scene_path


@dataclass(frozen=True)
class OfSceneFiles:
    """
    The files.

    Parameters
    ----------
    files : FILE
        YAML file or bundled scene.

    """

    files: list[str] = positional('+')


def run_check(options: argparse.Namespace) -> int:
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


@dataclass(frozen=True)
class OfOneScene:
    """
    The scene.

    Parameters
    ----------
    scene : SCENE
        Bundled scene or YAML file.

    """

    scene: str = positional()


def run_show(options: argparse.Namespace) -> int:
    """Print a scene with all its default values."""
    data = Scene.load(options.scene).to_dict(derived=True)
    print(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=55).rstrip())
    return 0


def run_list(_: argparse.Namespace) -> int:
    """Print the name of each bundled scene, and what it is."""
    print(table([(name, _first_comment(name)) for name in scene_names()]))
    return 0


def _first_comment(name: str) -> str:
    """Describe a scene by the first sentence of its file."""
    lines = []
    for line in scene_path(name).read_text(encoding='utf-8').splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).split('. ')[0].rstrip('.')


check = Subcommand((OfSceneFiles(),), run_check)
show = Subcommand((OfOneScene(),), run_show)
list = Subcommand((), run_list)  # noqa: A001
