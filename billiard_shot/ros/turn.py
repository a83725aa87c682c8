"""
A turn of a game, played with the mechanical cue: decide, aim, arm, watch, judge.

A simulated table tells what each shot did. With a camera the ruling follows from the places of the
balls where these are enough; otherwise somebody is asked.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
import math
from traceback import format_exception
from typing import Any, TypeAlias, TypeVar

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import TurnShot

from billiard_shot import Stroke
from billiard_shot.cue.outcome import GoalOutcome as Execution
from billiard_shot.cue.outcome import RefusedError
from billiard_shot.game.agent import Agent, scene_of
from billiard_shot.game.call import Decision
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.rack import decision_of
from billiard_shot.game.referee import choose, concede, judge
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.seen import Places, possible_rulings
from billiard_shot.game.state import State
from billiard_shot.perception.sightings import Balls
from billiard_shot.ros.client import CanceledError, NotReadyError, RobotClient, TableUnknownError
from billiard_shot.ros.game_table import GameTable
from billiard_shot.ros.terminal import escaped

T = TypeVar('T')

TurnStage = PlayTurn.Feedback
AIMED = 'aimed'  # message of the feedback that tells when a shot waits to be armed

Tell: TypeAlias = Callable[[int, str, str, Places], object]
"""Called with the stage, a message, the id of the shot, and the balls of the stage PLACE."""

Ask: TypeAlias = Callable[[str, State, Places, Callable[[], bool]], Outcome | None]
"""
Called to ask somebody about a shot; None if the answer is no longer needed.

