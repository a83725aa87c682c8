"""Ball, cue, contacts, cloth and table, with the units, ranges and sources of their numbers."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)

from collections.abc import Iterator
from dataclasses import dataclass
import math
from typing import Any, ClassVar

from billiard_shot.scene.errors import Mistake
from billiard_shot.scene.fields import boolean, CheckedRecord, choice, number, section

# Restitution, friction and fading of the cushion models: Mathavan, Jackson and Parkin (Proc.
# IMechE C 224, 2010), measured for snooker cushions up to 2.5 m/s, with a fading that fits their
# measurements up to 3.5 m/s (Am. J. Phys. 77, 2009); Han (J. Mech. Sci. Technol. 19, 2005), who
# neglects the cloth, with van Balen's restitution and friction from Alciatore's range; Stronge
# (Impact Mechanics, 2nd ed., 2018) with the same, and a frequency ratio of elastic bodies. Scenes
# of pool use them too, because the values published for pool are not conclusive
# (docs/measured.md).
CUSHIONS = {
    'mathavan': (0.98, 0.14, 0.11, 0.0),
    'han': (0.85, 0.2, 0.0, 0.0),
    'stronge': (0.85, 0.2, 0.0, 1.7),
}


@dataclass(frozen=True, slots=True)
class BallBall(CheckedRecord):
    """
    The contact between two balls.

    Parameters
    ----------
    restitution : float
        0 to 1. 0.95: middle of the 0.92 to 0.98 that Alciatore gives (physical properties of pool
        equipment, billiards.colostate.edu).
    friction_fast, friction_slow, friction_decay : float
        The coefficient of friction at slip v is friction_fast + friction_slow exp(-friction_decay
        v). All are at least 0; friction_decay is in s/m. By default Alciatore's fit to Marlow's
        measurements (technical proof TP A.14). With friction_slow 0 the coefficient is constant.
    stiffness : float
        Stiffness of the virtual spring, above 0, in the units of the other contacts; of those with
        a duration, the tip has the stiffness 1.5. It matters only if more than two bodies collide
        and `duration` is 0 or the law is not `bistiffness`. 25: the duration of a contact is
        proportional to the root of mass over stiffness; it is 0.25 ms for two balls and 1.3 ms for
        the tip (high-speed films, Alciatore).
    duration : float
        Duration of the contact of two balls that meet at 3 m/s [s], at least 0 and at most 10 ms,
        as if their restitution were 1. At other speeds it follows from the exponent. While balls
        are in contact the impact is passed on to balls at small distances. 0: contacts take no
        time. 0.25 ms: high-speed films (Alciatore).
    gap : float
        Largest distance of balls that count as touching when one of them is hit (and of a ball and
        a cushion when it is struck) [m], at least 0 and at most 1 mm; if contacts take no time,
        bodies farther apart collide one after the other. 0.1 um includes balls that were placed in
        contact. Values below 10 nm count as 10 nm: bodies pressed together may overlap by that.

    """

    restitution: float = number('', minimum=0, maximum=1, default=0.95)
    friction_fast: float = number('', minimum=0, default=0.00995)
    friction_slow: float = number('', minimum=0, default=0.108)
    friction_decay: float = number('s/m', minimum=0, default=1.088)
    stiffness: float = number('any unit', above=0, default=25.0)
    duration: float = number('s', minimum=0, maximum=0.01, default=0.25e-3)
    gap: float = number('m', minimum=0, maximum=1e-3, default=1e-7)


@dataclass(frozen=True, slots=True)
class Cushion(CheckedRecord):
    """
    The cushions of a table.

    Parameters
    ----------
    model : str
        `mathavan`: ball, cushion and cloth, with friction at both contacts and work-energy
        restitution (Mathavan 2010), and its continuation to balls that hop. It is the default
        because it was measured, up to 2.5 m/s, and because it includes the cloth, as the strike
        does. `han`: ball and cushion alone, in closed form (Han 2005), for balls on the cloth;
        those in the air meet the default model. `stronge`: the same two, with a spring along the
        surface of the nose, see `frequency_ratio`.
    restitution : float, optional
        0.05 to 1; by default that of the model, see `CUSHIONS`.
    friction : float, optional
        At least 0; by default that of the model.
    early_fading, fading : float, optional
        At a speed of approach v the restitution is divided by 1 + early_fading v + (fading v)^2;
        at least 0 [s/m]. The first one is 0 by default, `fading` that of the model.
    height : float
        Height of the nose above the cloth, in ball diameters, 0.5 to 0.95. 0.635: WPA.
    depth : float
        Depth of the cushions from the nose outwards [m], above 0 and at most 1; the facings of
        pockets are as long. 2 in: WPA.
    duration : float
        Duration of the contact of a ball that meets the cushion straight at 3 m/s [s], as if its
        restitution were 1; at most 20 ms, at least ten times that of two balls. Meanwhile the ball
        moves along the cushion, and if it hops it may land. 0: contacts take no time. 5 ms: we
        found no measurement; 2 to 10 ms are plausible.
    stiffness : float
        Stiffness of the virtual spring, above 0, in the units of the other contacts; it matters
        only if the struck ball touches a cushion. 0.1: a contact of 5 ms, as for
        `BallBall.stiffness`.
    frequency_ratio : float
        Frequency of the ball on the spring along the surface of the nose, relative to that on the
        normal spring: the root of (1 + m r^2 / I) times the ratio of stiffnesses; at most 3. 0,
        the default of `mathavan`: the nose has no such spring, and is rigid along its surface.
        Stronge (Impact Mechanics, 2nd ed., 2018, chapter 5) has 1.5 to 1.7, the default of
        `stronge`, for elastic bodies, whose ratio of stiffnesses is (2 - 2 nu) / (2 - nu) at
        Poisson's ratio nu. It does not matter if the struck ball touches a cushion, or if a ball
        on the cloth meets a cushion of model `han`.

    """

    model: str = choice(*CUSHIONS, default='mathavan')
    restitution: float = number(
        '', minimum=0.05, maximum=1, derived=lambda cushion: CUSHIONS[cushion.model][0]
    )
    friction: float = number('', minimum=0, derived=lambda cushion: CUSHIONS[cushion.model][1])
    early_fading: float = number('s/m', minimum=0, default=0.0)
    fading: float = number('s/m', minimum=0, derived=lambda cushion: CUSHIONS[cushion.model][2])
    height: float = number('ball diameters', minimum=0.5, maximum=0.95, default=0.635)
    depth: float = number('m', above=0, maximum=1, default=0.0508)
    duration: float = number('s', minimum=0, maximum=0.02, default=5e-3)
    stiffness: float = number('any unit', above=0, default=0.1)
    frequency_ratio: float = number(
        '', minimum=0, maximum=3, derived=lambda cushion: CUSHIONS[cushion.model][3]
    )


class Pocket(CheckedRecord):
    """
    Parameters of corner and side pockets.

    Parameters
    ----------
    mouth : float
        Distance between the two points where the lines of noses and facings meet [m], above 0 and
        at most 1.
    cut_deg : float
        Angle between a nose and the adjacent facing [degrees], above 90 and below 180.
    jaw_radius : float
        Radius of the rounded corner between the two [m], above 0 and at most 1.
    shelf : float
        From the middle of the mouth to the edge of the hole [m], 0 to 1.
    radius : float
        Radius of the hole [m], above 0 and at most 1. A ball falls when its centre is beyond the
        edge.

    """

    __slots__ = ()
    mouth: float
    cut_deg: float
    jaw_radius: float
    shelf: float
    radius: float


@dataclass(frozen=True, slots=True)
class CornerPocket(Pocket):
    """Pocket in a corner: WPA sizes; radii of jaw and hole as on common tables. See `Pocket`."""

    mouth: float = number('m', above=0, maximum=1, default=0.116)  # 4.5 to 4.625 in
    cut_deg: float = number('degrees', above=90, maximum=179, default=142.0)
    jaw_radius: float = number('m', above=0, maximum=1, default=0.021)
    shelf: float = number('m', minimum=0, maximum=1, default=0.038)  # 1 to 2.25 in
    radius: float = number('m', above=0, maximum=1, default=0.062)


@dataclass(frozen=True, slots=True)
class SidePocket(Pocket):
    """Pocket in the middle of a long side: as `CornerPocket`."""

    mouth: float = number('m', above=0, maximum=1, default=0.129)  # 5 to 5.125 in
    cut_deg: float = number('degrees', above=90, maximum=179, default=104.0)
    jaw_radius: float = number('m', above=0, maximum=1, default=0.008)
    shelf: float = number('m', minimum=0, maximum=1, default=0.005)  # 0 to 0.375 in
    radius: float = number('m', above=0, maximum=1, default=0.0645)


def _too_small_for_pockets(table: Any) -> Iterator[Mistake]:
    """Mistakes of tables without a straight cushion between two pockets."""
    if table.pockets:
        corner = table.corner.mouth * math.sqrt(0.5) + _rounding(table.corner)
        side = 0.5 * table.side.mouth + _rounding(table.side)
        for name, needed in (('length', 2.0 * (corner + side)), ('width', 2.0 * corner)):
            if getattr(table, name) <= needed:
                yield Mistake(
                    (name,),
                    (
                        f'must be above {needed:.4g} with these pockets, got '
                        f'{getattr(table, name)!r} (m)'
                    ),
                )


def is_instant_beside(short: float, long: float) -> bool:
    """
    Whether a contact is so short that it acts within a longer one as if it took no time.

    A contact of a tenth of the duration does. If a ball hits a ball that touches a cushion
    (restitution 0.95 and 0.8), the speeds then err by 0.002 of the first one. At a quarter of the
    duration they err by 0.014, at equal durations by a third.

    Parameters
    ----------
    short, long : float
        Durations of the contacts [s].

    """
    return 10.0 * short <= long


def hasty_cushion(scene: Any) -> Iterator[Mistake]:
    """Cushions whose contact is not much longer than that of two balls."""
    if scene.table is None:
        return
    cushion, balls = scene.table.cushion.duration, scene.contacts.ball_ball.duration
    if cushion > 0.0 and not is_instant_beside(balls, cushion):
        yield Mistake(
            ('table', 'cushion', 'duration'),
            (
                'must be 0 or at least ten times contacts.ball_ball.duration, '
                f'{10.0 * balls:.4g}, got {cushion!r} (s)'
            ),
        )


@dataclass(frozen=True, slots=True)
class Table(CheckedRecord):
    """
    A table with cushions and, unless it is a carom table, six pockets.

    Parameters
    ----------
    length, width : float
        From nose to nose [m], above 0 and at most 20. 2.54 x 1.27: nine feet (WPA).
    pockets : bool
        False for a carom table.
    cushion : Cushion
    corner, side : CornerPocket, SidePocket

    """

    RULES: ClassVar = (_too_small_for_pockets,)
    length: float = number('m', above=0, maximum=20, default=2.54)
    width: float = number('m', above=0, maximum=20, default=1.27)
    pockets: bool = boolean(default=True)
    cushion: Cushion = section(Cushion, optional=True)
    corner: CornerPocket = section(CornerPocket, optional=True)
    side: SidePocket = section(SidePocket, optional=True)


def _rounding(pocket: Pocket) -> float:
    """Length of a nose that its rounded end takes [m]."""
    return pocket.jaw_radius * math.tan(0.5 * math.radians(180.0 - pocket.cut_deg))


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
class Ball(CheckedRecord):
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
class Cue(CheckedRecord):
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


def _stiffness_or_duration(contact: Any) -> Iterator[Mistake]:
    stiffness, duration = contact.stiffness, contact.duration
    if stiffness is None and duration is None:
        yield Mistake(('duration',), 'is missing, and so is stiffness; one of them must be given')
    if stiffness is not None and duration is not None:
        yield Mistake(
            ('stiffness',), f'must be omitted, because duration is given, got {stiffness!r}'
        )


@dataclass(frozen=True, slots=True)
class ContactParameters(CheckedRecord):
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
class Contacts(CheckedRecord):
    """The contacts: tip and ball, ball and table (its cloth), ball and ball."""

    RULES: ClassVar = (_stated_alike,)
    cue_ball: ContactParameters = section(ContactParameters)
    ball_table: ContactParameters = section(ContactParameters)
    ball_ball: BallBall = section(BallBall, optional=True)


def _rise_from_nothing(cloth: Any) -> Iterator[Mistake]:
    if cloth.rolling_rise > 0.0 and cloth.rolling_resistance == 0.0:
        yield Mistake(
            ('rolling_rise',),
            f'must be 0 without rolling_resistance, got {cloth.rolling_rise!r} (s/m)',
        )


@dataclass(frozen=True, slots=True)
class Cloth(CheckedRecord):
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
