"""`billiard-shot export`: a scene, and the compiled core, for pages and for programs in C."""

import argparse
import json
from pathlib import Path

from billiard_shot.embed.scenes import c_scene, copy_library, copy_module, export_scene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for the scene and the files."""
    parser.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        required=True,
        metavar='FILE',
        help='NAME.json for the JavaScript module, NAME.h for C',
    )
    parser.add_argument(
        '--core',
        action='store_true',
        help='also put the core beside it: module and WebAssembly, or header and library',
    )


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
