"""A rack as pages; the table of a game, drawn with characters."""

from collections.abc import Callable, Sequence
from html import escape
from itertools import product
from pathlib import Path
from typing import Any

from billiard_shot.embed.scenes import core_script
from billiard_shot.game.rack import PlayedShot, RackRecord, replayed
from billiard_shot.game.state import State
from billiard_shot.pictures.canvas import has_matplotlib, new_figure, save
from billiard_shot.pictures.table import draw_start_and_rest, draw_table, draw_trails
from billiard_shot.pictures.trails import trails_of
from billiard_shot.pictures.view import page_of
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import reason
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import ball_in_words

COLUMNS = 67
ROW = 2.0  # height of a character, in widths
CUE, POCKET, HEAD_STRING = '@', 'O', ':'


def table_text(state: State) -> str:
    """
    Draw the balls of a state on the table, with its pockets, its head string and its size [m].

    The foot of the table is to the right. Balls that are too near to each other for the size of
    the characters are drawn beside their places.
    """
    rows = round(COLUMNS * state.width / state.length / ROW)
    cells = [[' '] * COLUMNS for _ in range(rows)]
    for line in cells:
        line[COLUMNS // 4] = HEAD_STRING
    taken: set[tuple[int, int]] = set()
    labels = {ball: _label(ball) for ball in state.balls}
    for ball, label in labels.items():
        x, y = state.balls[ball]
        across = (x / state.length + 0.5) * COLUMNS - 0.5 * len(label)
        down = (0.5 - y / state.width) * rows - 0.5
        row, column = min(
            (
                place
                for place in product(range(rows), range(COLUMNS - len(label) + 1))
                if not any((place[0], place[1] + i) in taken for i in range(-1, len(label) + 1))
            ),
            key=lambda place: (ROW * (place[0] - down)) ** 2 + (place[1] - across) ** 2,
        )
        cells[row][column : column + len(label)] = label
        taken |= {(row, column + i) for i in range(len(label))}
    named = state.game.pockets
    x, y = 0.5 * state.length, 0.5 * state.width
    key = [f'{labels[ball]} {ball_in_words(ball)}' for ball in labels if not ball.isdecimal()]
    return '\n'.join(
        [
            *([_spread(*(f'{end}_left' for end in ('head', 'side', 'foot')))] if named else []),
            f'{_edge(named)} y {y:.2f}',
            *(f'|{"".join(line)}|' for line in cells),
            f'{_edge(named)} y {-y:.2f}',
            *([_spread(*(f'{end}_right' for end in ('head', 'side', 'foot')))] if named else []),
            _spread(f'x {-x:.2f}', ', '.join([*key, f'{HEAD_STRING} head string']), f'x {x:.2f}'),
        ]
    )


def _label(ball: str) -> str:
    """One or two characters for a ball."""
    if ball == CUE_BALL:
        return CUE
    return ball if ball.isdecimal() else ball[0].upper()


def _edge(pockets: bool) -> str:
    corner = POCKET if pockets else '+'
    half = '-' * ((COLUMNS - 1) // 2)
    return f'{corner}{half}{POCKET if pockets else "-"}{half}{corner}'


def _spread(left: str, middle: str, right: str) -> str:
    """Put words at the left end, in the middle and at the right end of a line."""
    text = middle.center(COLUMNS + 2)
    return left + text[len(left) : COLUMNS + 2 - len(right)] + right


PANEL_SIZE = 3.4, 2.05  # inches
LIST = 'index.html'  # name of the page with all shots
CORE = 'core.js'  # name of the file that all pages include
STYLE = (
    'body{font:16px sans-serif;max-width:64em;margin:2em auto;padding:0 1em}'
    'ol{display:grid;grid-template-columns:repeat(auto-fill,minmax(17em,1fr));gap:1.5em 2em;'
    'list-style:none;padding:0}'
    'img{display:block;width:100%;margin-bottom:.3em}'
)


def write_rack(
    record: RackRecord, scene: Scene, folder: Path, stop: Callable[[], bool] = lambda: False
) -> Path:
    """
    Write the pages of a rack that was played with `simulated`: each shot, and a list of all.

    The pages have links to each other, and share one file with the core. If matplotlib is there,
    the list has pictures.

    Parameters
    ----------
    record : RackRecord
    scene : Scene
        On which it was played.
    folder : Path
        Is made if it is not there.
    stop : callable
        Asked before each page and picture: if true, the list is written, and no more of them.

    Returns
    -------
    Path
        The page with the list of shots.

    Raises
    ------
    ValueError
        If a page cannot be written.

    """
    texts = [
        f'{number}. {_in_words(record, played)}'
        for number, played in enumerate((shot for shot in record.shots if shot.offsets), 1)
    ]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        try:
            shots = [shot for _, shot in replayed(record, scene)]
            _write_pages(folder, shots, texts, stop)
            if has_matplotlib():
                for number, shot in enumerate(shots, 1):
                    if stop():
                        break
                    figure = new_figure(*PANEL_SIZE)
                    draw_panel(figure.subplots(), shot)
                    save(figure, folder / _name(number, 'png'))
        finally:  # also if Ctrl+C ends the work
            _write_list(folder, record, texts)
    except OSError as error:
        raise ValueError(f'{folder}: {reason(error)}') from None
    return folder / LIST


def _write_pages(
    folder: Path, shots: Sequence[Shot], texts: Sequence[str], stop: Callable[[], bool]
) -> None:
    """Write the page of each shot, and the file with the core."""
    (folder / CORE).write_text(core_script(), encoding='utf-8')
    for number, (shot, text) in enumerate(zip(shots, texts, strict=True), 1):
        if stop():
            break
        links = {'All shots': LIST}
        if number > 1:
            links['← Previous'] = _name(number - 1)
        if number < len(shots):
            links['Next →'] = _name(number + 1)
        page = page_of(shot, text, links, CORE)
        (folder / _name(number)).write_text(page, encoding='utf-8')


def _write_list(folder: Path, record: RackRecord, texts: Sequence[str]) -> None:
    """Write the list of all shots, with the pages and pictures that are there."""
    items = []
    for number, text in enumerate(texts, 1):
        page, picture = _name(number), _name(number, 'png')
        image = f'<img src="{picture}" alt="">' if (folder / picture).is_file() else ''
        link = f'<a href="{page}">' if (folder / page).is_file() else '<a>'
        items.append(f'<li>{link}{image}{escape(text)}</a></li>')
    end = f'{record.winner or "nobody"} wins' if record.state['over'] else 'not finished'
    title = f'{record.game}, rack {record.number}: {end}'
    (folder / LIST).write_text(
        f'<!doctype html><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<style>{STYLE}</style><h1>{escape(title)}</h1><ol>{"".join(items)}</ol>\n',
        encoding='utf-8',
    )


def draw_panel(axes: Any, shot: Shot) -> None:
    """Draw a shot from above, without a legend."""
    x, y = outline_of(shot.scene).frame
    axes.set(xlim=(-x, x), ylim=(-y, y), aspect='equal')
    axes.set_axis_off()
    draw_table(axes, shot.scene)
    trails = trails_of(shot)
    draw_trails(axes, trails)
    draw_start_and_rest(axes, trails)


def _name(number: int, kind: str = 'html') -> str:
    """Name of the page of a shot, or of its picture."""
    return f'shot-{number:02d}.{kind}'


def _in_words(record: RackRecord, played: PlayedShot) -> str:
    player = record.players[played.state['player']]
    why = f' ({played.reason})' if played.reason else ''
    return f'{player}{why}: {played.text}'
