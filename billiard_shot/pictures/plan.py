"""A plan on its table with noisy executions; and a map of the success of pots."""

from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures import table
from billiard_shot.pictures.canvas import add_legend, GREEN, new_figure, save, VERMILION
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.problem import Target
from billiard_shot.planning.result import Dispersion, RankedStroke
from billiard_shot.planning.success_map import SuccessMap
from billiard_shot.planning.targets import Gate, Pass, Pot, Rest
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import rounded

DRAWN_PATHS = 60  # drawn paths of the cue ball


def draw_plan(planned: RankedStroke, outcomes: Dispersion, path: Path) -> None:
    """
    Write a picture of a plan, from above.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    save(plan_figure(planned, outcomes), path)


def plan_figure(planned: RankedStroke, outcomes: Dispersion) -> Any:
    """Draw a plan from above, with its outcomes under execution noise."""
    scene, trails = planned.scene, trails_of(planned.shot)
    a, b, elevation, _, speed = planned.stroke.offsets
    figure, axes = table.table_axes(
        scene,
        outcomes.final_positions[:, 0],
        f'{planned.kind}: success {planned.estimate}; '
        f'a {rounded(a, 2, "+")}, b {rounded(b, 2, "+")} radii, '
        f'{np.degrees(elevation):.1f}°, {speed:.2f} m/s',
    )
    _draw_target(axes, planned.target)
    for line in outcomes.paths[:DRAWN_PATHS]:
        axes.plot(*line.T, color='#555555', linewidth=0.4, alpha=0.25, zorder=1.5)
    table.draw_trails(axes, trails)
    for reached, colour, label in (
        (True, GREEN, 'ends, target reached'),
        (False, VERMILION, 'ends, target missed'),
    ):
        moved = outcomes.moved & (outcomes.success == reached)[:, np.newaxis]
        axes.plot(
            *outcomes.final_positions[moved].T,
            '.',
            color=colour,
            markersize=2.5,
            alpha=0.6,
            linestyle='',
            zorder=4.3,  # above the ball that rests without errors
            label=label,
        )
    table.draw_start_and_rest(axes, trails)
    table.draw_cue(axes, scene, planned.stroke, trails.start(CUE_BALL))
    add_legend(figure, axes)
    return figure


def _draw_target(axes: Any, target: Target) -> None:
    from matplotlib.patches import Circle

    round_: tuple[tuple[float, float], float] | None = None
    match target:
        case Rest():
            round_ = target.rest, target.radius
        case Pass():
            round_ = target.passing, target.radius
        case Pot() if target.leave is not None:
            round_ = target.leave, target.radius
        case Gate():
            axes.plot(*np.transpose(target.gate), '|-', color=GREEN, linewidth=2.0, zorder=1.4)
    if round_:
        axes.add_patch(Circle(*round_, facecolor=GREEN, alpha=0.2, edgecolor=GREEN, zorder=1.4))


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
    table.draw_table(axes, made.scene)
    image = axes.pcolormesh(
        made.x, made.y, made.success, cmap=COLOUR_MAP, vmin=0.0, vmax=1.0, zorder=0.25
    )
    if min(made.success.shape) > 1:
        inks = [_ink(level) for level in CONTOURS]
        style = {'levels': CONTOURS, 'colors': inks, 'linewidths': 0.8, 'zorder': 1}
        lines = axes.contour(made.x, made.y, made.success, **style)
        lines.set(paths=[_long_lines(line) for line in lines.get_paths()])
        axes.clabel(lines, fmt=lambda level: f'{100 * level:.0f}', fontsize='x-small')
    table.draw_balls(axes, made.scene, made.scene.object_balls)
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
