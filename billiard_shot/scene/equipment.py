"""Ball, cue, contacts and cloth, with the units, ranges and sources of their numbers."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterator
from dataclasses import dataclass
import math
from typing import Any, ClassVar

from billiard_shot.scene.checks import check
from billiard_shot.scene.errors import Mistake
from billiard_shot.scene.fields import boolean, number, section
from billiard_shot.scene.table import BallBall

# Squirt of a common shaft, 1.9 degrees at half a radius off centre (a = 0.5), after Alciatore
# (technical proof TP A.31, billiards.colostate.edu): tan = 2.5 a s / (1 + 30 + 2.5 s^2) with
# s^2 = 1 - a^2, for a ball 30 times as heavy as the cue's end. His tip and ball part without
# sideways rebound, as ours do at restitution 0. Rebound along the normal adds 20 to 40 percent;
# this lighter end makes up for it: scene `pool` is within 8 percent of his for a = 0.1 to 0.5.
END_MASS = 0.0042
# Of a maple shaft, 11 GPa and 13 mm thick, that a bridge holds 0.25 m behind the tip: 3 E I / L^3.
END_STIFFNESS = 3e3
CUE_LENGTH = 1.47
# Instructors ask for at least 4 in past the ball (0.1 m, cuemaster-poolschool.com).
FOLLOW_THROUGH = 0.15
FERRULE_RADIUS = 0.0065  # a pool cue's ferrule is 13 mm wide
STANDARD_GRAVITY = 9.80665  # CGPM 1901


def _inertia_of_a_ball(ball: Any) -> Iterator[Mistake]:
    hollow = 2 / 3 * ball.mass * ball.radius**2
    if ball.inertia > hollow * (1 + 1e-9):
        yield Mistake(
            ('inertia',),
            (f'must be at most 2/3 m r^2 = {hollow:.3g}, got {ball.inertia!r} (kg m^2)'),
        )


@dataclass(frozen=True, slots=True)
class Ball:
    """
    A ball.

    Parameters
    ----------
    mass : float
        [kg], above 0 and at most 2.
    radius : float
        [m], above 0 and at most 0.5.
    inertia : float, optional
        Moment of inertia about any axis through the centre [kg m^2], above 0 and at most that of a
        hollow ball, 2/3 m r^2; by default that of a solid ball, 2/5 m r^2.

    """

    RULES: ClassVar = (_inertia_of_a_ball,)
    mass: float = number('kg', above=0, maximum=2)
    radius: float = number('m', above=0, maximum=0.5)
    inertia: float = number(
        'kg m^2', above=0, derived=lambda ball: 0.4 * ball.mass * ball.radius**2
    )

    def __post_init__(self) -> None:
        check(self)


def _end_of_a_cue(cue: Any) -> Iterator[Mistake]:
    if cue.guided and cue.end_mass != math.inf:
        yield Mistake(
            ('end_mass',),
            f'must be omitted for a guided cue, got {cue.end_mass!r} (kg)',
        )
    if not cue.guided and cue.end_mass > cue.mass:
        yield Mistake(
            ('end_mass',),
            (f'must be at most the mass of the cue, {cue.mass:g}, got {cue.end_mass!r} (kg)'),
        )


@dataclass(frozen=True, slots=True)
class Cue:
    """
    A cue that moves along its axis.

    Parameters
    ----------
    mass : float
        [kg], above 0 and at most 100.
    guided : bool
        True if bearings hold the cue, so that its tip cannot move sideways (the mechanical cue of
        the paper).
    end_mass : float, optional
        Effective mass of the tip for sideways motion [kg], above 0 and at most the mass of the
        cue; by default 4.2 g, see `END_MASS`. A guided cue must not have one: it is infinite.
    end_stiffness : float, optional
        Force of the shaft that pulls the tip back to the axis of the cue, per distance from there
        [N/m], 0 to 1e5. By default 3 kN/m, see `END_STIFFNESS`; 0 for a guided cue.
    ferrule_radius : float, optional
        Half the width of the cue right behind its tip [m], 0 to 1. By default 6.5 mm; 0 for a
        guided cue, whose shape is unknown.
    length : float, optional
        Length of the cue [m], 0 to 20; balls and cushions can be in its way. By default 1.47 m (58
        in, the usual length); 0 for a guided cue, whose shape is unknown.
    tip_curvature_radius : float
        Radius of the spherical surface of a rounded tip [m], 0 to 1. A stroke that is given by
        the axis of the cue then meets the ball nearer to its centre. By default 0: the tip is a
        point on the axis. Common tips have the curvature of a dime, 9 mm, or a nickel, 10.6 mm.
    follow_through : float
        Distance that the cue goes on after the strike [m], above 0 and at most 20; it may hit the
        ball again. By default 0.15 m, see `FOLLOW_THROUGH`. A cue that is slower than 0.8 m/s
        goes less far, by the square of its speed.

    """

    RULES: ClassVar = (_end_of_a_cue,)
    mass: float = number('kg', above=0, maximum=100)
    guided: bool = boolean(default=False)
    end_mass: float = number(
        'kg', above=0, derived=lambda cue: math.inf if cue.guided else min(END_MASS, cue.mass)
    )
    end_stiffness: float = number(
        'N/m', minimum=0, maximum=1e5, derived=lambda cue: 0.0 if cue.guided else END_STIFFNESS
    )
    ferrule_radius: float = number(
        'm', minimum=0, maximum=1, derived=lambda cue: 0.0 if cue.guided else FERRULE_RADIUS
    )
    length: float = number(
        'm', minimum=0, maximum=20, derived=lambda cue: 0.0 if cue.guided else CUE_LENGTH
    )
    tip_curvature_radius: float = number('m', minimum=0, maximum=1, default=0.0)
    follow_through: float = number('m', above=0, maximum=20, default=FOLLOW_THROUGH)

    def __post_init__(self) -> None:
        check(self)


def _stiffness_or_duration(contact: Any) -> Iterator[Mistake]:
    stiffness, duration = contact.stiffness, contact.duration
    if stiffness is None and duration is None:
        yield Mistake(('duration',), 'is missing, and so is stiffness; one of them must be given')
    if stiffness is not None and duration is not None:
        yield Mistake(
            ('stiffness',), f'must be omitted, because duration is given, got {stiffness!r}'
        )


@dataclass(frozen=True, slots=True)
class ContactParameters:
    """
    Parameters of the contact of tip and ball, or of ball and cloth.

    Parameters
    ----------
    restitution : float
        Coefficient of restitution, 0 to 1.
    friction : float
        Coefficient of Coulomb friction, at least 0.
    stiffness : float, optional
        Stiffness of the virtual spring, above 0; only ratios of stiffnesses matter. The contact
        has either a stiffness or a duration.
    duration : float, optional
        Time from touch to parting at 2 m/s [s], above 0 and at most 20 ms: of a central hit by the
        cue of the scene, or of a ball that falls onto the cloth. The restitution e is part of it:
        with a linear spring of stiffness k it is (1 + e) / 2 pi sqrt(m / k), for the mass m of the
        ball on the cloth, and for 1 / (1 / m + 1 / M) if a cue of mass M hits it. That is its time
        under law `bistiffness`; the other laws take the same spring, which then lasts otherwise.
    exponent : float, optional
        Exponent of the spring, 1 to 10. By default that of the `Scene`, which fills it in. Another
        one needs a duration.

    """

    RULES: ClassVar = (_stiffness_or_duration,)
    restitution: float = number('', minimum=0, maximum=1)
    friction: float = number('', minimum=0)
    stiffness: float | None = number('any unit', above=0, nullable=True)
    duration: float | None = number('s', above=0, maximum=0.02, nullable=True)
    exponent: float = number('', minimum=1, maximum=10, derived=lambda _: 1.0)

    def __post_init__(self) -> None:
        check(self)


def _stated_alike(contacts: Any) -> Iterator[Mistake]:
    """
    Mistakes of a tip and a cloth of which one has a stiffness, and the other one a duration.

    A stiffness means nothing without that of the other contact.
    """
    tip, cloth = contacts.cue_ball, contacts.ball_table
    for key, other in (('stiffness', 'duration'), ('duration', 'stiffness')):
        values = [getattr(contact, each) for contact in (tip, cloth) for each in (key, other)]
        if [value is not None for value in values] == [True, False, False, True]:
            yield Mistake(
                ('ball_table', key),
                f'is missing: cue_ball has a {key}, so that ball_table must have one in place of '
                f'its {other}, {values[-1]!r}',
            )


@dataclass(frozen=True, slots=True)
class Contacts:
    """The contacts: tip and ball, ball and table (its cloth), ball and ball."""

    RULES: ClassVar = (_stated_alike,)
    cue_ball: ContactParameters = section(ContactParameters)
    ball_table: ContactParameters = section(ContactParameters)
    ball_ball: BallBall = section(BallBall, optional=True)

    def __post_init__(self) -> None:
        check(self)


def _rise_from_nothing(cloth: Any) -> Iterator[Mistake]:
    if cloth.rolling_rise > 0.0 and cloth.rolling_resistance == 0.0:
        yield Mistake(
            ('rolling_rise',),
            f'must be 0 without rolling_resistance, got {cloth.rolling_rise!r} (s/m)',
        )


@dataclass(frozen=True, slots=True)
class Cloth:
    """
    The cloth, which slows a ball down between impacts.

    Parameters
    ----------
    sliding_friction : float, optional
        Coefficient of friction of a sliding ball, at least 0. By default the friction of the
        contact ball_table, which the `Scene` fills in (infinite before).
    rolling_resistance : float
        Deceleration of a rolling ball in units of gravity, 0 to 1. 0.01: Alciatore, physical
        properties of pool equipment (billiards.colostate.edu), who gives 0.005 to 0.015.
    rolling_rise : float
        Rise of that deceleration with speed: at the speed v [m/s] it is rolling_resistance +
        rolling_rise v; 0 to 1 [s/m], and 0 without rolling resistance. 0.0014 +- 0.0002: see scene
        `carom`.
    spin_deceleration : float
        Deceleration of the spin about the vertical [rad/s^2], at least 0. 10: the same source, 5
        to 15.
    gravity : float
        [m/s^2], above 0 and at most 100.

    """

    RULES: ClassVar = (_rise_from_nothing,)
    sliding_friction: float = number('', minimum=0, derived=lambda _: math.inf)
    rolling_resistance: float = number('', minimum=0, maximum=1, default=0.01)
    rolling_rise: float = number('s/m', minimum=0, maximum=1, default=0.0)
    spin_deceleration: float = number('rad/s^2', minimum=0, default=10.0)
    gravity: float = number('m/s^2', above=0, maximum=100, default=STANDARD_GRAVITY)

    def __post_init__(self) -> None:
        check(self)
