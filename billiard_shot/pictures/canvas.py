"""Figures of matplotlib, an extra that is imported when the first picture is drawn."""

import math
from pathlib import Path
from typing import Any

from billiard_shot.scene.errors import reason

IN_A_ROW = 7  # entries of a legend


def require_matplotlib() -> None:
    """Raise ValueError, with the command that installs it, if matplotlib is missing."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise ValueError("pictures need matplotlib: pip install 'billiard_shot[plot]'") from None


def has_matplotlib() -> bool:
    """Whether pictures can be drawn."""
    try:
        require_matplotlib()
    except ValueError:
        return False
    return True


def new_figure(width: float, height: float) -> Any:
    """
    Make an empty figure of a size [inches], without any display.

    Raises
    ------
    ValueError
        If matplotlib is missing, with the command that installs it.

    """
    require_matplotlib()
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout='constrained')


def add_legend(figure: Any, axes: Any) -> None:
    """Add a legend below a figure that names everything in some of its axes once."""
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    if once:
        rows = math.ceil(len(once) / IN_A_ROW)
        figure.legend(
            once.values(),
            once.keys(),
            loc='outside lower center',
            frameon=False,
            ncols=math.ceil(len(once) / rows),
            fontsize='small',
        )


def save(figure: Any, path: Path) -> None:
    """Write a figure to a file; ValueError if that cannot be done."""
    try:
        figure.savefig(path, dpi=120)
    except (OSError, ValueError) as error:
        raise ValueError(f'picture: {path}: {reason(error)}') from error
