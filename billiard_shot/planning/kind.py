"""What players call a shot, seen from what happens in it."""

import math

import numpy as np

from billiard_shot.planning.targets import Hit, Pot, Target
from billiard_shot.shot.shot import Shot
from billiard_shot.table.run import NOSE_NAMES, TableEvent
from billiard_shot.table.trajectory import EventKind

STRAIGHT = math.radians(10.0)  # of deflection, below which a cut is none
MASSE = math.radians(30.0)  # elevation from which on a curve is called a massé
CURVED = 0.5  # ball radii that a path has to leave the straight one to be a curve
CUE = 'cue'
MEETINGS = (EventKind.BALL, EventKind.CLUSTER)


def kind_of(shot: Shot, target: Target) -> str:
    """Name a shot: the cue ball's way first, then that of the ball that is to be potted."""
    if shot.table is None:
        return _way(shot, math.inf) or 'direct'
    events = shot.table.events
    meeting = next((e for e in events if e.kind in MEETINGS and CUE in e.balls), None)
    time = meeting.time if meeting else math.inf
    words = [_way(shot, time)]
    if any(_cushion(event, CUE) and event.time < time for event in events):
        words.append('kick')
    if isinstance(target, Pot) and meeting:
        if target.pot not in meeting.balls:
            words.append('combination')
        if any(_cushion(event, target.pot) for event in events):
            words.append('bank')
        elif target.pot in meeting.balls and _deflection(shot, meeting, target.pot) > STRAIGHT:
            words.append('cut')
        if target.leave is not None:
            words.append('position')
    elif isinstance(target, Hit) and meeting and _deflection(shot, meeting, target.hit) > STRAIGHT:
        words.append('cut')
    return ', '.join(word for word in words if word) or 'direct'


def _cushion(event: TableEvent, ball: str) -> bool:
    return event.kind == EventKind.CUSHION and event.place in NOSE_NAMES and ball in event.balls


def _way(shot: Shot, end: float) -> str:
    """Whether the cue ball jumps over a ball, or goes around one, before a time."""
    path = shot.trajectory
    events = (
        event.time
        for event in path.events
        if event.kind in (EventKind.CUSHION, EventKind.BALL, EventKind.CLUSTER)
    )
    end = min(end, path.duration, *events, math.inf)
    places = path.at(np.linspace(0.0, end, 200)).position
    radius = shot.scene.ball.radius
    for name, (x, y) in shot.scene.balls.items():
        beside = np.hypot(places[:, 0] - x, places[:, 1] - y)
        over = (beside < 2.0 * radius) & (places[:, 2] > 1.2 * radius)
        if name != CUE and over.any() and end > 0.0 and beside[-1] > 2.0 * radius:
            return 'jump'
    chord = places[-1, :2] - places[0, :2]
    length = float(np.hypot(*chord))
    away = places[:, :2] - places[0, :2]
    if length > 0.0:
        aside = np.abs(chord[0] * away[:, 1] - chord[1] * away[:, 0]) / length
        if aside.max() > CURVED * radius:
            return 'massé' if shot.stroke.offsets[2] > MASSE else 'curve'
    return ''


def _deflection(shot: Shot, meeting: TableEvent, ball: str) -> float:
    """Angle between the cue ball's way to a ball and that ball's way."""
    assert shot.table is not None
    before = shot.trajectory.at(max(meeting.time - 1e-6, 0.0)).velocity[:2]
    after = shot.table.balls[ball].at(meeting.time).velocity[:2]
    turn = math.atan2(after[1], after[0]) - math.atan2(before[1], before[0])
    return abs((turn + math.pi) % (2.0 * math.pi) - math.pi)
