"""A planned shot, and the fully checked motion of the mechanism for it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from billiard_shot.cue.joint_trajectory import (
    JointTrajectory,
    stroke_profile,
    stroke_trajectory,
    StrokeProfile,
    StrokeTrajectory,
    TrajectoryBuilder,
)
from billiard_shot.cue.mechanism import (
    Alignment,
    BASE_Z,
    check_range,
    EXACT,
    LimitError,
    LimitViolation,
    Mechanism,
    raise_violations,
    STROKE,
)
from billiard_shot.cue.model import (
    inverse_kinematics,
    pose_by_encoders,
    TipPose,
    travel_pivot_height,
)
from billiard_shot.perception.sightings import Balls, positions_of
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import axes, Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import Trajectory
from billiard_shot.table.strike.placement import clearance, surroundings_of


class GoalOutcome(IntEnum):
    """
    Outcome of a goal to play a shot.

    The numbers are part of the interface: the constants in the result of
    `billiard_shot_msgs/action/ExecuteShot` map to them one to one. Zero is success. From 100 on
    the goal was refused, and nothing moved.
    """

    OK = 0
    CANCELED = 1
    DISARMED = 2  # by a call, deactivation or the interlock, or after a pause
    ARM_TIMEOUT = 3  # armed for too long without being able to fire
    ESTOP = 4
    FAULT = 5  # the mechanism did not follow its commands
    EXPIRED = 6  # not armed in time: the goal was no longer valid
    TABLE_MOVED = 7  # a ball moved between the goal and the shot
    TABLE_STALE = 8  # the balls are no longer known well enough
    NOT_READY = 100  # not active, not disarmed, or an input does not allow it
    BUSY = 101  # another shot is being executed
    INVALID_PLAN = 102  # a field is invalid, or contradicts another field
    ALREADY_PLAYED = 103  # the cue has been aimed for this shot before
    ALREADY_EXPIRED = 104  # or the plan is from before the start of this program
    TABLE_UNKNOWN = 105  # the balls are not known well enough: too old, invalid or uncertain
    TABLE_DIFFERS = 106  # a ball does not lie at its planned place
    NOT_PREDICTED = 107  # the library refuses the stroke, or its prediction did not finish
    SPEED_OUT_OF_LIMITS = 108
    ELEVATION_OUT_OF_LIMITS = 109
    OUT_OF_REACH = 110  # a joint would be out of its range
    STROKE_OUT_OF_LIMITS = 111  # force, travel, cushions, or braking distance before the cloth
    TOUCHES_AGAIN = 112  # the cue would touch the ball a second time, or another ball
    MISCUE = 113  # the tip would slide on the ball, and the goal does not allow that

    @property
    def refused(self) -> bool:
        """Whether the goal was refused, so that nothing moved."""
        return self >= 100


class RefusedError(ValueError):
    """Refusal of a goal, with its outcome and a message that says why."""

    def __init__(self, outcome: GoalOutcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome


MIN_STEP = 1e-6  # s: a gap that may close within this time counts as a touch

SETBACK = 2.0
"""
Distance from the tip to the start of the round shaft, in half-widths of the shaft.

At this distance the rounded front of the shaft is clear of the ball, for offsets of up to 0.9
radii.
"""


class Shape(NamedTuple):
    """Radii of a ball, of the sphere of the tip's curvature, and of the shaft [m]."""

    ball: float
    tip: float
    shaft: float


def gap(away: Array, velocity: Array, along: Array, behind: float) -> tuple[float, float]:
    """
    Distance of a ball's centre to a half-line along the cue [m], and its rate of change [m/s].

    Parameters
    ----------
    away, velocity : (3,) float array
        Centre [m] and velocity [m/s] of the ball relative to the tip.
    along : (3,) float array
        Unit vector along the cue, towards its tip.
    behind : float
        Distance from the tip back to the end of the half-line [m].

    """
    ahead = float(away @ along)
    off = away + max(-ahead, behind) * along
    distance = math.sqrt(off @ off)
    return distance, float(velocity @ off) / distance if distance > 0.0 else 0.0


