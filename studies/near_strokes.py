"""Random strokes at a cue ball that lies within two millimetres of cushions and other balls."""

import math

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, nose_standoff
from billiard_shot.shot.lowest_elevation import lowest_elevation
from billiard_shot.shot.stroke import Stroke

NEAR = 2e-3  # m
AT_CUSHION, TOUCHING, LOWEST = 0.7, 0.2, 0.3  # shares of the places, balls and strokes
MOST_OFFSET = 0.95  # radii
STEEPEST_CUE = math.radians(80.0)
SPEEDS = 0.1, 8.0  # m/s


def near_scene(scene: Scene, draw: np.random.Generator, *, own: bool) -> Scene:
    """
    Draw a scene whose cue ball is near others.

    Parameters
    ----------
    scene : Scene
        With table, ball and cue.
    draw : Generator
    own : bool
        Whether the cue ball lies near one of the scene's own balls. Else it is alone with one to
        three balls near it or each other, and in most cases near a cushion.

    """
    others = scene.object_balls
    while True:
        if own:
            balls = {CUE_BALL: _beside(list(others.values()), scene.ball.radius, draw), **others}
        else:
            balls = {CUE_BALL: _on_table(scene, draw)}
            for number in range(draw.integers(1, 4)):
                near = _beside(list(balls.values()), scene.ball.radius, draw)
                balls[str(number + 1)] = near
        try:
            return Scene.from_dict({**scene.to_dict(), 'balls': balls})
        except ValueError:  # balls overlap, or one lies in a cushion or over a pocket
            continue


def _on_table(scene: Scene, draw: np.random.Generator) -> tuple[float, float]:
    """Draw a place on the table, near a cushion in most cases (x, y) [m]."""
    if scene.table is None:
        return 0.0, 0.0
    standoff = nose_standoff(
        2.0 * scene.ball.radius * scene.table.cushion.height, scene.ball.radius
    )
    most = 0.5 * np.array([scene.table.length, scene.table.width]) - standoff
    place = draw.uniform(-most, most)
    if draw.random() < AT_CUSHION:
        side = draw.integers(2)
        place[side] = math.copysign(most[side] - NEAR * draw.random(), place[side])
    return float(place[0]), float(place[1])


def _beside(
    places: list[tuple[float, float]], radius: float, draw: np.random.Generator
) -> tuple[float, float]:
    """Draw a place within `NEAR` of a ball at one of the given places (x, y) [m]."""
    x, y = places[draw.integers(len(places))]
    gap = NEAR * draw.random() if draw.random() > TOUCHING else 0.0
    angle = draw.uniform(-math.pi, math.pi)
    apart = 2.0 * radius + gap
    return x + apart * math.cos(angle), y + apart * math.sin(angle)


def near_stroke(scene: Scene, draw: np.random.Generator) -> Stroke:
    """
    Draw a stroke with any offsets and direction, as steep as drawn or as balls and cushions ask.

    If the cue has no room in the drawn direction, the stroke is one that is refused.
    """
    offset, around = MOST_OFFSET * draw.random(), draw.uniform(0.0, 2.0 * math.pi)
    a, b = offset * math.cos(around), offset * math.sin(around)
    azimuth = draw.uniform(-math.pi, math.pi)
    speed = SPEEDS[0] * (SPEEDS[1] / SPEEDS[0]) ** draw.random()
    elevation = draw.uniform(0.0, STEEPEST_CUE) if draw.random() > LOWEST else 0.0
    lowest = float(lowest_elevation(scene, [[a, b, 0.0, azimuth, speed]])[0])
    elevation = max(elevation, min(lowest, 0.5 * math.pi))
    return Stroke.from_offsets(a, b, elevation, azimuth, speed)
