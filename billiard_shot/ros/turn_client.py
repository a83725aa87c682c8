"""Turns of games at the terminal: a client of the action `play_turn`, for the operator."""

import argparse
from collections.abc import Callable
from dataclasses import replace
import math
from pathlib import Path
from typing import Any

from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.srv import RuleShot
from rclpy.action import ActionClient
from rclpy.client import Client

from billiard_shot import Scene
from billiard_shot.game.referee import start
from billiard_shot.game.state import State
from billiard_shot.game.typed import OUTCOME_HELP, read_outcome
from billiard_shot.ros.client import FIRE, LOOK_PERIOD, result_of, RobotClient, say, TypedLines
from billiard_shot.ros.turn import AIMED, balls_message, game_state_message, places_of, state_of

LAST_SHOT_TIME = 180.0  # s in which an interrupted turn ends: a shot may have to be judged

WORDS = {
    PlayTurn.Feedback.PLACE: 'place',
    PlayTurn.Feedback.PLAY: 'plays',
    PlayTurn.Feedback.RULE: 'unknown',
    PlayTurn.Feedback.JUDGED: 'ruling',
}


def add_turn_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of games."""
    add = parser.add_argument
    game = (
        'play a turn of this game, such as practice or eight_ball, with a running player --serve'
    )
    add('--game', metavar='GAME', help=game)
    add('--balls', type=int, metavar='N', help='rack only the first N balls of the game')
    agents = 'player, greedy, random, or one of the --modules of player --serve'
    add('--agent', default='player', metavar='NAME', help=f'who decides: {agents} (player)')
    add('--seed', type=int, default=0, metavar='N', help='of the rack and of the agent (0)')
    saved = 'file of the game, written after the turn; if it exists, the game goes on from it'
    add('--state', type=Path, metavar='FILE', help=saved)
    add('--serve', action='store_true', help='offer the action play_turn, until Ctrl+C')
    modules = 'games and players of your own that goals of --serve may name'
    add('--modules', nargs='+', default=[], metavar='MODULE', help=modules)


def first_state(options: argparse.Namespace, scene: Scene) -> State:
    """Read the state of the game, or start a game; ValueError if that is not possible."""
    if options.state and options.state.exists():
        state = State.load(options.state)
        if options.game not in (None, state.game.name):
            raise ValueError(f'--game: {options.state} has a game of {state.game.name}')
        if state.over:
            raise ValueError(f'--state: the game of {options.state} is over')
        return state
    return start(options.game or 'practice', scene, options.seed, balls=options.balls)


class Operator:
    """Tells the operator what happens in a turn, and passes on what the operator types."""

    def __init__(self, client: RobotClient, *, arms: bool) -> None:
        self._client, self._arms, self._typed = client, arms, TypedLines()
        self._now = PlayTurn.Feedback()
        self._rule: Client[Any, Any] = client.create_client(RuleShot, 'player/rule_shot')
        client.create_timer(LOOK_PERIOD, self._pass_on)

    def hear(self, message: Any) -> None:
        """Print feedback."""
        self._now = now = message.feedback
        asked = ''
        if now.message == AIMED and not self._arms:
            asked = f'; type {FIRE} and Enter'
        elif now.stage == now.RULE:
            asked = '; type what it did (? for help)'
        if now.stage in WORDS:
            say(f'  {WORDS[now.stage]:11} {now.message}{asked}')

    def _pass_on(self) -> None:
        line, now = self._typed.next(), self._now
        if line == FIRE and now.stage == now.PLAY:
            self._client.arm(now.shot_id)
        elif line is not None and now.stage == now.RULE:
            try:
                told = read_outcome(line)
            except ValueError as error:
                say(OUTCOME_HELP if line == '?' else f'  {error}')
                return
            request = RuleShot.Request(
                shot_id=now.shot_id,
                first_contact=told.first_contact,
                to_cushion=told.to_cushion,
                pocketed=list(told.pockets),
                pockets=list(told.pockets.values()),
                double_hit=told.double_hit,
            )
            answer = self._rule.call_async(request)
            answer.add_done_callback(lambda done: say(f'  {result_of(done).message or "used"}'))
        elif line:
            say(f'  "{line}" is not asked for now')


def play_turn(
    client: RobotClient, state: State, scene: Scene, options: argparse.Namespace
) -> bool:
    """Have a turn played, and print it; return False if it was not played, or the rack is lost."""
    action: ActionClient[Any, Any, Any] = ActionClient(client, PlayTurn, 'play_turn')
    client.wait_for('player', action.server_is_ready)
    say(f'{state.game.name}: {len(state.object_balls)} balls, player {state.player}')
    goal = PlayTurn.Goal(
        state=game_state_message(state),
        balls=balls_message(state.balls),
        agent=options.agent,
        seed=options.seed,
        arm=options.arm,
    )
    hear = Operator(client, arms=options.arm).hear
    answer: Callable[[], Any] = lambda: None  # noqa: E731
    try:
        with client.acting('play_turn', action, goal, hear, LAST_SHOT_TIME) as answer:
            client.until(answer, math.inf)
    finally:  # also after Ctrl+C: a stroke that had begun has been judged
        if ended := answer():
            result = ended.result
            say(f'  turn        {result.message}')
            if options.state:
                places = places_of(result.balls)
                after = replace(state_of(result.state, places, scene), time_left=state.time_left)
                after.save(options.state)
    if result.outcome == result.OVER:
        return result.state.winner == state.player
    return result.outcome == result.TURN_ENDED
