"""`billiard-shot view` and `explore`: a shot or a scene as an HTML page; a shot as a video."""

import argparse
import asyncio
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
import sys
from typing import ClassVar

from billiard_shot import Scene
from billiard_shot.cli.options import option, Subcommand
from billiard_shot.cli.output import reporting
from billiard_shot.cli.shots import (
    of_each,
    OfSite,
    OfUsualScene,
    scene_name,
    SHOT_OPTIONS,
    shots_of,
    site_of,
    title_of,
)
from billiard_shot.pictures.table import image_times, require_encoder, write_video
from billiard_shot.pictures.view import page_of_scene, write_page, write_text
from billiard_shot.scene.fields import whole_number


@dataclass(frozen=True)
class OfShotPage:
    """
    The page or video.

    Parameters
    ----------
    output : FILE.html
        Output file; FILE-NAME for each of several strokes (default: %(PAGE)s).
    video : FILE.gif
        Write a video of the table from above instead; .gif or .mp4.
    title : str
        Title of the page (default: the name of the shot).

    """

    PAGE: ClassVar = Path('shot.html')
    output: Path | None = option('-o')
    video: Path | None = None
    title: str | None = None


def run_view(options: argparse.Namespace) -> int:
    """Write pages or videos and print their paths; 1 if a stroke was refused, and so left out."""
    page = options.output or OfShotPage.PAGE
    if options.video and options.output:
        raise ValueError('--output must not be given together with --video')
    if options.video:
        require_encoder(options.video)  # before the work, not after it
    elif page.suffix != '.html':
        raise ValueError(f'--output must be a file .html, got {page}')
    shots, site = shots_of(options), site_of(options)
    for name, shot in shots.items():
        if shot.status.refused:
            text = f'{shot.status.name}: {shot.message}'
            print(title_of(name, text, shots), file=sys.stderr)
            continue
        path = of_each(options.video or page, name, shots)
        if options.video:
            with reporting('video', len(image_times(shot))) as report:
                write_video(shot, path, options.title or '', report)
        else:
            write_page(shot, path, options.title or _title(name, options), site)
        print(path)
    return 1 if any(shot.status.refused for shot in shots.values()) else 0


def _title(name: str, options: argparse.Namespace) -> str:
    """Name of the shot if it has one, else of the scene."""
    recorded = options.scene and Path(options.scene).suffix == '.json'
    return name if recorded or options.strokes else scene_name(options)


view = Subcommand((OfShotPage(), OfSite(), *SHOT_OPTIONS), run_view)


@dataclass(frozen=True)
class OfScenePage:
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


def run_explore(options: argparse.Namespace) -> int:
    """Write the page and print its path, or serve it and print its address."""
    name = scene_name(options)
    title = options.title or Path(name).stem
    if options.plan:
        _serve(Scene.load(name), title, options)
        return 0
    if options.port is not None:
        raise ValueError('--port needs --plan')
    output = options.output or OfScenePage.PAGE
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


explore = Subcommand((OfUsualScene('nine_ball'), OfScenePage(), OfSite(), OfServer()), run_explore)
