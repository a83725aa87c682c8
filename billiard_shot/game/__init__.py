"""Games: rules and referee, and players that decide which shot to play."""

from billiard_shot.game.rack import (
    Agent,
    agent_names,
    find_agent,
    Pairing,
    play,
    simulated,
    Simulator,
    summary,
)
from billiard_shot.game.referee import choose, judge, start
from billiard_shot.game.state import (
    Call,
    Decision,
    find_game,
    Foul,
    Game,
    game_names,
    Outcome,
    outcome_of,
    Ruling,
    State,
)

__all__ = [
    'Agent',
    'Call',
    'Decision',
    'Foul',
    'Game',
    'Outcome',
    'Pairing',
    'Ruling',
    'Simulator',
    'State',
    'agent_names',
    'choose',
    'find_agent',
    'find_game',
    'game_names',
    'judge',
    'outcome_of',
    'play',
    'simulated',
    'start',
    'summary',
]
