"""
Plan strokes for targets and play them: plan, execute, and compare with the target.

    ros2 run billiard_shot plan_player '{rest: [0.5, -0.3], radius: 0.1}'

Needs the nodes that the player needs, and a planner with the same scene as the cue_driver.
"""

import argparse
from collections.abc import Sequence
import math
from typing import Any

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import Target
from rclpy.action import ActionClient
import yaml

from billiard_shot.cue.sightings import Balls
from billiard_shot.planning.statistics import estimate_in_words
from billiard_shot.ros.plan_conversions import target_message
from billiard_shot.ros.player import (
    add_player_arguments,
    DEFAULT_VALIDITY,
    own_arguments,
    parser_of,
    play_shot,
    Player,
    run_player,
)
from billiard_shot.scene.placement import CUE_BALL

NOISE = {
    'sigma_a': 2e-4,
    'sigma_b': 2e-4,
    'sigma_elevation': 4e-4,
    'sigma_azimuth': 4e-4,
    'sigma_speed': 0.005,
}
"""Execution noise of the mechanism, with a margin."""

LIMITS = {'speed_min': 0.2, 'speed_max': 2.0, 'elevation_max_deg': 57.0, 'offset_max': 0.35}
"""Default limits of strokes, which are narrower than those of the mechanism."""

BUDGET = 6000
"""Default number of strokes to simulate."""

PLAN_TIMEOUT = 600.0
"""Time to wait for a plan [s]."""


class NoPlanError(RuntimeError):
    """The planner has found no stroke; the message says why."""


class PlanPlayer(Player):
    """Player that gets its strokes from a planner; its arguments are those of `Player`."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._plan: ActionClient[Any, Any, Any] = ActionClient(self, PlanShot, 'plan_shot')

    def wait_for_all(self) -> None:
        """Wait for the planner and for everything that a shot needs."""
        self.wait_for('action', 'plan_shot', self._plan.server_is_ready)
        super().wait_for_all()

    def plan(self, target: Target, **goal: Any) -> PlanShot.Result:
        """Plan for a target and the current balls; NoPlanError if no stroke is found."""
        response = self.act(
            'plan_shot',
            self._plan,
            PlanShot.Goal(target=target, balls=self.known_table().balls, **goal),
            lambda ended: self.until(ended.done, PLAN_TIMEOUT),
        )
        if response is None:
            raise NoPlanError(f'no plan within {PLAN_TIMEOUT:g} s')
        if response.status != GoalStatus.STATUS_SUCCEEDED:
            raise NoPlanError(response.result.message)
        return response.result


def play_target(
    player: PlanPlayer,
    text: str,
    limits: dict[str, Any] | None = None,
    arm: bool = True,
    valid_for: float = DEFAULT_VALIDITY,
) -> bool:
    """Plan for a target in YAML, play, and print the result; return False if it was missed."""
    target = _target_of(text)
    try:
        result = player.plan(target, use_noise=True, **NOISE, **goal_limits(limits or LIMITS))
    except NoPlanError as error:
        print(f'{text}: {error}', flush=True)
        return False
    best = result.plans[0]
    goal = player.goal_to_play(best.plan, valid_for)
    success = estimate_in_words(best.success, best.trials, (best.success_low, best.success_high))
    print(
        f'{text}: planned in {result.compute_time:.2f} s, {result.simulations} strokes '
        f'simulated\n'
        f'  plan        {best.kind}, success {success}'
    )
    if best.warning:
        print(f'  warning     {best.warning}')
    if not play_shot(player, 'planned', goal, arm):
        return False
    reached, words = judge(target, player.balls())
    print(f'  target      {words}', flush=True)
    return reached


def judge(target: Target, balls: Balls) -> tuple[bool, str]:
    """Judge by the balls at rest whether a target was reached; return that, and a sentence."""
    if CUE_BALL not in balls:
        return False, 'not reached: the cue ball is not on the table'
    if target.kind == Target.POT and target.ball in balls:
        return False, f'not reached: ball {target.ball!r} is still on the table'
    if target.kind == Target.REST or (target.kind == Target.POT and target.use_point):
        apart = math.dist(balls[CUE_BALL].position, (target.point.x, target.point.y))
        reached = apart <= target.radius
        return reached, (
            f'{"reached" if reached else "not reached"}: the cue ball rests {1e3 * apart:.1f} mm '
            f'from the point, {1e3 * target.radius:g} mm are allowed'
        )
    if target.kind == Target.POT:
        return True, f'reached: ball {target.ball!r} is pocketed'
    return True, 'not judged: the balls at rest do not show whether it was reached'


def goal_limits(limits: dict[str, Any]) -> dict[str, Any]:
    """Convert limits such as `LIMITS` to fields of a goal of `plan_shot`."""
    fields = {name: value for name, value in limits.items() if not name.endswith('_deg')}
    fields |= {
        name.removesuffix('_deg'): math.radians(value)
        for name, value in limits.items()
        if name.endswith('_deg')
    }
    return {'use_limits': True, 'azimuth_half_range': math.pi, 'budget': BUDGET, **fields}


def _target_of(text: str) -> Target:
    return target_message(yaml.safe_load(text))


def _checked(text: str) -> str:
    try:
        _target_of(text)
    except (ValueError, yaml.YAMLError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def _budget(text: str) -> int:
    number = int(text)
    if not 1 <= number < 2**32:
        raise argparse.ArgumentTypeError(f'{text} is not allowed; it must be at least 1')
    return number


def main(args: Sequence[str] | None = None) -> None:
    """Play to targets."""
    parser = parser_of('plan_player', __doc__)
    parser.add_argument(
        'targets',
        nargs='+',
        type=_checked,
        metavar='TARGET',
        help="YAML as in docs/planning.md, such as '{rest: [0.5, -0.3], radius: 0.1}' or "
        "'{pot: 8, pocket: any}'; several are played one after the other",
    )
    add_player_arguments(parser, scene=False)
    parser.add_argument(
        '--first-contact',
        default='',
        metavar='BALL',
        help='ball that the cue ball must contact first',
    )
    parser.add_argument(
        '--budget',
        type=_budget,
        default=BUDGET,
        metavar='N',
        help=f'largest number of strokes to simulate ({BUDGET})',
    )
    for name, text in (
        ('speed_min', 'speed of the slowest stroke in m/s'),
        ('speed_max', 'speed of the fastest stroke in m/s'),
        ('elevation_max_deg', 'elevation of the steepest stroke in degrees'),
        ('offset_max', 'largest offset of the tip in ball radii'),
    ):
        parser.add_argument(
            f'--{name.replace("_", "-")}',
            type=float,
            default=LIMITS[name],
            metavar='NUMBER',
            help=f'{text} ({LIMITS[name]:g})',
        )
    options = parser.parse_args(own_arguments(args))
    limits = {name: getattr(options, name) for name in (*LIMITS, 'budget', 'first_contact')}
    run_player(
        lambda: PlanPlayer(
            simulate_safety_inputs=options.simulate_safety_inputs, timeout=options.wait
        ),
        lambda player, text: play_target(player, text, limits, options.arm, options.valid_for),
        options.targets,
        'plan_player',
        args,
    )


if __name__ == '__main__':
    main()
