"""Games: rules and referee, and players that decide which shot to play."""

from billiard_shot.game.agent import Agent, simulated, Simulator
from billiard_shot.game.call import Call, Decision
from billiard_shot.game.game import find_game, Game, game_names
from billiard_shot.game.outcome import Outcome, outcome_of
from billiard_shot.game.racking import start
from billiard_shot.game.referee import choose, judge
from billiard_shot.game.ruling import Foul, Ruling
from billiard_shot.game.state import State
from billiard_shot.game.tournament import agent_names, find_agent, Pairing, play, summary

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
