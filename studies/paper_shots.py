"""
The trajectories of the paper's Table 1: its figures (a), (b) and (c).

Each is drawn as computed by the model, and as it follows from the printed velocities and spins.
The two differ, see paper.py. As in the paper (footnote 7), the ball does not bounce.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import (
    add_legend,
    BLACK,
    GREY,
    MOTIONS,
    new_figure,
    save,
    VERMILION,
)
from billiard_shot.pictures.table import draw_balls, draw_cue
from billiard_shot.pictures.trails import Trails, trails_of
from billiard_shot.scene import Effects, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.run.simulate import simulate
from studies.paper import PRINTED

PANELS: Mapping[str, str] = {'vertical': 'a', 'horizontal': 'b', 'massé': 'c'}
PANEL_SCALE = 1.8  # size of a panel, relative to the extent of the slide


@dataclass(frozen=True, slots=True, eq=False)
class PaperShot:
    """A row of Table 1: the shot as predicted, and trails of it and of the printed numbers."""

    name: str
    shot: Shot
    computed: Trails
    printed: Trails


def paper_shot(name: str) -> PaperShot:
    """Compute a row of Table 1, with the ball kept on the cloth."""
    stroke, numbers = PRINTED[name]
    scene = replace(Scene.load('paper'), effects=Effects(flight='off'))
    shot = predict(scene, stroke)
    start = BallState(
        np.array(scene.cue_ball), np.array([*numbers[:2], 0.0]), np.array(numbers[3:])
    )
    run = simulate(scene, {CUE_BALL: start})
    return PaperShot(name, shot, trails_of(shot), Trails(scene, run))


def draw_paper_shots(path: Path) -> None:
    """Write the three trajectories, each from the strike until the ball has rolled a bit."""
    figure = new_figure(12.0, 4.5)
    panels = figure.subplots(1, len(PANELS))
    for axes, (name, letter) in zip(panels, PANELS.items(), strict=True):
        row = paper_shot(name)
        _draw(axes, row)
        x, y, _ = row.shot.trajectory.final_position
        axes.set_title(
            f'({letter}) {name}; rests at ({x:.2f}, {y:.2f}) m'.replace('-', '−'),
            fontsize='medium',
            loc='left',
        )
    figure.suptitle(
        'The paper’s Table 1: the printed velocities and spins do not follow from its model',
        fontsize='medium',
    )
    add_legend(figure, panels[0])
    save(figure, path)


def _draw(axes: Any, row: PaperShot) -> None:
    for trails, printed in ((row.computed, False), (row.printed, True)):
        for piece in trails.pieces(CUE_BALL):
            name = 'slides' if piece.motion == Motion.SLIDE else 'rolls'
            axes.plot(
                piece.points[:, 0],
                piece.points[:, 1],
                ':' if printed else '-',
                color=BLACK if printed else MOTIONS[piece.motion],
                linewidth=1.0 if printed else 2,
                label='slides, then rolls, from the printed numbers'
                if printed and name == 'slides'
                else None
                if printed
                else name,
            )
        x, y = turn_to_roll(trails)
        axes.plot(
            x,
            y,
            'o',
            color=GREY if printed else VERMILION,
            markeredgecolor='black',
            markersize=5,
            linestyle='',
            label='the same, from the printed numbers' if printed else 'begins to roll',
        )
    scene = row.shot.scene
    draw_balls(axes, scene, {CUE_BALL: row.computed.start(CUE_BALL)}, faint=True)
    draw_cue(axes, scene, row.shot.stroke, row.computed.start(CUE_BALL))
    ends = np.array([turn_to_roll(row.computed), turn_to_roll(row.printed), (0.0, 0.0)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * PANEL_SCALE * float((high - low).max())
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        aspect='equal',
        xlabel='x (m)',
        ylabel='y (m)',
    )
    axes.grid(alpha=0.3)


def turn_to_roll(trails: Trails) -> tuple[float, float]:
    """Find the point (x, y) [m] where the cue ball begins to roll."""
    mark = next(mark for mark in trails.run.events if mark.kind == EventKind.ROLL)
    x, y, _ = mark.position.tolist()
    return x, y
