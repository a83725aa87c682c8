"""Effects that a scene turns on or off."""

from dataclasses import dataclass

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import choice

_SETTINGS = 'auto', 'on', 'off'


@dataclass(frozen=True, slots=True)
class Effects:
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

    def __post_init__(self) -> None:
        check(self)
