"""
Launches: the start of a shot as numbers that can be fitted, and the ways of the balls after it.

The numbers of a launch: the speed of the struck ball [m/s]; its direction [rad]; its spin times
its radius [m/s] about the axes by which it rolls (follow), turns about the vertical (side), and
curves (masse); and for each ball the distance (x, y) [m] from where it was seen to lie. The struck
ball may lie farther off along its way: this stands for an error of the time of the strike.

If the stroke was commanded, the first five numbers are its errors, in standard deviations: of a,
b, elevation, azimuth and speed. The scene then tells velocity and spin, so that shots decide
numbers of the cue, too.
"""

from dataclasses import replace
import math

import numpy as np

from billiard_shot.calibration.recording import Command, Floats, Frame
from billiard_shot.calibration.watched import Watched
from billiard_shot.planning.strikes import strike_alone
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, nose_standoff
from billiard_shot.scene.player import A, B, with_errors
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.predict import predict
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.initial_states import VECTORS
from billiard_shot.table.simulate import simulate, simulate_batch
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.trajectory import BallState, EventKind

SPEED, DIRECTION, FOLLOW, SIDE, MASSE = range(5)
PLACES = 5  # number of the first place; all before it are those of the strike

SPIN_SIGMAS = (0.8, 0.8, 0.12)
"""
Standard deviations of follow, side and masse, relative to the speed.

A tip meets the ball up to half a radius off its centre, which gives a spin of 5/4 of the speed. A
cue that is raised by 5 degrees turns a tenth of the side into masse.
"""

ERROR_STEP = 0.02
"""Step of the errors of a stroke for differences, in standard deviations."""

LEAST_PLACE_SIGMA = 0.5e-3
"""Places before the strike are known no better [m]: pictures are distorted."""

GAP = 1e-7
"""Gap that is left between balls, and to a nose, if they were seen to overlap [m]."""

PUSHES = 4
"""How often balls that overlap are moved apart: three that touch need two."""

MAX_EVENTS = 2000

CONTACTS = EventKind.BALL, EventKind.CUSHION, EventKind.CLUSTER

SOLVED = Status.OK, Status.OFF_TABLE


def size_of(watched: Watched) -> int:
    """Return how many numbers a launch has."""
    return PLACES + 2 * len(watched.balls)


def prior_of(watched: Watched) -> tuple[Floats, Floats]:
    """Return the likely numbers of a launch, and the inverse of their covariance."""
    n = size_of(watched)
    speed, direction = math.hypot(*watched.velocity), math.atan2(*watched.velocity[::-1])
    mean, precision, sigmas = np.zeros(n), np.zeros((n, n)), np.ones(PLACES)
    if watched.command is None:
        mean[SPEED], mean[DIRECTION] = speed, direction
        sigmas[:] = 0.5 * speed, 0.2, *(each * speed for each in SPIN_SIGMAS)
    precision[range(PLACES), range(PLACES)] = sigmas**-2
    across = np.maximum(watched.rest_sigma, LEAST_PLACE_SIGMA) ** -2
    precision[range(PLACES, n), range(PLACES, n)] = np.repeat(across, 2)
    along = 1.0 / (1.0 / across[0] + (speed * watched.start_sigma) ** 2)
    way = watched.velocity / speed
    struck = slice(PLACES, PLACES + 2)
    precision[struck, struck] += (along - across[0]) * np.outer(way, way)
    return mean, precision


def steps_of(watched: Watched) -> Floats:
    """Return the steps of the numbers of a launch for differences."""
    speed = math.hypot(*watched.velocity)
    steps = np.full(size_of(watched), 2e-6)
    steps[:PLACES] = ERROR_STEP
    if watched.command is None:
        steps[:PLACES] = 1e-5 * speed, 1e-5, 1e-4 * speed, 1e-4 * speed, 1e-4 * speed
    return steps


def launch_of(scene: Scene, frame: Frame, watched: Watched, stroke: Stroke) -> Floats:
    """Return the numbers of the launch that a scene predicts for a stroke."""
    x, y = frame.to_table(watched.rest[0]).tolist()
    shot = predict(replace(scene, balls={CUE_BALL: (x, y)}), stroke)
    launch, _ = prior_of(watched)
    if shot.status.refused:
        return launch
    radius = frame.scale * scene.ball.radius
    (u, v, _), (a, b, c) = shot.velocity.tolist(), (radius * shot.spin).tolist()
    direction = math.atan2(v, u)
    cosine, sine = math.cos(direction), math.sin(direction)
    launch[SPEED], launch[DIRECTION] = frame.scale * math.hypot(u, v), direction + frame.angle
    launch[FOLLOW], launch[SIDE], launch[MASSE] = b * cosine - a * sine, c, a * cosine + b * sine
    return launch


