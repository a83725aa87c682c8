"""Turns of games at the terminal: the operator fires, and says what a camera does not show."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from billiard_shot_msgs.action import PlayTurn

from billiard_shot import Scene
from billiard_shot.cli.options import option
from billiard_shot.game.rack import Agent, find_agent
from billiard_shot.game.referee import start
from billiard_shot.game.state import State
from billiard_shot.game.typed import OUTCOME_HELP, Places, read_outcome
from billiard_shot.ros.client import FIRE, LOOK_PERIOD, RobotClient, say, TypedLines
from billiard_shot.ros.turn import AIMED, game_state_message, GameTable, Question, state_of, Turn
from billiard_shot.scene.fields import whole_number

WORDS = {
    PlayTurn.Feedback.PLACE: 'place',
    PlayTurn.Feedback.PLAY: 'plays',
    PlayTurn.Feedback.RULE: 'unknown',
    PlayTurn.Feedback.JUDGED: 'ruling',
}


@dataclass(frozen=True)
class OfGame:
    """
    The game, and the action that plays turns.

    Parameters
    ----------
    game : GAME
        Play a turn of this game, such as practice or eight_ball.
    balls : N
        Rack only the first N balls of the game.
    agent : NAME
        Who decides: player, greedy, random, or a module of your own (%(default)s).
    seed : N
        Of the rack and of the agent (%(default)d).
    state : FILE
        File of the game, written after the turn; if it exists, the game goes on from it.
    serve : bool
        Offer the action play_turn, until Ctrl+C.
    modules : MODULE
        Games and players of your own that goals of --serve may name.

    """

    game: str | None = None
    balls: int | None = None
    agent: str = 'player'
    seed: int = whole_number(minimum=0, default=0)
    state: Path | None = None
    serve: bool = False
    modules: list[str] = option(default=())


def first_turn(options: Any, scene: Scene) -> tuple[State, Agent]:
    """Read the state of the game, or start a game; ValueError if that is not possible."""
    agent = find_agent(options.agent)(scene, options.seed)
    if not (options.state and options.state.exists()):
        return start(options.game or 'practice', scene, options.seed, balls=options.balls), agent
    state = State.load(options.state)
    if options.game not in (None, state.game.name):
        raise ValueError(f'--game: {options.state} has a game of {state.game.name}')
    if state.over:
        raise ValueError(f'--state: the game of {options.state} is over')
    on_table = state_of(game_state_message(state), state.balls, scene)
    return replace(on_table, time_left=state.time_left), agent


class Operator:
    """Tells the operator what happens in a turn, and takes what the operator types."""

    def __init__(self, client: RobotClient, *, arms: bool) -> None:
        self._client, self._arms, self._typed = client, arms, TypedLines()
        self._stage, self._shot_id = PlayTurn.Feedback.DECIDE, ''
        self.question = Question(client)
        client.create_timer(LOOK_PERIOD, self._take)

    def tell(self, stage: int, message: str, shot_id: str, balls: Places) -> None:
        """Print what happens, and what to type."""
        self._stage, self._shot_id = stage, shot_id
        asked = ''
        if message == AIMED and not self._arms:
            asked = f'; type {FIRE} and Enter'
        elif stage == PlayTurn.Feedback.RULE:
            asked = '; type what it did (? for help)'
        if stage in WORDS:
            say(f'  {WORDS[stage]:11} {message}{asked}')

    def _take(self) -> None:
        line = self._typed.next()
        if line == FIRE and self._stage == PlayTurn.Feedback.PLAY:
            self._client.arm(self._shot_id)
        elif line is not None and self._stage == PlayTurn.Feedback.RULE:
            try:
                self.question.answer(self._shot_id, read_outcome(line))
                say('  used')
            except ValueError as error:
                say(OUTCOME_HELP if line == '?' else f'  {error}')
        elif line:
            say(f'  "{line}" is not asked for now')


def play_turn(table: GameTable, state: State, agent: Agent, options: Any) -> bool:
    """Play a turn, and print it; return False if it was not played, or the rack is lost."""
    say(f'{state.game.name}: {len(state.object_balls)} balls, player {state.player}')
    operator = Operator(table.client, arms=options.arm)
    turn = Turn(table, agent, operator.tell, operator.question.ask, options.arm, state)
    try:
        outcome, message = turn.play()
        say(f'  turn        {message}')
    finally:
        if options.state:
            turn.state.save(options.state)
    if outcome == PlayTurn.Result.OVER:
        return turn.state.winner == state.player
    return outcome == PlayTurn.Result.TURN_ENDED
