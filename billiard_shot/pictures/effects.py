"""Bars for what effects cost and change."""

from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.study.effects import EffectStudy

COLOUR, PALE = '#1b6b4a', '#a9c9ba'  # called for; only if forced on
LINEAR = 10.0  # us, to which the axis of time is linear
LEAST = 1e-3  # mm and degrees: less is not drawn


def draw_effects(studies: Sequence[EffectStudy], title: str, path: Path) -> None:
    """
    Draw cost and changes of effects as bars, medians where there are several shots.

    Raises
    ------
    ValueError
        If there is no matplotlib, or the file cannot be written.

    """
    figure, axes = new_figure(3, 11.0, 1.2 + 0.32 * len(studies))
    colours = [COLOUR if study.simulated else PALE for study in studies]
    names = [study.name.replace('_', ' ') for study in studies]
    quantities = (
        ('time', 1e6, 'costs (µs)'),
        ('distance', 1e3, 'moves the place of rest (mm)'),
        ('turn', 180.0 / math.pi, 'turns the shot by (degrees)'),
    )
    for axis, (quantity, unit, label) in zip(axes, quantities, strict=True):
        values = [unit * study.median(quantity) for study in studies]
        _bars(axis, names, values, colours, logarithmic=quantity != 'time')
        axis.set_xlabel(label)
    for axis in axes[1:]:
        axis.set_yticklabels([])
    pale = '; pale: not called for, what forcing it on would do' if PALE in colours else ''
    figure.suptitle(f'What each effect adds: {title}{pale}', fontsize=10)
    save(figure, path)


def _bars(
    axis: Any, names: list[str], values: list[float], colours: list[str], logarithmic: bool
) -> None:
    finite = [value for value in values if math.isfinite(value)]
    if logarithmic:
        axis.set_xscale('log')
        axis.set_xlim(LEAST, 10.0 * max([10.0 * LEAST, *finite]))
        lengths = [max(value, LEAST) for value in values]
    else:
        axis.set_xscale('symlog', linthresh=LINEAR)  # some effects save time, and much of it
        powers = [sign * 10.0**power for power in (1, 3, 5) for sign in (-1, 1)]
        low, high = 3.0 * min([-LINEAR, *finite]), 3.0 * max([LINEAR, *finite])
        axis.set_xticks([0.0, *(power for power in powers if low < power < high)])
        axis.axvline(0.0, color='black', linewidth=0.8)
        lengths = values
    shown = [
        length if math.isfinite(length) else 10.0 * max([LEAST, *finite]) for length in lengths
    ]
    bars = axis.barh(names, shown, color=colours)
    texts = [_text(value) for value in values]
    axis.bar_label(bars, texts, padding=3, fontsize=8)
    axis.margins(x=0.18)
    axis.invert_yaxis()
    axis.tick_params(labelsize=9)
    for side in ('top', 'right'):
        axis.spines[side].set_visible(False)


def _text(value: float) -> str:
    if math.isinf(value):
        return 'never rests'
    return '0' if abs(value) < LEAST else f'{value:.3g}' if abs(value) < 1e3 else f'{value:.0f}'
