"""
Conversions between messages and the library, of shots and of the mechanical cue: pure functions.

Input that cannot be read raises ValueError with the field, its value and the allowed range.
"""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
import math
from typing import Any, NamedTuple

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import BallState, BallTrajectory, Effect, Plan, Strike, TableState
from billiard_shot_msgs.srv import PredictShot, PredictShots
from builtin_interfaces.msg import Duration as DurationMessage
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from billiard_shot import effects_of, Scene, Shot, Stroke, Trajectory
from billiard_shot.cue import joint_trajectory
from billiard_shot.cue.controller import Controller, MeasuredStrike, Result
from billiard_shot.cue.plan import GoalOutcome, RefusedError, ShotPlan, tip_at
from billiard_shot.cue.safety import SafetyState
from billiard_shot.perception import gate
from billiard_shot.perception.sightings import Balls, positions_of, Sighting
from billiard_shot.records import Array, Triple
from billiard_shot.ros.parameters import MAX_SAMPLES
from billiard_shot.scene.errors import InputError
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.play import StrokeBatch
from billiard_shot.status import Status

MAX_STROKES = 10_000
"""Largest number of strokes in a request for many predictions."""

MAX_KEY_TIMES = 8
"""Largest number of samples in a short answer."""

MAX_AHEAD = 0.1
"""Longest time by which a picture may be ahead of the clock [s]."""

HEIGHT_ERROR = 5e-3
"""Largest error of the measured height of a ball that lies on the cloth [m]."""

RUN_UP = 0.05
"""Distance [m] from the ball to the tip's position in a plan, which is in front of the ball."""


class BadStrokeError(ValueError):
    """A stroke that cannot be read, with a message that names the field."""

    status = Status.INVALID_STROKE


# --- requests -----------------------------------------------------------------------------------


def stroke_of(pose: Pose, speed: float, ball: Triple) -> Stroke:
    """
    Read the stroke of a cue in a pose, at the ball whose centre is `ball` (metres, frame table).

    All of its errors are BadStrokeError.
    """
    position, quaternion = xyz(pose.position), xyzw(pose.orientation)
    for axis, value in zip('xyz', position, strict=True):
        if not math.isfinite(value):
            raise BadStrokeError(f'cue_pose.position.{axis} must be finite, got {value}')
    if not 0.0 < speed < math.inf:
        raise BadStrokeError(f'speed must be finite and above 0 m/s, got {speed}')
    try:
        gate.check_quaternion('orientation', quaternion)
        return Stroke.from_pose(position, quaternion, speed, ball=ball)
    except (ValueError, ArithmeticError) as error:
        raise BadStrokeError(f'cue_pose, speed: {error}') from error


class Batch(NamedTuple):
    """Strokes of a request; the rows of strokes that cannot be predicted are not finite."""

    normals: Array
    velocities: Array
    statuses: NDArray[np.uint16]  # of the strokes that cannot be predicted; else OK


def requested_batch(request: PredictShots.Request, scene: Scene, ball: Triple) -> Batch:
    """Read the strokes of a request, at the ball whose centre is `ball` (metres, frame table)."""
    count = len(request.cue_poses)
    if count > MAX_STROKES:
        raise ValueError(f'cue_poses must have at most {MAX_STROKES} elements, got {count}')
    if len(request.speeds) != count:
        raise ValueError(
            f'speeds must have {count} elements, as cue_poses, got {len(request.speeds)}'
        )
    normals, velocities = np.full((2, count, 3), np.nan)
    statuses = np.zeros(count, np.uint16)
    curvature = scene.cue.tip_curvature_radius / scene.ball.radius
    for i, (pose, speed) in enumerate(zip(request.cue_poses, request.speeds, strict=True)):
        try:
            stroke = stroke_of(pose, speed, ball)
        except BadStrokeError as error:
            statuses[i] = error.status
            continue
        if stroke.miss:
            statuses[i] = Status.MISS
        else:
            normals[i], velocities[i] = stroke.touching(curvature).normal, stroke.velocity
    return Batch(normals, velocities, statuses)


def table_scene(scene: Scene, table: TableState | None, frame: str) -> tuple[Scene, Balls]:
    """Replace the balls of a scene by those of the table state; return these, too."""
    if table is None:
        raise ValueError('use_table_state: no message received on topic table_state')
    check_frame('table_state.header.frame_id', table.header, frame)
    return requested_scene(scene, table.balls, table.header.stamp, 'table_state.balls')


