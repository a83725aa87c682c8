"""The page about a film: pictures with what was found, and four clicks that tell the corners."""

from base64 import b64encode
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from billiard_shot.film.film import FilmResult, Shot
from billiard_shot.film.lens import Bytes, Camera, Floats
from billiard_shot.film.tracks import rows_of
from billiard_shot.pictures.colours import ball_colour
from billiard_shot.pictures.view import write_text

WIDEST, QUALITY = 1280, 80
"""Largest width of a picture [px], and its quality."""

MOST_SHOTS = 30
"""Shots that are drawn."""

GAP = 0.1
"""Between sights that are farther apart, a track is not drawn [s]."""

STYLE = """
body { margin: 0 auto; max-width: 1100px; padding: 20px 16px 60px; color: #1d2327;
  font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; } h2 { font-size: 18px; margin: 34px 0 8px; }
figure { margin: 0 0 20px; } figcaption { color: #5b666e; }
svg { display: block; width: 100%; height: auto; }
.warning { border-left: 4px solid #d55e00; padding: 4px 12px; }
.nose, .ball, .track { fill: none; vector-effect: non-scaling-stroke; stroke-width: 1.5px; }
.nose { stroke: #f0e442; } .sight { fill: #cc79a7; } .corner { fill: #d55e00; }
.ball { stroke: #fff; } .under { stroke: #000; stroke-width: 4px; }
code { overflow-wrap: anywhere; }
"""

SCRIPT = """
const picture = document.getElementById('corners'), text = document.getElementById('option');
let clicks = [];
picture.addEventListener('click', event => {
  const at = new DOMPoint(event.clientX, event.clientY)
    .matrixTransform(picture.getScreenCTM().inverse());
  if (clicks.length === 4) {
    clicks = [];
    picture.querySelectorAll('.corner').forEach(each => each.remove());
  }
  clicks.push(`${at.x.toFixed(1)},${at.y.toFixed(1)}`);
  const dot = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
  dot.setAttribute('class', 'corner');
  for (const [key, value] of [['cx', at.x], ['cy', at.y], ['r', 4]]) dot.setAttribute(key, value);
  picture.append(dot);
  text.textContent = clicks.length < 4 ? `${4 - clicks.length} more` :
    `--corners ${clicks.join(' ')}`;
});
"""


class Drawn(NamedTuple):
    """A picture, and marks in its pixels, as SVG."""

    picture: Bytes
    marks: str
    caption: str = ''


def write_page(result: FilmResult, radius: float, height: float, path: Path) -> None:
    """Write the page of a film; radius of the balls and height of the noses in m."""
    camera = result.table.camera
    first = result.pictures[0][1]
    parts = [f'<h1>What was found in {escape(Path(result.recording.name).name)}</h1>']
    parts.append(f'<p>{len(result.recording.shots)} shots, {len(result.balls)} balls.</p>')
    parts += _list('What was noticed, and what was given up', _notes(result))
    parts += _corners(Drawn(first, _table(result, height)))
    parts.append('<h2>Shots</h2>')
    for shot in result.shots[:MOST_SHOTS]:
        parts.append(_figure(_drawn(result, shot, radius, camera)))
    if len(result.shots) > MOST_SHOTS:
        parts.append(f'<p>{len(result.shots) - MOST_SHOTS} more shots are not drawn.</p>')
    write_text(path, _page(parts))


def write_corner_page(picture: Bytes, why: str, path: Path) -> None:
    """Write a page that only asks for the corners."""
    warning = f'<p class="warning">{escape(why)}</p>'
    write_text(
        path, _page(['<h1>The table was not found</h1>', warning, *_corners(Drawn(picture, ''))])
    )


def _page(parts: Sequence[str]) -> str:
    return '\n'.join([
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Film</title>',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<style>{STYLE}</style></head><body>', *parts,
        f'<script>{SCRIPT}</script></body></html>',
    ])  # fmt: skip


def _notes(result: FilmResult) -> Iterator[str]:
    yield f'errors of noses and sights: {result.table.error:.2f} px (root mean square)'
    yield from result.notes
    for path, why in result.given_up:
        yield f'a spot from {path.time[0]:.2f} s on, seen {len(path.time)} times: {why}'


def _list(title: str, texts: Iterator[str]) -> list[str]:
    items = [f'<li>{escape(text)}</li>' for text in texts]
    return [f'<h2>{title}</h2><ul>', *items, '</ul>']


def _corners(drawn: Drawn) -> list[str]:
    return [
        '<h2>The table</h2><p>Yellow: the noses of the cushions. If they are elsewhere, click on '
        'the four corners at which their lines cross, and give the command this option: '
        '<code id="option">--corners</code></p>',
        _figure(drawn, 'id="corners" style="cursor: crosshair"'),
    ]


def _figure(drawn: Drawn, more: str = '') -> str:
    height, width = drawn.picture.shape[:2]
    shown = drawn.picture
    if width > WIDEST:
        size = WIDEST, round(height * WIDEST / width)
        shown = cv2.resize(shown, size, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    code = cv2.imencode('.jpg', cv2.cvtColor(shown, cv2.COLOR_RGB2BGR), options)[1].tobytes()
    return (
        f'<figure><svg {more} viewBox="-0.5 -0.5 {width} {height}" role="img" aria-label="picture '
        f'of the film"><image x="-0.5" y="-0.5" width="{width}" height="{height}" '
        f'href="data:image/jpeg;base64,{b64encode(code).decode()}"/>{drawn.marks}</svg>'
        f'<figcaption>{escape(drawn.caption)}</figcaption></figure>'
    )


def _line(kind: str, pixels: Floats, colour: str = '') -> str:
    points = ' '.join(f'{u:.1f},{v:.1f}' for u, v in pixels)
    stroke = f' style="stroke: {colour}"' if colour else ''
    return f'<polyline class="{kind}" points="{points}"{stroke}/>'


def _table(result: FilmResult, height: float) -> str:
    dots = ''.join(
        f'<circle class="sight" cx="{u:.1f}" cy="{v:.1f}" r="3"/>'
        for u, v in result.table.sights.pixel
    )
    return _line('nose', result.table.camera.rim(height)) + dots


def _drawn(result: FilmResult, shot: Shot, radius: float, camera: Camera) -> Drawn:
    """Draw the tracks of a shot, and the balls of a picture in it."""
    inside = [each for each in result.pictures if shot.begin <= each[0] <= shot.end]
    time, picture = min(
        inside or result.pictures, key=lambda each: abs(each[0] - shot.strike - 0.5)
    )
    marks = []
    for name, path in result.balls.items():
        rows = rows_of(path)
        near = rows[np.abs(rows[:, 0] - time).argmin()]
        rows = rows[(rows[:, 0] >= shot.begin) & (rows[:, 0] <= shot.end)]
        lifted = np.column_stack([rows[:, 1:3], np.full(len(rows), radius)])
        pixels = camera.project(lifted)
        for part in np.split(pixels, 1 + np.flatnonzero(np.diff(rows[:, 0]) > GAP)):
            marks += [_line('track under', part), _line('track', part, ball_colour(name))]
        if abs(near[0] - time) < GAP:
            place = np.array([[near[1], near[2], radius]])
            marks.append(_line('ball', camera.outlines(place, radius, 36)[0]))
    caption = f'{result.shots.index(shot) + 1}: {shot.struck} is struck at {shot.strike:.3f} s'
    return Drawn(picture, ''.join(marks), f'{caption}; the picture is that of {time:.2f} s')
