"""
Play shots with the mechanical cue: for targets, given strokes, or a turn of a game.

    ros2 run billiard_shot player '{rest: [0.5, -0.3], radius: 0.1}'
    ros2 run billiard_shot player --b 0.3 --speed 0.5
    ros2 run billiard_shot player --game practice --balls 3

Needs an active cue_driver, a mechanism, and a node that publishes table_state; for strokes and
targets also a predictor, and for targets a planner. With `--serve` it is the node with the action
`play_turn` (billiard_shot_msgs/action/PlayTurn).
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import ExecuteShot, PlayTurn
from billiard_shot_msgs.srv import PredictShot

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cli.options import add_options, check_options, option, positional
from billiard_shot.cli.shots import STROKE_OPTIONS, strokes_from_options, strokes_given
from billiard_shot.cue.plan import GoalOutcome, RefusedError
from billiard_shot.game.rack import Agent, find_agent
from billiard_shot.game.referee import start
from billiard_shot.game.state import State
from billiard_shot.game.typed import OUTCOME_HELP, Places, read_outcome
from billiard_shot.planning.problem import Target
from billiard_shot.planning.statistics import estimate_in_words
from billiard_shot.ros import conversions
from billiard_shot.ros.client import (
    CLIENT_HELP,
    FIRE,
    LOOK_PERIOD,
    OfClient,
    RobotClient,
    run_client,
    say,
    TypedLines,
    UNSEEN_TIME,
    VALIDITY,
)
from billiard_shot.ros.node_runner import own_arguments, parser_of
from billiard_shot.ros.parameters import within_mechanism
from billiard_shot.ros.plan_conversions import target_in, target_message
from billiard_shot.ros.turn import (
    AIMED,
    game_state_message,
    GameTable,
    Question,
    state_of,
    Turn,
    TurnServer,
)
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.scene.placement import CUE_BALL

WORDS = {
    PlayTurn.Feedback.PLACE: 'place',
    PlayTurn.Feedback.PLAY: 'plays',
    PlayTurn.Feedback.RULE: 'unknown',
    PlayTurn.Feedback.JUDGED: 'ruling',
}


@dataclass(frozen=True)
class OfTurn:
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


MAX_VALIDITY = 3600.0  # s within which a shot must be fired
MAX_BUDGET = 2**32 - 1  # strokes to simulate; no larger number fits into a goal


def play_shot(client: RobotClient, name: str, goal: ExecuteShot.Goal, arm: bool) -> bool:
    """Play one shot and print its prediction and outcome; return False if it was not played."""
    plan = goal.plan
    answer = client.predict(
        PredictShot.Request(cue_pose=plan.cue_pose, speed=plan.speed, use_table_state=True)
    )
    status = Status(answer.status)
    say(f'{name}: {plan.speed:g} m/s, elevation {plan.elevation + 0.0:g} rad')
    places = (f'{each.id} ({each.position.x:.3f}, {each.position.y:.3f})' for each in plan.balls)
    say(f'  balls       {", ".join(places)} m')
    if status.refused:
        say(f'  predicted   {status.name}: {answer.message}')
        return False
    if answer.miscue:
        say('  warning     a miscue: the tip will slide on the ball')

    typed = TypedLines()

    def tell_how_to_fire() -> None:
        if arm:
            return
        while typed.next() is not None:
            pass  # a word that was typed before does not fire
        service = client.resolve_service_name('cue_driver/arm')
        say(
            f'  aimed       to fire, type {FIRE} and Enter, or: ros2 service call {service} '
            f'billiard_shot_msgs/srv/Arm "{{shot_id: {plan.shot_id}}}"'
        )

    response = client.execute(goal, lambda: arm or typed.next() == FIRE, tell_how_to_fire)
    result = response.result
    executed = f'  executed    {GoalOutcome(result.outcome).name}: {result.message}'
    if response.status != GoalStatus.STATUS_SUCCEEDED:
        say(executed)
        return False
    speed = result.strike.speed
    if result.measured:
        executed += (
            f': {speed:.4f} m/s ({100 * (speed / plan.speed - 1):+.3f} %), '
            f'elevation {result.elevation:.5f} rad'
        )
    say(executed)
    balls = client.wait_for_rest(result.strike.header.stamp, unseen_time=UNSEEN_TIME)
    if CUE_BALL not in balls or not balls[CUE_BALL].is_seen:
        say('  outcome     the cue ball is not on the table')
    else:
        x, y = balls[CUE_BALL].position
        expected = conversions.vectors(answer.trajectory.positions)[-1]
        apart = math.dist((x, y), expected[:2])
        there = f'({x:.4f}, {y:.4f}) m'
        say(f'  outcome     rests at {there}, {1e3 * apart:.2f} mm from the prediction')
    return True


def play_stroke(
    client: RobotClient, name: str, stroke: Stroke, scene: Scene, options: argparse.Namespace
) -> bool:
    """Play a given stroke and print the result; return False if it was not played."""
    try:
        goal = client.goal(stroke, client.balls(), scene, name, options.valid_for)
        goal.allow_miscue = options.allow_miscue
    except RefusedError as error:
        say(f'{name}: {error}')
        return False
    return play_shot(client, name, goal, options.arm)


def play_target(
    client: RobotClient, text: str, target: Target, options: argparse.Namespace
) -> bool:
    """Plan for a target, play, and print the result; return False if it was missed."""
    answer = client.plan(target_message(target), options.budget or 0)
    result = answer.result
    if answer.status != GoalStatus.STATUS_SUCCEEDED:
        say(f'{text}: {result.message}')
        return False
    best = result.plans[0]
    success = estimate_in_words(best.success, best.trials, (best.success_low, best.success_high))
    say(
        f'{text}: {best.kind}, success {success}; {result.simulations} strokes simulated in '
        f'{result.compute_time:.2f} s'
    )
    if best.warning:
        say(f'  warning     {best.warning}')
    goal = client.goal_to_play(best.plan, options.valid_for)
    if not play_shot(client, '  planned', goal, options.arm):
        return False
    places = {name: ball.position for name, ball in client.balls().items()}
    reached, words = target.judged_at_rest(places)
    say(f'  target      {words}')
    return reached


# --- the program --------------------------------------------------------------------------------


def _target(text: str) -> tuple[str, Target]:
    try:
        target = target_in(text)
        target_message(target)  # refuses targets that the action does not take
        return text, target
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


@dataclass(frozen=True)
class OfPlayer:
    """
    Targets, and how shots are fired.

    Parameters
    ----------
    targets : TARGET
        YAML as in docs/planning.md, such as '{rest: [0.5, -0.3], radius: 0.1}' or
        '{pot: 8, pocket: any}'; strokes are played first, then the targets, then the game.
    mechanism : FILE
        Mechanism of the driver; games keep to its limits and those of the scene's robot.
    allow_miscue : bool
        Play a stroke in which the tip is predicted to slide on the ball.
    budget : N
        Largest number of strokes to simulate for a plan (the planner's parameter).
    arm : bool
        Fire each shot as soon as it is aimed, unasked.
    valid_for : S
        Time in seconds within which a shot must be fired (%(default)g).
    simulate_safety_inputs : bool
        Publish that the emergency stop is released and the interlock closed; only for simulations;
        refused if another node publishes one of them.

    """

    targets: list[tuple[str, Target]] = positional('*', type=_target)
    mechanism: str = ''
    allow_miscue: bool = False
    budget: int | None = whole_number(minimum=1, maximum=MAX_BUDGET, default=None)
    arm: bool = False
    valid_for: float = number('s', above=0, maximum=MAX_VALIDITY, default=VALIDITY)
    simulate_safety_inputs: bool = False


def main(args: Sequence[str] | None = None) -> None:
    """Play shots."""
    parser = parser_of('player', __doc__, CLIENT_HELP)
    add_options(parser, *STROKE_OPTIONS, OfClient(), OfTurn(), OfPlayer())
    options = parser.parse_args(own_arguments(args))
    plays_game = bool(options.game or options.state)
    plays = strokes_given(options) or options.targets or plays_game
    if options.serve and plays:
        parser.error('--serve must not be given together with a stroke, a TARGET or a game')
    strokes: dict[str, Stroke] = {}
    game = None
    try:
        check_options(options, parser)
        scene = within_mechanism(Scene.load(options.scene), options.mechanism)
        if strokes_given(options) or not (plays or options.serve):  # without any: an error
            strokes = strokes_from_options(options, scene)
        if plays_game:
            game = first_turn(options, scene)
    except (ValueError, OSError) as error:
        parser.error(str(error))

    def work(client: RobotClient) -> bool:
        table = GameTable(client, scene)
        if options.serve:
            return TurnServer(table, options.modules).serve()
        if options.targets:
            client.wait_for_planner()
        if options.targets or strokes:
            client.wait_for_predictor()
        client.wait_for_driver()
        return (
            all(play_stroke(client, *named, scene, options) for named in strokes.items())
            and all(play_target(client, text, target, options) for text, target in options.targets)
            and (game is None or play_turn(table, *game, options))
        )

    run_client(
        'player',
        args,
        work,
        serves=options.serve,
        simulate_safety_inputs=options.simulate_safety_inputs,
        timeout=options.wait,
    )
