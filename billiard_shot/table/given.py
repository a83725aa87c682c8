"""States of balls as people give them, checked, in the form that compiled code takes."""
from collections.abc import Mapping, Sequence
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.table.trajectory import BallState

INPUT = 9  # columns of a ball's state: position, velocity, spin

States = Mapping[str, BallState]


def check_options(tolerance: float, max_events: int) -> None:
    """Raise ValueError for options that make no sense."""
    if not 0.0 < tolerance < math.inf:
        raise ValueError(
            f'tolerance: {tolerance!r} is not allowed; it must be finite and above 0 (m)'
        )
    if isinstance(max_events, bool) or not isinstance(max_events, int) or max_events < 1:
        raise ValueError(
            f'max_events: {max_events!r} is not allowed; it must be a whole number, at least 1'
        )


def _row(name: str, state: BallState) -> list[NDArray[np.float64]]:
    rows = []
    for field in ('position', 'velocity', 'spin'):
        try:
            row = np.asarray(getattr(state, field), dtype=float)
        except (TypeError, ValueError):
            row = np.empty(0)
        if row.ndim not in (1, 2) or row.shape[-1] != 3:
            raise ValueError(
                f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must be '
                'three numbers, or rows of three'
            )
        rows.append(row)
    return rows


def checked(scene: Scene, states: States) -> NDArray[np.float64]:
    """(1, balls, INPUT) states, all of which can be."""
    radius = scene.ball.radius
    given = np.empty((1, len(states), INPUT))
    for i, (name, state) in enumerate(states.items()):
        rows = _row(name, state)
        for k, (field, row) in enumerate(zip(('position', 'velocity', 'spin'), rows, strict=True)):
            if row.shape != (3,) or not np.isfinite(row).all():
                raise ValueError(
                    f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must '
                    'be three finite numbers'
                )
            given[0, i, 3 * k : 3 * k + 3] = row
        if given[0, i, 2] < radius * (1.0 - 1e-6):
            raise ValueError(
                f'states[{name!r}].position: {given[0, i, 2]:.6g} is not allowed as z; it must be '
                f'at least the radius, {radius:g} (m)'
            )
        table = scene.table
        if table is not None and (
            abs(given[0, i, 0]) > 0.5 * table.length or abs(given[0, i, 1]) > 0.5 * table.width
        ):
            raise ValueError(
                f'states[{name!r}].position: ({given[0, i, 0]:g}, {given[0, i, 1]:g}) is not '
                f'allowed; it must be on the table, within {0.5 * table.length:g} and '
                f'{0.5 * table.width:g} of its middle (m)'
            )
    names, places = list(states), given[0, :, :3]
    for i in range(len(names)):
        gaps = np.linalg.norm(places[:i] - places[i], axis=1) - 2.0 * radius
        for j in np.flatnonzero(gaps < -1e-9):
            raise ValueError(
                f'states: balls {names[j]!r} and {names[i]!r} overlap by {-gaps[j]:.3g} m'
            )
    return given


def many(states: States | Sequence[States]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """Names of the balls, and (tables, balls, INPUT) states."""
    if isinstance(states, Mapping):
        names = tuple(states)
        rows = [[np.atleast_2d(row) for row in _row(name, states[name])] for name in names]
        counts = {len(row) for ball in rows for row in ball} - {1}
        if len(counts) > 1:
            raise ValueError(
                f'states: arrays of {sorted(counts)} rows are not allowed; all must have as many'
            )
        tables = counts.pop() if counts else 1
        given = np.empty((tables, len(names), INPUT))
        for i, ball in enumerate(rows):
            for k, row in enumerate(ball):
                given[:, i, 3 * k : 3 * k + 3] = row
        return names, given
    names = tuple(states[0]) if len(states) else ()
    given = np.empty((len(states), len(names), INPUT))
    for t, table in enumerate(states):
        if set(table) != set(names):
            raise ValueError(
                f'states[{t}]: balls {sorted(table)} are not allowed; all tables must have the '
                f'same, {sorted(names)}'
            )
        for i, name in enumerate(names):
            given[t, i] = np.concatenate(_row(name, table[name]))
    return names, given
