"""The scene: all that a prediction has to know, except the stroke."""
# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from billiard_shot.scene.bundled import scene_path
from billiard_shot.scene.checks import check, fill_in, read, write
from billiard_shot.scene.effects import Effects
from billiard_shot.scene.equipment import Ball, Cloth, Contacts, Cue
from billiard_shot.scene.fields import choice, Derived, number, places, section
from billiard_shot.scene.furniture import Table
from billiard_shot.scene.mistakes import InputError, Lines, Mistake, TWICE
from billiard_shot.scene.placing import balls_off_the_table, CUE_BALL, overlapping_balls
from billiard_shot.scene.yaml_file import read_document


@dataclass(frozen=True, slots=True)
class Scene:
    """
    Everything a prediction has to know, except the stroke.

    Parameters
    ----------
    ball, cue, contacts, cloth, effects : Ball, Cue, Contacts, Cloth, Effects
    law : str
        Of restitution: `bistiffness`, `energetic` (the paper's) or `poisson`.
    exponent : float
        Of the contact springs' force: 1, or 1.5 after Hertz; at least 1.
    balls : mapping of str to (x, y)
        Where balls lie on the table [m]; the cue ball is `cue`, at the origin if not placed.
    table : Table, optional
        Cushions and pockets; without, the cloth is endless.

    Raises
    ------
    ValueError
        Naming every wrong field, its value and what is allowed.

    """

    RULES: ClassVar = (overlapping_balls, balls_off_the_table)
    ball: Ball = section(Ball)
    cue: Cue = section(Cue)
    contacts: Contacts = section(Contacts)
    law: str = choice('bistiffness', 'energetic', 'poisson', default='bistiffness')
    exponent: float = number('', least=1, default=1.0)
    cloth: Cloth = section(Cloth, optional=True)
    balls: Mapping[str, tuple[float, float]] = places()
    effects: Effects = section(Effects, optional=True)
    table: Table | None = section(Table, absent=True)

    def __post_init__(self) -> None:
        check(self)
        if isinstance(self.cloth.sliding_friction, Derived):
            cloth = fill_in(self.cloth, sliding_friction=self.contacts.ball_table.friction)
            object.__setattr__(self, 'cloth', cloth)

    @classmethod
    def load(cls, name_or_path: str | Path) -> Self:
        """
        Read a scene from YAML.

        Parameters
        ----------
        name_or_path : str or Path
            The name of a bundled scene, such as 'paper', or a file: a Path, or text with a folder
            or the ending .yaml or .yml in it.

        Raises
        ------
        ValueError
            If there is no such scene; or for all mistakes in it together, each with its line.

        """
        text = str(name_or_path)
        is_file = isinstance(name_or_path, Path) or Path(text).suffix in ('.yaml', '.yml')
        path = Path(text) if is_file or Path(text).name != text else scene_path(text)
        document = read_document(path)
        return cls._read(document.data, document.mistakes, f'scene {path}', document.lines)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Make a scene of what its YAML file would hold; ValueError lists all mistakes."""
        return cls._read(data, [], 'scene', None)

    @classmethod
    def _read(
        cls, data: object, known: list[Mistake], about: str, lines: Lines | None
    ) -> Self:
        """Read a scene in which some mistakes are known already."""
        twice = {mistake.path for mistake in known}
        try:
            scene = read(cls, data)
        except InputError as error:
            # The file's reader says more about a key that is there twice.
            known = [*known, *(mistake for mistake in error.mistakes
                               if mistake.text != TWICE or mistake.path not in twice)]
        if known:
            raise InputError(known, about, lines) from None
        return scene

    def to_dict(self, *, derived: bool = False) -> dict[str, Any]:
        """Plain dict from which `from_dict` makes an equal scene; `derived`: all of it."""
        return write(self, derived=derived)

    @property
    def cue_ball(self) -> tuple[float, float, float]:
        """Centre of the cue ball before the strike [m]."""
        x, y = self.balls.get(CUE_BALL, (0.0, 0.0))
        return x, y, self.ball.radius
