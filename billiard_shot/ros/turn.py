"""
A turn of a game, played with the mechanical cue: decide, aim, arm, watch, judge.

A simulated table tells what each shot did. With a camera the ruling follows from the places of the
balls where these are enough; otherwise somebody is asked.
"""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
import math
from time import monotonic
from traceback import format_exception
from typing import Any, TypeAlias, TypeVar

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import TurnShot
from billiard_shot_msgs.srv import PlaceBalls
from rclpy.client import Client
from std_msgs.msg import String
from std_srvs.srv import Trigger

from billiard_shot import Scene, Stroke
from billiard_shot.cue.lying import positions_of
from billiard_shot.cue.outcome import GoalOutcome as Execution
from billiard_shot.cue.outcome import RefusedError
from billiard_shot.cue.sightings import Balls
from billiard_shot.game.agent import Agent, scene_of
from billiard_shot.game.call import Decision
from billiard_shot.game.outcome import Outcome, outcome_of
from billiard_shot.game.referee import choose, concede, judge
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.seen import Places, possible_rulings
from billiard_shot.game.state import State
from billiard_shot.game.tournament import find_agent
from billiard_shot.ros.client import (
    CanceledError,
    NotReadyError,
    RobotClient,
    short_id,
    TableUnknownError,
)
from billiard_shot.ros.game_conversions import balls_message, shot_message
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.shot.replay import from_json

PLACE_TOLERANCE = 0.01
"""Largest distance of a ball from its place [m]; the player then decides for where it lies."""

PLACE_TIME = 600.0
"""Longest time in which balls are put somewhere by hand [s]."""

FORGET_PERIOD = 2.0
"""Time between two calls that make a tracker forget the balls [s]."""

RECORD_TIME = 5.0
"""Longest time in which a simulated table publishes its record of a shot [s]."""

T = TypeVar('T')

TurnStage = PlayTurn.Feedback
Tell: TypeAlias = Callable[[int, str, str, Places], object]
"""Called with the stage, a message, the id of the shot, and the balls of the stage PLACE."""

Ask: TypeAlias = Callable[[str, State, Places], Outcome]
"""Called with the id of a shot, the state before it, and the places of the balls after it [m]."""


class NotPlayedError(RuntimeError):
    """The driver has refused or ended a shot; the message says why."""


class AgentError(RuntimeError):
    """The agent has failed; the message says how, and `__cause__` where."""


