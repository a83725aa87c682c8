"""`billiard-shot scene`: bundled scenes, and checks of scene files."""

import argparse
import sys

import yaml

from billiard_shot import Scene
from billiard_shot.cli.output import table
from billiard_shot.scene.files import scene_names, scene_path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands check, show and list."""
    actions = parser.add_subparsers(required=True, metavar='ACTION')
    text = 'report every mistake in scene files, with line, key and allowed range'
    check = actions.add_parser('check', help=text, description=text)
    check.add_argument('files', nargs='+', metavar='FILE', help='YAML file or bundled scene')
    check.set_defaults(act=_check)
    text = 'print a scene with all its default values'
    show = actions.add_parser('show', help=text, description=text)
    show.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    show.set_defaults(act=_show)
    text = 'list the bundled scenes'
    actions.add_parser('list', help=text, description=text).set_defaults(act=_list)


def run(options: argparse.Namespace) -> int:
    """Run a subcommand; 1 if a file has mistakes."""
    return int(options.act(options))


def _check(options: argparse.Namespace) -> int:
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


def _show(options: argparse.Namespace) -> int:
    data = Scene.load(options.scene).to_dict(derived=True)
    print(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=55).rstrip())
    return 0


def _list(options: argparse.Namespace) -> int:
    print(table([(name, _first_comment(name)) for name in scene_names()]))
    return 0


def _summary(scene: Scene) -> str:
    balls = len({'cue', *scene.balls})
    return f'{balls} ball{"s" * (balls > 1)}, law {scene.law}'


def _first_comment(name: str) -> str:
    """Describe a scene by the first sentence of its file."""
    lines = []
    for line in scene_path(name).read_text(encoding='utf-8').splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).split('. ')[0].rstrip('.')
