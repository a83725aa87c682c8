"""An atlas as a picture: for each place of the object ball, chances from all over the table."""
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.atlas import Chart
from billiard_shot.study.pictures import new_figure, save


def draw_atlas(chart: Chart, chances: NDArray[np.float64], path: Path) -> None:
    """
    Write a picture of an atlas: a small table for each place of the object ball, where it lies.

    In it, each place of the cue ball has the colour of its chance of success.

    Raises
    ------
    ValueError
        If there is no matplotlib, or the file cannot be written.

    """
    table, places = chart.scene.table, chart.places
    assert table is not None
    half = 0.5 * table.length, 0.5 * table.width
    width = 11.0  # inches, two of them for the bar
    row = (width - 2.0) / chart.columns * half[1] / half[0]
    figure, _ = new_figure(0, width, chart.rows * (row + 0.1) + 0.8)
    grid = figure.subplots(chart.rows, chart.columns, squeeze=False)
    for i, (x, y) in enumerate(places):
        column, row = divmod(i, chart.rows)
        axes = grid[chart.rows - 1 - row, column]
        picture = axes.imshow(
            chances[i].reshape(chart.columns, chart.rows).T, origin='lower', vmin=0.0, vmax=1.0,
            extent=(-half[0], half[0], -half[1], half[1]), cmap='viridis',
        )
        axes.plot(x, y, 'o', color='white', markeredgecolor='black', markersize=4)
        axes.set(xticks=[], yticks=[], facecolor='#cccccc')
    for name, (u, v) in chart.scene.balls.items():
        if name not in ('cue', chart.ball):
            for axes in grid.flat:
                axes.plot(u, v, 'o', color='black', markersize=4)
    figure.colorbar(picture, ax=grid, shrink=0.8, label='chance of success')
    figure.suptitle(
        f'From where the cue ball reaches the target; ball {chart.ball} is the white dot',
        fontsize='medium',
    )
    save(figure, path)
