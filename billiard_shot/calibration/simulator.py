"""A simulator of others as a table: it is asked for shots, whose strokes are known."""

from collections.abc import Mapping
from dataclasses import replace
import math
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.calibration.recording import RecordedShot, Recording, Track
from billiard_shot.planning.problem import limits_of, raise_for_clearance
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import as_floats, check_type, whole
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.shot.stroke import Stroke

SHOTS = 40
"""Number of shots that a simulator is asked for."""

OBJECT_BALL = '1'

FROM_NOSES, APART = 3.0, 6.0
"""Least distances of the balls from the noses and from each other, in ball radii."""

SLOWEST, FASTEST = 0.5, 4.0
"""Speeds of the cue [m/s], as far as the robot of the scene allows them."""

STEEPEST = math.radians(10.0)
"""Largest elevation, unless the cue needs more for clearance [rad]."""

OFF_CENTRE = 0.6
"""Largest offsets of the tip to each side, relative to the robot's limit."""

ASIDE = 2.2
"""How far beside the middle of a ball the strokes at it aim, at most, in ball radii."""

TRIES = 1000
"""How many strokes are drawn until the cue has room."""

BEHIND, LEVEL_SPEED, BEFORE_RETURN = 2.5, 1.0, 0.3
"""
Distance of a ball in the way of the cue from the cue ball, in ball radii; speed of the cue [m/s];
time within which the cue ball does not come back [s].
"""

SIGMA = 1e-4
"""Standard deviation of places that a simulator tells [m]."""


class Simulator(Protocol):
    """A function that plays a stroke, by simulation or with a robot."""

    def __call__(
        self, scene: Scene, stroke: Stroke, errors: np.random.Generator
    ) -> Mapping[str, ArrayLike]:
        """
        Play a stroke with the errors of the player.

        Parameters
        ----------
        scene : Scene
            With the balls as they lie.
        stroke : Stroke
            As it is commanded.
        errors : numpy.random.Generator
            Source of the errors of the execution.

        Returns
        -------
        mapping of str to (n, 3) array_like
            Of each ball, as long as it is on the table: times since the strike, ascending [s], x
            and y [m]. 20 a second are enough.

        Raises
        ------
        ValueError
            If the stroke cannot be played, as when a ball is in the way of the cue.

        """


def without_obstacles(simulator: Simulator, scene: Scene) -> Scene:
    """
    Return the scene with a cue that passes through balls and cushions, if the simulator's does.

    A level cue strikes the cue ball through another one. The cue of the simulator passes if the
    cue ball leaves, and the other ball stays.
    """
    gap = BEHIND * scene.ball.radius
    balls = {CUE_BALL: (0.0, 0.0), OBJECT_BALL: (-gap, 0.0)}
    there = replace(scene, balls=balls, cue=replace(scene.cue, length=0.0))
    stroke = Stroke.from_offsets(0.0, 0.0, 0.0, 0.0, LEVEL_SPEED)
    try:
        tracks = _tracks(balls, simulator(there, stroke, np.random.default_rng(0)))
    except ValueError:
        return scene
    cue, other = (
        float(np.ptp(track.place[track.time < BEFORE_RETURN, 0])) for track in tracks.values()
    )
    return replace(there, balls=scene.balls) if cue > gap and other < SIGMA else scene


def recording_of(
    simulator: Simulator, scene: SceneLike, shots: int = SHOTS, seed: int = 1
) -> Recording:
    """
    Record shots of a simulator, slow and fast ones, at a ball and at cushions.

    Parameters
    ----------
    simulator : Simulator
    scene : Scene, str or Path
        Its table, the limits of its strokes, and its noise: the errors of the simulator.
    shots : int
        At least 1.
    seed : int
        Of places, strokes and errors.

    Raises
    ------
    ValueError
        If an argument makes no sense, or what the simulator returns.

    """
    scene, shots = Scene.load(scene), whole('shots', shots, 1)
    draw = np.random.default_rng(whole('seed', seed, 0))
    played = []
    for number, speed in enumerate(draw.permutation(np.geomspace(SLOWEST, FASTEST, shots))):
        there, stroke = _shot(scene, float(speed), number % 2 == 0, draw)
        tracks = _tracks(there.balls, simulator(there, stroke, draw))
        played.append(RecordedShot(str(number + 1), tracks, CUE_BALL, stroke, scene.noise, 0.0))
    return Recording('simulator', tuple(played), exact=True)


def _shot(
    scene: Scene, speed: float, hits: bool, draw: np.random.Generator
) -> tuple[Scene, Stroke]:
    """Draw places of two balls, and a stroke at the other one or in any direction."""
    if scene.table is None:
        raise ValueError('scene must have a table, got an endless cloth')
    radius, limits = scene.ball.radius, limits_of(scene, None, scene.noise)
    half = 0.5 * np.array([scene.table.length, scene.table.width]) - FROM_NOSES * radius
    for _ in range(TRIES):
        cue, other = draw.uniform(-half, half, (2, 2))
        distance = float(np.linalg.norm(other - cue))
        aside = draw.uniform(-ASIDE, ASIDE) * radius
        azimuth = draw.uniform(-math.pi, math.pi)
        if hits:
            azimuth = math.atan2(*(other - cue)[::-1]) + math.atan2(aside, distance)
        a, b = scene.robot.offset_max * draw.uniform(-OFF_CENTRE, OFF_CENTRE, 2)
        stroke = np.array([[a, b, draw.uniform(0.0, STEEPEST), azimuth, speed]])
        if distance < APART * radius:
            continue
        balls = {CUE_BALL: tuple(cue.tolist()), OBJECT_BALL: tuple(other.tolist())}
        there = replace(scene, balls=balls)
        (stroke,) = raise_for_clearance(there, limits, limits.clip(stroke))
        if np.isfinite(stroke).all():
            return there, Stroke.from_offsets(*stroke.tolist())
    raise ValueError(
        'scene must have room for two balls and the cue, within the limits of its robot'
    )


def _tracks(lying: Mapping[str, Place], seen: Mapping[str, ArrayLike]) -> dict[str, Track]:
    """Check the result of a simulator; put the places before the strike first."""
    check_type('the result of the simulator', seen, Mapping)
    tracks = {}
    for name, place in lying.items():
        if name not in seen:
            raise ValueError(f'simulator must return all balls, got {sorted(seen)} without {name}')
        rows = as_floats(seen[name])
        if rows.ndim != 2 or rows.shape[1] != 3 or not np.isfinite(rows).all():
            wanted = must_be('(n, 3) finite times, x and y', rows.shape)
            raise ValueError(f'simulator: ball {name!r} {wanted} (s, m, m)')
        rows = np.concatenate([[(0.0, *place)], rows[rows[:, 0] > 0.0]])
        if not (np.diff(rows[:, 0]) > 0.0).all():
            raise ValueError(f'simulator: times of ball {name!r} must ascend')
        tracks[name] = Track(rows[:, 0], rows[:, 1:], np.full(len(rows), SIGMA))
    return tracks
