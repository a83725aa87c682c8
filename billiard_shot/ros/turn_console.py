"""Turns of games at the terminal: starts a game or goes on with it, and asks the operator."""

import argparse
from pathlib import Path
import select
import sys

from billiard_shot_msgs.action import PlayTurn

from billiard_shot import Scene
from billiard_shot.game.game import find_game, start
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.seen import Places, told_outcome
from billiard_shot.game.state import State
from billiard_shot.game.tournament import find_agent
from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.game_table import GameTable
from billiard_shot.ros.turn import AgentError, make_agent, Turn, TurnStage

FIRE = 'fire'
"""What the operator types to fire an aimed shot."""

WORDS = {
    TurnStage.PLACE: 'place',
    TurnStage.PLAY: 'plays',
    TurnStage.RULE: 'unknown',
    TurnStage.JUDGED: 'ruling',
}


def typed_fire() -> bool:
    """Whether the operator has typed the word that fires; does not wait."""
    return (
        bool(select.select([sys.stdin], [], [], 0.0)[0]) and sys.stdin.readline().strip() == FIRE
    )


def add_turn_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of games."""
    add = parser.add_argument
    add('--game', metavar='GAME', help='play a turn of this game, such as practice or eight_ball')
    add('--balls', type=int, metavar='N', help='rack only the first N balls of the game')
    agents = 'player, greedy, random, or a module'
    add('--agent', default='player', metavar='NAME', help=f'who decides: {agents} (player)')
    add('--seed', type=int, default=0, metavar='N', help='of the rack and of the agent (0)')
    saved = 'file of the game, written after the turn; if it exists, the game goes on from it'
    add('--state', type=Path, metavar='FILE', help=saved)
    add(
        '--serve', action='store_true', help='play the turns of the action play_turn, until Ctrl+C'
    )


def first_state(options: argparse.Namespace, scene: Scene) -> State:
    """
    Read the state of the game, or start a game.

    Raises
    ------
    ValueError
        If the options, the file or the scene do not fit.

    """
    find_agent(options.agent)
    if options.state and options.state.exists():
        state = State.load(options.state)
        if options.game not in (None, state.game):
            raise ValueError(f'--game: {options.state} has a game of {state.game}')
        if state.over:
            raise ValueError(f'--state: the game of {options.state} is over')
        find_game(state.game)
        return state
    return start(options.game or 'practice', scene, options.seed, balls=options.balls)


def play_turn(
    client: RobotClient, state: State, scene: Scene, options: argparse.Namespace
) -> bool:
    """Play a turn and print it; return False if it was not played, or the rack is lost."""

    def tell(stage: int, message: str, shot_id: str, balls: Places) -> None:
        if stage == TurnStage.PLAY and not options.arm:
            message += f'; when it is aimed, type {FIRE} and Enter'
        if stage in WORDS:
            print(f'  {WORDS[stage]:11} {message}', flush=True)

    may_fire = (lambda: True) if options.arm else typed_fire
    try:
        agent = make_agent(options.agent, scene, options.seed)
    except AgentError as error:
        print(f'  turn        {error}', flush=True)
        return False
    turn = Turn(GameTable(client, scene), agent, tell, ask, may_fire, state=state)
    print(f'{state.game}: {len(state.object_balls)} balls, player {state.player}', flush=True)
    outcome, message = turn.play()
    print(f'  turn        {message}', flush=True)
    if options.state:
        turn.state.save(options.state)
    if outcome == PlayTurn.Result.OVER:
        return turn.state.winner == state.player
    return outcome == PlayTurn.Result.TURN_ENDED


def ask(shot_id: str, state: State, places: Places) -> Outcome:
    """Ask the operator what a shot did."""
    while True:
        first = input('  ball that the cue ball met first (Enter: none): ').strip()
        driven = input('  balls that then met a cushion: ').split()
        pockets = {}
        for ball in (ball for ball in state.balls if ball not in places):
            if pocket := input(f'  pocket of {ball} (Enter: left the table): ').strip():
                pockets[ball] = pocket
        try:
            return told_outcome(state, places, first, driven, pockets)
        except ValueError as error:
            print(f'  {error}')
