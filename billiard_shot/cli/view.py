"""`billiard-shot view`: write a shot as an interactive HTML page, or as a video."""

import argparse
from dataclasses import dataclass
from pathlib import Path
import sys
from typing import ClassVar

from billiard_shot.cli.options import option
from billiard_shot.cli.output import reporting
from billiard_shot.cli.shots import (
    of_each,
    OfSite,
    scene_name,
    SHOT_OPTIONS,
    shots_of,
    site_of,
    title_of,
)
from billiard_shot.pictures.table import image_times, require_encoder, write_video
from billiard_shot.pictures.view import write_page


@dataclass(frozen=True)
class OfPage:
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


OPTIONS = OfPage(), OfSite(), *SHOT_OPTIONS


def run(options: argparse.Namespace) -> int:
    """Write pages or videos and print their paths; 1 if a stroke was refused, and so left out."""
    page = options.output or OfPage.PAGE
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
