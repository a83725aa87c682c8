"""`billiard-shot explore`: write a scene as an HTML page to play on, or serve it with plans."""

import argparse
import asyncio
from contextlib import suppress
from functools import partial
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.shots import add_scene_argument, add_site_argument, scene_name, site_of
from billiard_shot.pictures.view import page_of_scene, write_text

PAGE = Path('table.html')
LARGEST_PORT = 65535
EXTRA = "pip install 'billiard_shot[live]'"


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
    add_site_argument(parser)
    parser.add_argument(
        '--plan',
        action='store_true',
        help='serve the page on this machine until Ctrl+C, with plans; print its address. Needs '
        f'the extra live: {EXTRA}',
    )
    parser.add_argument('--port', type=int, metavar='N', help='for --plan (default: a free one)')


def run(options: argparse.Namespace) -> int:
    """Write the page and print its path, or serve it and print its address."""
    name = scene_name(options)
    title = options.title or Path(name).stem
    if options.plan:
        _serve(Scene.load(name), title, options)
        return 0
    if options.port is not None:
        raise ValueError('--port needs --plan')
    output = options.output or PAGE
    if output.suffix != '.html':
        raise ValueError(f'--output must be a file .html, got {output}')
    write_text(output, page_of_scene(name, title, site=site_of(options)))
    print(output)
    return 0


def _serve(scene: Scene, title: str, options: argparse.Namespace) -> None:
    for name in ('output', 'site'):
        if getattr(options, name):
            raise ValueError(f'--{name} must not be given together with --plan')
    port = options.port or 0
    if not 0 <= port <= LARGEST_PORT:
        raise ValueError(f'--port must be 0 to {LARGEST_PORT}, got {port}')
    try:
        from billiard_shot.cli.plan_server import serve
    except ModuleNotFoundError:
        raise ValueError(f'--plan: needs tornado, an extra: {EXTRA}') from None
    page = page_of_scene(scene, title, planner=True)
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(scene, page, port, partial(print, flush=True)))
