"""
Draw the pictures of docs/figures anew: python docs/redraw.py [NAME.png ...] (default: all).

Two are screenshots: view.jpg of `billiard-shot view`, foxglove.png of Foxglove. games-rack.png is
drawn by `benchmarks/games.py --write`.
"""

import os
from pathlib import Path
import re
import shlex
import sys
from tempfile import TemporaryDirectory

from billiard_shot.cli import main
from billiard_shot.pictures.figures import FIGURES

sys.path.append(str(Path(__file__).resolve().parent / '_ext'))
from pages import DOCS, FILE

SCREENSHOTS = {'view.jpg', 'foxglove.png'}
MEASURED = {'games-rack.png'}
STUDIES = (
    'study accuracy --picture accuracy.png',
    'atlas pool_table --ball 8 --ball-at 0.5 0.2 --cue-grid 24x12 --budget 2000 '
    '--output atlas.jsonl --picture atlas.png',
    'study effects nine_ball --picture effects.png',
    'study laws --picture laws.png',
    'study tolerance --picture tolerance.png',
)


def commands() -> dict[str, list[str]]:
    """Return the commands that draw each picture; those of shots are in the pages themselves."""
    drawn = {f'{name}.png': [f'study figures {name} -o .'] for name in FIGURES}
    pages = ''.join((DOCS / page).read_text() for page in ('recipes.md', 'tutorial.md'))
    before = re.findall(r'^(?:\$ )?billiard-shot (.* -o .*)$', pages, re.MULTILINE)
    shots = re.findall(r'^(?:\$ )?billiard-shot (.*)$', pages.replace('\\\n', ''), re.MULTILINE)
    for command in (*STUDIES, *shots):
        for name in re.findall(r'--picture ([\w-]+\.png)', command):
            drawn[name] = [each for each in before if each.split()[-1] in command] + [command]
    return {name: drawn[name] for name in sorted(drawn) if (DOCS / 'figures' / name).is_file()}


def redraw(names: list[str]) -> None:
    """Draw pictures in a folder with the files that the pages show."""
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        for page in ('recipes.md', 'tutorial.md'):
            for name, text in FILE.findall((DOCS / page).read_text()):
                Path(name).write_text(text)
        drawn = commands()
        for name in names or drawn:
            for command in drawn[name]:
                assert main(shlex.split(command)) in (None, 0), command
            (DOCS / 'figures' / name).write_bytes(Path(name).read_bytes())


if __name__ == '__main__':
    redraw(sys.argv[1:])