def first_touch(
    ball: Trajectory,
    cue: Callable[[float], tuple[float, float]],
    contact: Array,
    along: Array,
    shape: Shape,
    cue_acceleration: float,
    until: float,
) -> float:
    """
    Time [s] after the strike at which a ball and the cue touch; inf if they do not by `until`.

    For the cue ball, which the tip touches at the start, this is the next touch.

    Each step is so short that the gap cannot close within it (conservative advancement: Mirtich,
    "Impulse-based dynamic simulation of rigid body systems", 1996). The distance to a half-line is
    convex. So during smooth motion the accelerations bound how far the gap can fall below its
    tangent.

    Parameters
    ----------
    ball : Trajectory
        Trajectory of the ball from the end of the strike on.
    cue : callable
        Returns the distance that the cue has moved along its axis since the strike [m], and its
        speed [m/s], at a time [s].
    contact : (3,) float array
        Position of the tip at the end of the strike [m].
    along : (3,) float array
        Unit vector along the cue.
    shape : Shape
    cue_acceleration : float
        Largest acceleration of the cue [m/s^2].
    until : float
        End of the search [s].

    """
    rows = ball.rows['acceleration']
    bend = cue_acceleration + float(np.sqrt((rows * rows).sum(axis=1).max()))
    bodies = (
        (shape.tip, shape.ball + shape.tip),
        (SETBACK * shape.shaft, shape.ball + shape.shaft),
    )
    time = 0.0
    for segment in ball.segments:
        if segment.motion in (Motion.POCKETED, Motion.OFF_TABLE):
            return math.inf
        end = min(segment.end, until)
        while time < end:
            dt = time - segment.start
            moved, speed = cue(time)
            away = (
                segment.position
                - contact
                + (segment.velocity + 0.5 * segment.acceleration * dt) * dt
                - moved * along
            )
            velocity = segment.velocity + segment.acceleration * dt - speed * along
            step = math.inf
            for behind, size in bodies:
                distance, rate = gap(away, velocity, along, behind)
                free = max(distance - size, 0.0)
                step = min(step, (rate + math.sqrt(rate * rate + 2.0 * bend * free)) / bend)
            if step < MIN_STEP:
                return time
            time += step
        time = min(time, end)
    return math.inf


ELEVATION_TOLERANCE = 1e-6  # rad, between a plan's elevation and that of its pose

PLAYABLE = (Status.OK, Status.INFINITE_SEQUENCE, Status.TOLERANCE_NOT_REACHED)
"""Statuses of predictions in which the cue's motion is known well enough to brake the cue."""

_OUTCOMES = {
    'stroke.speed': GoalOutcome.SPEED_OUT_OF_LIMITS,
    'elevation': GoalOutcome.ELEVATION_OUT_OF_LIMITS,
    'force': GoalOutcome.STROKE_OUT_OF_LIMITS,
    'travel': GoalOutcome.STROKE_OUT_OF_LIMITS,
    'cloth': GoalOutcome.STROKE_OUT_OF_LIMITS,
    'cushion': GoalOutcome.STROKE_OUT_OF_LIMITS,
    'touch': GoalOutcome.TOUCHES_AGAIN,
}


@dataclass(frozen=True, slots=True)
class ShotPlan:
    """
    A planned shot, in the frame `table`.

    Parameters
    ----------
    shot_id : str
        Name of the shot; a shot is played once.
    position : (3,) tuple of float
        Position of the tip before the stroke: any point on its axis in front of the ball [m].
    quaternion : (4,) tuple of float
        Orientation of the tip frame, x y z w; +x points along the stroke.
    speed : float
        Speed of the cue as it meets the ball [m/s].
    elevation : float
        Downward angle of the stroke [rad]; the same as that of the quaternion.
    balls : mapping of str to Sighting
        The balls for which the shot was planned; the cue ball is `cue`.
    made : float
        When the plan was made, on the clock of the messages [s]; 0: not known.

    """

    shot_id: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    speed: float
    elevation: float
    balls: Balls
    made: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class PreparedShot:
    """Motion of the mechanism for a plan: the `aimed` joints (6,), the stroke, the prediction."""

    plan: ShotPlan
    shot: Shot
    contact: TipPose
    profile: StrokeProfile
    aimed: Array
    stroke: StrokeTrajectory


