"""Conversions between messages of the planner and the library: pure functions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
import re
from typing import Any

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import RankedPlan, TableState, Target
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import Header

from billiard_shot import PlanResult, Scene
from billiard_shot.cue.sightings import Balls, Sighting
from billiard_shot.planning import targets
from billiard_shot.ros.conversions import (
    check_frame,
    scene_of,
    sightings_of,
    table_scene,
    trajectory_message,
)
from billiard_shot.ros.cue_conversions import plan_message, plan_of
from billiard_shot.ros.parameters import MAX_SAMPLES
from billiard_shot.scene import Noise
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.values import one_or_many

LIMITS = (
    'speed_min',
    'speed_max',
    'elevation_min',
    'elevation_max',
    'azimuth',
    'azimuth_half_range',
    'offset_max',
)
# Limits that are angles: fields of a goal, in radians, and of `Robot`, in degrees.
ANGLES = {
    'elevation_min': 'elevation_min_deg',
    'elevation_max': 'elevation_max_deg',
    'azimuth': 'azimuth_deg',
    'azimuth_half_range': 'azimuth_half_range_deg',
}

NOISE_FIELDS = {
    'a': 'sigma_a',
    'b': 'sigma_b',
    'elevation_deg': 'sigma_elevation',
    'azimuth_deg': 'sigma_azimuth',
    'speed': 'sigma_speed',
}
LIMIT_FIELDS = {limit: name for name, limit in ANGLES.items()}
TARGET_FIELDS = {
    **dict.fromkeys(('hit', 'pot'), 'target.ball'),
    **dict.fromkeys(('rest', 'pass', 'at', 'leave'), 'target.point'),
    'gate': 'target.point, target.other_point',
    'pocket': 'target.pockets',
    'direction': 'target.direction',
    'direction_tolerance_deg': 'target.within',
    'radius': 'target.radius',
}
"""Fields of a goal, by the names that the library uses in its messages."""


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """Arguments of `billiard_shot.plan`."""

    scene: Scene
    target: dict[str, Any]
    noise: Noise
    constraints: dict[str, Any]
    budget: int
    seed: int
    time_limit: float | None = None  # s
    balls: Balls = field(default_factory=dict)  # as they were seen; empty: those of the scene


def plan_request_of(
    goal: PlanShot.Goal, default: PlanRequest, table: TableState | None, frame: str
) -> PlanRequest:
    """
    Make the request for a goal; missing values are those of `default` or of the table state.

    Raises
    ------
    ValueError
        With the field, its value, and the allowed range. Fields that the library checks are not
        checked here.

    """
    if goal.sample_count > MAX_SAMPLES:
        raise ValueError(f'sample_count is {goal.sample_count}: must be at most {MAX_SAMPLES}')
    check_frame('header.frame_id', goal.header, frame)
    scene, balls = default.scene, {}
    if goal.balls:
        scene, balls = scene_of(scene, goal.balls), sightings_of(goal.balls)
    elif table is not None:
        scene = table_scene(scene, table, frame)
        balls = sightings_of(table.balls, table.header.stamp)
    constraints = dict(default.constraints)
    if goal.use_limits:
        constraints = {name: getattr(goal, name) for name in LIMITS if name not in ANGLES}
        constraints |= {limit: math.degrees(getattr(goal, name)) for name, limit in ANGLES.items()}
    if goal.keep:
        constraints['keep'] = names_in(goal.keep)
    elif 'keep' in default.constraints:
        kept = one_or_many(default.constraints['keep'])
        constraints['keep'] = [name for name in kept if name in scene.balls]
    if goal.first_contact:
        constraints['first_contact'] = names_in(goal.first_contact)
    noise = default.noise
    if goal.use_noise:
        try:
            noise = Noise(
                goal.sigma_a,
                goal.sigma_b,
                math.degrees(goal.sigma_elevation),
                math.degrees(goal.sigma_azimuth),
                goal.sigma_speed,
            )
        except ValueError as error:
            raise ValueError(_renamed(str(error), NOISE_FIELDS)) from None
    target = target_of(goal.target) or default.target
    return PlanRequest(
        scene,
        target,
        noise,
        constraints,
        goal.budget or default.budget,
        goal.seed or default.seed,
        goal.time_limit or default.time_limit,
        balls,
    )


def in_fields(message: str, goal: PlanShot.Goal) -> str:
    """
    Replace names in a message of `plan` by the fields of a goal.

    If the goal leaves the target or the limits to the node's parameters, the names of the
    parameters stay.
    """
    if goal.target.kind != Target.DEFAULT and message.startswith('target: '):
        return _renamed(message.removeprefix('target: '), TARGET_FIELDS)
    if message.startswith('constraints: '):
        names = LIMIT_FIELDS if goal.use_limits else {}
        return _renamed(message.removeprefix('constraints: '), names)
    return message


def _renamed(message: str, names: dict[str, str]) -> str:
    """Replace the name at the start of each line."""
    return re.sub(
        r'^( *)(\w+)(?=: )',
        lambda found: found[1] + names.get(found[2], found[2]),
        message,
        flags=re.MULTILINE,
    )


def target_of(target: Target) -> dict[str, Any] | None:
    """Read a target in the form that `plan` takes; None for the target of the node."""
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
                    found['direction_tolerance_deg'] = math.degrees(target.within)
            if target.use_point:
                found['at'] = point
        case Target.POT:
            found = {'pot': names_in(target.ball), 'pocket': list(target.pockets) or 'any'}
            if target.use_point:
                found['leave'] = point
        case _:
            raise ValueError(f'target.kind is {target.kind}: must be one of its constants, 0 to 5')
    if target.radius:
        found['radius'] = target.radius
    return found


def names_in(text: str) -> list[str] | str:
    """Read names of balls with commas between them; a single name stays as it is."""
    names = [name.strip() for name in text.split(',')]
    return names if len(names) > 1 else text


def target_message(target: Mapping[str, Any]) -> Target:
    """
    Make the message of a target in the form that `plan` takes.

    Raises
    ------
    ValueError
        With every invalid field, its value and the allowed range.

    """
    match targets.read_target(target):
        case targets.Rest(point, radius):
            return Target(kind=Target.REST, point=_flat(Point, point), radius=radius)
        case targets.Pass(point, radius):
            return Target(kind=Target.PASS, point=_flat(Point, point), radius=radius)
        case targets.Gate((point, other)):
            return Target(
                kind=Target.GATE, point=_flat(Point, point), other_point=_flat(Point, other)
            )
        case targets.Hit(ball, direction, direction_tolerance_deg, point, radius):
            return Target(
                kind=Target.HIT,
                ball=ball,
                point=_flat(Point, point),
                radius=radius,
                use_point=point is not None,
                direction=_flat(Vector3, direction),
                use_direction=direction is not None,
                within=math.radians(direction_tolerance_deg),
            )
        case targets.Pot(balls, pockets, point, radius):
            return Target(
                kind=Target.POT,
                ball=', '.join(balls),
                pockets=pockets,
                point=_flat(Point, point),
                use_point=point is not None,
                radius=radius,
            )


def _flat(kind: type, place: tuple[float, float] | None) -> Any:
    x, y = place or (0.0, 0.0)
    return kind(x=x, y=y)


def result_of(
    result: PlanResult, request: PlanRequest, plan_id: str, goal: PlanShot.Goal, header: Header
) -> PlanShot.Result:
    """Make the result of a goal planned for `request`, with the requested number of strokes."""
    return PlanShot.Result(
        status=int(result.status),
        message=result.message,
        plans=[
            ranked_message(result, rank, request, plan_id, header, goal.sample_count)
            for rank in range(len(result.ranking[: goal.plan_count or 1]))
        ],
        found=len(result.ranking),
        simulations=result.simulations,
        compute_time=result.wall_time,
    )


def ranked_message(
    result: PlanResult,
    rank: int,
    request: PlanRequest,
    plan_id: str,
    header: Header,
    sample_count: int,
) -> RankedPlan:
    """Message of the planned stroke `rank`, from 0; `trajectory_message` describes the samples."""
    planned = result.ranking[rank]
    a, b, _, azimuth, _ = planned.stroke.offsets
    low, high = planned.interval
    x, y, _ = planned.scene.cue_ball
    places = {CUE_BALL: (x, y), **planned.scene.balls}
    balls = request.balls or {name: Sighting(place) for name, place in places.items()}
    shot_id = f'{planned.kind} {plan_id}-{rank + 1}'
    return RankedPlan(
        plan=plan_message(plan_of(planned.stroke, balls, planned.scene, shot_id), header),
        kind=planned.kind,
        azimuth=azimuth,
        a=a,
        b=b,
        success=planned.success,
        success_low=low,
        success_high=high,
        trials=planned.trials,
        warning=planned.warning,
        trajectory=trajectory_message(planned.shot.trajectory, sample_count),
    )
