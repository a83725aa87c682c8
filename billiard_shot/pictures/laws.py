"""Outcomes of the laws along lines through a stroke."""

from collections.abc import Mapping, Sequence
import math
from pathlib import Path

from billiard_shot.study.laws import Jump, Line
from billiard_shot.study.problem import Vector

COLUMNS = 3
STYLES = {
    'bistiffness': ('tab:blue', '-'),
    'energetic': ('tab:red', '-'),
    'pairwise': ('tab:green', '--'),
    'newton': ('tab:gray', ':'),
}


def draw(
    lines: Sequence[Line],
    distances: Mapping[tuple[str, str], Vector],
    jumps: Mapping[tuple[str, str], Sequence[Jump]],
    about: str,
    path: Path,
) -> None:
    """
    Write a picture, a panel a line: distance from start to rest, by way; dots where a law jumps.

    `distances` and `jumps` go by name of the line and way.
    """
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        raise ValueError('--picture: needs matplotlib (pip install matplotlib)') from None
    rows = math.ceil(len(lines) / COLUMNS)
    figure = Figure(figsize=(3.3 * COLUMNS, 2.6 * rows + 0.6), layout='constrained')
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for axes in panels[len(lines) :]:
        axes.set_axis_off()
    for axes, line in zip(panels, lines, strict=False):
        for way, (colour, dashes) in STYLES.items():
            if (line.name, way) in distances:
                axes.plot(
                    line.values,
                    distances[line.name, way],
                    dashes,
                    color=colour,
                    linewidth=1.2,
                    label=way,
                )
        for way in ('bistiffness', 'energetic'):
            for jump in jumps.get((line.name, way), ()):
                axes.axvline(jump.place, color=STYLES[way][0], linewidth=0.6, alpha=0.6)
        if line.values[0] > 0.0 and line.values[-1] > 50.0 * line.values[0]:
            axes.set_xscale('log')
        axes.set_xlabel(line.name)
        axes.tick_params(labelsize='small')
        axes.grid(alpha=0.3)
    figure.supylabel('distance from start to rest (m)', fontsize='medium')
    figure.suptitle(f'{about}; thin lines: jumps', fontsize='medium')
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc='outside lower center', ncols=4, frameon=False, fontsize='small'
    )
    figure.savefig(path, dpi=120)
