"""A map of success: the chance of a pot by the place of the cue ball."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.table import draw_balls, draw_table
from billiard_shot.planning.success_map import SuccessMap
from billiard_shot.table.colours import VERMILION
from billiard_shot.table.outline import outline_of

# Even in lightness, for any kind of colour vision, and in grey (van der Walt and Smith, 2015).
COLOUR_MAP = 'viridis'
CONTOURS = (0.25, 0.5, 0.75, 0.9)  # of contour lines
RING = 1.9  # ball radii: around the ball that is to be potted
MIN_CONTOUR_POINTS = 8  # points of a contour line that is left out
LIGHT = 0.6  # success from which on the colours are light, so that lines are black
MAP_WIDTH = 9.0  # inches


def map_in_words(made: SuccessMap) -> str:
    """Say how surely the ball is potted from the places of a map."""
    known = made.success[made.success >= 0.0]
    half = 0.5 * (made.high - made.low)[made.success > 0.0]
    place = ', '.join(f'{round(each, 3):g}' for each in made.scene.balls[made.ball])
    each = f', each ± {100.0 * half.mean():.0f} %' if len(half) else ''
    return (
        f'ball {made.ball} at ({place}) m: {100.0 * known.mean():.0f} % on average of '
        f'{len(known)} places{each}'
    )


def draw_success_map(made: SuccessMap, path: Path) -> None:
    """
    Write a picture of a map, with the table and its balls.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    from matplotlib.patches import Circle

    half = outline_of(made.scene).frame
    figure = new_figure(MAP_WIDTH, (MAP_WIDTH - 0.5) * half[1] / half[0] + 1.3)
    axes = figure.subplots()
    axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]), aspect='equal')
    axes.set(xlabel='x (m)', ylabel='y (m)')
    draw_table(axes, made.scene)
    image = axes.pcolormesh(
        made.x, made.y, made.success, cmap=COLOUR_MAP, vmin=0.0, vmax=1.0, zorder=0.25
    )
    if min(made.success.shape) > 1:
        inks = [_ink(level) for level in CONTOURS]
        style = {'levels': CONTOURS, 'colors': inks, 'linewidths': 0.8, 'zorder': 1}
        lines = axes.contour(made.x, made.y, made.success, **style)
        lines.set(paths=[_long_lines(line) for line in lines.get_paths()])
        axes.clabel(lines, fmt=lambda level: f'{100 * level:.0f}', fontsize='x-small')
    draw_balls(axes, made.scene, made.scene.object_balls)
    place, radius = made.scene.balls[made.ball], RING * made.scene.ball.radius
    axes.add_patch(Circle(place, radius, fill=False, edgecolor=VERMILION, linewidth=1.5, zorder=5))
    axes.set_title(map_in_words(made), fontsize='small', loc='left')
    bar = figure.colorbar(
        image,
        ax=axes,
        location='bottom',
        fraction=0.05,
        aspect=50,
        pad=0.02,
        label='success of the best stroke found, by the place of the cue ball (%)',
        ticks=[0.0, *CONTOURS, 1.0],
        format=lambda part, _: f'{100 * part:.0f}',
    )
    for level in CONTOURS:
        bar.ax.axvline(level, color=_ink(level), linewidth=0.8)
    save(figure, path)


def _long_lines(path: Any) -> Any:
    """Leave out lines around single cells: they hide the cell, and a number does not fit in."""
    from matplotlib.path import Path as Line

    lines = [
        line for line in path.to_polygons(closed_only=False) if len(line) > MIN_CONTOUR_POINTS
    ]
    return Line.make_compound_path(*map(Line, lines)) if lines else Line(np.zeros((0, 2)))


def _ink(success: float) -> str:
    """Choose a line colour that is visible on the colour of a success probability."""
    return 'black' if success > LIGHT else 'white'
