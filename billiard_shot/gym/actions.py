"""Actions: a stroke and a place of the cue ball in hand, as numbers from -1 to 1."""

import math
from typing import Any

from gymnasium import spaces
from gymnasium.error import ResetNeeded
import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.numerics.angles import wrapped
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.player import A, B

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
    offsets[:, :2] *= np.minimum(1.0, largest / np.maximum(distance, largest))[:, np.newaxis]
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
    change[:, 3] = wrapped(change[:, 3])
    found[:, :5] = change / np.maximum(half, 1e-12)
    found[:, 5:] = np.asarray(place) / (np.array([table.length, table.width]) / 2.0 - radius)
    return np.clip(found, -1.0, 1.0).astype(np.float32)


def _limits(scene: Scene) -> tuple[Array, Array]:
    """Return the middles and the half ranges (5,) of strokes."""
    robot = scene.robot
    low = np.array([-robot.offset_max, -robot.offset_max, 0.0, 0.0, robot.speed_min])
    high = np.array([robot.offset_max, robot.offset_max, 0.0, 0.0, robot.speed_max])
    low[2], high[2] = np.radians([robot.elevation_min_deg, robot.elevation_max_deg])
    middle, range_ = math.radians(robot.azimuth_deg), math.radians(robot.azimuth_half_range_deg)
    low[3], high[3] = middle - range_, middle + range_
    return 0.5 * (low + high), 0.5 * (high - low)
