"""The action `play_turn`: plays a turn of a game for whoever sends a goal."""

from collections.abc import Sequence
import math

from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.srv import RuleShot
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future

from billiard_shot.game.rack import agent_names, find_agent
from billiard_shot.game.state import game_names
from billiard_shot.game.typed import Places, ShotReport
from billiard_shot.ros.node_runner import GoalHandle
from billiard_shot.ros.turn import (
    balls_message,
    early_end,
    game_state_message,
    GameTable,
    places_of,
    Question,
    state_of,
    Turn,
)
from billiard_shot.scene.errors import InputError, Mistake, must_be_one_of, printable


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
