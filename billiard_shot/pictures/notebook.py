"""HTML for notebooks: a picture, if matplotlib is there, and a table in degrees and per cent."""

from base64 import b64encode
from collections.abc import Callable, Iterable
from functools import singledispatch
from html import escape
from io import BytesIO
import math
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import ball_colour, has_matplotlib
from billiard_shot.pictures.table import draw_balls, shot_figure, table_axes
from billiard_shot.planning.result import PlanResult
from billiard_shot.planning.statistics import interval_in_words, percent
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import OFFSETS
from billiard_shot.shot import shot as story
from billiard_shot.shot.play import StrokeBatch
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import rounded

PICTURE_DPI = 80  # of pictures
# As on the page of a shot: the face of the cue ball, and where the tip meets it.
FACE = (
    '<svg viewBox="-1.1 -1.1 2.2 2.2" style="width: 8em" role="img"'
    ' aria-label="Where the tip meets the cue ball, seen along the cue">'
    '<circle r="1" fill="#f4f2e8" stroke="#8d959c" stroke-width="0.02"/>'
    '<path d="M-1 0H1M0 -1V1" stroke="#8d959c" stroke-width="0.015"/>'
    '<circle cx="{x:.4f}" cy="{y:.4f}" r="0.07" fill="#d55e00"/></svg>'
)


@singledispatch
def html_of(thing: object) -> str:
    """Make HTML of a scene, a stroke, a shot, a plan or a batch of strokes."""
    raise TypeError(f'thing must be one that notebooks show, got {type(thing).__name__}')


@html_of.register
def _scene(scene: Scene) -> str:
    table, noise, robot = scene.table, scene.noise, scene.robot
    balls = {CUE_BALL: scene.cue_ball, **scene.balls}

    def figure() -> Any:
        drawn, axes = table_axes(scene)
        draw_balls(axes, scene, balls)
        return drawn

    facts = {
        'table': f'{table.length:g} × {table.width:g} m' if table else 'an endless cloth',
        'balls': ', '.join(balls),
        'each ball': f'{1e3 * scene.ball.mass:g} g, radius {1e3 * scene.ball.radius:g} mm',
        'law': scene.law,
        'strokes': f'{robot.speed_min:g} to {robot.speed_max:g} m/s, elevation '
        f'{robot.elevation_min_deg:g}° to {robot.elevation_max_deg:g}°',
        'errors of strokes': f'a {1e3 * noise.a:g} mm, b {1e3 * noise.b:g} mm, elevation '
        f'{noise.elevation_deg:g}°, azimuth {noise.azimuth_deg:g}°, speed {noise.speed:g} m/s',
    }
    return _picture(figure) + _table(facts.items())


@html_of.register
def _stroke(stroke: Stroke) -> str:
    a, b, elevation, azimuth, speed = stroke.offsets
    facts = {
        'a, b': f'{_signed(a)}, {_signed(b)} ball radii',
        'elevation': _degrees(elevation),
        'azimuth': _degrees(azimuth),
        'speed': f'{speed:.3g} m/s',
    }
    return FACE.format(x=a, y=-b) + _table(facts.items())


@html_of.register
def _shot(shot: Shot) -> str:
    said = _said(shot.status, shot.message)
    return said + _picture(lambda: shot_figure(shot)) + _table(story.facts(shot).items())


@html_of.register
def _plan(plan: PlanResult) -> str:
    said, best = _said(plan.status, plan.message), plan.best
    if best is None:
        return said
    rows = [('kind', 'success', 'trials', *OFFSETS, 'warning')]
    for each in plan.ranking:
        a, b, elevation, azimuth, speed = each.stroke.offsets
        success = f'{percent(each.success)} % ({interval_in_words(each.interval)})'
        angles = _degrees(elevation), _degrees(azimuth)
        stroke = _signed(a), _signed(b), *angles, f'{speed:.2f} m/s'
        rows.append((each.kind, success, str(each.trials), *stroke, each.warning))
    title = f'{best.kind}: success {best.estimate}'
    return said + _picture(lambda: shot_figure(best.shot, title)) + _table(rows)


@html_of.register
def _batch(batch: StrokeBatch) -> str:
    fallen = batch.motion == Motion.POCKETED
    shares = {Status(each).name: batch.status == each for each in np.unique(batch.status)}
    shares |= {'miscue': batch.miscue, 'double hit': batch.double_hit}
    shares |= {f'{name} falls': fallen[:, i] for i, name in enumerate(batch.names)}
    told = {name: f'{percent(which.mean())} %' for name, which in shares.items() if which.any()}

    def figure() -> Any:
        rests = (batch.motion == Motion.REST)[..., np.newaxis]
        ends = np.where(rests, batch.final_position[..., :2], np.nan)
        seen = ends.reshape(-1, 2)
        drawn, axes = table_axes(batch.scene, seen[np.isfinite(seen).all(axis=1)])
        for i, name in enumerate(batch.names):
            face = {'color': ball_colour(name), 'markeredgecolor': 'black', 'markersize': 4}
            axes.plot(*ends[:, i].T, 'o', **face, markeredgewidth=0.3, linestyle='', alpha=0.6)
        return drawn

    return _picture(figure) + _table([('strokes', str(len(batch.status))), *told.items()])


def _said(status: Status, message: str) -> str:
    return f'<p><b>{status.name}</b>: {escape(message)}</p>'


def _picture(figure: Callable[[], Any]) -> str:
    """Draw a figure as an image; '' if matplotlib is missing."""
    if not has_matplotlib():
        return ''
    file = BytesIO()
    figure().savefig(file, format='png', dpi=PICTURE_DPI)
    return f'<img alt="" src="data:image/png;base64,{b64encode(file.getvalue()).decode()}">'


def _table(rows: Iterable[tuple[str, ...]]) -> str:
    """Write rows of texts; the first of each is its name."""
    lines = (
        f'<th style="text-align: left">{escape(name)}</th>'
        + ''.join(f'<td style="text-align: left">{escape(cell)}</td>' for cell in cells)
        for name, *cells in rows
    )
    return f'<table>{"".join(f"<tr>{line}</tr>" for line in lines)}</table>'


def _degrees(radians: float) -> str:
    return f'{rounded(math.degrees(radians), 2)}°'


def _signed(offset: float) -> str:
    return rounded(offset, 2, '+')
