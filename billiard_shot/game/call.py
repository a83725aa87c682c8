"""Calls and decisions of players."""

from dataclasses import dataclass, field

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import boolean, choice, name
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run import POCKET_NAMES


@dataclass(frozen=True, slots=True)
class Call:
    """
    The call of a player before a shot.

    Parameters
    ----------
    ball : str, optional
        The ball that is to fall; None if the game needs no call.
    pocket : str
        The pocket into which it is to fall, one of `POCKET_NAMES`; '' if the game needs no call.
    safety : bool
        The turn ends with the shot, even if a ball falls.
    push_out : bool
        The shot is a push-out; only on the shot after the break of nine-ball.

    """

    ball: str | None = name(nullable=True)
    pocket: str = choice(*POCKET_NAMES, '', default='')
    safety: bool = boolean(default=False)
    push_out: bool = boolean(default=False)

    def __post_init__(self) -> None:
        check(self)

    @property
    def passes(self) -> bool:
        """Whether the turn passes to the other player even if a ball falls."""
        return self.safety or self.push_out


NO_CALL = Call()


@dataclass(frozen=True, slots=True)
class Decision:
    """
    One of the choices of a state, or a stroke with its call.

    Parameters
    ----------
    stroke : Stroke, optional
        None if the player takes a choice, or concedes because it finds no stroke.
    call : Call
    choice : str
        One of `State.choices`; '' for a stroke.
    success : float, optional
        The probability, as the player states it, of a legal shot that keeps its turn.
    reason : str
        Of the decision, in one line.

    """

    stroke: Stroke | None = None
    call: Call = field(default=NO_CALL)
    choice: str = ''
    success: float | None = None
    reason: str = ''
