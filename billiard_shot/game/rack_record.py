"""What happened in a rack, as plain data: shots, rulings and times, from which it is replayed."""

from dataclasses import asdict, dataclass, field
import json
from pathlib import Path
from typing import Any

from billiard_shot.game.state import State
from billiard_shot.scene.errors import reason

# How visits to the table end. A miss is a shot that the player gave an even chance or more; a
# shot with less was all that the leave before it had left.
ENDS = ('won', 'miss', 'leave', 'scratch', 'foul', 'safety', 'no shot', 'break', 'illegal')


@dataclass(frozen=True, slots=True)
class PlayedShot:
    """One decision of a rack."""

    state: dict[str, Any]  # before it, see `State.to_dict`
    offsets: tuple[float, ...] = ()  # as planned, of `from_offsets`; empty if there is no stroke
    call: dict[str, Any] = field(default_factory=dict)  # see `Call`
    choice: str = ''  # that was taken
    success: float | None = None  # probability that the player gave its shot
    reason: str = ''  # why it was played
    kept: bool = False  # whether the player kept its turn
    miscue: bool = False  # the tip slid on the cue ball
    fouls: tuple[str, ...] = ()
    text: str = ''  # the ruling
    end: str = ''  # how the visit ended, one of `ENDS`; '' if it went on
    cpu: float = 0.0  # s that the decision took
    wall: float = 0.0  # s


@dataclass(frozen=True, slots=True)
class RackRecord:
    """A rack that was played."""

    game: str
    number: int  # in its tournament
    seed: int  # of the errors of execution, see `errors_of`
    players: tuple[str, ...]  # names of players 0 and 1
    shots: tuple[PlayedShot, ...]
    state: dict[str, Any]  # at the end

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
            PlayedShot(**shot | {name: tuple(shot[name]) for name in ('offsets', 'fouls')})
            for shot in data['shots']
        )
        return cls(**{**data, 'players': tuple(data['players']), 'shots': shots})

    def save(self, path: Path) -> None:
        """Write the record as JSON; a file that was there is replaced at once."""
        new = path.with_name(f'{path.name}.new')
        new.write_text(json.dumps(self.to_dict(), allow_nan=False) + '\n', encoding='utf-8')
        new.replace(path)

    @classmethod
    def load(cls, path: Path) -> 'RackRecord':
        """Read a record that `save` wrote; ValueError names the file."""
        try:
            record = cls.from_dict(json.loads(path.read_text(encoding='utf-8')))
            State.from_dict(record.state)
        except (KeyError, TypeError, json.JSONDecodeError, UnicodeDecodeError):
            raise ValueError(f'{path}: must be the record of a rack') from None
        except (OSError, ValueError) as error:
            raise ValueError(f'{path}: {reason(error)}') from None
        return record