@dataclass
class Turn:
    """
    A turn that is played.

    Parameters
    ----------
    client : RobotClient
    scene : Scene
        Table and cue of the robot.
    agent : Agent
    tell : callable
        See `Tell`.
    ask : callable
        Asks somebody what a shot did, see `Ask`.
    may_fire : callable
        Whether to arm a shot; it is called again and again while the cue is aimed.
    state : State
        Before the next shot.
    shots : list of TurnShot
        What has been played.

    """

    client: RobotClient
    scene: Scene
    agent: Agent
    tell: Tell
    ask: Ask
    may_fire: Callable[[], bool]
    state: State
    shots: list[TurnShot] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._records: list[String] = []
        self._listening = self.client.create_subscription(
            String, 'table_sim/shot', self._records.append, LATCHED
        )
        self._place: Client[Any, Any] = self.client.create_client(PlaceBalls, 'table_sim/place')
        self._forget: Client[Any, Any] = self.client.create_client(Trigger, 'table_tracker/reset')
        self._forgot = -math.inf  # time of the last such call [s]

    def play(self) -> tuple[int, str]:
        """Play until the turn ends; return the outcome of `PlayTurn.Result`, and a message."""
        result, player = PlayTurn.Result, self.state.player
        try:
            while not self.state.over and self.state.player == player:
                self._go_on()
        except CanceledError:
            return result.CANCELED, 'canceled'
        except NotPlayedError as error:
            return result.NOT_PLAYED, str(error)
        except AgentError as error:
            self.client.get_logger().error(''.join(format_exception(error.__cause__)))
            return result.AGENT_FAILED, str(error)
        except TableUnknownError as error:
            return result.TABLE_UNKNOWN, str(error)
        except (NotReadyError, TimeoutError) as error:
            return result.NOT_READY, str(error)
        finally:
            self.client.destroy_subscription(self._listening)
            self.client.destroy_client(self._place)
            self.client.destroy_client(self._forget)
        if not self.state.over:
            return result.TURN_ENDED, f'player {self.state.player} is next'
        winner = self.state.winner
        return result.OVER, 'nobody wins' if winner is None else f'player {winner} wins'

    def _go_on(self) -> None:
        """Take a choice, or play a shot; change the state."""
        state = self.state
        self.tell(TurnStage.DECIDE, f'player {state.player} decides', '', {})
        if state.places_cue_ball:
            x, y = self._ask_agent(_place, state)
            if why := state.no_place(x, y):
                self._judged(state, Decision(), concede(state, f'{(x, y)}: {why}'), '')
                return
            state = state.with_cue_ball(x, y)
        wanted = state
        if not state.choices:
            state = self._arranged(wanted)
        decision = self._ask_agent(_decide, wanted)
        if state.balls != wanted.balls:  # an agent may decide when it places the cue ball
            decision = self._ask_agent(_decide, state)
        if decision.choice not in (state.choices or ('',)):
            why = f'{decision.choice!r} is not a choice'
            self._judged(state, Decision(), concede(state, why), '')
        elif decision.choice:
            self.state = choose(state, decision.choice)
        elif decision.stroke is None:
            self._judged(state, decision, judge(state, decision.call, None), '')
        else:
            self._shoot(state, decision, decision.stroke)

    def _ask_agent(self, ask: Callable[..., T], *arguments: Any) -> T:
        """Ask the agent in a thread, so that the client goes on, and can be canceled."""
        pool = ThreadPoolExecutor(1)
        answer = pool.submit(ask, self.agent, *arguments)
        pool.shutdown(wait=False)
        self.client.until(answer.done, math.inf)
        if error := answer.exception():
            raise AgentError(f'the agent has failed: {error!r}') from error
        return answer.result()

    def _shoot(self, state: State, decision: Decision, stroke: Stroke) -> None:
        """Play a stroke, watch the balls, and judge."""
        shot_id = f'{state.game} {state.shots + 1} {short_id()}'
        try:
            goal = self.client.goal(stroke, scene_of(self.scene, state), shot_id)
        except RefusedError as error:
            raise NotPlayedError(str(error)) from None
        self.tell(TurnStage.PLAY, decision.reason or 'plays', shot_id, {})
        self._records.clear()
        answer = self.client.execute(goal, self.may_fire)
        if answer.status != GoalStatus.STATUS_SUCCEEDED:
            name = Execution(answer.result.outcome).name
            raise NotPlayedError(f'{name}: {answer.result.message}')
        self.tell(TurnStage.WATCH, 'the balls roll', shot_id, {})
        seen = self.client.wait_for_rest(answer.result.strike.header.stamp)
        places = positions_of(seen, self.scene)
        self._judged(state, decision, self._ruling(state, decision, shot_id, places), shot_id)

    def _ruling(self, state: State, decision: Decision, shot_id: str, places: Places) -> Ruling:
        if self.client.count_publishers('table_sim/shot'):
            if not self.client.until(lambda: self._records, RECORD_TIME):
                raise TableUnknownError('table_sim/shot: no record of the shot')
            outcome = outcome_of(from_json(self._records[-1].data))
            return judge(state, decision.call, replace(outcome, places=places))
        found = possible_rulings(state, decision.call, places)
        if len(found) == 1:
            return found[0]
        rulings = ' or '.join(f'"{each.text}"' for each in found)
        self.tell(TurnStage.RULE, f'pictures do not show how to rule: {rulings}', shot_id, {})
        return judge(state, decision.call, self.ask(shot_id, state, places))

    def _judged(self, state: State, decision: Decision, ruling: Ruling, shot_id: str) -> None:
        gone = [ball for ball in state.balls if ball not in ruling.state.balls]
        self.shots.append(shot_message(shot_id, decision.reason, decision.success, ruling, gone))
        self.tell(TurnStage.JUDGED, ruling.text, shot_id, {})
        self.state = ruling.state
        self._ask_agent(_tell, state, decision, ruling)

    # --- the table ------------------------------------------------------------------------------

    def _arranged(self, state: State) -> State:
        """Wait until the balls lie as a state says; return the state with their real places."""
        seen = self.client.wait_for_rest()
        if _apart(seen, state.balls):
            what = ', '.join(
                [
                    *(f'{name} at ({x:.3f}, {y:.3f}) m' for name, (x, y) in _moves(seen, state)),
                    *(f'{name} off the table' for name in seen if name not in state.balls),
                ]
            )
            self.tell(TurnStage.PLACE, f'put the balls in their places: {what}', '', state.balls)
            if self._place.service_is_ready():
                self._place_simulated(state.balls)
            if not self.client.until(lambda: self._lie_at(state.balls), PLACE_TIME):
                raise TableUnknownError(f'the balls were not put in their places: {what}')
            seen = self.client.wait_for_rest()
        try:
            return replace(state, balls=positions_of(seen, self.scene))
        except ValueError as error:
            raise TableUnknownError(f'table_state: {error}') from None

    def _lie_at(self, wanted: Places) -> bool:
        """Whether the balls lie so; a tracker has to forget those that were taken away."""
        seen, now = self.client.balls(), monotonic()
        taken = [name for name, ball in seen.items() if not (ball.is_seen or name in wanted)]
        if taken and now - self._forgot > FORGET_PERIOD and self._forget.service_is_ready():
            self._forgot = now
            self._forget.call_async(Trigger.Request())
        return not _apart(seen, wanted)

    def _place_simulated(self, balls: Places) -> None:
        request = PlaceBalls.Request(balls=balls_message(balls))
        answer = self.client.answer(self._place.call_async(request), 'table_sim/place')
        if not answer.success:
            raise TableUnknownError(f'table_sim/place: {answer.message}')


