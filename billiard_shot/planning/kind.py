"""Players' name for a shot, derived from its events."""

import math

import numpy as np

from billiard_shot.numerics.angles import wrapped
from billiard_shot.planning.targets import Break, Gate, Hit, Pass, Pot, Safe, Target
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.table.run import NOSE_NAMES, TableEvent
from billiard_shot.table.trajectory import EventKind

STRAIGHT = math.radians(10.0)  # of deflection: smaller ones are not a cut
MASSE = math.radians(30.0)  # elevation: above it, a curve is a massé
CURVED = 0.5  # ball radii: deviation from a straight line that makes a path a curve
TOUCH = 1e-4  # ball radii: balls at smaller distances touch
COLLISIONS = (EventKind.BALL, EventKind.CLUSTER)


def kind_of(shot: Shot, target: Target) -> str:
    """Name a shot: first the path of the cue ball, then that of the ball to be potted."""
    events = shot.events
    collision = next((e for e in events if e.kind in COLLISIONS and CUE_BALL in e.balls), None)
    time = min(collision.time if collision else math.inf, _reached(shot, target))
    words = [_path_name(shot, time)]
    if any(_cushion(event, CUE_BALL) and event.time < time for event in events):
        words.append('kick')
    if isinstance(target, Pot) and collision:
        ball = _potted(shot, target, collision)
        touched = _touches(shot, collision, ball)
        if not touched:
            words.append('combination')
        if any(_cushion(event, ball) for event in events):
            words.append('bank')
        elif touched and _deflection(shot, collision, ball) > STRAIGHT:
            words.append('cut')
        if target.leave is not None:
            words.append('position')
    elif (
        isinstance(target, Hit)
        and collision
        and _deflection(shot, collision, target.hit) > STRAIGHT
    ):
        words.append('cut')
    elif isinstance(target, Safe | Break):
        words.append('safety' if isinstance(target, Safe) else 'break')
    return ', '.join(word for word in words if word) or 'direct'


def _potted(shot: Shot, target: Pot, collision: TableEvent) -> str:
    """Find the ball that the stroke pots; if it pots none, the one that is met first."""
    fell = (ball for ball, pocket in shot.pocketed.items() if pocket in target.pocket)
    met = (ball for ball in collision.balls if ball != CUE_BALL)
    return next(
        (ball for ball in (*fell, *met) if ball != CUE_BALL and target.wants(ball)), target.pot[0]
    )


def _touches(shot: Shot, collision: TableEvent, ball: str) -> bool:
    """Say whether the cue ball touches a ball in a collision, or only balls that touch it."""
    apart = math.dist(
        *(shot.run.balls[name].at(collision.time).position for name in (CUE_BALL, ball))
    )
    return ball in collision.balls and (
        ball == shot.first_contact or apart <= (2.0 + TOUCH) * shot.scene.ball.radius
    )


def _reached(shot: Shot, target: Target) -> float:
    """Time at which the cue ball reaches the point or gate that it has to pass; else infinite."""
    match target:
        case Pass():
            point, radius = np.array(target.passing), target.radius
        case Gate():
            point, radius = np.mean(target.gate, axis=0), 0.5 * math.dist(*target.gate)
        case _:
            return math.inf
    path = shot.trajectory
    speed = max(float(np.hypot(*segment.velocity[:2])) for segment in path.segments)
    times = np.linspace(0.0, path.duration, 2 + math.ceil(4.0 * speed * path.duration / radius))
    apart = np.hypot(*(path.at(times).position[:, :2] - point).T)
    near = np.flatnonzero(apart <= radius)
    return float(times[near[0]]) if len(near) else math.inf


def _cushion(event: TableEvent, ball: str) -> bool:
    return event.kind == EventKind.CUSHION and event.place in NOSE_NAMES and ball in event.balls


def _path_name(shot: Shot, end: float) -> str:
    """Say whether the cue ball jumps over a ball, or curves around one, before a time."""
    path = shot.trajectory
    stops = EventKind.CUSHION, *COLLISIONS
    end = min(end, path.duration, *(e.time for e in path.events if e.kind in stops))
    places = path.at(np.linspace(0.0, end, 200)).position
    radius = shot.scene.ball.radius
    for name, (x, y) in shot.scene.balls.items():
        beside = np.hypot(places[:, 0] - x, places[:, 1] - y)
        over = (beside < 2.0 * radius) & (places[:, 2] > 1.2 * radius)
        if name != CUE_BALL and over.any() and end > 0.0 and beside[-1] > 2.0 * radius:
            return 'jump'
    chord = places[-1, :2] - places[0, :2]
    length = float(np.hypot(*chord))
    away = places[:, :2] - places[0, :2]
    if length > 0.0:
        aside = np.abs(chord[0] * away[:, 1] - chord[1] * away[:, 0]) / length
        if aside.max() > CURVED * radius:
            return 'massé' if shot.stroke.offsets[2] > MASSE else 'curve'
    return ''


def _deflection(shot: Shot, collision: TableEvent, ball: str) -> float:
    """Angle between the directions of the cue ball before a collision and of the ball after it."""
    before = shot.trajectory.at(max(collision.time - 1e-6, 0.0)).velocity[:2]
    if collision.time == 0.0:  # during the strike
        before = np.array(shot.stroke.velocity[:2])
    after = shot.run.balls[ball].at(collision.time).velocity[:2]
    turn = math.atan2(after[1], after[0]) - math.atan2(before[1], before[0])
    return abs(wrapped(turn))
