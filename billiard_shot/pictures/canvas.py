"""
Figures of matplotlib, an extra that is imported when the first picture is drawn; and colours.

Colours of motions and of balls are the same in pictures, RViz and the view in the browser. Those
of motions and marks are from the palette of Okabe and Ito (jfly.uni-koeln.de/color), which people
with any kind of colour vision can tell apart; lines differ in their dashes, too.
"""

import math
from pathlib import Path
import re
from typing import Any

from billiard_shot.scene.errors import reason
from billiard_shot.table.model.motion import Motion

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


BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE, GREY = (
    '#000000',
    '#e69f00',
    '#56b4e9',
    '#009e73',
    '#0072b2',
    '#d55e00',
    '#cc79a7',
    '#7f7f7f',
)

MOTIONS = {Motion.SLIDE: VERMILION, Motion.ROLL: BLUE, Motion.FLIGHT: BLACK, Motion.SPIN: PURPLE}

CUE_BALL_COLOUR = '#fbfaf3'
# Pool balls 1 to 8; 9 to 15 have a stripe in the colours of 1 to 7.
POOL = ('#f2bd1d', '#1c4fa1', '#d3222a', '#4c2a7a', '#f07d1a', '#14743f', '#7a1f2b', '#1b1b1b')
NAMED = {
    'cue': CUE_BALL_COLOUR,
    'white': CUE_BALL_COLOUR,
    'red': '#c5161d',
    'yellow': '#f5cf2b',
    'green': '#14743f',
    'brown': '#6b3a1e',
    'blue': '#1c4fa1',
    'pink': '#ef8fb0',
    'black': '#1b1b1b',
}
OTHER = '#9aa3ab'


def ball_colour(name: str) -> str:
    """Colour of a ball, by its number or by a name that begins with a colour."""
    if name.isdecimal() and 1 <= int(name) <= 15:
        return POOL[(int(name) - 1) % 8 if int(name) < 9 else int(name) - 9]
    letters = re.match('[a-z]*', name.lower())
    return NAMED.get(letters.group() if letters else '', OTHER)


def is_striped(name: str) -> bool:
    """Whether a ball is white with a stripe of its colour."""
    return name.isdecimal() and 9 <= int(name) <= 15
