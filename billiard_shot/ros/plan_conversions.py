"""Conversions between messages of the planner and the library: pure functions."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
import math
import re
from typing import Any, cast, TypeVar

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import RankedPlan, TableState, Target
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import Header
import yaml

from billiard_shot import PlanResult, Scene
from billiard_shot.perception import gate
from billiard_shot.perception.sightings import Balls, largest_deviation, Sighting
from billiard_shot.planning import targets
from billiard_shot.planning.problem import Target as PlanTarget
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.target_fields import ANY
from billiard_shot.ros import conversions
from billiard_shot.ros.parameters import MAX_SAMPLES
from billiard_shot.scene import Noise, Robot
from billiard_shot.scene.fields import SECTION_KEY
from billiard_shot.scene.placement import CUE_BALL, Place

DEGREES = '_deg'  # end of the names of angles in degrees

R = TypeVar('R')

TARGET_FIELDS = {
    **dict.fromkeys(('hit', 'pot'), 'target.balls'),
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
    target: PlanTarget | dict[str, Any]
    noise: Noise
    constraints: dict[str, Any]
    budget: int
    seed: int
    seconds: float | None = None
    balls: Balls = field(default_factory=dict)  # as they were seen; empty: those of the scene


def plan_request_of(
    goal: PlanShot.Goal, default: PlanRequest, table: TableState | None, frame: str
) -> PlanRequest:
    """
    Make the request for a goal; missing values are those of `default` or of the table state.

    ValueError names the mistakes, but not in fields that `plan` checks.
    """
    if goal.sample_count > MAX_SAMPLES:
        raise ValueError(f'sample_count must be at most {MAX_SAMPLES}, got {goal.sample_count}')
    conversions.check_frame('header.frame_id', goal.header, frame)
    of_balls = {name: list(getattr(goal, name)) for name in ('keep', 'first_contact')}
    of_target = {f'target.{name}': getattr(goal.target, name) for name in ('balls', 'pockets')}
    for name, names in (of_balls | of_target).items():
        gate.check_count(name, names)
        for each in names:
            gate.check_name(name, each)
    scene = default.scene
    balls: Balls = {}
    if goal.balls:
        scene, balls = conversions.requested_scene(scene, goal.balls)
    elif table is not None:
        scene, balls = conversions.table_scene(scene, table, frame)
    constraints = default.constraints
    if goal.limits:
        constraints = asdict(record_of(Robot, goal.limits[0], 'limits'))
    constraints = constraints | {name: names for name, names in of_balls.items() if names}
    noise = default.noise
    if goal.noise:
        noise = replace(record_of(Noise, goal.noise[0], 'noise'), bias=noise.bias)
    if not (goal.noise and goal.noise[0].balls):
        noise = replace(noise, balls=max(noise.balls, largest_deviation(balls)))
    return PlanRequest(
        scene,
        requested_target(goal.target) or default.target,
        noise,
        constraints,
        goal.budget or default.budget,
        goal.seed or default.seed,
        seconds=goal.seconds or (None if goal.budget else default.seconds),
        balls=balls,
    )


def record_of(kind: type[R], message: Any, field: str) -> R:
    """
    Make a record of the library from a message with the same fields.

    Messages have no sections of the record. Angles are in radians in the message. They are in
    degrees in the record, where the names of their fields end in `_deg`. ValueError names the
    fields of the message, below `field`.
    """
    values, paths = {}, {}
    for each in fields(cast(Any, kind)):
        if SECTION_KEY in each.metadata:
            continue
        there = each.name.removesuffix(DEGREES)
        value = getattr(message, there)
        values[each.name] = value if there == each.name else math.degrees(value)
        paths[each.name] = f'{field}.{there}'
    try:
        return kind(**values)
    except ValueError as error:
        raise ValueError(_renamed(str(error), paths)) from None


def in_fields(message: str, goal: PlanShot.Goal) -> str:
    """
    Replace names in a message of `plan` by the fields of a goal.

    If the goal leaves the target to the node's parameter, the names of the library stay.
    """
    if goal.target.kind != Target.DEFAULT and message.startswith('target: '):
        return _renamed(message.removeprefix('target: '), TARGET_FIELDS)
    return message.removeprefix('constraints: ')


def _renamed(message: str, names: dict[str, str]) -> str:
    """Replace the name at the start of each line."""
    return re.sub(
        r'^( *)(\w+)',
        lambda found: found[1] + names.get(found[2], found[2]),
        message,
        flags=re.MULTILINE,
    )


def requested_target(target: Target) -> dict[str, Any] | None:
    """Read a target in the form that `plan` takes; None for the target of the node."""
    point, other, direction = (
        (each.x, each.y) for each in (target.point, target.other_point, target.direction)
    )
    ball, *more = target.balls or ['']
    if target.kind == Target.HIT and (more or not ball):
        raise ValueError(f'target.balls must be one name, got {list(target.balls)}')
    found: dict[str, Any]
    match target.kind:
        case Target.DEFAULT:
            return None
        case Target.REST:
            found = {'rest': point}
        case Target.PASS:
            found = {'pass': point}
        case Target.GATE:
            return {'gate': (point, other)}
        case Target.HIT:
            found = {'hit': ball, 'at': target.use_point and point}
            if target.use_direction:
                found |= {
                    'direction': direction,
                    'direction_tolerance_deg': math.degrees(target.within),
                }
        case Target.POT:
            found = {
                'pot': list(target.balls) or 'any',
                'pocket': list(target.pockets) or 'any',
                'leave': target.use_point and point,
            }
        case _:
            raise ValueError(
                f'target.kind must be one of its constants, 0 to 5, got {target.kind}'
            )
    return {name: value for name, value in {**found, 'radius': target.radius}.items() if value}


def target_in(text: str) -> PlanTarget:
    """Read a target from YAML; ValueError if it has mistakes. `plan` checks if it fits a scene."""
    try:
        return targets.read_target(yaml.safe_load(text))
    except yaml.YAMLError as error:
        raise ValueError(f'target: {text!r} is not YAML: {error}') from None


def target_message(target: PlanTarget | Mapping[str, Any]) -> Target:
    """Make the message of a target as `plan` takes it; ValueError names its mistakes."""
    found = targets.read_target(target)
    message = Target(radius=getattr(found, 'radius', 0.0))
    point: Place | None
    match found:
        case targets.Rest(rest=point):
            message.kind = Target.REST
        case targets.Pass(passing=point):
            message.kind = Target.PASS
        case targets.Gate(gate=(point, other)):
            message.kind, message.other_point = Target.GATE, conversions.filled(Point, other)
        case targets.Hit(hit=ball, at=point, direction=direction):
            message.kind, message.balls, message.use_point = Target.HIT, [ball], bool(point)
            if direction:
                message.use_direction, message.direction = (
                    True,
                    conversions.filled(Vector3, direction),
                )
                message.within = math.radians(found.direction_tolerance_deg)
        case targets.Pot(pot=balls, pocket=pockets, leave=point):
            message.kind, message.pockets, message.use_point = Target.POT, pockets, bool(point)
            message.balls = [] if ANY in balls else balls
        case _:
            raise ValueError(f'target must be rest, pass, gate, hit or pot, got {target!r}')
    message.point = conversions.filled(Point, point or ())
    return message


def plan_result(
    result: PlanResult, request: PlanRequest, plan_id: str, goal: PlanShot.Goal, header: Header
) -> PlanShot.Result:
    """Make the result of a goal planned for `request`, with the requested number of strokes."""
    return PlanShot.Result(
        status=int(result.status),
        message=in_fields(result.message, goal),
        plans=[
            ranked_message(planned, request, f'{plan_id}-{rank}', header, goal.sample_count)
            for rank, planned in enumerate(result.ranking[: goal.plan_count or 1], start=1)
        ],
        found=len(result.ranking),
        simulations=result.simulations,
        compute_time=result.wall_time,
    )


def ranked_message(
    planned: RankedStroke, request: PlanRequest, name: str, header: Header, sample_count: int
) -> RankedPlan:
    """Message of a planned stroke with a unique name; `trajectory_message` has the samples."""
    a, b, _, azimuth, _ = planned.stroke.offsets
    low, high = planned.interval
    x, y, _ = planned.scene.cue_ball
    places = {CUE_BALL: (x, y), **planned.scene.balls}
    balls = request.balls or {ball: Sighting(place) for ball, place in places.items()}
    plan = conversions.plan_of(planned.command, balls, planned.scene, f'{planned.kind} {name}')
    return RankedPlan(
        plan=conversions.plan_message(plan, header),
        kind=planned.kind,
        azimuth=azimuth,
        a=a,
        b=b,
        success=planned.success,
        success_low=low,
        success_high=high,
        trials=planned.trials,
        warning=planned.warning,
        trajectory=conversions.trajectory_message(planned.shot.trajectory, sample_count),
    )