def requested_scene(
    scene: Scene, balls: Sequence[BallState], stamp: Time | None = None, field: str = 'balls'
) -> tuple[Scene, Balls]:
    """
    Replace the balls of a scene by those of a message, with its stamp; return these, too.

    The cue ball must be among them, and all must be seen at rest, where balls can lie.
    """
    sightings = sightings_of(balls, stamp, field)
    if CUE_BALL not in sightings:
        raise ValueError(f'{field}: the cue ball, {CUE_BALL!r}, must be on the table')
    for name, ball in sightings.items():
        if ball.is_moving or not ball.is_seen:
            fault = 'moves' if ball.is_seen else 'is not seen'
            raise ValueError(f'{field}: ball {name!r} {fault}; must be seen and at rest')
    try:
        return replace(scene, balls=positions_of(sightings, scene)), sightings
    except InputError as error:  # in `balls` of the scene
        wrong = [each._replace(path=(field, *each.path[1:])) for each in error.mistakes]
        raise InputError(wrong) from None


def sightings_of(
    balls: Sequence[BallState], stamp: Time | None = None, field: str = 'balls'
) -> dict[str, Sighting]:
    """
    Read the balls that are not pocketed; `stamp` is the stamp of their message.

    Their names and numbers must pass the gate (billiard_shot.perception.sightings).
    """
    gate.check_count(field, balls)
    sightings: dict[str, Sighting] = {}
    names = set()
    for ball in balls:
        gate.check_name(f'{field}: id', ball.id)
        if ball.id in names:
            raise ValueError(f'{field}: {ball.id!r} occurs twice; each name must occur only once')
        names.add(ball.id)
        if ball.state == BallState.POCKETED:
            continue
        if ball.state not in (BallState.ON_TABLE, BallState.UNKNOWN):
            raise ValueError(f'{field}: state of {ball.id!r} must be 0, 1 or 2, got {ball.state}')
        is_seen = ball.state == BallState.ON_TABLE
        where = f'{field}: ball {ball.id!r}'
        gate.check_position(f'{where}: position', xyz(ball.position))
        gate.check_systematic_error(f'{where}: systematic_error', ball.systematic_error)
        sightings[ball.id] = Sighting(
            (ball.position.x, ball.position.y),
            gate.plane_covariance(
                f'{where}: position_covariance', ball.position_covariance.tolist()
            ),
            is_seen=is_seen,
            is_moving=ball.moving,
            time=seconds(ball.last_seen) or (seconds(stamp) if stamp and is_seen else 0.0),
            systematic_error=ball.systematic_error,
        )
    return sightings


def picture_time(stamp: Time, now: float) -> float:
    """Read the time of a picture [s], which may hardly be later than `now` [s]."""
    ahead = seconds(stamp) - now
    if not ahead <= MAX_AHEAD:
        raise ValueError(
            f'header.stamp must be at most {MAX_AHEAD:g} s ahead of the clock, got {ahead:.3g} s'
        )
    return seconds(stamp)


def ball_message(name: str, ball: Sighting) -> BallState:
    """Message of a ball that is on the table or not seen; its height is that of a ball at rest."""
    xx, xy, yy = ball.covariance
    return BallState(
        id=name,
        state=BallState.ON_TABLE if ball.is_seen else BallState.UNKNOWN,
        position=filled(Point, ball.position),
        position_covariance=[xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0],
        moving=ball.is_moving,
        last_seen=stamp_of(ball.time),
        systematic_error=ball.systematic_error,
    )


def place_balls(
    request: PredictShot.Request | PredictShots.Request,
    scene: Scene,
    table: TableState | None,
    frame: str,
) -> tuple[Scene, Triple]:
    """Check a request; return the scene with its balls, and the centre of its cue ball [m]."""
    check_frame('header.frame_id', request.header, frame)
    if not 0.0 <= request.tolerance < math.inf:
        raise ValueError(
            'tolerance must be finite and above 0 m, or 0 for the default, got '
            f'{request.tolerance}'
        )
    count = getattr(request, 'sample_count', 0)
    if count > MAX_SAMPLES:
        raise ValueError(f'sample_count must be at most {MAX_SAMPLES}, got {count}')
    if request.use_table_state:
        scene, _ = table_scene(scene, table, frame)
        return scene, scene.cue_ball
    return scene, _resting('ball_position', request.ball_position, scene.ball.radius)


