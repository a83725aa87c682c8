"""Between messages of the planner and the library: pure functions, each way."""
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import BallState, RankedPlan, Target
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from std_msgs.msg import Header

from billiard_shot import PlanResult, RankedStroke, Scene
from billiard_shot.cue.plan import tip_at
from billiard_shot.ros.conversions import CUE_BALL, FRAME, trajectory_message
from billiard_shot.ros.cue_conversions import pose_of
from billiard_shot.scene import Noise

LIMITS = ('speed_min', 'speed_max', 'elevation_min', 'elevation_max', 'azimuth', 'azimuth_range',
          'offset_max')
ANGLES = ('elevation_min', 'elevation_max', 'azimuth', 'azimuth_range')
SAMPLES = 200
"""Samples of a planned trajectory."""


@dataclass(frozen=True, slots=True)
class Task:
    """What `billiard_shot.plan` is asked for."""

    scene: Scene
    target: dict[str, Any]
    noise: Noise
    constraints: dict[str, Any]
    budget: int
    seed: int


def task_of(
    goal: PlanShot.Goal, default: Task, table: Sequence[BallState] | None
) -> Task:
    """
    Task that a goal asks for; what it leaves open is as in `default`, or on the table.

    Raises
    ------
    ValueError
        Naming the field, its value, and what is allowed. What the library checks is not checked
        here.

    """
    frame = goal.header.frame_id
    if frame not in ('', FRAME):
        raise ValueError(f'header.frame_id is {frame!r}: must be {FRAME!r}, or empty')
    scene = default.scene
    balls = goal.balls or table
    if balls:
        scene = with_balls(scene, balls)
    constraints = dict(default.constraints)
    if goal.use_limits:
        constraints = {name: getattr(goal, name) for name in LIMITS if name not in ANGLES}
        constraints |= {f'{name}_deg': math.degrees(getattr(goal, name)) for name in ANGLES}
    if goal.first_contact:
        constraints['first_contact'] = goal.first_contact
    noise = default.noise
    if goal.use_noise:
        noise = Noise(
            goal.sigma_a, goal.sigma_b, math.degrees(goal.sigma_elevation),
            math.degrees(goal.sigma_azimuth), goal.sigma_speed)
    target = target_of(goal.target) or default.target
    return Task(scene, target, noise, constraints, goal.budget or default.budget,
                goal.seed or default.seed)


def with_balls(scene: Scene, balls: Sequence[BallState]) -> Scene:
    """
    Scene with the balls where they are now.

    Raises
    ------
    ValueError
        For balls that cannot lie so; if there is no cue ball, or a name is there twice.

    """
    names = [ball.id for ball in balls]
    if len(set(names)) < len(names):
        raise ValueError(f'balls: each name must be there once, but they are {names}')
    places = {ball.id: (ball.position.x, ball.position.y) for ball in balls if not ball.pocketed}
    if CUE_BALL not in places:
        raise ValueError(f'balls: the cue ball, {CUE_BALL!r}, must be on the table')
    return replace(scene, balls=places)


def target_of(target: Target) -> dict[str, Any] | None:
    """Target in the form that `plan` takes; None for that of the node."""
    point = target.point.x, target.point.y
    found: dict[str, Any]
    match target.kind:
        case Target.DEFAULT:
            return None
        case Target.REST:
            found = {'rest': point}
        case Target.PASS:
            found = {'pass': point}
        case Target.GATE:
            return {'gate': (point, (target.other_point.x, target.other_point.y))}
        case Target.HIT:
            found = {'hit': target.ball}
            if target.use_direction:
                found['direction'] = target.direction.x, target.direction.y
                if target.within:
                    found['within_deg'] = math.degrees(target.within)
            if target.use_point:
                found['at'] = point
        case Target.POT:
            found = {'pot': target.ball, 'pocket': list(target.pockets) or 'any'}
            if target.use_point:
                found['leave'] = point
        case _:
            raise ValueError(f'target.kind is {target.kind}: must be one of its constants, 0 to 5')
    if target.radius:
        found['radius'] = target.radius
    return found


def result_of(result: PlanResult, task: Task | None, stamp: Time) -> PlanShot.Result:
    """Make the result of an action."""
    balls = {} if task is None else {CUE_BALL: task.scene.cue_ball[:2], **task.scene.balls}
    radius = 0.0 if task is None else task.scene.ball.radius
    return PlanShot.Result(
        status=int(result.status), message=result.message,
        plans=[ranked_message(each, stamp) for each in result.ranking],
        balls=[BallState(id=name, position=Point(x=float(x), y=float(y), z=radius))
               for name, (x, y) in balls.items()],
        simulations=result.simulations, compute_time=result.wall_time)


def ranked_message(planned: RankedStroke, stamp: Time) -> RankedPlan:
    """Message of a planned stroke."""
    a, b, elevation, azimuth, speed = planned.stroke.offsets
    low, high = planned.interval
    tip = tip_at(planned.stroke, planned.scene.cue_ball[:2], planned.scene)
    return RankedPlan(
        header=Header(frame_id=FRAME, stamp=stamp), kind=planned.kind,
        cue_pose=pose_of(tip.position, tip.quaternion), speed=speed, elevation=elevation,
        azimuth=azimuth, a=a, b=b, success=planned.success, success_low=low, success_high=high,
        trials=planned.trials, trajectory=trajectory_message(planned.shot.trajectory, SAMPLES))
