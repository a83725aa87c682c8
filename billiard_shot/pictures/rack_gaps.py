"""Speeds of the balls after a break, over the gap between balls in the rack."""

from pathlib import Path

import numpy as np

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.scene import Scene
from billiard_shot.study.rack_gaps import break_speeds, CUE_BALL_SPEED, without_duration

GAPS = np.geomspace(1e-8, 3e-3, 34)  # m
COLOUR = '#1b6b4a'


def draw_rack_gaps(path: Path) -> None:
    """Draw the speeds of the fifteen balls over the gap, with and without contact duration."""
    scene = Scene.load('pool')
    duration = 1e3 * scene.contacts.ball_ball.duration
    panels = (
        (scene, f'contacts of {duration:g} ms: a micrometre changes nothing'),
        (without_duration(scene), 'contacts without duration: a micrometre stops the rack'),
    )
    figure = new_figure(9.0, 3.6)
    axes = figure.subplots(1, 2)
    for panel, (where, finding) in zip(axes, panels, strict=True):
        speeds = np.sort([break_speeds(where, gap) for gap in GAPS], axis=1)
        panel.semilogx(1e3 * GAPS, speeds, color=COLOUR, linewidth=0.9)
        panel.set_title(finding, fontsize='medium')
        panel.set_xlabel('gap between neighbours (mm)')
        panel.set_ylim(0.0, 0.75 * CUE_BALL_SPEED)
        panel.grid(alpha=0.3)
    axes[0].set_ylabel('speeds of the 15 balls (m/s)')
    figure.suptitle(f'A break of fifteen, cue ball {CUE_BALL_SPEED:g} m/s, full on the head ball')
    save(figure, path)
