"""The work-precision picture."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from billiard_shot.study.accuracy import order, Point

COLOURS = {
    'this library': 'tab:red',
    'impulse scheme': 'tab:blue',
    'SciPy DOP853': 'tab:green',
    'SciPy Radau': 'tab:olive',
    'MuJoCo': 'tab:gray',
    'closed form': 'black',
}
SMALLEST = 1e-13  # m and parts of a speed: smaller errors are drawn there


def draw(
    curves: Mapping[str, Sequence[Point]], settings: Mapping[str, str], about: str, path: Path
) -> None:
    """
    Write a picture: error of the resting place over time, error of velocity over work.

    `curves` and `settings` (what a method's settings are) go by method. Points are hollow where a
    method has no answer to some of the strokes.
    """
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        raise ValueError('--picture: needs matplotlib (pip install matplotlib)') from None
    figure = Figure(figsize=(9.5, 4.4), layout='constrained')
    left, right = figure.subplots(1, 2)
    for name, points in curves.items():
        power = order(points)
        label = f'{name}: {settings[name]}^{abs(power):.1f}' if power == power else name
        most = max(p.answered for p in points)
        for axes, work, error in (
            (left, [1e6 * p.seconds for p in points], [1e-3 * p.rest for p in points]),
            (right, [p.evaluations for p in points], [p.part for p in points]),
        ):
            drawn = [max(x, SMALLEST) * (1e3 if axes is left else 1.0) for x in error]
            axes.loglog(work, drawn, color=COLOURS[name], label=label, linewidth=1.2)
            for x, y, p in zip(work, drawn, points, strict=True):
                axes.plot(
                    x,
                    y,
                    'o',
                    color=COLOURS[name],
                    markersize=4,
                    fillstyle='full' if p.answered == most else 'none',
                )
    left.set_xlabel('time of a strike (µs)')
    left.set_ylabel('error of the resting place (mm)')
    right.set_xlabel('evaluations: steps, or of the right-hand side')
    right.set_ylabel('error of velocity and spin\n(parts of the cue speed)')
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.tick_params(labelsize='small')
    figure.suptitle(f'What accuracy costs: {about} (worst error, mean work)', fontsize='medium')
    handles, labels = left.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc='outside lower center',
        ncols=3,
        frameon=False,
        fontsize='small',
        title='method: its error goes with',
        title_fontsize='small',
    )
    figure.savefig(path, dpi=120)
