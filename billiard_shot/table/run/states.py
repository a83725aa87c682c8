"""The states of balls, on one table or on many, as people give them, checked and packed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import as_floats, check_type, LARGEST
from billiard_shot.scene.placement import no_start, overlaps
from billiard_shot.table.model.motion import ABSENT, NOTHING, TableBall
from billiard_shot.table.run.results import BallState

MIN_HEIGHT = 1.0 - 1e-6  # of a ball's centre, relative to the radius: less is in the cloth

VECTORS = 'position', 'velocity', 'spin'

States = Mapping[str, BallState]


def ball_starts(tables: int, balls: int) -> NDArray[np.void]:
    """Return (tables, balls) TableBall, all vectors zero, that met nothing yet."""
    starts: NDArray[np.void] = ROWS.records(TableBall, tables * balls).reshape(tables, balls)
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
    """Return (1, balls) TableBall; raise ValueError if a table cannot begin like that."""
    check_balls('states', states)
    names, radius = list(states), scene.ball.radius
    starts = ball_starts(1, len(states))
    for i, (name, state) in enumerate(states.items()):
        for field, row in zip(VECTORS, state_rows(name, state), strict=True):
            if row.shape != (3,) or not (np.abs(row) <= LARGEST).all():
                raise ValueError(
                    f'states[{name!r}].{field} must be three finite numbers, {-LARGEST:g} to '
                    f'{LARGEST:g}, got {getattr(state, field)!r}'
                )
            starts[field][0, i] = row
    places = starts['position'][0]
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


def in_cushions(scene: Scene, starts: NDArray[np.void]) -> Iterator[tuple[int, int, str]]:
    """Yield table, ball and reason for the balls of (tables, balls) TableBall in a cushion."""
    if scene.table is None:
        return
    radius, position = scene.ball.radius, starts['position']
    bed = 0.5 * np.array([scene.table.length, scene.table.width]) - radius
    for t, i in zip(*np.nonzero((np.abs(position[..., :2]) > bed).any(axis=-1)), strict=True):
        velocity = starts['velocity'][t, i].tolist()
        if why := no_start(scene.table, position[t, i].tolist(), velocity, radius):
            yield int(t), int(i), why


@dataclass(frozen=True, slots=True, init=False, eq=False)
class TableStates:
    """
    The states of the balls on many tables, which need not have the same balls.

    Parameters
    ----------
    names : sequence of str
        The balls that a table may have.
    position : (tables, balls, 3) array_like
        Centres [m], frame `table`.
    velocity, spin : (tables, balls, 3) array_like, optional
        [m/s] and [rad/s]; by default zero: the balls rest.
    present : (tables, balls) array_like of bool, optional
        Whether a table has a ball; by default every table has all of them. The numbers of a ball
        that a table does not have are ignored.

    Raises
    ------
    ValueError
        If a name is given twice, or an array has another shape.

    """

    names: tuple[str, ...]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    spin: NDArray[np.float64]
    present: NDArray[np.bool_]

    def __init__(
        self,
        names: Sequence[str],
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        spin: ArrayLike | None = None,
        present: ArrayLike | None = None,
    ) -> None:
        names = tuple(names)
        if not names or len(set(names)) < len(names):
            raise ValueError(f'names must be one name or more, all different, got {names}')
        array = as_floats(position)
        tables = len(array) if array.ndim else 0
        found = {'position': array}
        for name, values in (('velocity', velocity), ('spin', spin)):
            found[name] = np.zeros_like(array) if values is None else as_floats(values)
        for name, values in found.items():
            _check_shape(name, values, (tables, len(names), 3))
        mask = np.ones(array.shape[:2], np.bool_) if present is None else np.asarray(present)
        if mask.dtype != np.bool_:
            raise ValueError(f'present must be true or false, got {mask.dtype}')
        _check_shape('present', mask, (tables, len(names)))
        for name, value in (('names', names), *found.items(), ('present', mask)):
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f'TableStates({len(self)} tables, balls: {", ".join(self.names)})'

    def __len__(self) -> int:
        """Return the number of tables."""
        return len(self.position)

    def starts(self) -> NDArray[np.void]:
        """Return the states as (tables, balls) TableBall, all zero where a ball is absent."""
        starts = ball_starts(len(self), len(self.names))
        for field in VECTORS:
            starts[field] = np.where(self.present[..., np.newaxis], getattr(self, field), 0.0)
        starts['motion'][~self.present] = ABSENT
        return starts

    def take(self, which: NDArray[np.integer] | NDArray[np.bool_] | slice) -> 'TableStates':
        """Select some of the tables."""
        position, velocity, spin, present = (
            getattr(self, name)[which] for name in (*VECTORS, 'present')
        )
        return TableStates(self.names, position, velocity, spin, present)


ManyStates: TypeAlias = TableStates | States | Sequence[States]
"""Tables as public functions take them, see `simulate_batch`."""


def table_states(states: ManyStates, present: ArrayLike | None = None) -> TableStates:
    """
    Read the states of many tables.

    Parameters
    ----------
    states : TableStates, mapping of str to BallState, or sequence of such mappings
        One mapping whose arrays are (tables, 3), or (3,) for all tables alike; or a mapping for
        each table, with the balls that this table has.
    present : (tables, balls) array_like of bool, optional
        For one mapping: whether a table has a ball.

    Raises
    ------
    ValueError
        Naming the ball, field and value that makes no sense.

    """
    if present is not None and not isinstance(states, Mapping):
        raise ValueError('present must not be given if states is not a mapping')
    if isinstance(states, TableStates):
        return states
    if isinstance(states, Mapping):
        return _from_columns(states, present)
    check_type('states', states, Sequence)
    return _from_tables(states)


def _from_columns(states: States, present: ArrayLike | None) -> TableStates:
    check_balls('states', states)
    rows = [[np.atleast_2d(row) for row in state_rows(*each)] for each in states.items()]
    counts = {len(row) for ball in rows for row in ball} - {1}
    if len(counts) > 1:
        raise ValueError(f'states must have as many rows in all arrays, got {sorted(counts)} rows')
    tables = counts.pop() if counts else 1
    each_ball = [[np.broadcast_to(row, (tables, 3)) for row in ball] for ball in rows]
    position, velocity, spin = np.stack(each_ball, axis=2)
    return TableStates(tuple(states), position, velocity, spin, present)


def _from_tables(states: Sequence[States]) -> TableStates:
    for t, table in enumerate(states):
        check_balls(f'states[{t}]', table)
    names = tuple(dict.fromkeys(name for table in states for name in table)) or ('cue',)
    vectors = np.zeros((len(VECTORS), len(states), len(names), 3))
    present = np.zeros((len(states), len(names)), np.bool_)
    for t, table in enumerate(states):
        for i, name in enumerate(names):
            if name not in table:
                continue
            present[t, i] = True
            numbers = state_rows(name, table[name])
            if any(each.shape != (3,) for each in numbers):
                raise ValueError(
                    f'states[{t}][{name!r}] must be three numbers a vector, got rows of them'
                )
            vectors[:, t, i] = numbers
    position, velocity, spin = vectors
    return TableStates(names, position, velocity, spin, present)


def _check_shape(name: str, values: NDArray[np.generic], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f'{name} must be of shape {shape}, got {values.shape}')
