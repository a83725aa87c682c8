"""`billiard-shot explore`: write a scene as an HTML page to play on, or serve it with plans."""

import argparse
import asyncio
from contextlib import suppress
from functools import partial
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.shots import add_scene_argument, scene_name
from billiard_shot.pictures.view import page_of_scene, write_text

PAGE = Path('table.html')
LARGEST_PORT = 65535


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for the scene and the page."""
    add_scene_argument(parser, 'nine_ball')
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.html',
        help=f'output file (default: {PAGE})',
    )
    parser.add_argument('--title', help='title of the page (default: the name of the scene)')
    parser.add_argument(
        '--plan',
        action='store_true',
        help='serve the page on this machine until Ctrl+C, with plans; print its address',
    )
    parser.add_argument(
        '--port', type=int, default=0, metavar='N', help='for --plan (default: a free one)'
    )


def run(options: argparse.Namespace) -> int:
    """Write the page and print its path, or serve it and print its address."""
    name = scene_name(options)
    title = options.title or Path(name).stem
    if options.plan:
        _serve(Scene.load(name), title, options)
        return 0
    output = options.output or PAGE
    if output.suffix != '.html':
        raise ValueError(f'--output must be a file .html, got {output}')
    write_text(output, page_of_scene(name, title))
    print(output)
    return 0


def _serve(scene: Scene, title: str, options: argparse.Namespace) -> None:
    if options.output:
        raise ValueError('--output must not be given together with --plan')
    if not 0 <= options.port <= LARGEST_PORT:
        raise ValueError(f'--port must be 0 to {LARGEST_PORT}, got {options.port}')
    try:
        from billiard_shot.cli.plan_server import serve
    except ModuleNotFoundError:
        raise ValueError(
            "--plan: needs tornado, an extra: pip install 'billiard_shot[live]'"
        ) from None
    page = page_of_scene(scene, title, planner=True)
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(scene, page, options.port, partial(print, flush=True)))
