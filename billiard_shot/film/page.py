"""The page about a film: pictures with what was found, and four clicks that tell the corners."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

import cv2
import numpy as np

from billiard_shot.film.drawing import outlined
from billiard_shot.film.film import FilmResult, Shot
from billiard_shot.film.lens import Bytes
from billiard_shot.pictures.calibration import styled_page
from billiard_shot.pictures.view import write_text
from billiard_shot.table.run.results import plural

WIDEST, QUALITY = 1280, 80
"""Largest width of a picture [px], and its quality."""

GAP = 0.1
"""Between sights that are farther apart, a track is not drawn [s]."""


def write_page(result: FilmResult, path: Path) -> None:
    """Write the page of a film."""
    errors = f'errors of noses and sights: {result.table.error:.2f} px (root mean square)'
    first = outlined(result.pictures[0][1], result.table, {})
    counts = (plural(len(result.recording.shots), 'shot'), plural(len(result.balls), 'ball'))
    parts = [
        f'<h1>What was found in {escape(Path(result.recording.name).name)}</h1>',
        f'<p>{", ".join(counts)}.</p>',
        '<h2>What was noticed, and what was given up</h2><ul>',
        *(f'<li>{escape(text)}</li>' for text in (errors, *result.notes)),
        '</ul>',
    ]
    asked = 'Yellow: the noses of the cushions. If they are elsewhere, click on the four corners'
    shots = [_figure(*drawn(result, shot)) for shot in result.shots]
    _write(path, parts, asked, first, ['<h2>Shots</h2>', *shots])


def write_corner_page(picture: Bytes, why: str, path: Path) -> None:
    """Write a page that only asks for the corners."""
    warning = f'<p class="warning">{escape(why)}</p>'
    asked = 'Click on the four corners of the noses'
    _write(path, ['<h1>The table was not found</h1>', warning], asked, picture)


def _write(
    path: Path, parts: Sequence[str], asked: str, picture: Bytes, shots: Sequence[str] = ()
) -> None:
    own = (files('billiard_shot.pictures') / 'page' / 'film.html').read_text(encoding='utf-8')
    table = (
        f'<h2>The table</h2><p>{asked} at which their lines cross, and give the command this '
        'option: <code id="option">--corners</code></p>'
    )
    corners = _figure(picture, '', 'id="corners" ')
    write_text(path, styled_page([*parts, table, corners, *shots, own]))


def drawn(result: FilmResult, shot: Shot) -> tuple[Bytes, str]:
    """Draw the tracks of a shot, and the balls of a picture in it; also return its caption."""
    inside = [each for each in result.pictures if shot.begin <= each[0] <= shot.end]
    time, picture = min(
        inside or result.pictures, key=lambda each: abs(each[0] - shot.strike - 0.5)
    )
    balls, tracks = {}, []
    for name, rows in result.balls.items():
        near = rows[np.abs(rows['time'] - time).argmin()]
        if abs(near['time'] - time) < GAP:
            balls[name] = near['place']
        rows = rows[(rows['time'] >= shot.begin) & (rows['time'] <= shot.end)]
        parts = np.split(rows['place'], 1 + np.flatnonzero(np.diff(rows['time']) > GAP))
        tracks += [(name, part) for part in parts]
    caption = f'{result.shots.index(shot) + 1}: {shot.struck} is struck at {shot.strike:.3f} s'
    caption += f'; the picture is that of {time:.2f} s'
    return outlined(picture, result.table, balls, tracks), caption


def _figure(picture: Bytes, caption: str, more: str = '') -> str:
    height, width = picture.shape[:2]
    if width > WIDEST:
        size = WIDEST, round(height * WIDEST / width)
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    code = cv2.imencode('.jpg', cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), options)[1].tobytes()
    return (
        f'<figure><img {more}data-width="{width}" alt="picture of the film" '
        f'src="data:image/jpeg;base64,{b64encode(code).decode()}">'
        f'<figcaption>{escape(caption)}</figcaption></figure>'
    )
