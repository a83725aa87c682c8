"""The work-precision picture."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from billiard_shot.pictures.canvas import add_legend, new_figure, save
from billiard_shot.study.accuracy import AccuracyPoint
from billiard_shot.table.colours import BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION

METHOD_COLOURS = {
    'this library': VERMILION,
    'impulse scheme': BLUE,
    'SciPy DOP853': GREEN,
    'SciPy Radau': PURPLE,
    'MuJoCo': GREY,
    'closed form': BLACK,
}
LEAST_REST, LEAST_PART = 1e-10, 1e-13  # mm; fraction of the cue speed. Less is drawn there.

Quantity = Callable[[AccuracyPoint], float]


def draw_accuracy(curves: Mapping[str, Sequence[AccuracyPoint]], path: Path, title: str) -> None:
    """
    Draw the error of the resting place over time, and the error of velocity over evaluations.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    figure = new_figure(11.0, 4.8)
    panels: tuple[tuple[Quantity, Quantity, str, str], ...] = (
        (
            lambda p: 1e6 * p.seconds,
            lambda p: max(p.rest, LEAST_REST),
            'time of a strike (µs)',
            'largest error of the resting place (mm)',
        ),
        (
            lambda p: p.evaluations,
            lambda p: max(p.part, LEAST_PART),
            'steps, or evaluations of the right-hand side',
            'largest error of velocity and spin\n(part of the cue speed)',
        ),
    )
    for axis, (work, error, work_label, error_label) in zip(
        figure.subplots(1, 2), panels, strict=True
    ):
        axis.set_xscale('log')
        axis.set_yscale('log')
        for name, points in curves.items():
            paying = settings_that_pay(points, work, error)
            others = [p for p in points if p not in paying]
            colour = METHOD_COLOURS[name]
            axis.plot(
                [*map(work, paying)],
                [*map(error, paying)],
                'o-',
                color=colour,
                ms=4,
                lw=1.2,
                label=name,
            )
            axis.plot(
                [*map(work, others)], [*map(error, others)], 'o', color=colour, ms=4, mfc='none'
            )
        axis.set_xlabel(work_label)
        axis.set_ylabel(error_label)
        axis.margins(0.08)
        axis.grid(alpha=0.3)
        axis.tick_params(labelsize='small')
    add_legend(figure, axis)
    figure.suptitle(
        f'{title}\nEach point is a step or a tolerance. Hollow: another setting costs less and '
        'errs less, or not all strokes are solved.',
        fontsize='medium',
    )
    save(figure, path)


def settings_that_pay(
    points: Sequence[AccuracyPoint], work: Quantity, error: Quantity
) -> list[AccuracyPoint]:
    """Find points that solve the most strokes, with less error than all cheaper ones; by work."""
    most = max(p.answered for p in points)
    paying: list[AccuracyPoint] = []
    for point in sorted((p for p in points if p.answered == most), key=work):
        if not paying or error(point) < error(paying[-1]):
            paying.append(point)
    return paying
