"""
Conversions between messages and the mechanical cue's library, both ways: pure functions.

Input that cannot be read raises ValueError with the field, its value and the allowed range.
"""

from collections.abc import Mapping, Sequence

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import Plan, Strike
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Pose, Quaternion
import numpy as np
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from billiard_shot import Scene, Stroke
from billiard_shot.cue import joint_trajectory
from billiard_shot.cue.controller import Controller, MeasuredStrike, Result
from billiard_shot.cue.plan import GoalOutcome, RefusedError, ShotPlan, tip_at
from billiard_shot.cue.safety import SafetyState
from billiard_shot.perception import gate
from billiard_shot.perception.sightings import Balls
from billiard_shot.records import Array
from billiard_shot.ros.conversions import (
    ball_message,
    check_frame,
    filled,
    seconds,
    sightings_of,
    xyz,
    xyzw,
)
from billiard_shot.scene.placement import CUE_BALL

RUN_UP = 0.05
"""Distance [m] from the ball to the tip's position in a plan, which is in front of the ball."""


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
