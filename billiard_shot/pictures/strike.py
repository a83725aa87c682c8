"""A strike seen close up: forces of tip and cloth on the ball during contact."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.trace import CollisionTrace, STATE_NAMES, trace_of_strike
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.shot import Shot
from billiard_shot.table.colours import BLUE, GREEN, GREY, VERMILION

CONTACTS = (('tip', BLUE, '-'), ('cloth', VERMILION, '--'))
MIN_LABEL_SHARE = 0.03  # of the strike's length that a state needs to be labelled


def draw_strike(shot: Shot, path: Path, title: str = '') -> None:
    """
    Write a picture: forces, grip, slip and elastic energies over the time of the strike.

    Raises
    ------
    ValueError
        If there was no strike, if the ball touched more than the cloth, if matplotlib is missing,
        or if the file cannot be written.

    """
    heights = (2.3, 1.9, 1.9, 1.9)
    figure = new_figure(9.0, sum(heights))
    trace = trace_of_strike(shot)
    panels = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    length = float(trace.time[-1])
    time = trace.time / length
    _states(panels, trace, time)
    frictions = model_of(shot.scene).friction
    for j, (name, colour, dashes) in enumerate(CONTACTS):
        style = {'color': colour, 'linestyle': dashes, 'linewidth': 1.6}
        touching = np.where(trace.active[:, j], 1.0, np.nan)
        force = trace.forces[:, 3 * j]
        panels[0].plot(time, length * force * touching, label=f'{name} presses', **style)
        if frictions[j] > 0.0:
            grip = grip_of(trace, j, frictions[j])
            panels[1].plot(time, grip, label=name, **style)
        panels[2].plot(time, trace.slip(j) * touching, label=name, **style)
        panels[3].plot(time, trace.energies[:, j] * touching, label=name, **style)
    panels[0].set(ylabel='force × length of\nthe strike (N s)', ylim=(0.0, None), xlim=(0.0, 1.0))
    panels[1].set(ylabel='friction / (μ ×\npressing force)', ylim=(0.0, 1.1))
    panels[1].axhline(1.0, color=GREY, linewidth=0.8)
    for word, height in (('slides', 1.0), ('sticks', 0.5)):
        panels[1].annotate(
            word,
            (1.0, height),
            (3, 0),
            textcoords='offset points',
            fontsize=8,
            va='center',
            annotation_clip=False,
        )
    panels[2].set(ylabel='slip (m/s)', ylim=(0.0, None))
    panels[3].set(
        ylabel='energy in\nthe contact (J)',
        ylim=(0.0, None),
        xlabel='time / length of the strike',
    )
    for axes in panels:
        axes.grid(alpha=0.3)
    panels[0].legend(loc='upper right', fontsize='small', frameon=False)
    figure.align_ylabels(panels)
    if title:
        figure.suptitle(title, fontsize='medium')
    save(figure, path)


def grip_of(trace: CollisionTrace, contact: int, friction: float) -> NDArray[np.float64]:
    """Friction force relative to its limit (n,): 1 during slip; NaN without a normal force."""
    limit = friction * trace.forces[:, 3 * contact]
    enough = trace.active[:, contact] & (limit > 1e-6 * limit.max())
    return np.where(enough, trace.friction(contact) / np.where(enough, limit, 1.0), np.nan)


def _states(panels: list[Any], trace: CollisionTrace, time: NDArray[np.float64]) -> None:
    """Shade every other state, and name those that are long enough."""
    for number, part in enumerate(trace.phases()):
        begin, end = time[part][0], time[part][-1]
        if number % 2:
            for axes in panels:
                axes.axvspan(begin, end, color=GREEN, alpha=0.08, linewidth=0)
        if end - begin > MIN_LABEL_SHARE:
            name = STATE_NAMES[tuple(trace.active[part][0].tolist())]
            panels[0].annotate(
                name,
                (0.5 * (begin + end), 1.0),
                (0, 2),
                ha='center',
                xycoords=('data', 'axes fraction'),
                fontsize=8,
                textcoords='offset points',
                annotation_clip=False,
            )
