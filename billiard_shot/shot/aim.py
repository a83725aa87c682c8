"""Aiming: the azimuth of a stroke that hits a ball at a cut angle, or goes through a point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import must_be_one_of, refused
from billiard_shot.shot.ghost_ball import path_of_cut, path_of_line
from billiard_shot.shot.lowest_elevation import lowest_elevation, Margins, margins_for
from billiard_shot.shot.predict import predict
from billiard_shot.shot.stroke import read_angle, read_numbers, Stroke
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import POCKET_NAMES

AimTarget = str | Sequence[float]  # a ball, or x and y of a point [m]


def aim(
    scene: SceneLike,
    target: AimTarget,
    *,
    speed: float,
    cut: float | None = None,
    cut_deg: float | None = None,
    pocket: str | None = None,
    a: float = 0.0,
    b: float = 0.0,
    elevation: float | None = None,
    elevation_deg: float | None = None,
    margin: float | None = None,
    margin_deg: float | None = None,
    correct_squirt: bool = False,
) -> Stroke:
    """
    Aim a stroke at a ball or at a point.

    Parameters
    ----------
    scene : Scene, str or Path
        Scene with the cue ball and its target.
    target : str or (2,) sequence of float
        Name of a ball, or x and y of a point [m], to which the line of the stroke goes.
    speed : float
        Of the cue [m/s], 1e-12 to 1e12.
    cut : float
        Cut angle [rad], from the line of the stroke to the direction of the ball: positive sends
        the ball to the right, as seen along the stroke. Between -pi/2 and pi/2; 0 by default.
    cut_deg : float
        The same angle in degrees.
    pocket : str
        Pocket into whose middle the ball shall go, instead of a cut angle.
    a, b, elevation, elevation_deg : float
        As for `Stroke.from_offsets`; by default the elevation is the lowest that leaves the
        margin, to 0.05 degrees.
    margin : float
        Angle by which the cue can be lower and still has room [rad], 0 to pi/2. By default the cue
        has room for the errors of the scene's player: lower by three standard deviations of the
        elevation, and of `b`. Fewer than 1 in 200 strokes are refused then.
    margin_deg : float
        The same angle in degrees.
    correct_squirt : bool
        Whether to turn the cue so that the cue ball leaves along the line, in spite of its side
        spin. Neither throw nor swerve is corrected: `plan` does that.

    Raises
    ------
    ValueError
        If there is no such ball or pocket, if the cut is not possible, or a number is out of
        range.

    """
    half = 0.5 * math.pi
    scene = Scene.load(scene)
    is_cut = cut is not None or cut_deg is not None
    if pocket is not None and is_cut:
        raise ValueError('pocket must not be given together with a cut')
    if not isinstance(target, str):
        target = read_numbers('target', target, 2)
        if is_cut:
            raise ValueError('cut must not be given for a point; it needs a ball')
    if elevation is not None or elevation_deg is not None:
        if margin is not None or margin_deg is not None:
            raise ValueError('margin must not be given together with an elevation')
        elevation = read_angle('elevation', elevation, elevation_deg, 0.0, half)
    if margin is not None or margin_deg is not None:
        margin = read_angle('margin', margin, margin_deg, 0.0, half)
    cut = read_angle('cut', cut, cut_deg, -half, half)
    if pocket is not None:
        cut = cut_for_pocket(scene, target, pocket)
    azimuth = azimuth_at(scene, target, cut)
    if elevation is None:
        radius = scene.ball.radius
        margins = margins_for(scene.noise, radius) if margin is None else Margins(0.0, margin)
        rows = [[a, each, 0.0, azimuth, speed] for each in (b, b - margins.b)]
        found = lowest_elevation(scene, rows, margin=margins.elevation).tolist()
        elevation = max(filter(math.isfinite, found), default=0.5 * math.pi)
    stroke = Stroke.from_offsets(a, b, elevation, azimuth, speed)
    if correct_squirt:
        stroke = Stroke.from_offsets(a, b, elevation, azimuth - squirt_of(scene, stroke), speed)
    return stroke


def azimuth_at(scene: Scene, target: AimTarget, cut: float = 0.0) -> float:
    """
    Find the direction in which the cue ball meets a ball at a cut angle [rad], -pi to pi.

    Parameters
    ----------
    scene : Scene
    target : str or (2,) sequence of float
        Ball, or point [m] through which the line of the stroke goes.
    cut : float
        Angle from the line of the stroke to the direction of the ball [rad], clockwise; for a ball
        only.

    Raises
    ------
    ValueError
        If there is no such ball, if the point is the middle of the cue ball, or the cut is not
        possible.

    """
    start = np.array(scene.cue_ball[:2])
    if not isinstance(target, str):
        line = np.array(target, float) - start
        if not line.any():
            raise refused(tuple(target), 'a point other than the middle of the cue ball', 'target')
        return _heading(line)
    away = _place_of(scene, target) - start
    if not abs(cut) < 0.5 * math.pi:
        raise ValueError(f'cut must be between -90 and 90, got {math.degrees(cut):.4g} (degrees)')
    path = path_of_cut(math.hypot(*away), 2.0 * scene.ball.radius, -cut)
    return wrapped(_heading(away) + path)


def cut_for_pocket(scene: Scene, target: AimTarget, pocket: str) -> float:
    """
    Find the cut angle [rad] that sends a ball to the middle of a pocket, without throw.

    Raises
    ------
    ValueError
        If the target is not a ball, if there is no such pocket, or if it cannot be reached.

    """
    if not isinstance(target, str):
        raise ValueError('pocket must not be given for a point; it needs a ball')
    if scene.table is None or not scene.table.pockets:
        raise ValueError('pocket needs a table with pockets; the scene has none')
    if pocket not in POCKET_NAMES:
        raise ValueError(f'pocket {must_be_one_of(POCKET_NAMES, pocket)}')
    place = _place_of(scene, target)
    way = outline_of(scene).holes[POCKET_NAMES.index(pocket), :2] - place
    away = place - np.array(scene.cue_ball[:2])
    line = wrapped(_heading(way) - _heading(away))
    cut = path_of_line(math.hypot(*away), 2.0 * scene.ball.radius, line) - line
    if not abs(cut) < 0.5 * math.pi:
        raise ValueError(
            f'pocket must be one that ball {target!r} reaches by a cut below 90 degrees, got '
            f'{pocket}, {abs(math.degrees(cut)):.0f} degrees'
        )
    return cut


def squirt_of(scene: Scene, stroke: Stroke) -> float:
    """Angle from the line of a stroke to the direction in which the cue ball leaves [rad]."""
    alone = predict(replace(scene, table=None, balls={}), stroke)
    _, _, _, azimuth, _ = stroke.offsets
    return wrapped(_heading(alone.velocity) - azimuth)


def _place_of(scene: Scene, ball: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    if ball not in scene.object_balls:
        raise ValueError(f'target {must_be_one_of(scene.object_balls, ball, "ball")}')
    return np.array(scene.balls[ball])


def _heading(vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    return math.atan2(vector[1], vector[0])
