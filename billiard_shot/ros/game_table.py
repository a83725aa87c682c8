"""The table of a robot in a game: watches the balls, has them put in their places."""

from collections.abc import Callable, Collection
from dataclasses import replace
import math
from time import monotonic
from typing import Any

from billiard_shot_msgs.srv import PlaceBalls
from builtin_interfaces.msg import Time
from rclpy.client import Client
from std_msgs.msg import String
from std_srvs.srv import Trigger

from billiard_shot import Scene
from billiard_shot.game.outcome import Outcome, outcome_of
from billiard_shot.game.seen import Places
from billiard_shot.game.state import State
from billiard_shot.perception.lying import positions_of
from billiard_shot.perception.sightings import Balls
from billiard_shot.ros.client import RobotClient, TableUnknownError, UNSEEN_TIME
from billiard_shot.ros.game_conversions import balls_message
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.shot.replay import from_json

PLACE_TOLERANCE = 0.01  # m of a ball from its place; the player then decides for where it lies
PLACE_TIME = 600.0  # s in which balls are put somewhere by hand
FORGET_PERIOD = 2.0  # s between two calls that make a tracker forget the balls
FOUND_TIME = 10.0  # s in which a tracker finds balls again
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

    def places_at_rest(self, strike: Time | None = None) -> Places:
        """Wait until all balls rest, see `RobotClient.wait_for_rest`; return their places [m]."""
        return positions_of(self.client.wait_for_rest(strike), self.scene)

    def after_shot(self, strike: Time) -> tuple[Places, list[str]]:
        """Wait until all balls that are seen rest; return their places [m], and the others."""
        balls = self.client.wait_for_rest(strike, unseen_time=UNSEEN_TIME)
        seen = {name: ball for name, ball in balls.items() if ball.is_seen}
        return positions_of(seen, self.scene), [name for name in balls if name not in seen]

    def are_found(self, names: Collection[str]) -> bool:
        """Whether each of these balls is seen, or known to have fallen into a pocket."""
        balls = self.client.balls()
        return all(name not in balls or balls[name].is_seen for name in names)

    def forget_all_but(self, left: Collection[str]) -> None:
        """Have a tracker forget balls that are gone; wait until it has found the others again."""
        if self._forget.service_is_ready():
            self.client.call(self._forget, Trigger.Request(), attempts=3)
            self.client.until(lambda: self.client.balls().keys() == set(left), FOUND_TIME)

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
            if self._place.service_is_ready():
                request = PlaceBalls.Request(balls=balls_message(state.balls))
                answer = self.client.call(self._place, request)
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
