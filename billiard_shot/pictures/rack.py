"""A rack as pages, with a page for each shot that plays it; and as one picture."""

from html import escape
from pathlib import Path

from billiard_shot.game.rack import replayed
from billiard_shot.game.rack_record import PlayedShot, RackRecord
from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.table import draw_balls, draw_table, draw_trails
from billiard_shot.pictures.trails import trails_of
from billiard_shot.pictures.view import page_of
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import reason
from billiard_shot.table.outline import outline_of

RACK_PANELS_PER_ROW = 4  # panels side by side

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
        end = f'{record.winner or "nobody"} wins' if record.state['over'] else 'not finished'
        title = f'{record.game}, rack {record.number}: {end}'
        page = folder / 'index.html'
        page.write_text(
            f'<!doctype html><meta charset="utf-8"><title>{escape(title)}</title>'
            f'<style>{STYLE}</style><h1>{escape(title)}</h1><ol>{"".join(items)}</ol>\n',
            encoding='utf-8',
        )
    except OSError as error:
        raise ValueError(f'{folder}: {reason(error)}') from None
    return page


def draw_rack(record: RackRecord, scene: Scene, path: Path) -> None:
    """
    Draw the strokes of a rack from above, one panel for each.

    Parameters
    ----------
    record, scene
        As of `write_rack`.
    path : Path
        The picture.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    shots = list(replayed(record, scene))
    rows = -(-len(shots) // RACK_PANELS_PER_ROW)
    figure = new_figure(3.4 * RACK_PANELS_PER_ROW, 2.05 * rows)
    half = outline_of(scene).frame
    panels = figure.subplots(rows, RACK_PANELS_PER_ROW, squeeze=False).ravel()
    for number, (axes, (played, shot)) in enumerate(zip(panels, shots, strict=False), 1):
        axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]), aspect='equal')
        draw_table(axes, shot.scene)
        if not shot.status.refused:
            trails = trails_of(shot)
            draw_trails(axes, trails)
            draw_balls(axes, shot.scene, {name: trails.start(name) for name in trails.balls})
        ball = played.call.get('ball')
        what = f'ball {ball}' if ball else played.reason.partition(':')[0]
        axes.set_title(f'{number}. {what}', fontsize='small', loc='left')
    for axes in panels:
        axes.set_axis_off()
    save(figure, path)


def _in_words(record: RackRecord, played: PlayedShot) -> str:
    player = record.players[played.state['player']]
    why = f' ({played.reason})' if played.reason else ''
    return f'{player}{why}: {played.text}'
