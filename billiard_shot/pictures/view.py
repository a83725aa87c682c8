"""
A shot or a scene as one self-contained HTML file: a table to play on.

The page has the compiled core in it. It plays the shot with the numbers that `predict` has, and
again whenever somebody moves a ball or the cue. Its parts are the files in `page`, put together
here.
"""

from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from importlib.resources import files
import json
from pathlib import Path
import re
import tempfile
from typing import Any
import webbrowser

from billiard_shot.embed.page_state import equipment_of, start_of
from billiard_shot.embed.scenes import core_script, export_scene
from billiard_shot.pictures.canvas import ball_colour, is_striped
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import reason
from billiard_shot.scene.player import NOISES, OFFSETS
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE, prepared_scene
from billiard_shot.shot.shot import Shot
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import HAPPENS

NO_LINKS: Mapping[str, str] = {}
DRAWN_CUE_LENGTH = 1.47  # m, if the scene does not give it


def page_of(
    shot: Shot,
    title: str = 'shot',
    links: Mapping[str, str] = NO_LINKS,
    core: str = '',
    framed: bool = False,
    site: str = '',
) -> str:
    """
    Make the page of a shot.

    A shot that was refused is shown as well: nothing moves. `links` are the addresses of other
    pages, by the texts that lead to them. `core` is the address of a file with `core_script`,
    which pages of one folder share; by default the page has the core in it. A `framed` page
    exchanges messages with the page around its frame (frame.js). `site` is the address at which
    the page is to be published: links that the page shares lead there.
    """
    return _page({**view_data(shot, title), 'framed': framed, 'site': site}, links, core)


def page_of_scene(
    scene: SceneLike,
    title: str = 'table',
    links: Mapping[str, str] = NO_LINKS,
    core: str = '',
    framed: bool = False,
    planner: bool = False,
    site: str = '',
) -> str:
    """
    Make a page of a scene without a stroke: the page aims.

    A page with a `planner` asks the server that it comes from for plans (plan.js). For the rest
    see `page_of`.
    """
    data = _scene_data(Scene.load(scene), title)
    return _page({**data, 'framed': framed, 'planner': planner, 'site': site}, links, core)


def write_page(shot: Shot, path: Path, title: str = 'shot', site: str = '') -> None:
    """Write the page of a shot to a file; ValueError if it was refused, or if that fails."""
    if shot.status.refused:
        raise ValueError(f'{path}: not written: {shot.status.name}: {shot.message}')
    write_text(path, page_of(shot, title, site=site))


def write_text(path: Path, text: str) -> None:
    """Write a page to a file; ValueError if that fails."""
    try:
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None


def open_page(shot: Shot) -> Path:
    """Write the page of a shot to a temporary file, and show it in the browser."""
    path = Path(tempfile.mkdtemp(prefix='billiard_shot-')) / 'shot.html'
    write_page(shot, path)
    webbrowser.open(path.as_uri())
    return path


def view_data(shot: Shot, title: str) -> dict[str, Any]:
    """Collect all that the page of a shot shows, in SI units and the frame `table`."""
    return {**_scene_data(shot.scene, title, shot.tolerance), 'start': start_of(shot)}


def _page(data: dict[str, Any], links: Mapping[str, str], core: str) -> str:
    # A link says what differs from the page that made it: another page asks before it follows it.
    begin = json.dumps([data['source'], data.get('start')], sort_keys=True)
    data = {**data, 'id': sha256(begin.encode()).hexdigest()[:12]}
    page = _part('page.html')
    listed = re.findall('<!-- (SCRIPTS .*?) -->', page, re.DOTALL)[0]  # in their order
    script = '\n'.join(_part(name) for name in listed.split()[1:])
    inline = '' if core else core_script()
    hashes = (b64encode(sha256(text.encode()).digest()).decode() for text in (script, inline))
    parts = {
        'POLICY': ' '.join(f"'sha256-{each}'" for each in hashes) + (" 'self' file:" * bool(core)),
        'CONNECT': "'self'" if data.get('planner') else '',
        'TITLE': escape(data['title']),
        'STYLE': _part('style.css'),
        'LINKS': ' '.join(
            f'<a href="{escape(to)}">{escape(text)}</a>' for text, to in links.items()
        ),
        # no text in it can end the script
        'DATA': json.dumps(data, ensure_ascii=False, allow_nan=False).replace('<', '\\u003c'),
        'CORE': f'<script src="{escape(core)}"></script>' if core else _script(inline),
        listed: script,
    }
    for name, text in parts.items():
        page = page.replace(f'<!-- {name} -->', text, 1)
    return page


def _part(name: str) -> str:
    return (files('billiard_shot.pictures') / 'page' / name).read_text(encoding='utf-8')


def _script(text: str) -> str:
    return f'<script>{text}</script>'


def _scene_data(
    scene: Scene, title: str, tolerance: float = DEFAULT_SHOT_TOLERANCE
) -> dict[str, Any]:
    curvature = scene.cue.tip_curvature_radius / scene.ball.radius
    return {
        'title': title,
        'scene': export_scene(scene, tolerance),
        'equipment': equipment_of(scene),
        'source': scene.to_dict(),
        'noises': {
            name: dict(zip(OFFSETS, noise.sigmas(scene.ball.radius).tolist(), strict=True))
            for name, noise in NOISES.items()
        },
        'words': {'happens': {str(kind): text for kind, text in HAPPENS.items()}},
        'table': _table(scene),
        'cue': {'length': scene.cue.length or DRAWN_CUE_LENGTH, 'tip_curvature': curvature},
        'balls': [
            {'name': name, 'colour': ball_colour(name), 'striped': is_striped(name)}
            for name in prepared_scene(scene).names
        ],
    }


def _table(scene: Scene) -> dict[str, Any] | None:
    if scene.table is None:
        return None
    outline = outline_of(scene)
    return {
        'size': [scene.table.length, scene.table.width],
        'cushions': [cushion.tolist() for cushion in outline.cushions],
        'holes': outline.holes.tolist(),
        'back': outline.back.tolist(),
        'frame': outline.frame.tolist(),
        'height': outline.height,
    }
