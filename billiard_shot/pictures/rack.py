"""A rack as pages: a list of its shots, and for each shot a page that plays it."""

from html import escape
from pathlib import Path

from billiard_shot.game.rack import replayed
from billiard_shot.game.rack_record import PlayedShot, RackRecord
from billiard_shot.pictures.view import page_of
from billiard_shot.scene import Scene

STYLE = 'body{font:16px sans-serif;max-width:50em;margin:2em auto;padding:0 1em}li{margin:.5em 0}'


def write_rack(record: RackRecord, scene: Scene, folder: Path) -> Path:
    """
    Write the pages of a rack that was played with `simulated`.

    Parameters
    ----------
    record : RackRecord
    scene : Scene
        On which it was played.
    folder : Path
        Is made if it is not there.

    Returns
    -------
    Path
        The page with the list of shots.

    Raises
    ------
    ValueError
        If a page cannot be written.

    """
    items = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number, (played, shot) in enumerate(replayed(record, scene), 1):
            text = _in_words(record, played)
            name = f'shot-{number:02d}.html'
            (folder / name).write_text(page_of(shot, f'{number}. {text}'), encoding='utf-8')
            items.append(f'<li><a href="{name}">{escape(text)}</a></li>')
        title = f'{record.game}, rack {record.number}: {record.winner or "nobody"} wins'
        page = folder / 'index.html'
        page.write_text(
            f'<!doctype html><meta charset="utf-8"><title>{escape(title)}</title>'
            f'<style>{STYLE}</style><h1>{escape(title)}</h1><ol>{"".join(items)}</ol>\n',
            encoding='utf-8',
        )
    except OSError as error:
        raise ValueError(f'{folder}: {error}') from None
    return page


def _in_words(record: RackRecord, played: PlayedShot) -> str:
    player = record.players[played.state['player']]
    why = f' ({played.reason})' if played.reason else ''
    return f'{player}{why}: {played.text}'
