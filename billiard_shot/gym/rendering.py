"""Pictures of the tables of environments, as arrays or in a window."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be_one_of
from billiard_shot.scene.rack import Place

RENDER_MODES = ['rgb_array', 'human']

RENDER_FPS = 2
"""Pictures a second of a video: each shows the balls at rest before a stroke."""

DRAWN = {'render_modes': RENDER_MODES, 'render_fps': RENDER_FPS}
"""Metadata of the environments of one table."""

DPI = 80


def render_mode_of(mode: str | None, modes: Sequence[str] = RENDER_MODES) -> str | None:
    """Check a render mode; ValueError if there is no such mode."""
    if mode is not None and mode not in modes:
        raise ValueError(f'render_mode {must_be_one_of(modes, mode, "mode")}')
    return mode


def picture_of(scene: Scene, places: Mapping[str, Place], title: str = '') -> NDArray[np.uint8]:
    """
    Draw balls on the table of a scene.

    Parameters
    ----------
    scene : Scene
    places : mapping of str to (x, y)
        Places of the balls that are on the table, by name [m].
    title : str

    Returns
    -------
    (height, width, 3) uint8 array
        Red, green and blue.

    Raises
    ------
    ValueError
        If matplotlib is missing, with the command that installs it.

    """
    from billiard_shot.pictures.table import draw_balls, table_axes

    figure, axes = table_axes(scene, title=title)  # says if matplotlib is missing
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    draw_balls(axes, scene, places)
    figure.set_dpi(DPI)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


class DrawnEnv(gymnasium.Env[Any, Any]):
    """
    An environment that draws its table.

    Parameters
    ----------
    render_mode : str, optional
        `rgb_array`: `render` gives a picture; `human`: each step shows one in a window.

    """

    metadata: dict[str, Any] = DRAWN
    scene: Scene

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode_of(render_mode)
        self._window: Any = None  # image in the window

    def places(self) -> Mapping[str, Place]:
        """Places of the balls that are on the table, by name [m]."""
        raise NotImplementedError

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the table: a (height, width, 3) array, or None if a window shows it."""
        return picture_of(self.scene, self.places()) if self.render_mode == 'rgb_array' else None

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            from matplotlib import pyplot as plt

            plt.close(self._window.figure)
            self._window = None

    def show(self) -> None:
        """Show the table in the window, if the render mode is `human`."""
        if self.render_mode != 'human':
            return
        picture = picture_of(self.scene, self.places())
        from matplotlib import pyplot as plt

        if self._window is None:
            axes = plt.figure(layout='tight').subplots()
            axes.set_axis_off()
            self._window = axes.imshow(picture)
            plt.show(block=False)
        self._window.set_data(picture)
        self._window.figure.canvas.draw_idle()
        self._window.figure.canvas.flush_events()