def check_frame(field: str, header: Header, frame: str) -> None:
    """Check that a header is in the table's frame, or that its frame is empty."""
    if header.frame_id not in ('', frame):
        raise ValueError(f'{field} must be {frame!r} or empty, got {header.frame_id!r}')


# --- responses ----------------------------------------------------------------------------------


def response_of(shot: Shot, sample_count: int, all_balls: bool = False) -> PredictShot.Response:
    """
    Make the answer for a shot; `trajectory_message` describes the samples of its trajectories.

    A shot with numbers that are not finite becomes a refusal.
    """
    if shot.status.refused:
        return PredictShot.Response(status=int(shot.status), message=shot.message)
    trajectory = trajectory_message(shot.trajectory, sample_count)
    others = [
        trajectory_message(ball, sample_count, name)
        for name, ball in shot.run.balls.items()
        if all_balls and name != CUE_BALL and ball.duration > 0.0
    ]
    response = PredictShot.Response(
        status=int(shot.status),
        miscue=shot.miscue,
        message=shot.message,
        velocity=filled(Vector3, shot.velocity),
        spin=filled(Vector3, shot.spin),
        cue_speed=float(shot.cue_speed),
        trajectory=trajectory,
        other_balls=others,
        effects=[
            Effect(name=effect.name, simulated=effect.simulated, reason=effect.reason)
            for effect in effects_of(shot)
        ],
        error_estimate=float(shot.error_estimate),
        compute_time=float(shot.wall_time),
    )
    numbers: list[Any] = [shot.velocity, shot.spin, shot.cue_speed, shot.error_estimate]
    for each in (trajectory, *others):
        numbers += [each.times, each.positions, each.velocities, each.spins]
    if not all(np.isfinite(values).all() for values in numbers):
        return PredictShot.Response(
            status=int(Status.INVALID_REQUEST),
            message='cue_pose, speed, ball_position: too large to compute with',
        )
    return response


def batch_response(batch: Batch, result: StrokeBatch, wall_time: float) -> PredictShots.Response:
    """Make the answer for the predictions of a batch; numbers of refused strokes are zero."""
    statuses = np.where(batch.statuses, batch.statuses, result.status)
    played = statuses < Status.MISS

    def flat(values: Array) -> 'array[float]':
        kept = played.reshape(-1, *[1] * (values.ndim - 1))
        return _doubles(np.where(kept & np.isfinite(values), values, 0.0))

    return PredictShots.Response(
        statuses=array('H', statuses.astype(np.uint16).tobytes()),
        miscues=(played & result.miscue).tolist(),
        velocities=flat(result.velocity),
        spins=flat(result.spin),
        final_positions=flat(result.final_position),
        error_estimates=flat(result.error_estimate),
        balls=list(result.names),
        final_motions=array('B', result.motion.tobytes()),
        compute_time=wall_time,
    )


def trajectory_message(trajectory: Trajectory, count: int, name: str = CUE_BALL) -> BallTrajectory:
    """
    Message of the trajectory of a ball until rest.

    It has `count` samples, equally spaced in time. If `count` is 0, they are at the `key_times`.
    """
    times = np.linspace(0.0, trajectory.duration, count) if count else key_times(trajectory)
    state = trajectory.at(times)
    return BallTrajectory(
        id=name,
        times=_doubles(times),
        positions=_doubles(state.position),
        velocities=_doubles(state.velocity),
        spins=_doubles(state.spin),
        motion=array('B', np.asarray(state.motion, dtype=np.uint8).tobytes()),
    )


def key_times(trajectory: Trajectory) -> Array:
    """Find the times [s] of start, first changes of motion, and rest: at most `MAX_KEY_TIMES`."""
    segments = trajectory.segments
    changes = [now.start for before, now in pairwise(segments) if now.motion != before.motion]
    return np.unique([0.0, *changes[: MAX_KEY_TIMES - 2], trajectory.duration])


def vectors(flat: 'array[float]') -> Array:
    """View the flat array of a message as an array (n, 3), without a copy."""
    return np.frombuffer(flat, dtype=np.float64).reshape(-1, 3)


# --- goals and results --------------------------------------------------------------------------


def plan_of(stroke: Stroke, balls: Balls, scene: Scene, shot_id: str) -> ShotPlan:
    """Plan of a stroke at the ball `cue`."""
    tip = tip_at(stroke, balls[CUE_BALL].position, scene)
    x, y, z = (tip.position - RUN_UP * tip.along).tolist()
    return ShotPlan(shot_id, (x, y, z), tip.quaternion, stroke.speed, tip.elevation, dict(balls))


