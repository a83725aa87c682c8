"""Makes goals of `execute_shot` from strokes: sealed, with a nonce and an expiry."""

from dataclasses import dataclass, field
import uuid

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import TableState
from billiard_shot_msgs.srv import SealShot
from rclpy.duration import Duration
from rclpy.time import Time
from std_msgs.msg import Header

from billiard_shot import RankedStroke, Scene, Status
from billiard_shot.cue.outcome import RefusedError
from billiard_shot.cue.plan import ShotPlan
from billiard_shot.ros import conversions
from billiard_shot.ros.conversions import BadRequestError
from billiard_shot.ros.cue_conversions import balls_of, goal_of, plan_of
from billiard_shot.ros.plan_conversions import places_of
from billiard_shot.scene.placement import CUE_BALL

DEFAULT_VALIDITY = 60.0
"""Time for which a goal is valid, if the request does not give one [s]."""

MAX_VALIDITY = 3600.0
"""Longest time for which a goal may be valid [s]."""


def short_id() -> str:
    """Make a unique name."""
    return uuid.uuid4().hex[:8]


@dataclass(frozen=True, slots=True)
class LastPlan:
    """The strokes of a plan, the best first, and the id under which they can be sealed."""

    ranking: tuple[RankedStroke, ...]
    plan_id: str = field(default_factory=short_id)


def seal(
    request: SealShot.Request,
    last: LastPlan | None,
    scene: Scene,
    table: TableState | None,
    header: Header,
) -> SealShot.Response:
    """
    Answer a request of the service `seal_shot`.

    Parameters
    ----------
    request
    last : LastPlan, optional
        Last plan; None if nothing has been planned yet.
    scene : Scene
        Scene for strokes that the request contains.
    table : TableState, optional
        Positions of the balls for such strokes; None if no table state has been received.
    header : Header
        Frame of the table, and ROS time.

    """
    try:
        conversions.check_frame('header.frame_id', request.header, header.frame_id)
        valid_for = request.valid_for or DEFAULT_VALIDITY
        if not 0.0 < valid_for <= MAX_VALIDITY:
            raise _invalid(
                f'valid_for is {request.valid_for}: must be above 0 s and at most '
                f'{MAX_VALIDITY:g} s, or 0 for {DEFAULT_VALIDITY:g} s'
            )
        if request.use_stroke:
            plan, what = _given(request, scene, table, header.frame_id), 'the given stroke'
        else:
            plan, what = _planned(request, last)
    except BadRequestError as error:
        return SealShot.Response(status=int(error.status), message=str(error))
    goal = sealed_goal(plan, header, valid_for)
    return SealShot.Response(
        status=int(Status.OK),
        message=f'sealed {what} as shot {plan.shot_id!r}, valid for {valid_for:g} s',
        plan=goal.plan,
        nonce=goal.nonce,
        expiry=goal.expiry,
    )


def sealed_goal(
    plan: ShotPlan, header: Header, valid_for: float = DEFAULT_VALIDITY
) -> ExecuteShot.Goal:
    """Make a goal to play a plan once, within `valid_for` [s] after the stamp of the header."""
    expiry = Time.from_msg(header.stamp) + Duration(nanoseconds=round(1e9 * valid_for))
    return goal_of(plan, uuid.uuid4().hex, header.stamp, expiry.to_msg(), header.frame_id)


def _planned(request: SealShot.Request, last: LastPlan | None) -> tuple[ShotPlan, str]:
    """Plan of the stroke that a request names, and a description of the stroke."""
    if last is None:
        raise _invalid('plan_id: there is no plan yet; send a goal to the action plan_shot first')
    if request.plan_id not in ('', last.plan_id):
        raise _invalid(
            f'plan_id is {request.plan_id!r}: must be that of the last plan, {last.plan_id!r}, or '
            'empty; a newer plan has replaced it'
        )
    rank = request.rank or 1
    if rank > len(last.ranking):
        raise _invalid(
            f'rank is {rank}: must be at most {len(last.ranking)}, the number of '
            'strokes in the plan'
        )
    ranked = last.ranking[rank - 1]
    _check_guided(ranked.scene)
    shot_id = request.shot_id or f'{ranked.kind} {last.plan_id}-{rank}'
    plan = plan_of(ranked.stroke, places_of(ranked.scene), ranked.scene, shot_id)
    return plan, f'{ranked.kind!r}, success {ranked.chance}, rank {rank} of the plan'


def _given(
    request: SealShot.Request, scene: Scene, table: TableState | None, frame: str
) -> ShotPlan:
    """Plan of the stroke in a request."""
    _check_guided(scene)
    if table is None:
        raise _invalid('use_stroke is true, but no message has been received on topic table_state')
    conversions.check_frame('table_state.header.frame_id', table.header, frame)
    try:
        balls = balls_of(table.balls)
    except RefusedError as error:
        raise _invalid(f'use_stroke: table_state: {error}') from None
    if CUE_BALL not in balls:
        raise _invalid(f'use_stroke: table_state has no ball {CUE_BALL!r} on the table')
    stroke = conversions.stroke_of(request, (*balls[CUE_BALL], scene.ball.radius))
    position, turn = request.cue_pose.position, request.cue_pose.orientation
    return ShotPlan(
        request.shot_id or f'stroke {short_id()}',
        (position.x, position.y, position.z),
        (turn.x, turn.y, turn.z, turn.w),
        request.speed,
        stroke.offsets[2],
        balls,
    )


def _check_guided(scene: Scene) -> None:
    if not scene.cue.guided:
        raise _invalid(
            "the cue of the planner's scene is not guided: must be `guided: true`, as for "
            'the mechanical cue'
        )


def _invalid(message: str) -> BadRequestError:
    return BadRequestError(Status.INVALID_REQUEST, message)
