"""States of balls as people give them, checked, in the form that compiled code takes."""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import record, ROWS, Vector3
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_start, overlaps
from billiard_shot.scene.values import as_floats, check_type, LARGEST
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.trajectory import BallState

MIN_HEIGHT = 1.0 - 1e-6  # of a ball's centre, relative to the radius: less is in the cloth

VECTORS = 'position', 'velocity', 'spin'

States = Mapping[str, BallState]


@record
class BallStart:
    """A ball at the beginning of a run."""

    position: Vector3  # m
    velocity: Vector3  # m/s
    spin: Vector3  # rad/s
    first_contact: int  # index of the first ball that it met before the run, or NOTHING
    absent: bool  # the table does not have this ball


def ball_starts(tables: int, balls: int) -> NDArray[np.void]:
    """Return (tables, balls) BallStart, all vectors zero, that met nothing yet."""
    starts: NDArray[np.void] = ROWS.records(BallStart, tables * balls).reshape(tables, balls)
    starts['first_contact'] = NOTHING
    return starts


def state_rows(name: str, state: BallState) -> list[NDArray[np.float64]]:
    """Return position, velocity and spin of a ball: each (3,), or rows (n, 3)."""
    check_type(f'states[{name!r}]', state, BallState)
    rows = []
    for field in VECTORS:
        row = as_floats(getattr(state, field))
        if row.ndim not in (1, 2) or row.shape[-1] != 3:
            raise ValueError(
                f'states[{name!r}].{field} must be three numbers, or rows of three, got '
                f'{getattr(state, field)!r}'
            )
        rows.append(row)
    return rows


def check_balls(name: str, states: States) -> None:
    """Raise ValueError if a table's states are no mapping, or have no balls."""
    check_type(name, states, Mapping)
    if not states:
        raise ValueError(f'{name} must contain at least one ball')


def validated_starts(scene: Scene, states: States) -> NDArray[np.void]:
    """Return (1, balls) BallStart; raise ValueError if a table cannot begin like that."""
    check_balls('states', states)
    names, radius = list(states), scene.ball.radius
    starts = ball_starts(1, len(states))
    vectors = _vectors(states)
    for i, field in enumerate(VECTORS):
        starts[field][0] = vectors[:, i]
    places = vectors[:, 0]
    if (places[:, 2] < radius * MIN_HEIGHT).any():
        i = int((places[:, 2] < radius * MIN_HEIGHT).argmax())
        raise ValueError(
            f'states[{names[i]!r}].position must have a z of at least the radius, {radius:g}, got '
            f'{places[i, 2]:.6g} (m)'
        )
    for t, i, why in in_cushions(scene, starts):
        x, y, _ = starts['position'][t, i]
        raise ValueError(f'states[{names[i]!r}].position must be {why}, got ({x:g}, {y:g}) (m)')
    lying = dict(zip(names, places.tolist(), strict=True))
    for _, name, why in overlaps(lying, radius):
        raise ValueError(f'states[{name!r}].position must be {why}, got {lying[name]} (m)')
    return starts


def _vectors(states: States) -> NDArray[np.float64]:
    """Return (balls, vectors, 3); raise ValueError if a vector is not three finite numbers."""
    for name, state in states.items():
        check_type(f'states[{name!r}]', state, BallState)
    vectors = as_floats([[getattr(each, field) for field in VECTORS] for each in states.values()])
    if vectors.shape == (len(states), 3, 3) and (np.abs(vectors) <= LARGEST).all():
        return vectors
    for name, state in states.items():
        for field, row in zip(VECTORS, state_rows(name, state), strict=True):
            if row.shape != (3,) or not (np.abs(row) <= LARGEST).all():
                raise ValueError(
                    f'states[{name!r}].{field} must be three finite numbers, {-LARGEST:g} to '
                    f'{LARGEST:g}, got {getattr(state, field)!r}'
                )
    raise AssertionError('one of the vectors is wrong')


def in_cushions(scene: Scene, starts: NDArray[np.void]) -> Iterator[tuple[int, int, str]]:
    """Yield table, ball and reason for the balls of (tables, balls) BallStart in a cushion."""
    if scene.table is None:
        return
    radius, position = scene.ball.radius, starts['position']
    bed = 0.5 * np.array([scene.table.length, scene.table.width]) - radius
    for t, i in zip(*np.nonzero((np.abs(position[..., :2]) > bed).any(axis=-1)), strict=True):
        velocity = starts['velocity'][t, i].tolist()
        if why := no_start(scene.table, position[t, i].tolist(), velocity, radius):
            yield int(t), int(i), why
