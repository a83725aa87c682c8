"""
A shot as one self-contained HTML file: a table to turn and zoom, balls that move and turn.

The page evaluates the segments of the trajectory, so that its positions are those of
`Trajectory.at`. It interpolates between orientations, which are close enough for that. Its parts
are the files in `page`, put together here.
"""

from collections.abc import Mapping
from importlib.resources import files
import json
import math
from pathlib import Path
import tempfile
from typing import Any
import webbrowser

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.cue_motion import cue_motion
from billiard_shot.pictures.orientations import orientations, product, rotation
from billiard_shot.pictures.trails import path_colours, Trails, trails_of
from billiard_shot.scene.errors import reason
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.table.colours import ball_colour, BLACK, is_striped, ORANGE, PURPLE, SKY
from billiard_shot.table.motion import Motion
from billiard_shot.table.outline import outline_of

SCRIPTS = (
    'vectors.js',
    'meshes.js',
    'shaders.js',
    'renderer.js',
    'elements.js',
    'motion.js',
    'camera.js',
    'labels.js',
    'stroke.js',
    'events.js',
    'player.js',
)
# Colours of the paths of balls: those of Okabe and Ito that stand out on a green cloth.
YELLOW = '#f0e442'
PATHS = '#ffffff', ORANGE, SKY, PURPLE, YELLOW, BLACK
PALE_ON_PAGE = '#7f9f91'
DRAWN_MOTIONS = (Motion.SLIDE, Motion.ROLL, Motion.FLIGHT)
ACROSS, UPWARD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
NO_LINKS: Mapping[str, str] = {}
DRAWN_CUE_LENGTH = 1.47  # m, if the scene does not give it


def page_of(shot: Shot, title: str = 'shot', links: Mapping[str, str] = NO_LINKS) -> str:
    """
    Make the page of a shot.

    A shot that was refused is shown as well: nothing moves. `links` are the addresses of other
    pages, by the texts that lead to them.
    """
    data = json.dumps(view_data(shot, title), ensure_ascii=False, allow_nan=False)
    parts = {
        'TITLE': _escaped(title),
        'STYLE': _part('style.css'),
        'LINKS': ' '.join(f'<a href="{to}">{text}</a>' for text, to in links.items()),
        'DATA': data.replace('<', '\\u003c'),  # no text in it can end the script
        'SCRIPT': '\n'.join(_part(name) for name in SCRIPTS),
    }
    page = _part('page.html')
    for name, text in parts.items():
        page = page.replace(f'<!-- {name} -->', text, 1)
    return page


def write_page(shot: Shot, path: Path, title: str = 'shot') -> None:
    """Write the page of a shot to a file; ValueError if it was refused, or if that fails."""
    if shot.status.refused:
        raise ValueError(f'{path}: not written: {shot.status.name}: {shot.message}')
    try:
        path.write_text(page_of(shot, title), encoding='utf-8')
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None


def open_page(shot: Shot) -> Path:
    """Write the page of a shot to a temporary file, and show it in the browser."""
    path = Path(tempfile.mkdtemp(prefix='billiard_shot-')) / 'shot.html'
    write_page(shot, path)
    webbrowser.open(path.as_uri())
    return path


def view_data(shot: Shot, title: str) -> dict[str, Any]:
    """Collect all that the page shows, in SI units and the frame `table`."""
    trails = trails_of(shot)
    colours = path_colours(trails, PATHS, PALE_ON_PAGE)
    return {
        'title': title,
        'message': f'{shot.status.name}: {shot.message}',
        'radius': shot.scene.ball.radius,
        'until': trails.until,
        'table': _table(shot),
        'cue': _cue(shot, trails),
        'stroke': _stroke(shot),
        'balls': [
            _ball(trails, name, number, colours.get(name))
            for number, name in enumerate(trails.balls)
        ],
        'ghosts': [ghost.tolist() for ghost in trails.ghosts],
        'events': _events(shot),
    }


def _part(name: str) -> str:
    return (files('billiard_shot.pictures') / 'page' / name).read_text(encoding='utf-8')


def _escaped(text: str) -> str:
    return text.replace('&', '&amp;').replace('<', '&lt;')


def _table(shot: Shot) -> dict[str, Any] | None:
    if shot.scene.table is None:
        return None
    outline = outline_of(shot.scene)
    return {
        'size': [shot.scene.table.length, shot.scene.table.width],
        'cushions': [cushion.tolist() for cushion in outline.cushions],
        'holes': outline.holes.tolist(),
        'back': outline.back.tolist(),
        'frame': outline.frame.tolist(),
        'height': outline.height,
    }


def _cue(shot: Shot, trails: Trails) -> dict[str, Any]:
    cue = cue_motion(shot, trails)
    return {
        'tip': cue.tip.tolist(),
        'direction': cue.direction.tolist(),
        'length': shot.scene.cue.length or DRAWN_CUE_LENGTH,
        'swing': cue.swing,
        'time': cue.time,
        'after': cue.after,
    }


def _stroke(shot: Shot) -> dict[str, Any]:
    """Collect the numbers of the stroke, and where the tip and its axis meet the ball's face."""
    ball = shot.scene.ball.radius
    a, b, elevation, azimuth, speed = shot.stroke.offsets
    touch = shot.stroke.touching(shot.scene.cue.tip_curvature_radius / ball)
    return {
        'a': a,
        'b': b,
        'elevation_deg': math.degrees(elevation),
        'azimuth_deg': math.degrees(azimuth),
        'speed': speed,
        'touch': touch.offsets[:2],
    }


def _ball(trails: Trails, name: str, number: int, path: str | None) -> dict[str, Any]:
    ball = trails.balls[name]
    vectors = 'position', 'velocity', 'acceleration', 'spin', 'spin_acceleration'
    numbers = [ball.rows['time'], ball.rows['motion'], *(ball.rows[each].T for each in vectors)]
    times, turns = orientations(ball, trails.until, _first(number))
    return {
        'name': name,
        'colour': ball_colour(name),
        'striped': is_striped(name),
        'path': path,
        'pale': path == PALE_ON_PAGE,
        'trails': [
            {
                'motion': piece.motion.name.lower(),
                'points': np.round(piece.points, 5).ravel().tolist(),
            }
            for piece in trails.pieces(name)
            if piece.motion in DRAWN_MOTIONS
        ],
        'segments': np.vstack(numbers).T.tolist(),
        'times': np.round(times, 6).tolist(),
        'turns': np.round(turns, 5).ravel().tolist(),
    }


def _first(number: int) -> NDArray[np.float64]:
    """Choose the first orientation of a ball: its number up, tilted to its own side."""
    around = 2.4 * number  # the golden angle: no two balls are tilted to the same side
    # the number, at +x with its head at +z, comes to +z with its head at +x
    up = product(rotation(math.pi * UPWARD), rotation(-0.5 * math.pi * ACROSS))
    aside = rotation(0.6 * np.array([math.cos(around), math.sin(around), 0.0]))
    return product(aside, up)


def _events(shot: Shot) -> list[dict[str, Any]]:
    if shot.status.refused:
        return []
    return [
        {'time': 0.0, 'kind': 'strike', 'balls': [CUE_BALL], 'text': 'cue strikes'},
        *({'time': e.time, 'kind': e.kind, 'balls': e.balls, 'text': str(e)} for e in shot.events),
    ]
