"""
A turn of a game, played with the mechanical cue: decide, aim, arm, watch, judge.

The action `play_turn` plays a turn for whoever sends a goal.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, fields, replace
from functools import partial
import math
from time import monotonic
from traceback import format_exception
from typing import Any, TypeAlias, TypeVar

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import BallState, GameState, TurnShot
from billiard_shot_msgs.srv import PlaceBalls, RuleShot
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
import numpy as np
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.client import Client
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from billiard_shot import Stroke
from billiard_shot.cue.plan import GoalOutcome as Execution
from billiard_shot.cue.plan import RefusedError
from billiard_shot.game.rack import Agent, agent_names, decision_of, find_agent, scene_of
from billiard_shot.game.referee import choose, concede, judge
from billiard_shot.game.state import (
    Decision,
    find_game,
    game_names,
    Outcome,
    outcome_of,
    Ruling,
    State,
)
from billiard_shot.game.typed import Places, possible_rulings, ShotReport, told_outcome
from billiard_shot.perception.sightings import Balls, positions_of
from billiard_shot.ros.client import (
    CanceledError,
    escaped,
    NotReadyError,
    RobotClient,
    TableUnknownError,
    UNSEEN_TIME,
)
from billiard_shot.ros.conversions import filled, sightings_of
from billiard_shot.ros.node_runner import GoalHandle, LATCHED
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import InputError, Mistake, must_be_one_of, printable, refused
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.replay import from_json

# Fields of a state that the message does not have.
OF_THE_TABLE = ('length', 'width', 'radius', 'balls', 'time_left')
NOBODY = -1


def state_of(message: GameState, balls: Mapping[str, tuple[float, float]], scene: Scene) -> State:
    """
    Read the state of a game on the table of a scene, with the balls at their places (x, y) [m].

    A cue ball in hand is not on the table, wherever it lies. ValueError names all mistakes.
    """
    if scene.table is None:
        raise ValueError('scene: a game needs a table')
    values = _shared(message)
    for name in ('choices', 'groups', 'fouls', 'scores'):
        values[name] = tuple(np.asarray(values[name]).tolist())
    values['phase'] = message.phase or 'play'
    values['winner'] = None if message.winner == NOBODY else message.winner
    values['balls'] = {
        name: place for name, place in balls.items() if name != CUE_BALL or not message.in_hand
    }
    if not (CUE_BALL in values['balls'] or message.in_hand or message.choices or message.over):
        raise refused(sorted(balls), f'with {CUE_BALL!r}, which is not in hand', 'balls')
    if message.winner != NOBODY and not message.over:
        raise refused(message.winner, f'{NOBODY} while the rack is not over', 'winner')
    decisive = find_game(message.game).decisive
    if not (message.over or message.choices or decisive in ('', *balls)):
        raise refused(sorted(balls), f'with {decisive!r} while the rack is not over', 'balls')
    values['length'], values['width'] = scene.table.length, scene.table.width
    values['radius'] = scene.ball.radius
    return State(**values)


def game_state_message(state: State) -> GameState:
    """Message of the state of a game."""
    values = _shared(state)
    values['game'] = state.game.name
    values['winner'] = NOBODY if state.winner is None else state.winner
    return GameState(**{**values, 'choices': list(state.choices), 'groups': list(state.groups)})


def _shared(record: State | GameState) -> dict[str, Any]:
    """Fields that a state and its message have in common."""
    names = (each.name for each in fields(State) if each.name not in OF_THE_TABLE)
    return {name: getattr(record, name) for name in names}


def balls_message(balls: Mapping[str, tuple[float, float]]) -> list[BallState]:
    """Message of balls at rest at their places (x, y) [m]."""
    return [BallState(id=name, position=filled(Point, place)) for name, place in balls.items()]


def places_of(balls: Sequence[BallState]) -> dict[str, tuple[float, float]]:
    """Read the places (x, y) [m] of balls; ValueError for balls that cannot be."""
    return {name: ball.position for name, ball in sightings_of(balls).items()}


PLACE_TOLERANCE = 0.01  # m of a ball from its place; the player then decides for where it lies
PLACE_TIME = 600.0  # s in which balls are put somewhere by hand
FORGET_PERIOD = 2.0  # s between two calls that make a tracker forget the balls
FOUND_TIME = 10.0  # s in which a tracker finds balls again, or a client a simulated table
RULE_TIME = 60.0  # s that somebody has to state the outcome of a shot after a cancel
RECORD_TIME = 5.0  # s in which a simulated table publishes its record of a shot


class GameTable:
    """
    The table of a robot, for turns of games.

    It is made once for all turns, because the end of a subscription can deadlock other processes
    (Fast DDS 3.2).
    """

    def __init__(self, client: RobotClient, scene: Scene) -> None:
        self.client, self.scene = client, scene
        self.records: list[String] = []  # of a simulated table, as JSON
        client.create_subscription(String, 'table_sim/shot', self.records.append, LATCHED)
        self._place: Client[Any, Any] = client.create_client(PlaceBalls, 'table_sim/place')
        self._forget: Client[Any, Any] = client.create_client(Trigger, 'table_tracker/reset')
        self._forgot = -math.inf  # time of the last such call [s]

    def places_at_rest(self) -> Places:
        """Wait until all balls rest, see `RobotClient.wait_for_rest`; return their places [m]."""
        return positions_of(self.client.wait_for_rest(), self.scene)

    def after_shot(self, strike: Time) -> tuple[Places, list[str]]:
        """Wait until all balls that are seen rest; return their places [m], and the others."""
        balls = self.client.wait_for_rest(strike, unseen_time=UNSEEN_TIME)
        seen = {name: ball for name, ball in balls.items() if ball.is_seen}
        return positions_of(seen, self.scene), [name for name in balls if name not in seen]

    def are_found(self, names: Collection[str]) -> bool:
        """Whether each of these balls is seen, or known to have fallen into a pocket."""
        balls = self.client.balls()
        return all(name not in balls or balls[name].is_seen for name in names)

    def forget_all_but(self, left: Collection[str]) -> str:
        """
        Have a tracker forget balls that are gone; wait until it has found the others again.

        Return why the balls are not known then; '' if they are.
        """
        if not self._forget.service_is_ready():
            return 'table_tracker/reset is not there: balls that are gone stay in table_state'
        self.client.call(self._forget, Trigger.Request(), attempts=3)
        found = self.client.until(lambda: self.client.balls().keys() == set(left), FOUND_TIME)
        return '' if found else 'table_tracker does not find the balls that are left'

    def record(self) -> Outcome | None:
        """
        Outcome of the last shot by a simulated table; None if the table is not simulated.

        If the simulated table publishes none, or a wrong one, TableUnknownError says so.
        """
        if not self.client.count_publishers('table_sim/shot'):
            return None
        if not self.client.until(lambda: self.records, RECORD_TIME):
            raise TableUnknownError('table_sim/shot: no record of the shot')
        try:
            return outcome_of(from_json(self.records[-1].data))
        except ValueError as error:
            raise TableUnknownError(f'table_sim/shot: {error}') from None

    def arrange(self, state: State, tell: Callable[[str, Places], object]) -> tuple[State, Balls]:
        """
        Wait until the balls lie as a state says; return it with their real places, and the balls.

        If balls lie elsewhere, `tell` is called with a message and with the places of all balls.
        If these are not put in their places, or are not known, TableUnknownError says so.
        """
        seen = self.client.wait_for_rest()
        if moves := _moves(seen, state.balls):
            what = ', '.join(moves)
            if unseen := [name for name in state.balls if name not in seen]:
                what += f'; never seen so far: {", ".join(unseen)}'
                if self._forget.service_is_ready():
                    what += ' (are they in class_names of table_tracker?)'
            tell(f'put the balls in their places: {what}', state.balls)
            is_simulated = self._place.service_is_ready  # soon after the start it is not known yet
            self.client.until(lambda: is_simulated() or self._lie_at(state.balls), FOUND_TIME)
            if is_simulated():
                request = PlaceBalls.Request(balls=balls_message(state.balls))
                answer = self.client.call(self._place, request, attempts=3)
                if not answer.success:
                    raise TableUnknownError(f'table_sim/place: {answer.message}')
            if not self.client.until(lambda: self._lie_at(state.balls), PLACE_TIME):
                raise TableUnknownError(f'the balls were not put in their places: {what}')
            seen = self.client.wait_for_rest()
        try:
            return replace(state, balls=positions_of(seen, self.scene)), seen
        except ValueError as error:
            raise TableUnknownError(f'table_state: {error}') from None

    def _lie_at(self, wanted: Places) -> bool:
        """Whether the balls lie so; a tracker has to forget those that were taken away."""
        seen, now = self.client.balls(), monotonic()
        taken = [name for name, ball in seen.items() if not (ball.is_seen or name in wanted)]
        if taken and now - self._forgot > FORGET_PERIOD and self._forget.service_is_ready():
            self._forgot = now
            self._forget.call_async(Trigger.Request())
        return not _moves(seen, wanted)


def _moves(seen: Balls, wanted: Places) -> list[str]:
    """Say which balls have to be moved, and where to."""
    return [
        *(
            f'{name} at ({x:.3f}, {y:.3f}) m'
            for name, (x, y) in wanted.items()
            if name not in seen or math.dist(seen[name].position, (x, y)) > PLACE_TOLERANCE
        ),
        *(f'{name} off the table' for name in seen if name not in wanted),
    ]


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


class Question:
    """What somebody is asked about a shot, if pictures do not show it."""

    def __init__(self, client: RobotClient) -> None:
        self._client = client
        self._asked: tuple[str, State, Places] | None = None
        self._told: Outcome | None = None

    def ask(
        self, shot_id: str, state: State, places: Places, is_over: Callable[[], bool]
    ) -> Outcome | None:
        """Wait for an answer, see `Ask`; CanceledError if the client is canceled before."""
        self._told, self._asked = None, (shot_id, state, places)

        def ended() -> bool:
            return self._told is not None or is_over()

        try:
            self._client.until(lambda: self._client.is_canceled or ended(), math.inf)
            answered = self._client.until(ended, RULE_TIME)
        finally:
            self._asked = None
        if not answered:
            raise CanceledError(f'canceled, and nobody has ruled on {shot_id!r}')
        return self._told

    def answer(self, shot_id: str, told: ShotReport) -> None:
        """Take an answer; ValueError says what is wrong with it."""
        if self._asked is None or shot_id != self._asked[0]:
            feedback = 'that of a shot for which feedback asks'
            wanted = repr(self._asked[0]) if self._asked else feedback
            raise ValueError(f'shot_id must be {wanted}, got {shot_id!r}')
        self._told = told_outcome(*self._asked[1:], told)


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
                gone = outcome.gone if outcome else frozenset()
                # The tracker may still tell of a ball that has fallen.
                lying = {ball: place for ball, place in places.items() if ball not in gone}
                ruling = self._ruling(state, decision, shot_id, lying, unseen, outcome)
            self._judged(state, decision, ruling, shot_id)
            left = ruling.state.balls.keys() & lying.keys()
            if (unseen or lying != places) and (problem := self.table.forget_all_but(left)):
                self.tell(TurnStage.WATCH, problem, shot_id, {})
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


class TurnServer:
    """
    The action `play_turn` (billiard_shot_msgs/action/PlayTurn), one goal at a time.

    The service `~/rule_shot` (billiard_shot_msgs/srv/RuleShot) takes what somebody saw of a shot
    that the feedback asks for. Both are of the node of the client, which answers whenever it
    waits, as it does during nearly all of a turn. Goals may name the games and players of the
    package, and `modules`.
    """

    def __init__(self, table: GameTable, modules: Sequence[str] = ()) -> None:
        self._table, self._client, self._modules = table, table.client, modules
        self._goal: tuple[GoalHandle, Future[PlayTurn.Result]] | None = None
        self._question = Question(table.client)
        self._taken = False
        self._client.create_service(RuleShot, '~/rule_shot', self._rule)
        ActionServer(
            self._client,
            PlayTurn,
            'play_turn',
            self._execute,
            goal_callback=self._may_accept,
            cancel_callback=self._cancel,
        )
        action = self._client.resolve_topic_name('play_turn')
        self._client.get_logger().info(f'ready: action {action}')

    def serve(self) -> bool:
        """Play the turns of goals, until a signal ends the program."""
        while True:
            with self._client.to_the_end():  # a cancel may come too late for the turn before
                self._client.until(lambda: self._goal, math.inf)
            if self._goal:
                goal, ended = self._goal
                result = self._play(goal)
                self._goal = None
                ended.set_result(result)

    # --- requests -------------------------------------------------------------------------------

    def _may_accept(self, _: PlayTurn.Goal) -> GoalResponse:
        if self._taken:
            self._client.get_logger().warning('rejected a goal: a turn is being played')
            return GoalResponse.REJECT
        self._taken = True
        return GoalResponse.ACCEPT

    async def _execute(self, goal: GoalHandle) -> PlayTurn.Result:
        ended: Future[PlayTurn.Result] = Future(executor=self._client.executor)
        self._goal = goal, ended
        result = await ended
        self._taken = self._client.is_canceled = False
        assert result is not None
        if goal.is_cancel_requested and result.outcome == result.CANCELED:
            goal.canceled()
        elif result.outcome in (result.TURN_ENDED, result.OVER):
            goal.succeed()
        else:
            goal.abort()
        return result

    def _cancel(self, _: GoalHandle) -> CancelResponse:
        self._client.is_canceled = True
        return CancelResponse.ACCEPT

    def _rule(self, request: RuleShot.Request, response: RuleShot.Response) -> RuleShot.Response:
        try:
            if len(request.pocketed) != len(request.pockets):
                raise ValueError(
                    f'pockets must have {len(request.pocketed)} elements, as pocketed, got '
                    f'{len(request.pockets)}'
                )
            pockets = dict(zip(request.pocketed, request.pockets, strict=True))
            told = ShotReport(
                request.first_contact, request.to_cushion, pockets, request.double_hit
            )
            self._question.answer(request.shot_id, told)
            response.success = True
        except ValueError as error:
            response.message = str(error)
        return response

    # --- the turn -------------------------------------------------------------------------------

    def _play(self, goal: GoalHandle) -> PlayTurn.Result:
        request, log = goal.request, self._client.get_logger()

        def tell(stage: int, message: str, shot_id: str, balls: Places) -> None:
            log.info(printable(message))
            feedback = PlayTurn.Feedback(stage=stage, message=message, shot_id=shot_id)
            feedback.balls = balls_message(balls)
            goal.publish_feedback(feedback)

        try:
            for field, name, known in (
                ('state.game', request.state.game, game_names()),
                ('agent', request.agent.partition(':')[0], ['', *agent_names()]),
            ):
                if name not in (*known, *self._modules):
                    raise InputError([Mistake((field,), must_be_one_of(known, name))])
            self._client.wait_for_driver()
            places = places_of(request.balls) or self._table.places_at_rest()
            state = state_of(request.state, places, self._table.scene)
            agent = find_agent(request.agent or 'player')(self._table.scene, request.seed)
        except Exception as error:
            outcome, message = early_end(error, self._client)
            return PlayTurn.Result(
                outcome=outcome, message=message, state=request.state, balls=request.balls
            )
        ask = self._question.ask
        turn = Turn(self._table, agent, tell, ask, request.arm, state)
        outcome, message = turn.play()
        log.info(printable(message))
        return PlayTurn.Result(
            outcome=outcome,
            message=message,
            state=game_state_message(turn.state),
            balls=balls_message(turn.state.balls),
            shots=turn.shots,
        )
