"""Which effects a scene forces on or off."""

from dataclasses import dataclass

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import choice

_WISHES = 'auto', 'on', 'off'


@dataclass(frozen=True, slots=True)
class Effects:
    """
    What a scene wishes of each effect: `auto` (where it is called for), `on` or `off`.

    Parameters
    ----------
    table_contact : str
        `off`: the ball is struck as if nothing were below it, and then put onto the cloth.
    tip_friction, table_friction : str
        `off`: in the strike the tip, or the cloth, only pushes along the normal.
    end_mass : str
        `off`: the tip cannot give way sideways, as if the cue were guided.
    tip_curvature : str
        `off`: a rounded tip meets the ball where the axis of the cue does.
    flight : str
        `off`: the ball is put back on the cloth after the strike, with its horizontal motion kept.
        `on`: it flies however low.
    bounce : str
        `off`: the ball stays down where it first lands. `on`: every hop is followed, until it is
        lost in rounding.
    slide : str
        `off`: the ball rolls at once, as it would at the end of its slide.
    roll, spin_decay : str
        `off`: nothing slows the roll, or the spin about the vertical; the ball may never rest.
    cushion, pocket : str
        `off`: the cloth goes on for ever; or the cushions go on where the pockets would be.
        `pocket: on`: every pocket is searched, however far from the path of a ball.
    ball_ball : str
        `off`: balls go through each other. `on`: every pair is searched, moving or not.
    throw : str
        `off`: balls are smooth when they meet.
    cluster : str
        `off`: bodies in touch meet two by two, one pair after the other.
    double_hit : str
        `off`: nobody looks whether the cue, following through, catches the ball again.

    """

    table_contact: str = choice(*_WISHES, default='auto')
    tip_friction: str = choice(*_WISHES, default='auto')
    table_friction: str = choice(*_WISHES, default='auto')
    end_mass: str = choice(*_WISHES, default='auto')
    tip_curvature: str = choice(*_WISHES, default='auto')
    flight: str = choice(*_WISHES, default='auto')
    bounce: str = choice(*_WISHES, default='auto')
    slide: str = choice(*_WISHES, default='auto')
    roll: str = choice(*_WISHES, default='auto')
    spin_decay: str = choice(*_WISHES, default='auto')
    cushion: str = choice(*_WISHES, default='auto')
    pocket: str = choice(*_WISHES, default='auto')
    ball_ball: str = choice(*_WISHES, default='auto')
    throw: str = choice(*_WISHES, default='auto')
    cluster: str = choice(*_WISHES, default='auto')
    double_hit: str = choice(*_WISHES, default='auto')

    def __post_init__(self) -> None:
        check(self)
