"""Errors and times over the tolerance."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.study.accuracy import cost_of_accuracy, Tolerance
from billiard_shot.table.colours import BLUE, GREEN, GREY, VERMILION

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
    _name(left, 'tolerance (dashed)', tolerances[0], 0.2 * tolerances[0], GREY)
    for quantity, name, colour in (
        ('largest_error', 'largest of all shots', VERMILION),
        ('typical_error', 'median', BLUE),
    ):
        errors = [1e3 * max(getattr(each, quantity), MIN_DRAWN_ERROR) for each in studied]
        left.loglog(tolerances, errors, 'o-', ms=4, color=colour)
        _name(left, name, tolerances[0], errors[0], colour)
    left.set_ylabel('error of the place of rest (mm)')
    for quantity, name, colour in TIMES:
        times = [1e3 * getattr(each, quantity) for each in studied]
        right.loglog(tolerances, times, 'o-', ms=4, color=colour)
        _name(right, name, tolerances[0], times[0], colour)
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


def _name(axis: Any, name: str, x: float, y: float, colour: str) -> None:
    axis.annotate(
        name, (x, y), (6, 0), textcoords='offset points', va='center', color=colour, fontsize=9
    )
