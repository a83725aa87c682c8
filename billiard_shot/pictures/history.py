"""Speed, spin and energy over time, of any shot."""

from pathlib import Path
from typing import Any

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.histories import History, history_of
from billiard_shot.pictures.trails import Trails
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.colours import (
    ball_colour,
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MOTIONS,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
)
from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import EventKind

MOTION_NAMES = {
    Motion.SLIDE: 'slides',
    Motion.ROLL: 'rolls',
    Motion.FLIGHT: 'flies',
    Motion.SPIN: 'spins',
}
LABELLED = {
    EventKind.CUSHION: 'cushion',
    EventKind.POCKET: 'pocket',
    EventKind.OFF: 'off',
    EventKind.BALL: 'ball',
    EventKind.CLUSTER: 'balls',
    EventKind.CUE: 'cue',
}
VISIBLE = 2e-3  # smallest energy of height that is drawn, relative to that of motion
MOST_NAMED = 5  # balls besides the cue ball that the key names


def draw_history(trails: Trails, path: Path, title: str = '') -> None:
    """
    Write a picture: speeds, the cue ball's spin, and energies of all balls, over time.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    history = history_of(trails)
    heights = (3.0, 2.4, 2.6)
    figure = new_figure(9.5, sum(heights))
    speeds, spins, energies = figure.subplots(3, 1, sharex=True, height_ratios=heights)
    _speeds(speeds, trails, history)
    _spins(spins, history)
    kinds = [(history.translation, SKY, 'of motion'), (history.rotation, ORANGE, 'of spin')]
    if history.height.max() > VISIBLE * history.translation.max():
        kinds.append((history.height, GREY, 'of height'))
    values, colours, labels = zip(*kinds, strict=True)
    energies.stackplot(history.time, *values, colors=colours, labels=labels, linewidth=0)
    energies.set(
        xlabel='time from the end of the strike (s)',
        ylabel='energy, all balls (J)',
        xlim=(0.0, trails.until),
        ylim=(0.0, None),
    )
    for axes in (speeds, spins, energies):
        axes.grid(alpha=0.3)
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small', frameon=False)
    if title:
        figure.suptitle(title, fontsize='medium')
    save(figure, path)


def _speeds(axes: Any, trails: Trails, history: History) -> None:
    seen = set()
    for piece in trails.pieces(CUE_BALL):
        label = f'cue ball {MOTION_NAMES[piece.motion]}'
        axes.axvspan(
            piece.times[0],
            piece.times[-1],
            color=MOTIONS[piece.motion],
            alpha=0.13,
            linewidth=0,
            label=None if label in seen else label,
        )
        seen.add(label)
    others = [name for name in history.speeds if name != CUE_BALL]
    for name in others:
        axes.plot(
            history.time,
            history.speeds[name],
            color=ball_colour(name),
            linewidth=1.0,
            label=f'ball {name}' if len(others) <= MOST_NAMED else None,
        )
    if len(others) > MOST_NAMED:
        axes.plot([], [], color=GREY, linewidth=1.0, label=f'{len(others)} other balls')
    if CUE_BALL in history.speeds:
        axes.plot(
            history.time, history.speeds[CUE_BALL], color=BLACK, linewidth=1.6, label='cue ball'
        )
        axes.plot(
            history.time,
            history.rims[CUE_BALL],
            color=BLACK,
            linewidth=1.0,
            linestyle='--',
            label='its rim, turning',
        )
    axes.set(ylabel='speed (m/s)', ylim=(0.0, None))
    for mark in trails.marks:
        if mark.balls[0] == CUE_BALL and mark.kind in LABELLED:
            axes.axvline(mark.time, color=BLACK, linewidth=0.6, linestyle=':')


def _spins(axes: Any, history: History) -> None:
    if CUE_BALL in history.spins:
        for k, (name, colour, dashes) in enumerate(
            (('x', BLUE, '-'), ('y', VERMILION, '--'), ('z', GREEN, '-.'))
        ):
            axes.plot(
                history.time,
                history.spins[CUE_BALL][:, k],
                dashes,
                color=colour,
                linewidth=1.4,
                label=f'about {name}',
            )
    axes.axhline(0.0, color=PURPLE, linewidth=0.5)
    axes.set(ylabel="cue ball's spin (rad/s)")
