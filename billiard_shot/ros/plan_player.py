"""
Closes the loop: asks for a plan, plays it, and compares what came of it with the target.

    python -m billiard_shot.ros.plan_player

Needs what the player needs, and a planner, all with the same scene (`make demo` has them
simulated).
"""
from collections.abc import Sequence
import math

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import RankedPlan, Target
from geometry_msgs.msg import Point
import numpy as np
import rclpy
from rclpy.action import ActionClient

from billiard_shot import Scene, Stroke
from billiard_shot.ros import cue_conversions
from billiard_shot.ros.client import START_UP
from billiard_shot.ros.conversions import CUE_BALL, vectors
from billiard_shot.ros.player import play, play_rounds, Player

PLACES = ((0.5, -0.3), (-0.2, 0.5))
"""Where the cue ball has to come to rest, one after the other [m]."""

RADIUS = 0.1
"""How near to it [m]."""

NOISE = {'sigma_a': 2e-4, 'sigma_b': 2e-4, 'sigma_elevation': 4e-4, 'sigma_azimuth': 4e-4,
         'sigma_speed': 0.005}
"""How exactly the mechanism plays, with something to spare."""

LIMITS = {'speed_min': 0.2, 'speed_max': 2.0, 'elevation_max': 1.0, 'azimuth_range': math.pi,
          'offset_max': 0.35}
"""What it is asked to play: slower, lower and more central than what it can."""


class PlanPlayer(Player):
    """Player that asks a planner what to play."""

    def __init__(self, namespace: str = '') -> None:
        super().__init__(namespace)
        self._plan = ActionClient(self, PlanShot, 'plan_shot')

    def wait_for_all(self) -> None:
        """Wait for the planner too."""
        super().wait_for_all()
        if not self.until(self._plan.server_is_ready, START_UP):
            raise TimeoutError(f'no action plan_shot within {START_UP:g} s')

    def plan(self, place: tuple[float, float]) -> PlanShot.Result:
        """Ask for a stroke that brings the cue ball to rest near a place (x, y) [m]."""
        x, y = place
        sent = self._plan.send_goal_async(PlanShot.Goal(
            target=Target(kind=Target.REST, point=Point(x=x, y=y), radius=RADIUS),
            balls=self.table.balls, use_noise=True, **NOISE, use_limits=True, **LIMITS,
            budget=6000))
        rclpy.spin_until_future_complete(self, sent, timeout_sec=10.0)
        ended = sent.result().get_result_async()
        self.until(ended.done, 60.0)
        result = ended.result()
        if result.status != GoalStatus.STATUS_SUCCEEDED:
            raise RuntimeError(f'no plan: {result.result.message}')
        return result.result

    def stroke_of(self, best: RankedPlan) -> Stroke:
        """Stroke of a plan, at the cue ball where it lies now."""
        place, turn = best.cue_pose.position, best.cue_pose.orientation
        return Stroke.from_pose(
            (place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w), best.speed,
            (*cue_conversions.balls_of(self.table.balls)[CUE_BALL],
             vectors(best.trajectory.positions)[0][2].item()))


def play_plan(player: PlanPlayer, place: tuple[float, float], scene: Scene) -> bool:
    """Plan, play and compare; whether the cue ball rests where it should."""
    try:
        result = player.plan(place)
    except RuntimeError as error:
        print(f'to {place}: {error}')
        return False
    best = result.plans[0]
    print(f'cue ball to ({place[0]:g}, {place[1]:g}), within {1e3 * RADIUS:g} mm: planned in '
          f'{result.compute_time:.2f} s, {result.simulations} strokes simulated\n'
          f'  plan        {best.kind}, {100 * best.success:.0f} % sure '
          f'({100 * best.success_low:.0f} to {100 * best.success_high:.0f} %)')
    if not play(player, 'planned', player.stroke_of(best), scene):
        return False
    away = float(np.hypot(*(player.rest() - place)))
    print(f'  target      missed by {1e3 * away:.1f} mm: '
          f'{"reached" if away <= RADIUS else "not reached"}', flush=True)
    return away <= RADIUS


def main(args: Sequence[str] | None = None) -> None:
    """Play to all places."""
    play_rounds(PlanPlayer, play_plan, PLACES, 'plan_player', args)


if __name__ == '__main__':
    main()
