"""Errors and times over the tolerance; changes and costs of effects."""

from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

from billiard_shot.pictures.canvas import BLUE, GREEN, GREY, new_figure, save, VERMILION
from billiard_shot.study import cost_of_accuracy, EffectStudy, Tolerance

TIMES = (
    ('strike', 'strike', BLUE),
    ('alone', 'shot alone', VERMILION),
    ('shot', 'all balls', GREEN),
)
MIN_DRAWN_ERROR = 1e-13  # m: smaller errors are drawn there


def draw_accuracy(studied: Sequence[Tolerance], path: Path, about: str) -> None:
    """
    Draw the errors and the times of tolerances.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    figure = new_figure(10.0, 4.4)
    left, right = figure.subplots(1, 2)
    tolerances = [1e3 * each.tolerance for each in studied]
    left.loglog(tolerances, tolerances, '--', color=GREY)
    _name_curve(left, 'tolerance (dashed)', tolerances[0], 0.2 * tolerances[0], GREY)
    for quantity, name, colour in (
        ('largest_error', 'largest of all shots', VERMILION),
        ('typical_error', 'median', BLUE),
    ):
        errors = [1e3 * max(getattr(each, quantity), MIN_DRAWN_ERROR) for each in studied]
        left.loglog(tolerances, errors, 'o-', ms=4, color=colour)
        _name_curve(left, name, tolerances[0], errors[0], colour)
    left.set_ylabel('error of the place of rest (mm)')
    for quantity, name, colour in TIMES:
        times = [1e3 * getattr(each, quantity) for each in studied]
        right.loglog(tolerances, times, 'o-', ms=4, color=colour)
        _name_curve(right, name, tolerances[0], times[0], colour)
    right.set_ylabel('processor time (ms)')
    for axis in (left, right):
        axis.set_xlabel('tolerance (mm)')
        axis.set_xlim(0.3 * min(tolerances), 3e3 * max(tolerances))  # room for the names
        axis.set_xticks([x for x in tolerances if x <= max(tolerances)])
        axis.grid(alpha=0.3)
        axis.tick_params(labelsize='small')
    title = cost_of_accuracy(studied)
    figure.suptitle(f'{title[0].upper()}{title[1:]} ({about})', fontsize='medium')
    save(figure, path)


def _name_curve(axis: Any, name: str, x: float, y: float, colour: str) -> None:
    axis.annotate(
        name, (x, y), (6, 0), textcoords='offset points', va='center', color=colour, fontsize=9
    )


PALE = 0.35  # opacity of effects that no shot calls for
MIN_DRAWN_CHANGE = 1e-3  # mm: smaller changes are not drawn
LINEAR = 10.0  # us, to which the axis of time is linear


def draw_effects(studies: Sequence[EffectStudy], path: Path, about: str) -> None:
    """
    Draw the changes and costs of effects as bars: medians if there are several shots.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    figure = new_figure(10.0, 1.6 + 0.3 * len(studies))
    change, cost = figure.subplots(1, 2)
    order = sorted(studies, key=lambda study: study.median('distance'))
    names = [_effect_name(study) for study in order]
    opacity = [1.0 if study.simulated else PALE for study in order]

    millimetres = [1e3 * study.median('distance') for study in order]
    drawn = [min(max(x, MIN_DRAWN_CHANGE), 1e6) for x in millimetres]
    change.set_xscale('log')
    change.set_xlim(MIN_DRAWN_CHANGE, 30.0 * max([10.0 * MIN_DRAWN_CHANGE, *drawn]))
    _bars(
        change, names, drawn, [BLUE] * len(order), opacity, [_millimetres(x) for x in millimetres]
    )
    change.set_xlabel('without the effect a ball comes to rest elsewhere, by (mm)')

    microseconds = [1e6 * study.median('time') for study in order]
    colours = [VERMILION if x > 0.0 else GREY for x in microseconds]
    cost.set_xscale('symlog', linthresh=LINEAR)
    cost.set_xticks([-1e6, -1e4, -1e2, 0.0, 1e2, 1e4, 1e6])
    cost.axvline(0.0, color='black', linewidth=0.8)
    _bars(
        cost,
        [''] * len(order),
        microseconds,
        colours,
        opacity,
        [_microseconds(x) for x in microseconds],
    )
    cost.set_xlabel('time that the effect adds to a prediction (µs)')
    longest = 30.0 * max(LINEAR, *map(abs, microseconds))
    cost.set_xlim(-longest, longest)
    cost.set_title(
        'grey: with the effect the shot ends sooner, or has fewer events', fontsize='small'
    )

    dearest = max(order, key=lambda study: study.median('time'))
    shown = any(
        alpha == PALE and x >= MIN_DRAWN_CHANGE
        for alpha, x in zip(opacity, millimetres, strict=True)
    )
    pale = '; pale: only if forced on' if shown else ''
    figure.suptitle(
        f'{_effect_name(order[-1]).capitalize()} changes most, {_millimetres(millimetres[-1])}; '
        f'{_effect_name(dearest)} costs most, {_microseconds(1e6 * dearest.median("time"))} '
        f'({about}{pale})',
        fontsize='medium',
    )
    save(figure, path)


def _bars(
    axis: Any,
    names: list[str],
    lengths: list[float],
    colours: list[str],
    opacity: list[float],
    texts: list[str],
) -> None:
    bars = axis.barh(range(len(lengths)), lengths, color=colours)
    for bar, alpha in zip(bars, opacity, strict=True):
        bar.set_alpha(alpha)
    axis.set_yticks(range(len(lengths)), names)
    axis.bar_label(bars, texts, padding=3, fontsize=8)
    axis.tick_params(labelsize=9)
    for side in ('top', 'right'):
        axis.spines[side].set_visible(False)


def _effect_name(study: EffectStudy) -> str:
    return study.name.replace('_', ' ')


def _millimetres(length: float) -> str:
    if math.isinf(length):
        return 'it never rests'
    if length >= 1e3:
        return f'{length / 1e3:.1f} m'
    if length < MIN_DRAWN_CHANGE:
        return '0'
    return f'{length:.0f} mm' if length >= 10.0 else f'{length:.2g} mm'


def _microseconds(time: float) -> str:
    return f'{time / 1e3:.1f} ms' if abs(time) >= 1e3 else f'{time:.0f} µs'
