"""
The pictures of docs/figures that show the model and shots, by name; other studies draw their own.

    python studies/figures.py [NAME ...] [-o FOLDER]
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
import sys

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/figures.py`

from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import progress
from billiard_shot.pictures.history import draw_history, draw_strike
from billiard_shot.pictures.table import draw_shot
from billiard_shot.pictures.trails import trails_of
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be_one_of, reason
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from studies.command import run_study
from studies.impulse import (
    draw_impulse_plane,
    draw_ping_pong,
    draw_two_balls,
)
from studies.paper import PRINTED
from studies.paper_shots import draw_paper_shots
from studies.planning_story import draw_planning_story
from studies.rack_gaps import draw_rack_gaps
from studies.tip import draw_tip
from studies.two_balls import TwoBalls


def combination() -> Shot:
    """Play the combination into the corner, with some follow and right-hand side."""
    stroke = Stroke.from_offsets(a=0.2, b=0.3, elevation=0.1, azimuth=0.55, speed=3.0)
    return predict(Scene.load('frozen_combination'), stroke)


def jump() -> Shot:
    """Jump with a jump cue over the ball that stands in front of the 8, and pot it."""
    stroke = Stroke.from_offsets(a=0, b=0, elevation_deg=40, azimuth_deg=-2.3, speed=3.9)
    return predict(Scene.load('jump_cue'), stroke)


def around() -> Shot:
    """Pot the same ball with a massé around the other one."""
    stroke = Stroke.from_offsets(a=-0.3, b=-0.2, elevation_deg=50, azimuth_deg=-20.5, speed=2)
    return predict(Scene.load('blocked'), stroke)


def masse() -> Shot:
    """Play the paper's massé, as computed by its model."""
    return predict(Scene.load('paper'), PRINTED['massé'][0])


def english() -> Shot:
    """Play a player's stroke with side and draw."""
    return predict(Scene.load('pool'), Stroke.from_offsets(0.3, -0.2, 0.15, 0.0, 3.0))


def _draw(shot: Shot, path: Path, about: str) -> None:
    """Draw a shot from above; the title names the shot and its result."""
    draw_shot(shot, path, f'{about}: {shot.message}')


FIGURES: Mapping[str, Callable[[Path], None]] = {
    'impulse-plane': partial(draw_impulse_plane, TwoBalls()),
    'two-balls': partial(draw_two_balls, TwoBalls()),
    'ping-pong': draw_ping_pong,
    'paper-shots': draw_paper_shots,
    'table-jump': lambda path: _draw(jump(), path, 'A jump over ball 1, elevation 40°'),
    'table-masse': lambda path: _draw(around(), path, 'A massé around ball 1, elevation 50°'),
    'rack-gaps': draw_rack_gaps,
    'planning-story': draw_planning_story,
    'tip': draw_tip,
    'history': lambda path: draw_history(
        trails_of(combination()),
        path,
        'The combination: nearly half of the energy falls into the pocket with the 8',
    ),
    'strike-side': lambda path: draw_strike(
        english(),
        path,
        'Right side and draw, 3 m/s: the tip sticks; the cloth presses on when it has left',
    ),
    'strike-masse': lambda path: draw_strike(
        masse(),
        path,
        "The paper's massé, 16.5 m/s, guided cue: the tip presses the ball three times",
    ),
}


@dataclass(frozen=True)
class OfFigures:
    """
    The figures, and their folder.

    Parameters
    ----------
    names : NAME
        Figures to draw (default: all).
    folder : FOLDER
        Folder for NAME.png; made if it is missing (default: %(default)s).
    list_ : bool
        Print the names of the figures and draw nothing.

    """

    names: list[str] = positional('*')
    folder: Path = option('-o', '--output', default=Path('figures'), dest='folder')
    list_: bool = False


OPTIONS = (OfFigures(),)


def run(options: argparse.Namespace) -> int:
    """Draw the figures and print the paths of the files."""
    for name in options.names:
        if name not in FIGURES:
            raise ValueError(f'NAME {must_be_one_of(FIGURES, name)}')
    if options.list:
        print('\n'.join(FIGURES))
        return 0
    try:
        options.folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f'--output: {reason(error)}') from None
    for name in progress(options.names or list(FIGURES), 'figures'):
        path = options.folder / f'{name}.png'
        FIGURES[name](path)
        print(path)
    return 0


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())