The arguments are the id of the shot, the state before it, the places of the balls that are seen
after it [m], and a function that returns whether the answer is no longer needed.
"""


class NotPlayedError(RuntimeError):
    """The driver has refused or ended a shot; the message says why."""


class AgentError(RuntimeError):
    """The agent has failed; the message says how, and `__cause__` where."""


EARLY_ENDS: dict[type[Exception], int] = {
    CanceledError: PlayTurn.Result.CANCELED,
    NotPlayedError: PlayTurn.Result.NOT_PLAYED,
    RefusedError: PlayTurn.Result.NOT_PLAYED,
    AgentError: PlayTurn.Result.AGENT_FAILED,
    TableUnknownError: PlayTurn.Result.TABLE_UNKNOWN,
    NotReadyError: PlayTurn.Result.NOT_READY,
    ValueError: PlayTurn.Result.INVALID,
    Exception: PlayTurn.Result.AGENT_FAILED,  # in the rules of a game of somebody else
}
"""Outcomes of turns that end early, by exception: of a class and its base, the class is first."""


def early_end(error: Exception, client: RobotClient) -> tuple[int, str]:
    """Outcome of `PlayTurn.Result` for an exception, and a message."""
    outcome = next(each for kind, each in EARLY_ENDS.items() if isinstance(error, kind))
    if outcome == PlayTurn.Result.AGENT_FAILED:
        client.get_logger().error(escaped(''.join(format_exception(error.__cause__ or error))))
    return outcome, str(error) or repr(error)


@dataclass
class Turn:
    """A turn that is played."""

    table: GameTable
    agent: Agent
    tell: Tell
    ask: Ask
    arms: bool  # each shot as soon as it is aimed
    state: State  # before the next shot
    shots: list[TurnShot] = field(default_factory=list)  # that have been played

    def play(self) -> tuple[int, str]:
        """Play until the turn ends; return the outcome of `PlayTurn.Result`, and a message."""
        player = self.state.player
        try:
            while not self.state.over and self.state.player == player:
                if self.table.client.is_canceled:
                    raise CanceledError('canceled')
                self._go_on()
        except Exception as error:
            return early_end(error, self.table.client)
        if not self.state.over:
            return PlayTurn.Result.TURN_ENDED, f'player {self.state.player} is next'
        winner = self.state.winner
        return PlayTurn.Result.OVER, 'nobody wins' if winner is None else f'player {winner} wins'

    def _go_on(self) -> None:
        """Take a choice, or play a shot; change the state."""
        self.tell(TurnStage.DECIDE, f'player {self.state.player} decides', '', {})
        wanted, decision, refusal = self._ask_agent(decision_of, self.agent, self.state)
        state = wanted
        seen: Balls = {}
        if not (wanted.choices or refusal):
            state, seen = self.table.arrange(
                wanted, lambda what, balls: self.tell(TurnStage.PLACE, what, '', balls)
            )
            if state.balls != wanted.balls:  # the balls never lie quite as wanted
                _, decision, refusal = self._ask_agent(decision_of, self.agent, state)
        if refusal:
            self._judged(state, decision, concede(state, refusal), '')
        elif decision.choice:
            self.state = choose(state, decision.choice)
        elif decision.stroke is None:
            self._judged(state, decision, judge(state, decision.call, None), '')
        else:
            self._shoot(state, seen, decision, decision.stroke)

    def _ask_agent(self, ask: Callable[..., T], *arguments: Any) -> T:
        """Ask the agent in a thread, so that the client goes on, and can be canceled."""
        pool = ThreadPoolExecutor(1)
        answer = pool.submit(ask, *arguments)
        pool.shutdown(wait=False)
        self.table.client.until(answer.done, math.inf)
        if error := answer.exception():
            raise AgentError(f'the agent has failed: {error!r}') from error
        return answer.result()

    def _shoot(self, state: State, seen: Balls, decision: Decision, stroke: Stroke) -> None:
        """Play a stroke that was decided for the balls that were seen, watch them, and judge."""
        scene, name = scene_of(self.table.scene, state), f'{state.game.name} {state.shots + 1}'
        goal = self.table.client.goal(stroke, seen, scene, name)
        shot_id = goal.plan.shot_id
        self.tell(TurnStage.PLAY, decision.reason or 'plays', shot_id, {})
        self.table.records.clear()
        aimed = partial(self.tell, TurnStage.PLAY, AIMED, shot_id, {})
        answer = self.table.client.execute(goal, lambda: self.arms, aimed)
        result = answer.result
        ended = answer.status != GoalStatus.STATUS_SUCCEEDED and NotPlayedError(
            f'{Execution(result.outcome).name}: {result.message}'
        )
        if ended and not result.struck:
            raise ended
        with self.table.client.to_the_end():  # a shot that has been played is judged
            ruling = None
            while ruling is None:
                self.tell(TurnStage.WATCH, 'the balls roll', shot_id, {})
                places, others = self.table.after_shot(result.strike.header.stamp)
                unseen = [name for name in others if name in state.balls]
                # A simulated table does not hear of a strike that was not measured.
                outcome = self.table.record() if result.measured else None
                ruling = self._ruling(state, decision, shot_id, places, unseen, outcome)
            self._judged(state, decision, ruling, shot_id)
            if unseen:
                self.table.forget_all_but(ruling.state.balls.keys() & places.keys())
        if ended and self.state.player == state.player and not self.state.over:
            raise ended

    def _ruling(
        self,
        state: State,
        decision: Decision,
        shot_id: str,
        places: Places,
        unseen: list[str],
        outcome: Outcome | None,
    ) -> Ruling | None:
        """Judge by what is known of a shot, or by what somebody says; None if more is seen now."""
        if outcome and outcome.gone.issuperset(unseen):
            return judge(state, decision.call, replace(outcome, places=places))
        if unseen:
            balls = ', '.join(f'ball {name!r}' for name in unseen)
            question = f'{balls} not seen: potted? If not, let the camera see it'
        else:
            found = possible_rulings(state, decision.call, places)
            if len(found) == 1:
                return found[0]
            rulings = ' or '.join(f'"{each.text}"' for each in found)
            question = f'pictures do not show how to rule: {rulings}'
        self.tell(TurnStage.RULE, question, shot_id, {})
        is_over = lambda: bool(unseen) and self.table.are_found(unseen)  # noqa: E731
        told = self.ask(shot_id, state, places, is_over)
        return judge(state, decision.call, told) if told else None

    def _judged(self, state: State, decision: Decision, ruling: Ruling, shot_id: str) -> None:
        self.shots.append(
            TurnShot(
                shot_id=shot_id,
                decision=decision.reason,
                success=-1.0 if decision.success is None else decision.success,
                miscue=ruling.miscue,
                ruling=ruling.text,
                fouls=[str(foul) for foul in ruling.fouls],
                gone=[ball for ball in state.balls if ball not in ruling.state.balls],
            )
        )
        self.tell(TurnStage.JUDGED, ruling.text, shot_id, {})
        self.state = ruling.state
        self._ask_agent(self.agent.saw, state, decision, ruling)
