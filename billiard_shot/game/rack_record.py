"""What happened in a rack, as plain data: shots, rulings and times, from which it is replayed."""

from dataclasses import asdict, dataclass, field
from typing import Any

from billiard_shot.game.state import State

# How visits to the table end. A miss is a shot that the player gave an even chance or more; a
# shot with less was all that the leave before it had left.
ENDS = ('won', 'miss', 'leave', 'scratch', 'foul', 'safety', 'no shot', 'break', 'illegal')


@dataclass(frozen=True, slots=True)
class PlayedShot:
    """
    One decision of a rack.

    Attributes
    ----------
    state : dict
        The state before it, see `State.to_dict`.
    offsets : tuple of float
        The stroke as planned: a, b, elevation, azimuth, speed of `from_offsets`; empty for none.
    call : dict
        Ball, pocket, safety, push_out.
    choice : str
        The choice that was taken; '' for a stroke.
    success : float, optional
        The probability that the player gave its shot.
    reason : str
        Why it was played.
    kept : bool
        Whether the player kept its turn.
    fouls : tuple of str
    text : str
        The ruling.
    end : str
        How the visit ended, one of `ENDS`; '' if it went on.
    cpu, wall : float
        Time of the decision [s].

    """

    state: dict[str, Any]
    offsets: tuple[float, ...] = ()
    call: dict[str, Any] = field(default_factory=dict)
    choice: str = ''
    success: float | None = None
    reason: str = ''
    kept: bool = False
    fouls: tuple[str, ...] = ()
    text: str = ''
    end: str = ''
    cpu: float = 0.0
    wall: float = 0.0


@dataclass(frozen=True, slots=True)
class RackRecord:
    """
    A rack that was played.

    Attributes
    ----------
    game : str
    number : int
        Of the rack in its tournament.
    seed : int
        Of the errors of execution, see `errors_of`.
    players : tuple of str
        Names of players 0 and 1.
    shots : tuple of PlayedShot
    state : dict
        At the end.

    """

    game: str
    number: int
    seed: int
    players: tuple[str, ...]
    shots: tuple[PlayedShot, ...]
    state: dict[str, Any]

    @property
    def winner(self) -> str | None:
        """Name of the winner; None if nobody has won."""
        winner = State.from_dict(self.state).winner
        return None if winner is None else self.players[winner]

    def to_dict(self) -> dict[str, Any]:
        """Plain dict that `from_dict` turns into an equal record."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> 'RackRecord':
        """Make a record from such a dict."""
        shots = tuple(
            PlayedShot(
                **{
                    **shot,
                    'offsets': tuple(shot['offsets']),
                    'fouls': tuple(shot['fouls']),
                }
            )
            for shot in data['shots']
        )
        return cls(**{**data, 'players': tuple(data['players']), 'shots': shots})
