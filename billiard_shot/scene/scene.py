"""The scene: all input of a prediction except the stroke; and its numbers by their names."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)

from collections.abc import Iterator, Mapping, Sequence
import dataclasses
from dataclasses import dataclass, InitVar, replace
import math
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.notebook import Shown
from billiard_shot.scene import placement
from billiard_shot.scene.equipment import Ball, Cloth, Contacts, Cue, hasty_cushion, Table
from billiard_shot.scene.errors import InputError, Mistake, refused, TWICE, unknown
from billiard_shot.scene.fields import (
    as_floats,
    check,
    CheckedRecord,
    choice,
    DerivedNumber,
    fill_in,
    NUMBER,
    number,
    places,
    Range,
    read,
    section,
    SECTION_KEY,
    write,
)
from billiard_shot.scene.files import Document, find_scene, read_document, resolved, scene_names
from billiard_shot.scene.player import ModelError, Noise, NOISES, Robot

PROPERTIES = 'Alciatore: physical properties of pool balls, cues and tables'
EQUIPMENT = 'WPA: Tables & Equipment Specifications'
CUSHION_SOURCE = f'{PROPERTIES}; snooker: Mathavan, Jackson and Parkin, Proc. IMechE C 224 (2010)'
RECORDED = 'carom: recordings of tailuge/billiards; pool and snooker: no rise is reported'
INCH, OUNCE = 0.0254, 0.028349523  # m, kg


class PublishedRange(NamedTuple):
    """A range of published values, in the unit of the number."""

    low: float
    high: float
    source: str


PUBLISHED = {
    'ball.mass': PublishedRange(5.5 * OUNCE, 6.0 * OUNCE, EQUIPMENT),
    'ball.radius': PublishedRange(1.1225 * INCH, 1.1275 * INCH, EQUIPMENT),
    'cue.tip_curvature_radius': PublishedRange(
        9.0e-3, 10.6e-3, 'curvatures of a dime and a nickel'
    ),
    'contacts.cue_ball.restitution': PublishedRange(
        0.71, 0.87, f'{PROPERTIES}: leather to phenolic'
    ),
    'contacts.cue_ball.duration': PublishedRange(
        0.8e-3, 3e-3, 'Alciatore: high-speed films, phenolic and fast to soft and slow'
    ),
    'contacts.ball_table.friction': PublishedRange(0.15, 0.4, PROPERTIES),
    'contacts.ball_ball.restitution': PublishedRange(0.92, 0.98, PROPERTIES),
    'cloth.sliding_friction': PublishedRange(0.15, 0.4, PROPERTIES),
    'cloth.rolling_resistance': PublishedRange(0.005, 0.015, PROPERTIES),
    'cloth.rolling_rise': PublishedRange(0.0, 0.0017, RECORDED),
    'cloth.spin_deceleration': PublishedRange(5.0, 15.0, PROPERTIES),
    'table.cushion.restitution': PublishedRange(0.6, 0.98, CUSHION_SOURCE),
    'table.cushion.friction': PublishedRange(
        0.14, 0.2, f'{CUSHION_SOURCE}; Han, J. Mech. Sci. Technol. 19 (2005)'
    ),
    'table.cushion.height': PublishedRange(0.625, 0.645, EQUIPMENT),
    'table.corner.mouth': PublishedRange(4.5 * INCH, 4.625 * INCH, EQUIPMENT),
    'table.corner.cut_deg': PublishedRange(141.0, 143.0, EQUIPMENT),
    'table.corner.shelf': PublishedRange(1.0 * INCH, 2.25 * INCH, EQUIPMENT),
    'table.side.mouth': PublishedRange(5.0 * INCH, 5.125 * INCH, EQUIPMENT),
    'table.side.cut_deg': PublishedRange(103.0, 105.0, EQUIPMENT),
    'table.side.shelf': PublishedRange(0.0, 0.375 * INCH, EQUIPMENT),
}


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
        for part in sections:
            place = place.setdefault(part, {})
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


PLAYER = 'robot', 'noise', 'model_error'

_SETTINGS = 'auto', 'on', 'off'


@dataclass(frozen=True, slots=True)
class Effects(CheckedRecord):
    """
    The setting of each effect: `auto` (simulated if the shot calls for it), `on` or `off`.

    Parameters
    ----------
    table_contact : str
        If `off`, the strike has no contact with the cloth; the ball is put onto it afterwards.
    tip_friction, table_friction : str
        If `off`, the contact with the tip, or with the cloth, has no friction in the strike.
    shaft : str
        If `off`, nothing holds the tip to the axis of the cue while it touches the ball, and it
        swings back at once when it leaves the ball.
    tip_spring : str
        If not `off`, a spring along the surface of the tip takes up the slip at the ball, as far
        as friction holds it. By default `off`; needs the effect `shaft` and law `bistiffness`.
    end_mass : str
        If `off`, the tip cannot move sideways, as if the cue were guided.
    tip_curvature : str
        If `off`, a rounded tip touches the ball where the axis of the cue does.
    flight : str
        If `off`, the ball is put back on the cloth after the strike and keeps its horizontal
        motion. If `on`, every flight is simulated, however low.
    bounce : str
        If `off`, the ball stays on the cloth where it first lands. If `on`, every hop is simulated
        until it is below rounding.
    slide : str
        If `off`, the ball rolls at once, as it would at the end of its slide.
    roll, spin_decay : str
        If `off`, nothing slows the roll, or the spin about the vertical; the ball may never rest.
    cushion, pocket : str
        If `cushion` is `off`, the cloth is endless. If `pocket` is `off`, the cushions continue
        across the pockets; if it is `on`, every pocket is checked, however far from a path.
    ball_ball : str
        If `off`, balls pass through each other. If `on`, every pair is checked, moving or not.
    throw : str
        If `off`, there is no friction between balls.
    cluster : str
        If `off`, touching bodies collide in pairs, one after the other.
    double_hit : str
        If `off`, the cue is gone after its first hit.

    """

    table_contact: str = choice(*_SETTINGS, default='auto')
    tip_friction: str = choice(*_SETTINGS, default='auto')
    table_friction: str = choice(*_SETTINGS, default='auto')
    shaft: str = choice(*_SETTINGS, default='auto')
    tip_spring: str = choice(*_SETTINGS, default='off')
    end_mass: str = choice(*_SETTINGS, default='auto')
    tip_curvature: str = choice(*_SETTINGS, default='auto')
    flight: str = choice(*_SETTINGS, default='auto')
    bounce: str = choice(*_SETTINGS, default='auto')
    slide: str = choice(*_SETTINGS, default='auto')
    roll: str = choice(*_SETTINGS, default='auto')
    spin_decay: str = choice(*_SETTINGS, default='auto')
    cushion: str = choice(*_SETTINGS, default='auto')
    pocket: str = choice(*_SETTINGS, default='auto')
    ball_ball: str = choice(*_SETTINGS, default='auto')
    throw: str = choice(*_SETTINGS, default='auto')
    cluster: str = choice(*_SETTINGS, default='auto')
    double_hit: str = choice(*_SETTINGS, default='auto')


def _end_of_a_guided_cue(scene: Any) -> Iterator[Mistake]:
    if scene.cue.guided and scene.effects.end_mass == 'on':
        yield Mistake(('effects', 'end_mass'), "must be auto or off for a guided cue, got 'on'")


def _exponents_of_a_ratio(scene: Any) -> Iterator[Mistake]:
    """Mistakes of contacts whose stiffnesses are a ratio, but not one of the same springs."""
    for name in ('cue_ball', 'ball_table'):
        contact = getattr(scene.contacts, name)
        other = (
            not isinstance(contact.exponent, DerivedNumber) and contact.exponent != scene.exponent
        )
        if other and contact.stiffness is not None:
            yield Mistake(
                ('contacts', name, 'exponent'),
                f'must be that of the scene, {scene.exponent:g}, unless a duration is given in '
                f'place of the stiffness, got {contact.exponent!r}',
            )


@dataclass(frozen=True, slots=True)
class Scene(Shown):
    """
    All input of a prediction except the stroke.

    Parameters
    ----------
    ball, cue, contacts, cloth, effects : Ball, Cue, Contacts, Cloth, Effects
    law : str
        Restitution law: `bistiffness`, `energetic` (that of the paper) or `poisson`.
    exponent : float
        Exponent of the force of the contact springs, 1 to 10: 1 is linear, 1.5 is Hertz's. With
        larger exponents impacts take many steps, and forces overflow. The contacts cue_ball and
        ball_table may have their own.
    balls : mapping of str to (x, y)
        Positions of the balls on the table [m]. The cue ball is `cue`; it is at the origin if it
        has no position.
    table : Table, optional
        Cushions and pockets; without a table, the cloth is endless.
    robot, noise : Robot, Noise
        The player, for the planner: limits of its strokes, and its execution noise.
    model_error : ModelError
        How far the scene itself errs: none unless a calibration or you state it.
    rack : Rack, optional
        Adds the balls of a game to `balls`.

    Raises
    ------
    ValueError
        Naming every invalid field, its value and the allowed range.

    """

    RULES: ClassVar = (
        placement.overlapping_balls,
        placement.balls_off_the_table,
        placement.rack_in_the_way,
        hasty_cushion,
        _end_of_a_guided_cue,
        _exponents_of_a_ratio,
    )
    ball: Ball = section(Ball)
    cue: Cue = section(Cue)
    contacts: Contacts = section(Contacts)
    law: str = choice('bistiffness', 'energetic', 'poisson', default='bistiffness')
    exponent: float = number('', minimum=1, maximum=10, default=1.0)
    cloth: Cloth = section(Cloth, optional=True)
    balls: Mapping[str, tuple[float, float]] = places()
    effects: Effects = section(Effects, optional=True)
    table: Table | None = section(Table, nullable=True)
    robot: Robot = section(Robot, optional=True)
    noise: Noise = section(Noise, optional=True, named=NOISES)
    model_error: ModelError = section(ModelError, optional=True)
    rack: InitVar[placement.Rack | None] = section(placement.Rack, nullable=True)

    def __post_init__(self, rack: placement.Rack | None) -> None:
        check(self, rack=rack)
        if rack and self.table:
            balls = {**self.balls, **placement.racked(rack, self.table, self.ball.radius)}
            object.__setattr__(self, 'balls', balls)
        if isinstance(self.cloth.sliding_friction, DerivedNumber):
            cloth = fill_in(self.cloth, sliding_friction=self.contacts.ball_table.friction)
            object.__setattr__(self, 'cloth', cloth)
        own = {
            name: fill_in(contact, exponent=self.exponent)
            for name in ('cue_ball', 'ball_table')
            if isinstance((contact := getattr(self.contacts, name)).exponent, DerivedNumber)
        }
        object.__setattr__(self, 'contacts', replace(self.contacts, **own))

    def __repr__(self) -> str:
        balls = len({placement.CUE_BALL, *self.balls})
        table = self.table
        cloth = f'a table of {table.length:g} x {table.width:g} m' if table else 'an endless cloth'
        return f'Scene({balls} ball{"s" * (balls > 1)} on {cloth}, law {self.law})'

    @property
    def planned_noise(self) -> Noise:
        """The errors that plans reckon with: those of the player and of the scene."""
        return self.noise.beside(self.model_error)

    @property
    def object_balls(self) -> dict[str, tuple[float, float]]:
        """Places of all balls but the cue ball [m]."""
        return {name: place for name, place in self.balls.items() if name != placement.CUE_BALL}

    @classmethod
    def names(cls) -> list[str]:
        """Names of the bundled scenes, in alphabetical order."""
        return scene_names()

    @classmethod
    def load(cls, name_or_path: 'Scene | str | Path') -> Self:
        """
        Read a scene from YAML.

        Its key `like` names another scene, which supplies all that the file does not give.

        Parameters
        ----------
        name_or_path : str, Path or Scene
            The name of a bundled scene, such as 'paper', or a file: a Path, or a string with a
            folder or the ending .yaml or .yml. A scene is returned as it is.

        Raises
        ------
        ValueError
            If there is no such scene, or if it has mistakes, listing all of them with their lines.

        """
        if isinstance(name_or_path, cls):
            return name_or_path
        if not isinstance(name_or_path, str | Path):
            allowed = f'a Scene, a path, or one of {", ".join(scene_names())}'
            raise refused(name_or_path, allowed, 'scene')
        path = find_scene(name_or_path)
        document = read_document(path)
        return cls._read(document, f'scene {path}', path.parent)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Make a scene from the content of a YAML file; ValueError lists all mistakes."""
        return cls._read(Document(data, None, []), 'scene', Path())

    @classmethod
    def _read(cls, document: Document, about: str, folder: Path) -> Self:
        mistakes = list(document.mistakes)
        twice = {mistake.path for mistake in mistakes}
        try:
            scene = read(cls, resolved(document.data, folder))
        except InputError as error:
            # The reader of the file has already reported duplicate keys, with their lines.
            mistakes += (
                mistake
                for mistake in error.mistakes
                if mistake.text != TWICE or mistake.path not in twice
            )
        if mistakes:
            raise InputError(mistakes, about, document.lines) from None
        return scene

    def to_dict(self, *, derived: bool = False) -> dict[str, Any]:
        """Plain dict that `from_dict` turns into an equal scene; `derived` adds derived values."""
        return write(self, derived=derived)

    def parameters(self, names: Sequence[str] | None = None) -> tuple[Parameter, ...]:
        """
        List numbers of the scene with their units, bounds and published ranges.

        Parameters
        ----------
        names : sequence of str, optional
            Keys joined by points, such as `table.cushion.restitution`; by default all numbers of
            ball, cue, contacts, cloth and table.

        Raises
        ------
        ValueError
            If a name is unknown.

        """
        return parameters_of(self, names)

    def with_parameters(self, names: Sequence[str], values: ArrayLike) -> Self:
        """
        Copy the scene with other numbers; values that follow from them are derived again.

        Parameters
        ----------
        names : sequence of str
            As of `parameters`.
        values : (names,) array_like

        Raises
        ------
        ValueError
            Naming each name that is unknown, and each value that is not allowed.

        """
        scene: Self = with_parameters(self, names, values)
        return scene

    @property
    def cue_ball(self) -> tuple[float, float, float]:
        """Centre of the cue ball before the strike [m]."""
        x, y = self.balls.get(placement.CUE_BALL, (0.0, 0.0))
        return x, y, self.ball.radius


SceneLike: TypeAlias = Scene | str | Path
"""A scene, the name of a bundled one, or the path of a file."""
