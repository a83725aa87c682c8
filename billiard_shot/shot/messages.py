"""The meaning of each status of a shot, and the reason for each refusal."""

import math

import numpy as np

from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene
from billiard_shot.shot.lowest_elevation import lowest_elevation
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table import clearance
from billiard_shot.table.run import NOSE_NAMES
from billiard_shot.table.trajectory import Trajectory


def message_of(status: Status, scene: Scene, stroke: Stroke, trajectory: Trajectory) -> str:
    """Explain a status; for a refused stroke: field, value and allowed range."""
    x, y, z = stroke.velocity
    elevation = math.degrees(math.atan2(-z, math.hypot(x, y))) + 0.0  # 0, not -0
    match status:
        case Status.OK | Status.OFF_TABLE:  # told by what happened
            return ''
        case Status.NEVER_RESTS:
            return (
                f'nothing stops the ball: its last motion, from {trajectory.duration:.3g} s on, '
                'is endless'
            )
        case Status.INFINITE_SEQUENCE:
            return 'an infinite, decaying sequence of impacts was replaced by its limit'
        case Status.NEGATIVE_ENERGY:
            return 'law: poisson drove an elastic energy below zero; take another law'
        case Status.TOLERANCE_NOT_REACHED:
            return 'tolerance: not reached; error_estimate states how large the error may be'
        case Status.BUDGET_EXCEEDED:
            return 'step budget exceeded in the impact or the bounces; the result is incomplete'
        case Status.MISS:
            return stroke.miss or (
                f'normal must point against the stroke, with a cosine below 0, got '
                f'{_vector(stroke.normal)}, cosine {_cosine(stroke):.3g}'
            )
        case Status.NEGATIVE_ELEVATION:
            return (
                f'elevation must be 0 to 90, got {elevation:.3g} (degrees); the velocity of the '
                f'cue, {_vector(stroke.velocity)} m/s, points up'
            )
        case Status.CUE_THROUGH_CLOTH:
            height = scene.ball.radius * (1.0 + stroke.normal[2])
            needed = scene.cue.ferrule_radius * math.cos(math.radians(elevation))
            return (
                f'normal must be at least {1e3 * needed:.3g} mm above the cloth, or the cue goes '
                f'through it, got {_vector(stroke.normal)}, {1e3 * height:.3g} mm above it'
            )
        case Status.CUE_THROUGH_BALL | Status.CUE_THROUGH_CUSHION:
            return _in_the_way(status, scene, stroke, trajectory, elevation)
    return status.name.lower().replace('_', ' ')


def _in_the_way(
    status: Status, scene: Scene, stroke: Stroke, trajectory: Trajectory, elevation: float
) -> str:
    around = clearance.surroundings_of(scene)
    touching = stroke.touching(scene.cue.tip_curvature_radius / scene.ball.radius)
    direction = np.array(stroke.velocity) / stroke.speed
    if status == Status.CUE_THROUGH_BALL:
        names = [f'ball {name!r}' for name in scene.object_balls]
        depth_in = clearance.depth_in_ball
    else:
        names = [f'the {name} cushion' for name in NOSE_NAMES]
        depth_in = clearance.depth_in_cushion
    depths = [
        depth_in(around, i, touching.normal, direction, trajectory.final_position)
        for i in range(len(names))
    ]
    pairs = zip(names, depths, strict=True)
    name, depth = next(pair for pair in pairs if pair[1] > rounding.PLACE)
    a, b, _, azimuth, _ = touching.offsets
    lowest = lowest_elevation(scene, [[a, b, 0.0, azimuth, 1.0]], trajectory.final_position)
    free = math.degrees(lowest[0])
    blocked = f'{name} blocks the cue, by {1e3 * depth:.3g} mm'
    if free >= 90.0:
        return f'{blocked} at {elevation:.3g} degrees; no elevation clears it'
    return f'elevation must be at least {free:g}, got {elevation:.3g} (degrees): {blocked}'


def _vector(values: tuple[float, ...]) -> str:
    return '(' + ', '.join(f'{value:.4g}' for value in values) + ')'


def _cosine(stroke: Stroke) -> float:
    pairs = zip(stroke.normal, stroke.velocity, strict=True)
    return sum(n * v for n, v in pairs) / stroke.speed
