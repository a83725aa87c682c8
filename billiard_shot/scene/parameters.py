"""The numbers of a scene by their names, such as `table.cushion.restitution`; to fit or vary."""

from collections.abc import Iterator, Mapping, Sequence
import dataclasses
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.scene.errors import InputError, Mistake, unknown
from billiard_shot.scene.fields import NUMBER, Range, SECTION_KEY
from billiard_shot.scene.published import PUBLISHED
from billiard_shot.scene.values import as_floats


@dataclass(frozen=True, slots=True)
class Parameter:
    """
    A number of a scene.

    Attributes
    ----------
    name : str
        Keys of the scene file, joined by points.
    value : float
    unit : str
        Empty for a number without unit.
    low, high : float
        Bounds of the values that are allowed; infinite where there is none.
    published : (float, float), optional
        Range of published values, see published.py.
    source : str
        Of that range; empty if there is none.

    """

    name: str
    value: float
    unit: str
    low: float
    high: float
    published: tuple[float, float] | None
    source: str


def parameters_of(scene: Any, names: Sequence[str] | None = None) -> tuple[Parameter, ...]:
    """
    List numbers of a scene.

    Parameters
    ----------
    scene : Scene
    names : sequence of str, optional
        By default all numbers that balls, cue, contacts, cloth and table have.

    Raises
    ------
    ValueError
        If a name is unknown.

    """
    known = {each.name: each for each in _numbers(scene, ())}
    wanted = list(known) if names is None else names
    return tuple(known[name] for name in _checked(known, wanted))


def with_parameters(scene: Any, names: Sequence[str], values: ArrayLike) -> Any:
    """
    Copy a scene with other numbers.

    Parameters
    ----------
    scene : Scene
    names : sequence of str
        As of `parameters_of`.
    values : (names,) array_like

    Raises
    ------
    ValueError
        Naming each name that is unknown, and each value that is not allowed.

    """
    known = [each.name for each in _numbers(scene, ())]
    row = as_floats(values)
    if row.shape != (len(names),):
        raise ValueError(f'values must be of shape ({len(names)},), got {row.shape}')
    data = scene.to_dict()
    for name, value in zip(_checked(known, names), row.tolist(), strict=True):
        *sections, last = name.split('.')
        place: dict[str, Any] = data
        for section in sections:
            place = place.setdefault(section, {})
        place[last] = value
    return type(scene).from_dict(data)


def rows_of_parameters(given: Mapping[str, ArrayLike], count: int) -> tuple[list[str], Any]:
    """
    Read numbers that differ from row to row of a batch.

    Returns
    -------
    names : list of str
    values : (count, names) float array

    Raises
    ------
    ValueError
        If an array does not have `count` rows.

    """
    names = list(given)
    values = np.zeros((count, len(names)))
    for k, (name, column) in enumerate(given.items()):
        found = as_floats(column)
        if found.shape not in ((1,), (count,)):  # a number alone is the same for all rows
            raise ValueError(
                f'parameters[{name!r}] must be of shape ({count},), got {found.shape}'
            )
        values[:, k] = found
    return names, values


def _checked(known: Any, names: Sequence[str]) -> Sequence[str]:
    mistakes = [
        Mistake((str(name),), unknown(str(name), known)) for name in names if name not in known
    ]
    if mistakes:
        raise InputError(mistakes, 'parameters')
    return names


def _numbers(section: Any, path: tuple[str, ...]) -> Iterator[Parameter]:
    """List the numbers of a section, and of those in it; robot and noise are not among them."""
    for field in dataclasses.fields(section):
        value, here = getattr(section, field.name), (*path, field.name)
        if value is None:
            continue
        if NUMBER in field.metadata:
            found: Range = field.metadata[NUMBER]
            low = found.minimum if found.above is None else found.above
            name = '.'.join(here)
            published = PUBLISHED.get(name)
            yield Parameter(
                name,
                float(value),
                found.unit,
                -math.inf if low is None else low,
                math.inf if found.maximum is None else found.maximum,
                published=published and published[:2],
                source=published.source if published else '',
            )
        elif SECTION_KEY in field.metadata and here[0] not in PLAYER:
            yield from _numbers(value, here)


PLAYER = 'robot', 'noise'
