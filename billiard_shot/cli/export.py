"""`billiard-shot export`: a scene, and the compiled core, for pages and for programs in C."""

import argparse
from dataclasses import dataclass
import json
from pathlib import Path

from billiard_shot.cli.options import option, positional
from billiard_shot.embed.scenes import c_scene, copy_library, copy_module, export_scene


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


OPTIONS = (OfExport(),)


def run(options: argparse.Namespace) -> int:
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
