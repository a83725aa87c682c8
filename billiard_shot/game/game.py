"""Games: a game is data and a few pure functions, in one module."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from billiard_shot.game.call import Call
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.plugins import find_plugin, names_in
from billiard_shot.scene.errors import refused

if TYPE_CHECKING:
    from billiard_shot.game.ruling import Ruling
    from billiard_shot.game.state import State


def any_ball(state: State, player: int = 0) -> tuple[str, ...]:
    """Return all object balls."""
    return state.object_balls


@dataclass(frozen=True, slots=True)
class Game:
    """
    The rules of a game.

    Parameters
    ----------
    name : str
        The name of its module: in the package as `eight_ball`, elsewhere as `package.module`.
    balls : tuple of str
        Names of the object balls.
    rack : callable
        Takes a state and the names of balls, and returns their places (x, y) [m].
    rule : callable
        Takes a `State`, a `Call` and an `Outcome`, and returns the `Ruling`, see there.
    targets : callable
        Takes a state, and returns the balls that the cue ball may meet first; by default all. In
        games with pockets the pot of such a ball keeps the turn.
    needs : callable
        Takes a state and a player, and returns the balls that this player has to pot to win; by
        default all.
    shared : bool
        Whether both players pot the same balls, so that a pot brings both nearer to the end.
    in_hand, phase : str
        Of the first state, see `State`.
    calls : bool
        Ball and pocket must be called; else any ball that falls legally keeps the turn.
    players : int
        1 or 2.
    goal : int
        Points that win; 0 if the game has no points.
    pockets : bool
        False for a game on a table without pockets.
    decisive : str
        Ball that stays on the table until the rack is decided; '' for none.

    """

    name: str
    balls: tuple[str, ...]
    rack: Callable[[State, tuple[str, ...]], Mapping[str, tuple[float, float]]]
    rule: Callable[[State, Call, Outcome], Ruling]
    targets: Callable[[State], tuple[str, ...]] = any_ball
    needs: Callable[[State, int], tuple[str, ...]] = any_ball
    shared: bool = True
    in_hand: str = 'kitchen'
    phase: str = 'break'
    calls: bool = True
    players: int = 2
    goal: int = 0
    pockets: bool = True
    decisive: str = ''


def game_names() -> list[str]:
    """Names of the games of the package, in alphabetical order."""
    return names_in('rules')


def find_game(name: str, field: str = 'game') -> Game:
    """
    Return a game.

    Parameters
    ----------
    name : str
        One of `game_names`; or `package.module`, a module of your own with a constant `GAME`.
    field : str
        That holds the name, for messages.

    Raises
    ------
    ValueError
        If there is no such game.

    """
    game = find_plugin(name, 'rules', 'GAME', field)
    if not isinstance(game, Game):
        raise refused(game, 'a Game', f'{name}.GAME')
    if game.name != name:  # by which a saved state finds it again
        raise refused(game.name, repr(name), f'{name}.GAME.name')
    return game
