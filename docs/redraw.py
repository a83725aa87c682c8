"""
Draw the pictures of docs/figures anew: python docs/redraw.py [NAME.png ...] (default: all).

Two are screenshots: view.jpg of `billiard-shot view`, foxglove.png of Foxglove. games-rack.png is
drawn by `benchmarks/games.py --write`, and those of films by `benchmarks/film.py --write`.
"""

import os
from pathlib import Path
import re
import shlex
import sys
from tempfile import TemporaryDirectory

sys.path += [
    str(Path(__file__).resolve().parent / '_ext'),
    str(Path(__file__).resolve().parents[1]),
]
from pages import DOCS, FILE

from billiard_shot.cli import main
from studies import figures, laws, methods

SCREENSHOTS = {'view.jpg', 'foxglove.png'}
FILMS = {'film-overhead.jpg', 'film-oblique-green.jpg', 'film-aside.jpg'}
MEASURED = {'games-rack.png', *FILMS}
STUDIES = (
    'study accuracy --picture tolerance.png',
    'map pool_table --ball 8 --ball-at 0.5 0.2 --grid 24x12 --picture success-map.png',
    'study effects nine_ball --picture effects.png',
    'laws.py --picture laws.png',
    'methods.py --picture accuracy.png',
)
SCRIPTS = {'figures.py': figures.main, 'laws.py': laws.main, 'methods.py': methods.main}


def commands() -> dict[str, list[str]]:
    """Return the commands that draw each picture; those of shots are in the pages themselves."""
    drawn = {f'{name}.png': [f'figures.py {name} -o .'] for name in figures.FIGURES}
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
                first, *words = shlex.split(command)
                script = SCRIPTS.get(first)
                assert (script(words) if script else main([first, *words])) == 0, command
            (DOCS / 'figures' / name).write_bytes(Path(name).read_bytes())


if __name__ == '__main__':
    redraw(sys.argv[1:])