def plan_message(plan: ShotPlan, header: Header) -> Plan:
    """Message of a plan; the header has the frame of the table, and the time of the plan."""
    return Plan(
        header=header,
        shot_id=plan.shot_id,
        cue_pose=pose_of(plan.position, plan.quaternion),
        speed=plan.speed,
        elevation=plan.elevation,
        balls=[ball_message(name, ball) for name, ball in plan.balls.items()],
    )


def shot_plan_of(message: Plan, frame: str) -> ShotPlan:
    """Read a plan in the frame `frame`; RefusedError (INVALID_PLAN) if it is invalid."""
    try:
        check_frame('plan.header.frame_id', message.header, frame)
        gate.check_name('plan.shot_id', message.shot_id)
        balls = sightings_of(message.balls, field='plan.balls')
        pose = checked_pose('plan.cue_pose', message.cue_pose)
    except ValueError as error:
        raise RefusedError(GoalOutcome.INVALID_PLAN, str(error)) from None
    made = seconds(message.header.stamp)
    return ShotPlan(message.shot_id, *pose, message.speed, message.elevation, balls, made)


def execution_result(result: Result, strike: Strike) -> ExecuteShot.Result:
    """Message of the result of a goal; `strike` is the message of its strike, if it has one."""
    message = ExecuteShot.Result(outcome=int(result.outcome), message=result.message)
    if result.has_met:
        message.struck, message.strike = True, strike
    if result.strike:
        message.measured, message.elevation = True, result.strike.tip.elevation
    return message


def strike_message(shot_id: str, strike: MeasuredStrike | None, header: Header) -> Strike:
    """Message of the strike of a shot; without pose and speed if it was not measured."""
    message = Strike(header=header, shot_id=shot_id)
    if strike:
        message.speed = strike.speed
        message.cue_pose = pose_of(strike.tip.position, strike.tip.quaternion)
    return message


def measured_stroke(strike: Strike, ball: tuple[float, float, float]) -> Stroke:
    """
    Stroke of a measured strike at a ball whose centre is `ball` [m].

    The tip is moved back along its axis, because the measured position may lie inside the ball.
    """
    gate.check_name('shot_id', strike.shot_id)
    position, quaternion = checked_pose('cue_pose', strike.cue_pose)
    along = np.array(Stroke.from_pose(position, quaternion, 1.0, ball).velocity)
    x, y, z = (np.array(position) - RUN_UP * along).tolist()
    return Stroke.from_pose((x, y, z), quaternion, strike.speed, ball)


def diagnostics_message(
    name: str, controller: Controller, problems: Mapping[str, str], stamp: Time
) -> DiagnosticArray:
    """Diagnostics message of the node `name`; '' is no problem."""
    wrong = list(filter(None, problems.values()))
    if controller.state is SafetyState.FAULT:
        level = DiagnosticStatus.ERROR
    elif controller.state is SafetyState.ESTOP or wrong:
        level = DiagnosticStatus.WARN
    else:
        level = DiagnosticStatus.OK
    values = {key: problem or 'ok' for key, problem in problems.items()}
    alignment = str(controller.mechanism.alignment)
    information = {'shot_id': controller.shot_id, 'alignment': alignment}
    status = DiagnosticStatus(
        level=level,
        name=name,
        hardware_id=f'{name.rpartition("/")[0]}/mechanical_cue',
        message='; '.join([f'{controller.state.name}: {controller.reason}', *wrong]),
        values=[
            KeyValue(key=key, value=value) for key, value in {**information, **values}.items()
        ],
    )
    return DiagnosticArray(header=Header(stamp=stamp), status=[status])


# --- joints -------------------------------------------------------------------------------------


def joint_trajectory_message(
    trajectory: joint_trajectory.JointTrajectory, names: Sequence[str], header: Header
) -> JointTrajectory:
    """Message of a trajectory; its stamp identifies the command."""
    message = JointTrajectory(header=header, joint_names=list(names))
    rows = zip(
        trajectory.times,
        trajectory.positions,
        trajectory.velocities,
        trajectory.accelerations,
        strict=True,
    )
    for time, position, velocity, acceleration in rows:
        message.points.append(
            JointTrajectoryPoint(
                positions=position.tolist(),
                velocities=velocity.tolist(),
                accelerations=acceleration.tolist(),
                time_from_start=Duration(nanoseconds=round(1e9 * time)).to_msg(),
            )
        )
    return message


