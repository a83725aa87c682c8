"""Actions as numbers from -1 to 1, and pictures of the tables, for all environments."""

from collections.abc import Mapping, Sequence
import math
from typing import Any

import gymnasium
from gymnasium import spaces
from gymnasium.error import ResetNeeded
import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be_one_of
from billiard_shot.scene.placement import Place
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION

Float32Array = NDArray[np.float32]

ACTION = 7  # a, b, elevation, azimuth, speed; x, y of the cue ball if it is in hand


def action_space() -> spaces.Box:
    """Return the space of actions (7,) of one table."""
    return spaces.Box(-1.0, 1.0, (ACTION,), np.float32)


def scene_of_table(scene: Any) -> Scene:
    """Load a scene; ValueError if it has no pockets."""
    found = Scene.load(scene)
    if found.table is None or not found.table.pockets:
        raise ValueError('scene must have a table with pockets')
    return found


def checked_actions(actions: ArrayLike, count: int, *, is_ready: bool) -> Array:
    """
    Return actions as an array (count, 7); ValueError if they have another shape or a NaN.

    Raises
    ------
    ResetNeeded
        If the environment is not ready, because `reset` was not called.

    """
    if not is_ready:
        raise ResetNeeded('reset must be called before step')
    rows = np.asarray(actions, float)
    if rows.shape != (count, ACTION):
        shape = (ACTION,) if count == 1 else (count, ACTION)
        raise ValueError(f'action must have the shape {shape}, got an array of {rows.size}')
    if not np.isfinite(rows).all():
        raise ValueError(f'action must be finite, got {rows[~np.isfinite(rows).all(axis=1)][0]}')
    return rows


def strokes_of(scene: Scene, actions: ArrayLike) -> Array:
    """
    Return the strokes of actions.

    Parameters
    ----------
    scene : Scene
        Its `robot` limits the strokes.
    actions : (n, 7) array_like
        -1 and 1 are the limits of the robot: of a and b together its largest offset, of the
        azimuth the ends of its range. What is beyond -1 and 1 is clipped.

    Returns
    -------
    (n, 5) float array
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.

    """
    middle, half = _limits(scene)
    offsets: Array = middle + half * np.clip(np.asarray(actions, float)[:, :5], -1.0, 1.0)
    distance = np.hypot(offsets[:, A], offsets[:, B])
    largest = scene.robot.offset_max
    offsets[:, [A, B]] *= np.minimum(1.0, largest / np.maximum(distance, largest))[:, np.newaxis]
    return offsets


def scaled_places(
    length: float, width: float, radius: float, actions: ArrayLike, last: float
) -> Array:
    """Scale x, y of actions (n, 7) to places of the cue ball (n, 2) [m] with x up to `last`."""
    half = np.array([0.5 * length, 0.5 * width]) - radius
    places: Array = half * np.clip(np.asarray(actions, float)[:, 5:], -1.0, 1.0)
    places[:, 0] = -half[0] + (places[:, 0] + half[0]) * (last + half[0]) / (2.0 * half[0])
    return places


def action_of(
    scene: Scene, offsets: ArrayLike, place: ArrayLike = (0.0, 0.0)
) -> NDArray[np.float32]:
    """
    Return the actions of strokes: the inverse of `strokes_of`.

    Parameters
    ----------
    scene : Scene
    offsets : (n, 5) array_like
        As of `Stroke.from_offsets`; what is beyond the limits is clipped.
    place : (2,) or (n, 2) array_like
        Of the cue ball, if it is in hand anywhere on the table [m].

    """
    middle, half = _limits(scene)
    table, radius = scene.table, scene.ball.radius
    assert table is not None
    rows = np.array(offsets, float)
    found = np.zeros((len(rows), ACTION))
    change = rows - middle
    change[:, AZIMUTH] = wrapped(change[:, AZIMUTH])
    found[:, :5] = change / np.maximum(half, 1e-12)
    found[:, 5:] = np.asarray(place) / (np.array([table.length, table.width]) / 2.0 - radius)
    return np.clip(found, -1.0, 1.0).astype(np.float32)


def _limits(scene: Scene) -> tuple[Array, Array]:
    """Return the middles and the half ranges (5,) of strokes."""
    robot = scene.robot
    low = np.array([-robot.offset_max, -robot.offset_max, 0.0, 0.0, robot.speed_min])
    high = np.array([robot.offset_max, robot.offset_max, 0.0, 0.0, robot.speed_max])
    low[ELEVATION], high[ELEVATION] = np.radians(
        [robot.elevation_min_deg, robot.elevation_max_deg]
    )
    middle, range_ = math.radians(robot.azimuth_deg), math.radians(robot.azimuth_half_range_deg)
    low[AZIMUTH], high[AZIMUTH] = middle - range_, middle + range_
    return 0.5 * (low + high), 0.5 * (high - low)


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
