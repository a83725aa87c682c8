"""Outcomes of the laws in parameter sweeps through a stroke."""

from collections.abc import Mapping, Sequence
import math
from pathlib import Path

from billiard_shot.pictures.canvas import add_legend, new_figure, save
from billiard_shot.records import Array
from billiard_shot.study.laws import Discontinuity, ParameterSweep
from billiard_shot.table.colours import BLUE, GREEN, GREY, VERMILION

PANELS_PER_ROW = 3
STYLES = {
    'bistiffness': (BLUE, '-'),
    'energetic': (VERMILION, '-'),
    'pairwise': (GREEN, '--'),
    'newton': (GREY, ':'),
}
SEARCHED = ('bistiffness', 'energetic')  # laws in which discontinuities are looked for


def draw_laws(
    sweeps: Sequence[ParameterSweep],
    distances: Mapping[tuple[str, str], Array],
    discontinuities: Mapping[tuple[str, str], Sequence[Discontinuity]],
    path: Path,
    about: str,
) -> None:
    """
    Write a picture with a panel for each sweep: distance from start to rest, over the parameter.

    Keys of `distances` and `discontinuities` are the name of the sweep and the law or method.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    rows = math.ceil(len(sweeps) / PANELS_PER_ROW)
    figure = new_figure(3.3 * PANELS_PER_ROW, 2.6 * rows + 0.6)
    panels = figure.subplots(rows, PANELS_PER_ROW, squeeze=False).ravel()
    for axes in panels[len(sweeps) :]:
        axes.set_axis_off()
    for axes, sweep in zip(panels, sweeps, strict=False):
        for way, (colour, dashes) in STYLES.items():
            if (sweep.name, way) in distances:
                axes.plot(
                    sweep.values,
                    distances[sweep.name, way],
                    dashes,
                    color=colour,
                    linewidth=1.2,
                    label=way,
                )
        for way in SEARCHED:
            for discontinuity in discontinuities.get((sweep.name, way), ()):
                axes.axvline(discontinuity.place, color=STYLES[way][0], linewidth=0.6, alpha=0.6)
        if sweep.values[0] > 0.0 and sweep.values[-1] > 50.0 * sweep.values[0]:
            axes.set_xscale('log')
        axes.set_xlabel(sweep.name)
        axes.tick_params(labelsize='small')
        axes.grid(alpha=0.3)
    figure.supylabel('distance from start to rest (m)', fontsize='medium')
    count = {
        way: sum(len(discontinuities.get((sweep.name, way), ())) for sweep in sweeps)
        for way in SEARCHED
    }
    findings = ', '.join(f'{number} of {way}' for way, number in count.items())
    figure.suptitle(f'{about}; discontinuities (thin lines): {findings}', fontsize='medium')
    add_legend(figure, panels[0])
    save(figure, path)
