"""States of balls as people give them, checked, in the form that compiled code takes."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_start
from billiard_shot.scene.values import as_floats, check_type, LARGEST
from billiard_shot.table.trajectory import BallState

STATE_COLUMNS = 9  # columns of a ball's state: position, velocity, spin
MIN_HEIGHT = 1.0 - 1e-6  # of a ball's centre, relative to the radius: less is in the cloth

States = Mapping[str, BallState]


def _row(name: str, state: BallState) -> list[NDArray[np.float64]]:
    check_type(f'states[{name!r}]', state, BallState)
    rows = []
    for field in ('position', 'velocity', 'spin'):
        row = as_floats(getattr(state, field))
        if row.ndim not in (1, 2) or row.shape[-1] != 3:
            raise ValueError(
                f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must be '
                'three numbers, or rows of three'
            )
        rows.append(row)
    return rows


def _check_balls(name: str, states: States) -> None:
    check_type(name, states, Mapping)
    if not states:
        raise ValueError(f'{name}: no balls are not allowed; there must be at least one')


def validated_states(scene: Scene, states: States) -> NDArray[np.float64]:
    """Return states (1, balls, STATE_COLUMNS), all of which can be."""
    _check_balls('states', states)
    radius = scene.ball.radius
    array = np.empty((1, len(states), STATE_COLUMNS))
    for i, (name, state) in enumerate(states.items()):
        rows = _row(name, state)
        for k, (field, row) in enumerate(zip(('position', 'velocity', 'spin'), rows, strict=True)):
            if row.shape != (3,) or not (np.abs(row) <= LARGEST).all():
                raise ValueError(
                    f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must '
                    f'be three finite numbers, {-LARGEST:g} to {LARGEST:g}'
                )
            array[0, i, 3 * k : 3 * k + 3] = row
        if array[0, i, 2] < radius * MIN_HEIGHT:
            raise ValueError(
                f'states[{name!r}].position: {array[0, i, 2]:.6g} is not allowed as z; it must be '
                f'at least the radius, {radius:g} (m)'
            )
        x, y, z, *velocity = array[0, i, :6].tolist()
        if scene.table is not None and (why := no_start(scene.table, (x, y, z), velocity, radius)):
            raise ValueError(f'states[{name!r}].position: ({x:g}, {y:g}) is not allowed; {why}')
    names, places = list(states), array[0, :, :3]
    if len(names) > 1:
        gaps = np.linalg.norm(places[:, np.newaxis] - places, axis=2) - 2.0 * radius
        np.fill_diagonal(gaps, 0.0)
        if gaps.min() < -rounding.PLACE:
            i, j = divmod(int(gaps.argmin()), len(names))
            raise ValueError(
                f'states: balls {names[min(i, j)]!r} and {names[max(i, j)]!r} overlap by '
                f'{-gaps[i, j]:.3g} m'
            )
    return array


def batch_states(states: States | Sequence[States]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """Return the names of the balls, and states (tables, balls, STATE_COLUMNS)."""
    if isinstance(states, Mapping):
        _check_balls('states', states)
        names = tuple(states)
        rows = [[np.atleast_2d(row) for row in _row(name, states[name])] for name in names]
        counts = {len(row) for ball in rows for row in ball} - {1}
        if len(counts) > 1:
            raise ValueError(
                f'states: arrays of {sorted(counts)} rows are not allowed; all must have as many'
            )
        tables = counts.pop() if counts else 1
        array = np.empty((tables, len(names), STATE_COLUMNS))
        for i, ball in enumerate(rows):
            for k, row in enumerate(ball):
                array[:, i, 3 * k : 3 * k + 3] = row
        return names, array
    check_type('states', states, Sequence)
    for t, table in enumerate(states):
        _check_balls(f'states[{t}]', table)
    names = tuple(states[0]) if len(states) else ()
    array = np.empty((len(states), len(names), STATE_COLUMNS))
    for t, table in enumerate(states):
        if set(table) != set(names):
            raise ValueError(
                f'states[{t}]: balls {sorted(table)} are not allowed; all tables must have the '
                f'same, {sorted(names)}'
            )
        for i, name in enumerate(names):
            numbers = _row(name, table[name])
            if any(each.shape != (3,) for each in numbers):
                raise ValueError(
                    f'states[{t}][{name!r}]: rows are not allowed; each must be three numbers'
                )
            array[t, i] = np.concatenate(numbers)
    return names, array
