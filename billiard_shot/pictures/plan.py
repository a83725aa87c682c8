"""A plan on its table: the planned stroke, and the final positions of noisy executions."""

from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import add_legend, save
from billiard_shot.pictures.table import (
    draw_cue,
    draw_start_and_rest,
    draw_trails,
    table_axes,
)
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.dispersion import Dispersion
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.targets import Gate, Pass, Pot, Rest, Target
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.colours import GREEN, VERMILION
from billiard_shot.table.words import rounded

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
    figure, axes = table_axes(
        scene,
        outcomes.final_positions[:, 0],
        f'{planned.kind}: success {planned.estimate}; '
        f'a {rounded(a, 2, "+")}, b {rounded(b, 2, "+")} radii, '
        f'{np.degrees(elevation):.1f}°, {speed:.2f} m/s',
    )
    _draw_target(axes, planned.target)
    for line in outcomes.paths[:DRAWN_PATHS]:
        axes.plot(*line.T, color='#555555', linewidth=0.4, alpha=0.25, zorder=1.5)
    draw_trails(axes, trails)
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
    draw_start_and_rest(axes, trails)
    draw_cue(axes, scene, planned.stroke, trails.start(CUE_BALL))
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
