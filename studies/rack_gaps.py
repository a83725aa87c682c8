"""Influence of gaps between the balls of a rack on a break."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import sites
from billiard_shot.table.run.results import BallState
from billiard_shot.table.run.simulate import simulate

RACK_ROWS = range(1, 6)  # balls in the rows of the triangle
CUE_BALL_SPEED = 8.0  # m/s, of the cue ball
READING_TIME = 5e-3  # s: when speeds are read


def break_speeds(scene: Scene, gap: float) -> NDArray[np.float64]:
    """
    Speeds of fifteen balls soon after a cue ball of 8 m/s met the head ball full (15,) [m/s].

    Parameters
    ----------
    scene : Scene
        Ball, cloth and contacts; nothing else counts.
    gap : float
        Between all neighbours in the triangle [m].

    """
    radius = scene.ball.radius
    rest = np.zeros(3)
    cue = np.array([-2.0 * radius - 1e-3, 0.0, radius])
    states = {'cue': BallState(cue, np.array([CUE_BALL_SPEED, 0.0, 0.0]), rest)}
    for number, site in enumerate(sites(RACK_ROWS, 0.0, 2.0 * radius + gap)):
        states[str(number)] = BallState(np.array([*site, radius]), rest, rest)
    run = simulate(replace(scene, table=None, balls={}), states)
    soon = list(run.at(READING_TIME).values())[1:]
    return np.array([np.linalg.norm(state.velocity) for state in soon])


def without_duration(scene: Scene) -> Scene:
    """Return a scene in which contacts between balls take no time."""
    contacts = scene.contacts
    return replace(
        scene, contacts=replace(contacts, ball_ball=replace(contacts.ball_ball, duration=0.0))
    )


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