def make_agent(name: str, scene: Scene, seed: int) -> Agent:
    """
    Make an agent.

    Raises
    ------
    ValueError
        If there is no such agent.
    AgentError
        If its module or its function `make` fails.

    """
    try:
        return find_agent(name)(scene, seed)
    except ValueError:
        raise
    except Exception as error:
        raise AgentError(f'agent {name!r} has failed: {error!r}') from error


def _place(agent: Agent, state: State) -> tuple[float, float]:
    x, y = map(float, agent.place(state))
    return x, y


def _decide(agent: Agent, state: State) -> Decision:
    found: Any = agent.decide(state)
    if not isinstance(found, Decision):
        raise TypeError(f'decide must return a Decision, got {found!r}')
    return found


def _tell(agent: Agent, state: State, decision: Decision, ruling: Ruling) -> None:
    agent.saw(state, decision, ruling)


def _moves(seen: Balls, state: State) -> list[tuple[str, tuple[float, float]]]:
    """Balls that lie elsewhere, with the places where they belong [m]."""
    return [(name, place) for name, place in state.balls.items() if _is_off(seen, name, place)]


def _is_off(seen: Balls, name: str, place: tuple[float, float]) -> bool:
    there = seen.get(name)
    return there is None or math.dist(there.position, place) > PLACE_TOLERANCE


def _apart(seen: Balls, wanted: Mapping[str, tuple[float, float]]) -> bool:
    """Whether a ball lies elsewhere, is missing, or should not be there."""
    return seen.keys() != wanted.keys() or any(
        _is_off(seen, name, place) for name, place in wanted.items()
    )
