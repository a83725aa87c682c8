"""`billiard-shot view`: write a shot as an interactive HTML page, or as a video."""

import argparse
from pathlib import Path
import sys

from billiard_shot.cli.output import reporting
from billiard_shot.cli.shots import (
    add_shot_arguments,
    add_site_argument,
    of_each,
    scene_name,
    shots_of,
    site_of,
    title_of,
)
from billiard_shot.pictures.video import image_times, require_encoder, write_video
from billiard_shot.pictures.view import write_page

PAGE = Path('shot.html')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for shots and output."""
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.html',
        help=f'output file; FILE-NAME for each of several strokes (default: {PAGE})',
    )
    parser.add_argument(
        '--video',
        type=Path,
        metavar='FILE.gif',
        help='write a video of the table from above instead; .gif or .mp4',
    )
    parser.add_argument('--title', help='title of the page (default: the name of the shot)')
    add_site_argument(parser)
    add_shot_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Write pages or videos and print their paths; 1 if a stroke was refused, and so left out."""
    page = options.output or PAGE
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
