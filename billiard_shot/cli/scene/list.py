"""`billiard-shot scene list`: the bundled scenes."""

import argparse

from billiard_shot.cli.output import table
from billiard_shot.scene.files import scene_names, scene_path

OPTIONS = ()


def run(options: argparse.Namespace) -> int:
    """Print the name of each scene, and what it is."""
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
