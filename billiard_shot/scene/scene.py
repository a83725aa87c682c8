"""The scene: all input of a prediction except the stroke."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, InitVar, replace
from pathlib import Path
from typing import Any, ClassVar, Self, TypeAlias

from numpy.typing import ArrayLike

from billiard_shot.notebook import Shown
from billiard_shot.scene.bundled import find_scene, scene_names
from billiard_shot.scene.checks import check, fill_in, read, write
from billiard_shot.scene.effects import Effects
from billiard_shot.scene.equipment import Ball, Cloth, Contacts, Cue
from billiard_shot.scene.errors import InputError, Mistake, refused, TWICE
from billiard_shot.scene.fields import choice, Derived, number, places, section
from billiard_shot.scene.inheritance import resolved
from billiard_shot.scene.parameters import Parameter, parameters_of, with_parameters
from billiard_shot.scene.placement import balls_off_the_table, CUE_BALL, overlapping_balls
from billiard_shot.scene.player import Noise, Robot
from billiard_shot.scene.rack import Rack, rack_in_the_way, racked
from billiard_shot.scene.table import hasty_cushion, Table
from billiard_shot.scene.yaml_file import Document, read_document


def _end_of_a_guided_cue(scene: Any) -> Iterator[Mistake]:
    if scene.cue.guided and scene.effects.end_mass == 'on':
        yield Mistake(('effects', 'end_mass'), "must be auto or off for a guided cue, got 'on'")


def _exponents_of_a_ratio(scene: Any) -> Iterator[Mistake]:
    """Mistakes of contacts whose stiffnesses are a ratio, but not one of the same springs."""
    for name in ('cue_ball', 'ball_table'):
        contact = getattr(scene.contacts, name)
        other = not isinstance(contact.exponent, Derived) and contact.exponent != scene.exponent
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
    rack : Rack, optional
        Adds the balls of a game to `balls`.

    Raises
    ------
    ValueError
        Naming every invalid field, its value and the allowed range.

    """

    RULES: ClassVar = (
        overlapping_balls,
        balls_off_the_table,
        rack_in_the_way,
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
    noise: Noise = section(Noise, optional=True)
    rack: InitVar[Rack | None] = section(Rack, nullable=True)

    def __post_init__(self, rack: Rack | None) -> None:
        check(self, rack=rack)
        if rack and self.table:
            balls = {**self.balls, **racked(rack, self.table, self.ball.radius)}
            object.__setattr__(self, 'balls', balls)
        if isinstance(self.cloth.sliding_friction, Derived):
            cloth = fill_in(self.cloth, sliding_friction=self.contacts.ball_table.friction)
            object.__setattr__(self, 'cloth', cloth)
        own = {
            name: fill_in(contact, exponent=self.exponent)
            for name in ('cue_ball', 'ball_table')
            if isinstance((contact := getattr(self.contacts, name)).exponent, Derived)
        }
        object.__setattr__(self, 'contacts', replace(self.contacts, **own))

    def __repr__(self) -> str:
        balls = len({CUE_BALL, *self.balls})
        table = self.table
        cloth = f'a table of {table.length:g} x {table.width:g} m' if table else 'an endless cloth'
        return f'Scene({balls} ball{"s" * (balls > 1)} on {cloth}, law {self.law})'

    @property
    def object_balls(self) -> dict[str, tuple[float, float]]:
        """Places of all balls but the cue ball [m]."""
        return {name: place for name, place in self.balls.items() if name != CUE_BALL}

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
        x, y = self.balls.get(CUE_BALL, (0.0, 0.0))
        return x, y, self.ball.radius


SceneLike: TypeAlias = Scene | str | Path
"""A scene, the name of a bundled one, or the path of a file."""
