"""The scene: all that a prediction has to know, except the stroke."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, InitVar
from pathlib import Path
from typing import Any, ClassVar, Self

from billiard_shot.scene.bundled import find_scene
from billiard_shot.scene.checks import check, fill_in, read, write
from billiard_shot.scene.effects import Effects
from billiard_shot.scene.equipment import Ball, Cloth, Contacts, Cue
from billiard_shot.scene.fields import choice, Derived, number, places, section
from billiard_shot.scene.furniture import Table
from billiard_shot.scene.likeness import resolved
from billiard_shot.scene.mistakes import InputError, Mistake, TWICE
from billiard_shot.scene.placing import balls_off_the_table, CUE_BALL, overlapping_balls
from billiard_shot.scene.player import Noise, Robot
from billiard_shot.scene.rack import Rack, rack_in_the_way, racked
from billiard_shot.scene.yaml_file import Document, read_document


def _end_of_a_guided_cue(scene: Any) -> Iterator[Mistake]:
    if scene.cue.guided and scene.effects.end_mass == 'on':
        yield Mistake(('effects', 'end_mass'), "'on' is not allowed; a guided cue has none")


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
    robot, noise : Robot, Noise
        Who plays, for the planner: limits of strokes, and how much they differ from the plan.
    rack : Rack, optional
        Puts the balls of a game onto the table, in addition to `balls`, where they stay.

    Raises
    ------
    ValueError
        Naming every wrong field, its value and what is allowed.

    """

    RULES: ClassVar = (
        overlapping_balls,
        balls_off_the_table,
        rack_in_the_way,
        _end_of_a_guided_cue,
    )
    ball: Ball = section(Ball)
    cue: Cue = section(Cue)
    contacts: Contacts = section(Contacts)
    law: str = choice('bistiffness', 'energetic', 'poisson', default='bistiffness')
    exponent: float = number('', least=1, default=1.0)
    cloth: Cloth = section(Cloth, optional=True)
    balls: Mapping[str, tuple[float, float]] = places()
    effects: Effects = section(Effects, optional=True)
    table: Table | None = section(Table, absent=True)
    robot: Robot = section(Robot, optional=True)
    noise: Noise = section(Noise, optional=True)
    rack: InitVar[Rack | None] = section(Rack, absent=True)

    def __post_init__(self, rack: Rack | None) -> None:
        check(self, rack=rack)
        if rack and self.table:
            balls = {**self.balls, **racked(rack, self.table, self.ball.radius)}
            object.__setattr__(self, 'balls', balls)
        if isinstance(self.cloth.sliding_friction, Derived):
            cloth = fill_in(self.cloth, sliding_friction=self.contacts.ball_table.friction)
            object.__setattr__(self, 'cloth', cloth)

    @classmethod
    def load(cls, name_or_path: str | Path) -> Self:
        """
        Read a scene from YAML.

        `like` in it names another scene from which it takes what it does not say itself.

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
        path = find_scene(name_or_path)
        document = read_document(path)
        return cls._read(document, f'scene {path}', path.parent)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Make a scene of what its YAML file would hold; ValueError lists all mistakes."""
        return cls._read(Document(data, None, []), 'scene', Path())

    @classmethod
    def _read(cls, document: Document, about: str, folder: Path) -> Self:
        mistakes = list(document.mistakes)
        twice = {mistake.path for mistake in mistakes}
        try:
            scene = read(cls, resolved(document.data, folder))
        except InputError as error:
            # The file's reader has said more about a key that is there twice.
            mistakes += (
                mistake
                for mistake in error.mistakes
                if mistake.text != TWICE or mistake.path not in twice
            )
        if mistakes:
            raise InputError(mistakes, about, document.lines) from None
        return scene

    def to_dict(self, *, derived: bool = False) -> dict[str, Any]:
        """Plain dict from which `from_dict` makes an equal scene; `derived`: all of it."""
        return write(self, derived=derived)

    @property
    def cue_ball(self) -> tuple[float, float, float]:
        """Centre of the cue ball before the strike [m]."""
        x, y = self.balls.get(CUE_BALL, (0.0, 0.0))
        return x, y, self.ball.radius
