"""Speed, spin and energy over time, of any shot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.colours import (
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
from billiard_shot.pictures.trails import Trails
from billiard_shot.records import Array
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.model.motion import Cause, Motion
from billiard_shot.table.run.results import EventKind

SAMPLES_PER_MOTION = 12  # of each motion of each ball


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """
    Motion and energy of balls at n times, in order; at an event, just before it and just after.

    Attributes
    ----------
    time : (n,) float array
        [s].
    speeds : mapping of str to (n,) float array
        Speed of every ball that ever moves [m/s].
    rims : mapping of str to (n,) float array
        Surface speed of a ball's rotation about a level axis [m/s]: its speed, if it rolls.
    spins : mapping of str to (n, 3) float array
        [rad/s], frame `table`.
    translation, rotation, height : (n,) float arrays
        Energies of all balls together [J]. The energy of height is relative to lying on the cloth.
        A ball in a pocket or off the table has no energy.

    """

    time: Array
    speeds: Mapping[str, Array]
    rims: Mapping[str, Array]
    spins: Mapping[str, Array]
    translation: Array
    rotation: Array
    height: Array


def history_of(trails: Trails) -> History:
    """Sample the motion of all moving balls over the time that is shown."""
    ball, gravity = trails.scene.ball, trails.scene.cloth.gravity
    moving = [name for name in trails.balls if trails.moved(name)]
    time = _times(trails, moving)
    states = {name: trails.balls[name].at(time) for name in moving}
    speeds = {name: np.linalg.norm(s.velocity, axis=1) for name, s in states.items()}
    sizes = {name: np.linalg.norm(s.spin, axis=1) for name, s in states.items()}
    nothing = np.zeros(len(time))
    heights = [
        np.where(s.motion < 5, s.position[:, 2] - ball.radius, 0.0) for s in states.values()
    ]
    return History(
        time,
        speeds,
        {name: ball.radius * np.hypot(*s.spin[:, :2].T) for name, s in states.items()},
        {name: s.spin for name, s in states.items()},
        sum((0.5 * ball.mass * v**2 for v in speeds.values()), nothing),
        sum((0.5 * ball.inertia * w**2 for w in sizes.values()), nothing),
        height=sum((ball.mass * gravity * z for z in heights), nothing),
    )


def _times(trails: Trails, names: list[str]) -> Array:
    """
    Find times just before and just after all events, and between them.

    During an impact, its balls move at constant velocities that stand for the impact. Their speeds
    and energies have no meaning then, so there are no times within an impact.
    """
    starts = np.concatenate(
        [[0.0, trails.until], *(trails.balls[name].rows['time'] for name in names)]
    )
    ends = np.unique(starts[starts <= trails.until])
    inner = ends[:-1, np.newaxis] + np.diff(ends)[:, np.newaxis] * np.linspace(
        0.0, 1.0, SAMPLES_PER_MOTION, endpoint=False
    )
    before = np.nextafter(ends[1:], 0.0)
    times = np.unique(np.concatenate([ends, inner.ravel(), before]))
    for name in names:
        rows = trails.balls[name].rows
        for end in np.flatnonzero(rows['cause'] == Cause.RELEASE):
            times = times[(times < rows['time'][end - 1]) | (times >= rows['time'][end])]
    return times


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
