"""`billiard-shot scene show`: a scene with all its default values."""

import argparse
from dataclasses import dataclass

import yaml

from billiard_shot import Scene
from billiard_shot.cli.options import positional


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


OPTIONS = (OfOneScene(),)


def run(options: argparse.Namespace) -> int:
    """Print the scene."""
    data = Scene.load(options.scene).to_dict(derived=True)
    print(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=55).rstrip())
    return 0
