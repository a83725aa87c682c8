"""Random sample strokes for a scene."""

import math

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.shot.lowest_elevation import lowest_elevation
from billiard_shot.shot.stroke import Stroke


def sample_strokes(scene: Scene, count: int, seed: int = 0) -> list[Stroke]:
    """
    Draw random strokes as people play them.

    Half of them are as level as cushions and other balls allow. Offsets are within half a radius
    of the middle, speeds 0.5 to 5 m/s. The aim is another ball, full or thin, if there is one,
    else any direction.
    """
    draw = np.random.default_rng(seed)
    x, y, _ = scene.cue_ball
    aims = [
        (math.atan2(v - y, u - x), math.hypot(u - x, v - y))
        for name, (u, v) in scene.balls.items()
        if (u, v) != (x, y)
    ]
    strokes = []
    for number in range(count):
        offset, around = 0.5 * math.sqrt(draw.random()), draw.uniform(0.0, 2.0 * math.pi)
        steep = math.radians(draw.uniform(5.0, 45.0)) if number % 2 else 0.0
        azimuth = draw.uniform(-math.pi, math.pi)
        if aims:
            direction, distance = aims[draw.integers(len(aims))]
            thin = 2.0 * scene.ball.radius / distance
            azimuth = direction + draw.uniform(-1.0, 1.0) * math.asin(min(thin, 1.0))
        speed = 0.5 * 10.0 ** draw.random()
        a, b = offset * math.cos(around), offset * math.sin(around)
        lowest = float(lowest_elevation(scene, [[a, b, 0.0, azimuth, speed]])[0])
        elevation = max(steep, min(lowest, math.radians(60.0)))
        strokes.append(Stroke.from_offsets(a, b, elevation, azimuth, speed))
    return strokes
