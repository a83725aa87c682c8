"""Games: rules and referee, and players that decide which shot to play."""

from billiard_shot.game.call import Call, Decision
from billiard_shot.game.game import find_game, Game, game_names, start
from billiard_shot.game.outcome import Outcome, outcome_of
from billiard_shot.game.referee import choose, judge, judge_batch, Rulings
from billiard_shot.game.ruling import Foul, Ruling
from billiard_shot.game.state import State

__all__ = [
    'Call',
    'Decision',
    'Foul',
    'Game',
    'Outcome',
    'Ruling',
    'Rulings',
    'State',
    'choose',
    'find_game',
    'game_names',
    'judge',
    'judge_batch',
    'outcome_of',
    'start',
]
