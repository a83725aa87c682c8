"""
What balls meet beside the cue and the cloth: other balls, cushions, pockets; sizes of a table.

Tables, pockets and cushions are measured as the World Pool-Billiard Association does (WPA Tables &
Equipment Specifications); its nine-foot table is the default.
"""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterator
from dataclasses import dataclass
import math
from typing import Any, ClassVar

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import choice, number, section, yes_or_no
from billiard_shot.scene.mistakes import Mistake

# A ball's meeting with a cushion, in the words of its authors: restitution and friction of
# Mathavan, Jackson and Parkin (Proc. IMechE C 224, 2010), measured for snooker cushions; of Han
# (J. Mech. Sci. Technol. 19, 2005), whose model takes no account of the cloth, restitution after
# van Balen and Alciatore's range for friction.
CUSHIONS = {'mathavan': (0.98, 0.14), 'han': (0.85, 0.2)}


@dataclass(frozen=True, slots=True)
class BallBall:
    """
    How two balls meet.

    Parameters
    ----------
    restitution : float
        0 to 1. 0.95: middle of the 0.92 to 0.98 that Alciatore gives (physical properties of pool
        equipment, billiards.colostate.edu).
    friction_fast, friction_slow, friction_decay : float
        The coefficient of friction at slip v is friction_fast + friction_slow exp(-friction_decay
        v), at least 0, at least 0 and in s/m, at least 0. By default Alciatore's fit to Marlow's
        measurements (technical proof TP A.14); a constant coefficient has no friction_slow.
    stiffness : float
        Of the virtual spring, above 0, in the units of the other contacts; it only counts where
        more than two bodies meet. 25: contacts last as the root of mass over stiffness, and two
        balls' 0.25 ms, the tip's 1.3 ms (high-speed films, Alciatore), with the tip's 1.5.
    gap : float
        Balls (and cushions) so near each other are in touch when one of them is hit [m], at
        least 0 and at most 1 mm; what is farther apart collides one after the other. 0.1 um:
        what was placed in touch, and no gaps of a rack, which are tens of um. Anything below
        10 nm is 10 nm: so deep bodies may be in each other that were pressed together.

    """

    restitution: float = number('', least=0, most=1, default=0.95)
    friction_fast: float = number('', least=0, default=0.00995)
    friction_slow: float = number('', least=0, default=0.108)
    friction_decay: float = number('s/m', least=0, default=1.088)
    stiffness: float = number('any unit', above=0, default=25.0)
    gap: float = number('m', least=0, most=1e-3, default=1e-7)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Cushion:
    """
    The cushions of a table.

    Parameters
    ----------
    model : str
        `mathavan`: ball, cushion and cloth meet, with friction at both and work-energy restitution
        (Mathavan 2010); the default, because it is the one that was measured, to 2.5 m/s, and the
        one in which the cloth takes part, as it does in the strike. `han`: ball and cushion alone,
        in closed form (Han 2005).
    restitution : float, optional
        0 to 1; by default that of the model, see `CUSHIONS`.
    friction : float, optional
        At least 0; by default that of the model.
    height : float
        Of the nose above the cloth, in ball diameters, at least 0.5 and at most 0.95. 0.635: WPA.
    depth : float
        How far cushions reach from their nose outwards [m], above 0: so long are the facings of
        pockets. 2 in: WPA.
    stiffness : float
        Of the virtual spring, above 0, in the units of the other contacts; it only counts where
        more than two bodies meet. 0.1: a contact of 5 ms, as for `BallBall.stiffness`.

    """

    model: str = choice('mathavan', 'han', default='mathavan')
    restitution: float = number(
        '', least=0, most=1, derived=lambda cushion: CUSHIONS[cushion.model][0]
    )
    friction: float = number('', least=0, derived=lambda cushion: CUSHIONS[cushion.model][1])
    height: float = number('ball diameters', least=0.5, most=0.95, default=0.635)
    depth: float = number('m', above=0, default=0.0508)
    stiffness: float = number('any unit', above=0, default=0.1)

    def __post_init__(self) -> None:
        check(self)


class Pocket:
    """
    What corner and side pockets have in common.

    Parameters
    ----------
    mouth : float
        Width between the two points where the lines of noses and facings meet [m], above 0.
    cut_deg : float
        Angle between a nose and the facing that goes on from it [degrees], above 90 and below 180.
    jaw_radius : float
        Radius of the rounded corner between the two [m], above 0.
    shelf : float
        From the middle of the mouth to the edge of the hole [m], at least 0.
    radius : float
        Of the hole [m], above 0. A ball falls when its centre is over the edge.

    """

    __slots__ = ()
    mouth: float
    cut_deg: float
    jaw_radius: float
    shelf: float
    radius: float

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class CornerPocket(Pocket):
    """Pocket in a corner: WPA sizes; radii of jaw and hole as on common tables. See `Pocket`."""

    mouth: float = number('m', above=0, default=0.116)  # 4.5 to 4.625 in
    cut_deg: float = number('degrees', above=90, most=179, default=142.0)
    jaw_radius: float = number('m', above=0, default=0.021)
    shelf: float = number('m', least=0, default=0.038)  # 1 to 2.25 in
    radius: float = number('m', above=0, default=0.062)


@dataclass(frozen=True, slots=True)
class SidePocket(Pocket):
    """Pocket in the middle of a long side: as `CornerPocket`."""

    mouth: float = number('m', above=0, default=0.129)  # 5 to 5.125 in
    cut_deg: float = number('degrees', above=90, most=179, default=104.0)
    jaw_radius: float = number('m', above=0, default=0.008)
    shelf: float = number('m', least=0, default=0.005)  # 0 to 0.375 in
    radius: float = number('m', above=0, default=0.0645)


def _room_for_pockets(table: Any) -> Iterator[Mistake]:
    """There must be some straight cushion between any two pockets."""
    if table.pockets:
        corner = table.corner.mouth * math.sqrt(0.5) + _rounding(table.corner)
        side = 0.5 * table.side.mouth + _rounding(table.side)
        for name, needed in (('length', 2.0 * (corner + side)), ('width', 2.0 * corner)):
            if getattr(table, name) <= needed:
                yield Mistake(
                    (name,),
                    (
                        f'{getattr(table, name)!r} is not allowed; with these pockets it must be '
                        f'above {needed:.4g} (m)'
                    ),
                )


@dataclass(frozen=True, slots=True)
class Table:
    """
    A table with cushions around its bed and, if it has any, six pockets.

    Parameters
    ----------
    length, width : float
        Of the bed, from nose to nose [m], above 0. 2.54 x 1.27: nine feet (WPA).
    pockets : bool
        False: a carom table.
    cushion : Cushion
    corner, side : CornerPocket, SidePocket

    """

    RULES: ClassVar = (_room_for_pockets,)
    length: float = number('m', above=0, default=2.54)
    width: float = number('m', above=0, default=1.27)
    pockets: bool = yes_or_no(default=True)
    cushion: Cushion = section(Cushion, optional=True)
    corner: CornerPocket = section(CornerPocket, optional=True)
    side: SidePocket = section(SidePocket, optional=True)

    def __post_init__(self) -> None:
        check(self)


def _rounding(pocket: Pocket) -> float:
    """How much of a nose its rounded end takes [m]."""
    return pocket.jaw_radius * math.tan(0.5 * math.radians(180.0 - pocket.cut_deg))
