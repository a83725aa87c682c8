"""Which effects a scene forces on or off."""

from dataclasses import dataclass

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import choice


@dataclass(frozen=True, slots=True)
class Effects:
    """
    Effects that can be forced: `auto` (simulated where the stroke calls for it), `on` or `off`.

    Parameters
    ----------
    flight : str
        `off` puts the ball back on the cloth after the strike with its horizontal motion kept.
    bounce : str
        `off` lets the ball stay down where it first lands; `on` is the same as `auto`.

    """

    flight: str = choice('auto', 'on', 'off', default='auto')
    bounce: str = choice('auto', 'on', 'off', default='auto')

    def __post_init__(self) -> None:
        check(self)
