"""The shots that were published, played through `simulate`."""

from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import BallBall, Scene
from billiard_shot.table.run import TableRun
from billiard_shot.table.simulate import simulate
from billiard_shot.table.trajectory import BallState, EventKind

IDEAL = BallBall(restitution=1.0, friction_fast=0.0, friction_slow=0.0)
NEAR = 1e-9  # m: from ball to ball before they meet, so that nothing changes on the way
CUTS = np.arange(5.0, 85.25, 0.5)  # degrees, among which the largest throw is looked for
_NOTHING = np.zeros(3)


def endless(scene: Scene, ball_ball: BallBall | None = None) -> Scene:
    """Return a scene with its cloth and ball only; give another contact of balls if wanted."""
    contacts = scene.contacts
    if ball_ball is not None:
        contacts = replace(contacts, ball_ball=ball_ball)
    return replace(scene, contacts=contacts, table=None, rack=None, balls={})


def cut_of(fraction: float) -> float:
    """Return the cut angle [degrees] of a hit that covers this fraction of the object ball."""
    return math.degrees(math.asin(1.0 - fraction))


def collide_two(scene: Scene, speed: float, cut: float, spin_ratio: float) -> TableRun:
    """
    Play a cue ball that moves along x into a resting ball `object`.

    Parameters
    ----------
    scene : Scene
        From `endless`.
    speed : float
        Of the cue ball as they meet [m/s].
    cut : float
        Angle of the line of centres from x [degrees].
    spin_ratio : float
        Forward spin, relative to that of a rolling ball: 1 rolling, 0 stun, negative draw.

    """
    radius = scene.ball.radius
    angle = math.radians(cut)
    centres = np.array([math.cos(angle), math.sin(angle), 0.0])
    place = np.array([0.0, 0.0, radius])
    spin = np.array([0.0, spin_ratio * speed / radius, 0.0])
    cue = BallState(place - (2.0 * radius + NEAR) * centres, np.array([speed, 0.0, 0.0]), spin)
    return simulate(scene, {'cue': cue, 'object': BallState(place, _NOTHING, _NOTHING)})


def after_slip(run: TableRun, name: str) -> tuple[float, float]:
    """Return speed [m/s] and direction [degrees from x] of a ball once it rolls for good."""
    rolls = [e.time for e in run.events if e.kind == EventKind.ROLL and name in e.balls]
    return _speed_and_direction(run.balls[name].at(rolls[-1]).velocity)


def deflection(scene: Scene, speed: float, fraction: float, spin_ratio: float) -> float:
    """Return the angle [degrees] by which a hit of this fraction of the ball turns a cue ball."""
    return -after_slip(collide_two(scene, speed, cut_of(fraction), spin_ratio), 'cue')[1]


def draw_for_right_angle(scene: Scene, speed: float) -> float:
    """Return the backspin, relative to a rolling ball, that turns a half-ball hit by 90 deg."""
    low, high = 0.0, 1.5
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (
            (low, middle) if deflection(scene, speed, 0.5, -middle) > 90.0 else (middle, high)
        )
    return 0.5 * (low + high)


def throw(scene: Scene, speed: float, cut: float) -> float:
    """Return the throw [degrees] of a stun shot: from the line of centres, back to the cue's."""
    run = collide_two(scene, speed, cut, 0.0)
    time = next(e.time for e in run.events if e.kind == EventKind.BALL)
    return cut - _speed_and_direction(run.balls['object'].at(time).velocity)[1]


def largest_throw(scene: Scene, speed: float) -> tuple[float, float]:
    """Return the largest throw of stun shots and the cut angle where it is [degrees]."""
    throws = [throw(scene, speed, cut) for cut in CUTS.tolist()]
    best = int(np.argmax(throws))
    return throws[best], float(CUTS[best])


def rebound(scene: Scene, speed: float) -> float:
    """Return the speed [m/s] with which a ball leaves a long cushion that it rolls at squarely."""
    if scene.table is None:
        raise ValueError('table: is missing; a rebound needs a scene with a table')
    radius = scene.ball.radius
    # a quarter of the length from the middle: no pocket is near
    place = np.array([0.25 * scene.table.length, 0.5 * scene.table.width - 1.5 * radius, radius])
    spin = np.array([-speed / radius, 0.0, 0.0])
    state = BallState(place, np.array([0.0, speed, 0.0]), spin)
    run = simulate(replace(scene, rack=None, balls={}), {'cue': state}, tolerance=1e-6)
    ball = run.balls['cue']
    met = next(e.time for e in run.events if e.kind == EventKind.CUSHION)
    left = next(segment.end for segment in ball.segments if segment.start == met)
    return _speed_and_direction(ball.at(left).velocity)[0]


def roll_out(scene: Scene, speed: float) -> float:
    """Return the distance [m] that a ball which rolls at this speed goes before it rests."""
    radius = scene.ball.radius
    place = np.array([0.0, 0.0, radius])
    spin = np.array([0.0, speed / radius, 0.0])
    run = simulate(endless(scene), {'cue': BallState(place, np.array([speed, 0.0, 0.0]), spin)})
    return float(run.final_position['cue'][0])


def speed_from_ramp(scene: Scene, height: float) -> float:
    """Return the speed [m/s] of a ball that rolled down from a height [m]: 7/10 m v^2 = m g h."""
    share = 1.0 + scene.ball.inertia / (scene.ball.mass * scene.ball.radius**2)
    return math.sqrt(2.0 * scene.cloth.gravity * height / share)


def _speed_and_direction(velocity: NDArray[np.float64]) -> tuple[float, float]:
    x, y = float(velocity[0]), float(velocity[1])
    return math.hypot(x, y), math.degrees(math.atan2(y, x))
