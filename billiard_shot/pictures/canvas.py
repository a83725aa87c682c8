"""Pictures need matplotlib, an extra: it is imported when the first one is drawn."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any


def require_matplotlib() -> None:
    """Raise ValueError, with what installs it, if there is no matplotlib."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise ValueError(
            "picture: needs matplotlib, an extra: pip install 'billiard_shot[plot]'"
        ) from None


def new_figure(columns: int, width: float, height: float) -> tuple[Any, Any]:
    """
    Make a figure with some axes side by side, without any display.

    Parameters
    ----------
    columns : int
        How many axes.
    width, height : float
        Of the figure [inches].

    Returns
    -------
    figure, axes : matplotlib Figure, list of Axes

    Raises
    ------
    ValueError
        If there is no matplotlib, with what installs it.

    """
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout='constrained')
    return figure, [figure.add_subplot(1, columns, 1 + column) for column in range(columns)]


def single_figure(width: float, height: float) -> tuple[Any, Any]:
    """Make a figure of a size [inches] with one pair of axes; as `new_figure`."""
    figure, axes = new_figure(1, width, height)
    return figure, axes[0]


def rows_figure(heights: Sequence[float], width: float) -> tuple[Any, list[Any]]:
    """Make a figure of axes below each other that share x; sizes in inches; as `new_figure`."""
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, sum(heights)), layout='constrained')
    axes = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    return figure, list(axes)


def save(figure: Any, path: Path) -> None:
    """Write a figure to a file; ValueError if that cannot be done."""
    try:
        figure.savefig(path, dpi=120)
    except (OSError, ValueError) as error:
        raise ValueError(f'picture: {path}: {error}') from error