def prepare_shot(
    mechanism: Mechanism, scene: Scene, plan: ShotPlan, *, allow_miscue: bool = False
) -> PreparedShot:
    """
    Compute the motion of the mechanism that plays a plan.

    Unless `allow_miscue`, a stroke is refused if the tip would slide on the ball.

    Raises
    ------
    RefusedError
        If the plan cannot be played, with the reason. If the plan violates limits of the
        mechanism, the message lists each of them, and by how much.

    """
    stroke = _stroke_of(plan, scene.ball.radius)
    # The mechanism brakes after the strike, so its cue does not follow as a player's does.
    alone = replace(scene.effects, double_hit='off')
    places = positions_of(plan.balls, scene)
    try:
        shot = predict(replace(scene, balls=places, effects=alone), stroke)
    except ValueError as error:
        raise RefusedError(GoalOutcome.INVALID_PLAN, str(error)) from error
    if shot.status not in PLAYABLE:
        raise RefusedError(GoalOutcome.NOT_PREDICTED, f'{shot.status.name}: {shot.message}')
    if shot.miscue and not allow_miscue:
        raise RefusedError(
            GoalOutcome.MISCUE, 'the tip would slide on the ball, and allow_miscue is false'
        )
    contact = tip_at(stroke, plan.balls[CUE_BALL].position, scene)
    bare = pose_by_encoders(mechanism, contact)
    speed = mechanism.alignment.encoder_speed(stroke.speed)
    try:
        if mechanism.alignment != EXACT:
            _check_without_alignment(shot.scene, bare)
        way = _clearance((contact, bare), scene.cue.ferrule_radius)
        profile = stroke_profile(
            mechanism,
            scene.cue.mass,
            scene.cloth.gravity,
            contact.elevation,
            speed,
            speed / stroke.speed * shot.cue_speed,
            shot.tip_time,
            clearance=way / max(_lengths(mechanism)),
        )
        aimed = inverse_kinematics(mechanism, contact, profile.contact_at)
    except LimitError as error:
        outcome = _OUTCOMES.get(error.violations[0].limit, GoalOutcome.OUT_OF_REACH)
        raise RefusedError(outcome, str(error)) from error
    aimed[STROKE] = 0.0
    raised = travel_pivot_height(mechanism, aimed[BASE_Z])
    trajectory = stroke_trajectory(profile, aimed, raised)
    _check_touch(mechanism, scene, shot, contact, trajectory)
    return PreparedShot(plan, shot, contact, profile, aimed, trajectory)


def tip_at(stroke: Stroke, ball: tuple[float, float], scene: Scene) -> TipPose:
    """Pose of the tip as a stroke meets the cue ball, which lies at (x, y) [m]."""
    _, _, elevation, azimuth, speed = stroke.offsets
    radius, dome = scene.ball.radius, scene.cue.tip_curvature_radius
    normal = np.array(stroke.touching(dome / radius).normal)
    along = np.array(stroke.velocity) / speed
    centre = np.array([*ball, radius])
    return TipPose(centre + (radius + dome) * normal + dome * along, azimuth, elevation)


def stroke_on_table(
    alignment: Alignment,
    stroke: Stroke,
    ball: tuple[float, float],
    scene: Scene,
    measured: Alignment = EXACT,
) -> Array:
    """
    Find the stroke that the tip plays if it was measured with another alignment.

    Parameters
    ----------
    alignment : Alignment
        That of the machine.
    stroke : Stroke
        As it was measured.
    ball : (x, y)
        Where the cue ball lies [m].
    scene : Scene
    measured : Alignment
        That of the driver which measured the stroke.

    Returns
    -------
    (5,) float array
        Arguments of `Stroke.from_offsets`; the azimuth is near the measured one.

    """
    tip = tip_at(stroke, ball, scene)
    position, azimuth, elevation = alignment.on_table(
        *measured.by_encoders(tip.position, tip.azimuth, tip.elevation)
    )
    right, up, _ = np.array(axes(elevation, azimuth))
    away = position - np.array([*ball, scene.ball.radius])
    away /= scene.ball.radius + scene.cue.tip_curvature_radius
    speed = alignment.speed(measured.encoder_speed(stroke.speed))
    return np.array([away @ right, away @ up, elevation, azimuth, speed])


def hidden_balls(shot: PreparedShot, width: float) -> set[str]:
    """Names of the balls within `width` [m] beside the axis of the cue and ahead of its tip."""
    x, y = shot.contact.position[:2]
    cos, sin = math.cos(shot.contact.azimuth), math.sin(shot.contact.azimuth)
    hidden = set()
    for name, ball in shot.plan.balls.items():
        dx, dy = ball.position[0] - x, ball.position[1] - y
        if max(cos * dx + sin * dy, abs(cos * dy - sin * dx)) <= width:
            hidden.add(name)
    return hidden


def aim_trajectory(mechanism: Mechanism, start: Array, aimed: Array) -> JointTrajectory:
    """Draw the cue back and raise it, travel above the balls, and lower it: from rest to rest."""
    builder = TrajectoryBuilder(start)
    height = travel_pivot_height(mechanism, start[BASE_Z], aimed[BASE_Z])
    above, there = start.copy(), aimed.copy()
    above[STROKE], above[BASE_Z] = aimed[STROKE], height
    there[BASE_Z] = height
    for target in (above, there, aimed):
        builder.move(target, mechanism.speeds, mechanism.accelerations, mechanism.jerks)
    return builder.trajectory()