def states_of(scene: Scene, frame: Frame, watched: Watched, launches: Floats) -> TableStates:
    """Return the states of the balls after the strikes of (n, numbers) launches."""
    radius, count = scene.ball.radius, len(watched.balls)
    position = np.full((len(launches), count, 3), radius)
    moved = watched.rest + launches[:, PLACES:].reshape(-1, count, 2)
    position[..., :2] = apart(scene, frame.to_table(moved))
    velocity, spin = np.zeros_like(position), np.zeros_like(position)
    if watched.command is not None:
        velocity[:, 0], spin[:, 0] = _struck(scene, watched.command, launches[:, :PLACES])
        return TableStates(watched.balls, position, velocity, spin)
    direction = launches[:, DIRECTION] - frame.angle
    ahead = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    left = ahead[:, ::-1] * np.array([-1.0, 1.0])
    velocity[:, 0, :2] = launches[:, SPEED, np.newaxis] * ahead
    follow, side, masse = (launches[:, k, np.newaxis] / radius for k in (FOLLOW, SIDE, MASSE))
    spin[:, 0, :2] = follow * left + masse * ahead
    spin[:, 0, 2:] = side
    return TableStates(watched.balls, position, velocity / frame.scale, spin / frame.scale)


def _struck(scene: Scene, command: Command, errors: Floats) -> tuple[Floats, Floats]:
    """
    Strike the ball with errors (n, 5) of a commanded stroke, in standard deviations.

    Returns
    -------
    velocity, spin : (n, 3) float arrays
        Of the ball [m/s] and [rad/s]; NaN if the stroke cannot be played.

    """
    model, radius = model_of(scene), scene.ball.radius
    stroke, noise = command
    # Launches that differ in the places of the balls alone have the same strike.
    different, which = np.unique(errors, axis=0, return_inverse=True)
    away = noise.means(radius) + different * noise.sigmas(radius)
    strokes = with_errors(np.array(stroke.offsets), away)
    if stroke.axis:
        strokes[:, [A, B]] /= 1.0 + model.tip_curvature  # where the tip touches
    struck = strike_alone(model, strokes)
    which = which.ravel()  # of another shape in some versions of NumPy
    return struck.velocity[which], struck.surface[which] / radius


def ways_of(scene: Scene, frame: Frame, watched: Watched, launches: Floats) -> Floats:
    """
    Return where the samples of a shot would lie after (n, numbers) launches.

    Parameters
    ----------
    scene : Scene
    frame : Frame
    watched : Watched
    launches : (n, numbers) float array

    Returns
    -------
    (n, samples, 2) float array
        [m]; infinite for launches that cannot be simulated.

    """
    times = watched.times
    batch = simulate_batch(
        scene,
        states_of(scene, frame, watched, launches),
        max_events=MAX_EVENTS,
        workers=1,
        until=float(times[-1]) + GAP,
        at=times,
    )
    places = frame.to_recording(batch.position_at[:, watched.ball, watched.at, :2])
    places[~np.isin(batch.status, SOLVED)] = np.inf
    return places


def contacts_of(scene: Scene, frame: Frame, watched: Watched, launch: Floats) -> Floats:
    """Return the times [s] at which balls meet balls and cushions after a launch (numbers,)."""
    states = states_of(scene, frame, watched, launch[np.newaxis])
    balls = {
        name: BallState(*(getattr(states, field)[0, i] for field in VECTORS))
        for i, name in enumerate(watched.balls)
    }
    run = simulate(scene, balls, until=watched.duration)
    return np.array([event.time for event in run.events if event.kind in CONTACTS])


def apart(scene: Scene, places: Floats) -> Floats:
    """Move balls (n, balls, 2) [m] out of each other, and out of the noses of a carom table."""
    diameter = 2.0 * scene.ball.radius + GAP
    count = places.shape[1]
    for _ in range(PUSHES):
        for i in range(count):
            for j in range(i + 1, count):
                between = places[:, j] - places[:, i]
                distance = np.linalg.norm(between, axis=-1, keepdims=True)
                push = np.maximum(0.5 * (diameter - distance), 0.0) / np.maximum(distance, GAP)
                places[:, i] -= push * between
                places[:, j] += push * between
        if scene.table is not None and not scene.table.pockets:
            nose = nose_standoff(scene.table.cushion, scene.ball.radius) + GAP
            half = np.array([scene.table.length, scene.table.width]) / 2.0 - nose
            places = np.clip(places, -half, half)
    return places
