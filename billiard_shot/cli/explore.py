"""`billiard-shot explore`: write a scene as an HTML page to play on, or serve it with plans."""

import argparse
import asyncio
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar

from billiard_shot import Scene
from billiard_shot.cli.options import option
from billiard_shot.cli.shots import OfSite, OfUsualScene, scene_name, site_of
from billiard_shot.pictures.view import page_of_scene, write_text
from billiard_shot.scene.fields import whole_number


@dataclass(frozen=True)
class OfPage:
    """
    The page.

    Parameters
    ----------
    output : FILE.html
        Output file (default: %(PAGE)s).
    title : str
        Title of the page (default: the name of the scene).

    """

    PAGE: ClassVar = Path('table.html')
    output: Path | None = option('-o')
    title: str | None = None


@dataclass(frozen=True)
class OfServer:
    """
    Plans for the page.

    Parameters
    ----------
    plan : bool
        Serve the page on this machine until Ctrl+C, with plans; print its address. Needs the
        extra live: %(EXTRA)s.
    port : N
        For --plan (default: a free one).

    """

    EXTRA: ClassVar = "pip install 'billiard_shot[live]'"
    plan: bool = False
    port: int | None = whole_number(minimum=0, maximum=65535, default=None)


OPTIONS = OfUsualScene('nine_ball'), OfPage(), OfSite(), OfServer()


def run(options: argparse.Namespace) -> int:
    """Write the page and print its path, or serve it and print its address."""
    name = scene_name(options)
    title = options.title or Path(name).stem
    if options.plan:
        _serve(Scene.load(name), title, options)
        return 0
    if options.port is not None:
        raise ValueError('--port needs --plan')
    output = options.output or OfPage.PAGE
    if output.suffix != '.html':
        raise ValueError(f'--output must be a file .html, got {output}')
    write_text(output, page_of_scene(name, title, site=site_of(options)))
    print(output)
    return 0


def _serve(scene: Scene, title: str, options: argparse.Namespace) -> None:
    for name in ('output', 'site'):
        if getattr(options, name):
            raise ValueError(f'--{name} must not be given together with --plan')
    try:
        from billiard_shot.cli.plan_server import serve
    except ModuleNotFoundError:
        raise ValueError(f'--plan: needs tornado, an extra: {OfServer.EXTRA}') from None
    page = page_of_scene(scene, title, planner=True)
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(scene, page, options.port or 0, partial(print, flush=True)))