def _stroke_of(plan: ShotPlan, radius: float) -> Stroke:
    invalid = GoalOutcome.INVALID_PLAN
    if CUE_BALL not in plan.balls:
        raise RefusedError(
            invalid, f'balls must have {CUE_BALL!r}, got {", ".join(plan.balls) or "none"}'
        )
    for name, ball in plan.balls.items():
        if ball.is_moving or not ball.is_seen:
            raise RefusedError(invalid, f'ball {name!r} of the plan must be seen and at rest')
    try:
        stroke = Stroke.from_pose(
            plan.position, plan.quaternion, plan.speed, (*plan.balls[CUE_BALL].position, radius)
        )
    except (ValueError, ArithmeticError) as error:
        raise RefusedError(invalid, str(error)) from error
    elevation = stroke.offsets[2]
    if not abs(plan.elevation - elevation) <= ELEVATION_TOLERANCE:
        raise RefusedError(
            invalid,
            f'elevation must be that of the quaternion, {elevation:.6g}, got {plan.elevation!r} '
            '(rad)',
        )
    return stroke


def _lengths(mechanism: Mechanism) -> set[float]:
    """Lengths of the cue's way per length of its encoder: a wrong speed may be one of length."""
    return {1.0, mechanism.alignment.speed_scale}


def _clearance(poses: Sequence[TipPose], thickness: float) -> float:
    """Distance that the cue can move on until its lower edge touches the cloth [m]."""
    ways = [math.inf]
    for pose in poses:
        height = float(pose.position[2]) - thickness * math.cos(pose.elevation)
        if (sine := math.sin(pose.elevation)) > 0.0:
            ways.append(height / sine)
    return min(ways)


def _check_without_alignment(scene: Scene, pose: TipPose) -> None:
    """
    Raise LimitError if the cue would pass through cloth or cushions without the alignment.

    The alignment may be wrong. `predict` checks the pose with it.
    """
    height, ball = float(pose.position[2]), np.array(scene.cue_ball)
    touching = (pose.position - ball) / scene.ball.radius
    cushions = surroundings_of(scene)._replace(balls=np.zeros((0, 2)))
    violations = check_range('cloth', height, 0.0, math.inf, 'm', 'the tip, by the encoders')
    if clearance(cushions, touching, pose.along, ball) != Status.OK:
        text = 'cushion: the cue would pass through a cushion, by the encoders'
        violations.append(LimitViolation('cushion', text))
    raise_violations(violations)


def _check_touch(
    mechanism: Mechanism, scene: Scene, shot: Shot, contact: TipPose, stroke: StrokeTrajectory
) -> None:
    """Refuse a stroke in which the cue touches the cue ball again, or another ball."""
    trajectory = stroke.trajectory
    left_at = trajectory.at(stroke.leave)[0][STROKE]
    stops, gone = stroke.stop - stroke.leave, trajectory.duration - stroke.leave

    def cue(length: float, time: float) -> tuple[float, float]:
        position, velocity, _ = trajectory.at(min(stroke.leave + time, stroke.home))
        return length * float(position[STROKE] - left_at), length * float(velocity[STROKE])

    shape = Shape(scene.ball.radius, scene.cue.tip_curvature_radius, scene.cue.ferrule_radius)
    for length, (name, ball) in itertools.product(_lengths(mechanism), shot.run.balls.items()):
        touch = first_touch(
            ball,
            functools.partial(cue, length),
            contact.position,
            contact.along,
            shape,
            length * mechanism.stroke.acceleration,
            until=gone,
        )
        if touch == math.inf:
            continue
        if touch == 0.0 and name != CUE_BALL:
            raise RefusedError(
                GoalOutcome.TOUCHES_AGAIN, f'touch: ball {name!r} is in the way of the cue'
            )
        again = ' again' if name == CUE_BALL else ''
        raise RefusedError(
            GoalOutcome.TOUCHES_AGAIN,
            f'touch: the cue would touch ball {name!r}{again} {1e3 * touch:.3g} ms after the '
            f'strike, as it {"brakes" if touch < stops else "is drawn back"}; it stops after '
            f'{1e3 * stops:.3g} ms and is out of the way after {1e3 * gone:.3g} ms',
        )
