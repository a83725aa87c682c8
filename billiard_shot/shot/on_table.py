"""What follows a strike where there is more than a ball on an endless cloth: the whole table."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import CollisionResult
from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene
from billiard_shot.shot.frozen import strike_together, touches
from billiard_shot.shot.model import StrikeModel
from billiard_shot.status import Status
from billiard_shot.table.initial_states import STATE_COLUMNS
from billiard_shot.table.params import TableParams

CUE = 'cue'


def has_table(scene: Scene) -> bool:
    """Whether a struck ball can meet anything but the cloth."""
    return scene.table is not None or bool(set(scene.balls) - {CUE})


def check_place(scene: Scene, centre: NDArray[np.float64]) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or no table."""
    x, y = float(centre[0]), float(centre[1])
    for name, (other_x, other_y) in scene.balls.items():
        overlap = 2.0 * scene.ball.radius - np.hypot(x - other_x, y - other_y)
        if name != CUE and overlap > rounding.PLACE:
            raise ValueError(
                f'position: ({x:g}, {y:g}) is not allowed; there it overlaps ball {name!r} by '
                f'{overlap:.3g} m'
            )
    table = scene.table
    if table is not None and (abs(x) > 0.5 * table.length or abs(y) > 0.5 * table.width):
        raise ValueError(
            f'position: ({x:g}, {y:g}) is not allowed; it must be on the table, within '
            f'{0.5 * table.length:g} and {0.5 * table.width:g} of its middle (m)'
        )


def names_of(scene: Scene) -> tuple[str, ...]:
    """Names of all balls: the cue ball, and the others in the scene's order."""
    return CUE, *(name for name in scene.balls if name != CUE)


def states_of(
    scene: Scene, centre: NDArray[np.float64], strikes: NDArray[np.void]
) -> NDArray[np.float64]:
    """States (tables, balls, STATE_COLUMNS) after strikes: all but the cue ball at rest."""
    names = names_of(scene)
    given = np.zeros((len(strikes), len(names), STATE_COLUMNS))
    for i, name in enumerate(names[1:], 1):
        given[:, i, :2] = scene.balls[name]
        given[:, i, 2] = scene.ball.radius
    given[:, 0, :3] = centre
    given[:, 0, 3:6] = strikes['velocity']
    given[:, 0, 6:9] = strikes['spin']
    return given


def strike_frozen(
    model: StrikeModel,
    table: TableParams,
    given: NDArray[np.float64],
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    strikes: NDArray[np.void],
) -> list[CollisionResult | None]:
    """
    Strike a ball that touches others or a cushion together with them, stroke by stroke.

    None for a stroke that is refused, or if the ball lies free. Changes `given` and `strikes`.
    """
    if not len(given) or not touches(table, model.surface.radius, given[0, :, :3]):
        return [None] * len(given)
    return [
        strike_together(model, table, given[i], normals[i], velocities[i], strikes[i])
        if strikes['status'][i] < Status.MISS
        else None
        for i in range(len(given))
    ]
