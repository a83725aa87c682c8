"""The action `play_turn`: plays a turn of a game for whoever sends a goal."""

from contextlib import suppress
from threading import Thread
from traceback import format_exception

from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.srv import RuleShot
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from billiard_shot import Scene
from billiard_shot.cue.lying import positions_of
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.seen import Places, told_outcome
from billiard_shot.game.state import State
from billiard_shot.ros.client import CanceledError, NotReadyError, RobotClient, TableUnknownError
from billiard_shot.ros.game_conversions import balls_message, game_state_message, state_of
from billiard_shot.ros.node_runner import GoalHandle
from billiard_shot.ros.turn import AgentError, make_agent, Turn

FOR_EVER = float('inf')


class TurnServer(Node):
    """
    Node with the action `play_turn` (billiard_shot_msgs/action/PlayTurn), one goal at a time.

    The service `~/rule_shot` (billiard_shot_msgs/srv/RuleShot) takes what somebody saw of a shot
    that the feedback asks for. `serve` plays the turns, in the thread that calls it; the node
    itself is spun in a thread of its own, so that it answers meanwhile.

    Parameters
    ----------
    client : RobotClient
        Does what a turn needs; it is spun by `serve`.
    scene : Scene
        Table and cue of the robot.

    """

    def __init__(self, client: RobotClient, scene: Scene) -> None:
        super().__init__('player', namespace=client.get_namespace())
        self._client, self._scene = client, scene
        self._goal: GoalHandle | None = None
        self._result: Future[PlayTurn.Result] | None = None
        self._asked: tuple[str, State, Places] | None = None
        self._told: Outcome | None = None
        self._taken = False
        self.create_service(RuleShot, '~/rule_shot', self._rule)
        ActionServer(
            self,
            PlayTurn,
            'play_turn',
            self._execute,
            goal_callback=self._may_accept,
            cancel_callback=self._cancel,
        )
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._thread = Thread(target=self._executor.spin)
        self._thread.start()
        self.get_logger().info(f'ready: action {self.resolve_topic_name("play_turn")}')

    def serve(self) -> bool:
        """Play the turns of goals, until a signal ends the program."""
        try:
            while True:
                self._serve_one()
        finally:  # a thread that still waits in the middleware would crash the end of Python
            self._executor.shutdown()
            self._thread.join()

    def _serve_one(self) -> None:
        """Wait for a goal, if there is none yet, and play its turn."""
        with suppress(CanceledError):  # too late for the turn before
            self._client.until(lambda: self._goal, FOR_EVER)
        if self._goal is None or self._result is None:
            return
        result, ended = self._play(self._goal), self._result
        self._goal, self._client.is_canceled = None, False
        ended.set_result(result)
        self._executor.wake()

    # --- requests -------------------------------------------------------------------------------

    def _may_accept(self, _: PlayTurn.Goal) -> GoalResponse:
        if self._taken:
            self.get_logger().warning('rejected a goal: a turn is being played')
            return GoalResponse.REJECT
        self._taken = True
        return GoalResponse.ACCEPT

    async def _execute(self, goal: GoalHandle) -> PlayTurn.Result:
        self._result = Future(executor=self._executor)
        ended = self._result
        self._goal = goal  # last: the other thread waits for it
        result = await ended
        self._taken = False
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
        asked = self._asked
        try:
            if asked is None or request.shot_id != asked[0]:
                wanted = repr(asked[0]) if asked else 'that of a shot for which feedback asks'
                raise ValueError(f'shot_id must be {wanted}, got {request.shot_id!r}')
            if len(request.pocketed) != len(request.pockets):
                raise ValueError(
                    f'pockets must have {len(request.pocketed)} elements, as pocketed, got '
                    f'{len(request.pockets)}'
                )
            _, state, places = asked
            pockets = dict(zip(request.pocketed, request.pockets, strict=True))
            self._told = told_outcome(
                state,
                places,
                request.first_contact,
                request.to_cushion,
                pockets,
                request.double_hit,
            )
            response.success = True
        except ValueError as error:
            response.message = str(error)
        return response

    # --- the turn -------------------------------------------------------------------------------

    def _play(self, goal: GoalHandle) -> PlayTurn.Result:
        request = goal.request

        def tell(stage: int, message: str, shot_id: str, balls: Places) -> None:
            self.get_logger().info(message)
            goal.publish_feedback(
                PlayTurn.Feedback(
                    stage=stage, message=message, shot_id=shot_id, balls=balls_message(balls)
                )
            )

        try:
            self._client.wait_for_driver()
            balls = positions_of(self._client.wait_for_rest(), self._scene)
            state = state_of(request.state, balls, self._scene)
            agent = make_agent(request.agent or 'player', self._scene, request.seed)
        except CanceledError:
            return _failed(PlayTurn.Result.CANCELED, 'canceled', goal)
        except TableUnknownError as error:
            return _failed(PlayTurn.Result.TABLE_UNKNOWN, str(error), goal)
        except AgentError as error:
            self.get_logger().error(''.join(format_exception(error.__cause__)))
            return _failed(PlayTurn.Result.AGENT_FAILED, str(error), goal)
        except (NotReadyError, TimeoutError) as error:
            return _failed(PlayTurn.Result.NOT_READY, str(error), goal)
        except ValueError as error:
            return _failed(PlayTurn.Result.INVALID, str(error), goal)
        turn = Turn(
            self._client,
            self._scene,
            agent,
            tell,
            self._ask,
            lambda: bool(request.arm),
            state=state,
        )
        outcome, message = turn.play()
        self.get_logger().info(message)
        return PlayTurn.Result(
            outcome=outcome,
            message=message,
            state=game_state_message(turn.state),
            balls=balls_message(turn.state.balls),
            shots=turn.shots,
        )

    def _ask(self, shot_id: str, state: State, places: Places) -> Outcome:
        self._told, self._asked = None, (shot_id, state, places)
        try:
            self._client.until(lambda: self._told, FOR_EVER)
        finally:
            self._asked = None
        assert self._told
        return self._told


def _failed(outcome: int, message: str, goal: GoalHandle) -> PlayTurn.Result:
    return PlayTurn.Result(outcome=outcome, message=message, state=goal.request.state)
