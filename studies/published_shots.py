"""The published shots, played with `simulate`."""

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import BallBall, Scene
from billiard_shot.scene.equipment import Table
from billiard_shot.scene.placement import head_string
from billiard_shot.table.run.results import BallState, EventKind, TableRun
from billiard_shot.table.run.simulate import simulate

IDEAL = BallBall(restitution=1.0, friction_fast=0.0, friction_slow=0.0)
START_GAP = 1e-9  # m: from ball to ball before they meet, so that nothing changes on the way
CUT_ANGLES = np.arange(5.0, 85.25, 0.5)  # degrees, among which the largest throw is looked for
SIGHTS = 0.09366  # m: diamonds behind the noses, 3 11/16 in (WPA)
CORNER_FIVE_SPEED = 2.0  # m/s: between medium and fast (Alciatore)
# Running side spins, relative to the spin of a rolling ball, of offsets up to half a radius.
CORNER_FIVE_SIDES = np.arange(0.0, 1.251, 0.05).tolist()
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
    cue = BallState(
        place - (2.0 * radius + START_GAP) * centres, np.array([speed, 0.0, 0.0]), spin
    )
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
    # The command line imports this module to list its commands, and this import takes a second.
    from scipy.optimize import bisect

    return float(
        bisect(lambda ratio: deflection(scene, speed, 0.5, -ratio) - 90.0, 0.0, 1.5, xtol=1e-6)
    )


def throw_angle(scene: Scene, speed: float, cut: float) -> float:
    """Return the throw [degrees] of a stun shot: from the line of centres, back to the cue's."""
    run = collide_two(scene, speed, cut, 0.0)
    time = next(e.time for e in run.events if e.kind == EventKind.BALL)
    return cut - _speed_and_direction(run.balls['object'].at(time).velocity)[1]


def largest_throw(scene: Scene, speed: float) -> tuple[float, float]:
    """Return the largest throw of stun shots and the cut angle where it is [degrees]."""
    throws = [throw_angle(scene, speed, cut) for cut in CUT_ANGLES.tolist()]
    best = int(np.argmax(throws))
    return throws[best], float(CUT_ANGLES[best])


def rebound(scene: Scene, speed: float) -> float:
    """Return the speed [m/s] with which a ball leaves a long cushion that it rolls at squarely."""
    run = bounce_at_cushion(scene, speed, 0.0)
    ball = run.balls['cue']
    met = next(e.time for e in run.events if e.kind == EventKind.CUSHION)
    left = next(segment.end for segment in ball.segments if segment.start == met)
    return _speed_and_direction(ball.at(left).velocity)[0]


def kept_speeds(
    scene: Scene, speed: float, angle: float, follow: float = 1.0
) -> tuple[float, float]:
    """
    Return the speed after a cushion, relative to that before: away from it, and along it.

    After slip the ball rolls; see `bounce_at_cushion`. Along the cushion it is NaN for an angle of
    0.
    """
    run = bounce_at_cushion(scene, speed, angle, follow)
    met = next(e.time for e in run.events if e.kind == EventKind.CUSHION)
    rolls = next(e.time for e in run.events if e.kind == EventKind.ROLL and e.time > met)
    ball = run.balls['cue']
    before, after = ball.at(0.0).velocity, ball.at(rolls).velocity
    return float(-after[1] / before[1]), float(after[0] / before[0]) if angle else math.nan


def bounce_at_cushion(scene: Scene, speed: float, angle: float, follow: float = 1.0) -> TableRun:
    """
    Play a ball that rolls or slides at a long cushion without side spin.

    Parameters
    ----------
    scene : Scene
        With a table.
    speed : float
        Near the cushion [m/s].
    angle : float
        Of its way from the normal of the cushion [degrees].
    follow : float
        Surface speed of its rolling spin over its speed; 1: it rolls.

    """
    table = _table_of(scene)
    radius = scene.ball.radius
    # a quarter of the length from the middle, moving to the middle: no pocket is near
    place = np.array([0.25 * table.length, 0.5 * table.width - 1.5 * radius, radius])
    along, into = -speed * math.sin(math.radians(angle)), speed * math.cos(math.radians(angle))
    spin = follow / radius * np.array([-into, along, 0.0])
    state = BallState(place, np.array([along, into, 0.0]), spin)
    return simulate(replace(scene, rack=None, balls={}), {'cue': state}, tolerance=1e-6)


def table_lengths(scene: Scene, speed: float) -> float:
    """Return the way [table lengths] of a ball that slides from the head spot along the table."""
    table = _table_of(scene)
    state = BallState(
        np.array([head_string(table), 0.0, scene.ball.radius]),
        np.array([speed, 0.0, 0.0]),
        _NOTHING,
    )
    run = simulate(replace(scene, rack=None, balls={}), {'cue': state})
    ball = run.balls['cue']
    places = [ball.at(time).position[0] for time in (0.0, *(e.time for e in run.events))]
    return float(np.abs(np.diff(places)).sum()) / table.length


def third_cushion(scene: Scene, origin: float, first: float, side: float) -> float:
    """
    Return the number at the third cushion of a shot of the corner-five system.

    The ball comes from a long cushion, and meets the other one, a short one and the first one
    again; if it meets fewer, the number is infinite. All places are numbered on the line of the
    diamonds, where the line of the ball's centre crosses it.

    Parameters
    ----------
    scene : Scene
        With a table.
    origin : float
        5 at the corner, and 1/2 less with each diamond.
    first : float
        Diamonds from the far end, at the first cushion.
    side : float
        Running side spin, relative to the spin of a rolling ball.

    """
    table = _table_of(scene)
    radius, diamond = scene.ball.radius, table.length / 8.0
    sights = 0.5 * table.width + SIGHTS
    end = 0.5 * table.length
    start = np.array([end - 2.0 * (origin - 1.0) * diamond, -sights, 0.0])
    line = np.array([end - first * diamond, sights, 0.0]) - start
    line /= np.linalg.norm(line)
    place = start + (SIGHTS + 4.0 * radius) / line[1] * line + np.array([0.0, 0.0, radius])
    velocity = CORNER_FIVE_SPEED * line
    spin = np.array([-velocity[1], velocity[0], side * CORNER_FIVE_SPEED]) / radius
    run = simulate(replace(scene, rack=None, balls={}), {'cue': BallState(place, velocity, spin)})
    met = [e.time for e in run.events if e.kind == EventKind.CUSHION]
    if len(met) < 3:
        return math.inf
    second, third = (run.balls['cue'].at(time).position for time in met[1:3])
    way = third - second
    crossing = third[0] - way[0] / way[1] * (sights + third[1])
    return float(end - crossing) / diamond


def corner_five(
    scene: Scene, system: Sequence[tuple[float, float]]
) -> tuple[float, NDArray[np.float64]]:
    """
    Find the running side spin with which shots of the corner-five system end nearest to it.

    Parameters
    ----------
    scene : Scene
        With a table.
    system : sequence of (origin, first)
        As of `third_cushion`.

    Returns
    -------
    side, thirds : float, (shots,) array
        The side spin and, with it, the numbers at the third cushion.

    """
    thirds = np.array(
        [[third_cushion(scene, *shot, side) for shot in system] for side in CORNER_FIVE_SIDES]
    )
    errors = np.abs(thirds + np.diff(system, axis=1)[:, 0]).max(axis=1)
    best = int(np.argmin(errors))
    return CORNER_FIVE_SIDES[best], thirds[best]


def _table_of(scene: Scene) -> Table:
    if scene.table is None:
        raise ValueError('table: is missing; a rebound needs a scene with a table')
    return scene.table


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
