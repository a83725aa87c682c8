"""A map of an atlas: the success probability of a pot by the position of the cue ball."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.table import draw_balls, draw_table
from billiard_shot.planning.atlas import Atlas, Map
from billiard_shot.planning.atlas.layouts import borders, grid
from billiard_shot.table.colours import VERMILION
from billiard_shot.table.outline import outline_of

# Even in lightness, for any kind of colour vision, and in grey (van der Walt and Smith, 2015).
COLOUR_MAP = 'viridis'
CONTOURS = (0.25, 0.5, 0.75, 0.9)  # of contour lines
RING = 1.9  # ball radii: around the ball that is to be potted
MIN_CONTOUR_POINTS = 8  # points of a contour line that is left out
LIGHT = 0.6  # success from which on the colours are light, so that lines are black
MIN_PICTURE_WIDTH, MIN_MAP_WIDTH = 9.0, 4.0  # inches: smallest width of a picture, and of a map


def draw_atlas(atlas: Atlas, path: Path) -> None:
    """
    Write a picture of an atlas: a map of the table for each position of the ball to be potted.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    maps, half = atlas.maps, outline_of(atlas.scene).frame
    columns = _columns(atlas, len(maps))
    rows = math.ceil(len(maps) / columns)
    width = max(MIN_PICTURE_WIDTH, MIN_MAP_WIDTH * columns)
    height = rows * ((width / columns - 0.5) * half[1] / half[0] + 0.6) + 0.7
    figure = new_figure(width, height)
    for number, each in enumerate(maps, 1):
        axes = figure.add_subplot(rows, columns, number)
        axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]), aspect='equal')
        image = _draw_map(axes, atlas, each)
    bar = figure.colorbar(
        image,
        ax=figure.axes,
        location='bottom',
        fraction=0.05,
        aspect=50,
        pad=0.02,
        label='success of the best stroke found, by the position of the cue ball (%)',
        ticks=[0.0, *CONTOURS, 1.0],
        format=lambda part, _: f'{100 * part:.0f}',
    )
    for level in CONTOURS:
        bar.ax.axvline(level, color=_ink(level), linewidth=0.8)
    save(figure, path)


def _columns(atlas: Atlas, maps: int) -> int:
    """Choose how many maps are side by side: as in the grid, if the positions fill one."""
    along, across = atlas.request.ball_grid or (0, 0)
    if along * across * len(atlas.request.ball) == maps:
        return along
    return math.ceil(math.sqrt(0.5 * maps))  # tables are about twice as long as wide


def _draw_map(axes: Any, atlas: Atlas, drawn: Map) -> Any:
    """Draw one map; return the image for the colour bar."""
    from matplotlib.patches import Circle

    scene, radius, counts = atlas.scene, atlas.scene.ball.radius, atlas.request.cue_grid
    assert scene.table is not None  # an atlas without a table is refused
    draw_table(axes, scene)
    image = axes.pcolormesh(
        *borders(scene.table, radius, counts),
        drawn.success,
        cmap=COLOUR_MAP,
        vmin=0.0,
        vmax=1.0,
        zorder=0.25,
    )
    if min(counts) > 1:
        x, y = zip(*grid(scene.table, radius, counts), strict=True)
        lines = axes.contour(
            x[: counts[0]],
            y[:: counts[0]],
            drawn.success,
            levels=CONTOURS,
            linewidths=0.8,
            colors=[_ink(level) for level in CONTOURS],
            zorder=1,
        )
        lines.set(paths=[_long_lines(path) for path in lines.get_paths()])
        axes.clabel(lines, fmt=lambda level: f'{100 * level:.0f}', fontsize='x-small')
    draw_balls(axes, scene, {**scene.object_balls, drawn.ball: drawn.ball_place})
    axes.add_patch(
        Circle(
            drawn.ball_place,
            RING * radius,
            fill=False,
            edgecolor=VERMILION,
            linewidth=1.5,
            zorder=5,
        )
    )
    at = ', '.join(f'{round(each, 3):g}' for each in drawn.ball_place)
    said = f'{100.0 * drawn.mean:.0f} % on average' if drawn.results else 'no results'
    if any(result.stroke for result in drawn.results):
        said += f', each ± {100.0 * drawn.mean_half_width:.0f} %'
    axes.set_title(f'ball {drawn.ball} at ({at}) m: {said}', fontsize='small', loc='left')
    axes.set_xlabel('x (m)', fontsize='x-small')
    axes.set_ylabel('y (m)', fontsize='x-small')
    axes.tick_params(labelsize='x-small')
    return image


def _long_lines(path: Any) -> Any:
    """Leave out lines around single fields: they hide the field, and a number does not fit in."""
    from matplotlib.path import Path as Line

    lines = [
        line for line in path.to_polygons(closed_only=False) if len(line) > MIN_CONTOUR_POINTS
    ]
    return Line.make_compound_path(*map(Line, lines)) if lines else Line(np.zeros((0, 2)))


def _ink(success: float) -> str:
    """Choose a line colour that is visible on the colour of a success probability."""
    return 'black' if success > LIGHT else 'white'