def stop_message(names: Sequence[str], frame: str) -> JointTrajectory:
    """Command to stop at once: one point at time 0 with zero velocities; its stamp 0 means now."""
    still = JointTrajectoryPoint(velocities=[0.0] * len(names))
    header = Header(frame_id=frame)
    return JointTrajectory(header=header, joint_names=list(names), points=[still])


def is_stop(message: JointTrajectory) -> bool:
    """Whether a message is a command to stop (`stop_message`)."""
    is_still = len(message.points) == 1 and not any(message.points[0].velocities)
    return is_still and seconds(message.header.stamp) == 0.0


def trajectory_of(
    message: JointTrajectory, names: Sequence[str]
) -> joint_trajectory.JointTrajectory:
    """Read a trajectory message; the joints are put in the order of `names`."""
    if sorted(message.joint_names) != sorted(names):
        raise ValueError(f'joint_names: {message.joint_names} must be {list(names)}')
    columns = [message.joint_names.index(name) for name in names]
    times = np.array([seconds(point.time_from_start) for point in message.points])
    rows = []
    for field in ('positions', 'velocities', 'accelerations'):
        values = [getattr(point, field) for point in message.points]
        if not values or any(len(each) != len(columns) for each in values):
            raise ValueError(f'points: each must have {len(columns)} {field}')
        rows.append(np.array(values)[:, columns])
    if not (np.diff(times) > 0.0).all() or not all(np.isfinite(row).all() for row in rows):
        raise ValueError('points: numbers must be finite, and times ascend')
    return joint_trajectory.JointTrajectory(times, *rows)


def joints_message(
    names: Sequence[str], position: Array, velocity: Array, stamp: Time
) -> JointState:
    """Message of the positions and velocities of joints."""
    return JointState(
        header=Header(stamp=stamp),
        name=list(names),
        position=position.tolist(),
        velocity=velocity.tolist(),
    )


# --- pieces -------------------------------------------------------------------------------------


def seconds(time: Time | DurationMessage) -> float:
    """Convert a time or a duration to seconds."""
    return time.sec + 1e-9 * time.nanosec


def stamp_of(seconds: float) -> Time:
    """Convert seconds to a time."""
    whole = math.floor(seconds)
    return Time(sec=whole, nanosec=min(round(1e9 * (seconds - whole)), 999_999_999))


def xyz(vector: Point | Vector3) -> Triple:
    """Read the three numbers of a message."""
    return vector.x, vector.y, vector.z


def xyzw(quaternion: Quaternion) -> tuple[float, float, float, float]:
    """Read the four numbers of a quaternion."""
    return quaternion.x, quaternion.y, quaternion.z, quaternion.w


def filled(kind: type, values: Any) -> Any:
    """Make a message with the fields x, y, z and w from up to four numbers, in this order."""
    return kind(**dict(zip('xyzw', map(float, values), strict=False)))


def _doubles(values: Array) -> 'array[float]':
    # Much faster than assigning a list, whose numbers are converted and checked one by one.
    return array('d', np.ascontiguousarray(values, dtype=np.float64).tobytes())


def _resting(field: str, point: Point, radius: float) -> Triple:
    """Centre of a ball on the cloth [m], of which x, y and perhaps a measured height are given."""
    x, y, z = xyz(point)
    gate.check_position(field, (x, y, z))
    if z != 0.0 and not abs(z - radius) <= HEIGHT_ERROR:
        raise ValueError(
            f'{field}.z must be 0, for a ball on the cloth, or within {1e3 * HEIGHT_ERROR:g} mm '
            f'of its radius, {radius} m, got {z} m'
        )
    return x, y, radius


def checked_pose(
    field: str, pose: Pose
) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    """Read the position [m] and the quaternion x y z w of a pose."""
    position, quaternion = xyz(pose.position), xyzw(pose.orientation)
    gate.check_position(f'{field}.position', position)
    gate.check_quaternion(f'{field}.orientation', quaternion)
    return position, quaternion


def pose_of(position: Sequence[float] | Array, quaternion: Sequence[float]) -> Pose:
    """Message of a position [m] and a quaternion x y z w."""
    return Pose(position=filled(Point, position), orientation=filled(Quaternion, quaternion))
