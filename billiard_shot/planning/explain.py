"""Why a shot misses a pot: the direction of the ball compared with the ideal direction."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
import math

import numpy as np

from billiard_shot.numerics.angles import wrapped
from billiard_shot.planning.targets import Pot
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.aim import aim
from billiard_shot.shot.ghost_ball import cut_of_path, grazing
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.table.outline import outline_of
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.trajectory import EventKind
from billiard_shot.table.words import ball_in_words, place_in_words

LEAST = math.radians(0.05)  # smaller deviations are not reported
FIRM = 2.0  # m/s, speed of a straight attempt


@dataclass(frozen=True, slots=True)
class Deviation:
    """
    Deviation of a ball from the direction to a pocket, and its causes.

    Angles are in radians. They are positive if they make the cut thicker, that is, turn the ball
    towards the path of the cue ball. The causes add up to `thick`.

    Attributes
    ----------
    ball, pocket : str
    thick : float
        Angle between the ideal direction, to the middle of the pocket, and the real one.
    aim : float
        Deviation if the cue ball went along the stroke, and the balls had no friction.
    squirt : float
        Part because the cue ball does not leave along the stroke.
    swerve : float
        Part because the path of the cue ball is not straight.
    throw : float
        Part because the balls have friction.

    """

    ball: str
    pocket: str
    thick: float
    aim: float
    squirt: float
    swerve: float
    throw: float

    def __str__(self) -> str:
        causes = {name: getattr(self, name) for name in ('aim', 'squirt', 'swerve', 'throw')}
        told = sorted((c for c in causes.items() if abs(c[1]) >= LEAST), key=lambda c: -abs(c[1]))
        why = ', '.join(f'{name} {_side(angle)}' for name, angle in told)
        where = f'{ball_in_words(self.ball)} beside {place_in_words(self.pocket)}'
        return f'{where}: {_side(self.thick)}' + (f' ({why})' if why else '')


def why_missed(shot: Shot, ball: str, pockets: Sequence[str] = POCKET_NAMES) -> str:
    """
    Say why a shot does not pot a ball; '' if it does.

    Parameters
    ----------
    shot : Shot
    ball : str
        The ball that was meant to fall.
    pockets : sequence of str
        Pockets into which it was meant to fall.

    """
    if shot.status.refused:
        return shot.message
    if shot.pocketed.get(ball) in pockets:
        return ''
    if shot.first_contact is None:
        return f'the cue ball passes {ball} at {1e3 * _gap(shot, ball):.0f} mm'
    if shot.first_contact != ball:
        return f'the cue ball meets {shot.first_contact} before {ball}'
    found = deviation_of(shot, ball, pockets)
    return str(found) if found else f'{ball} is not potted'


def deviation_of(shot: Shot, ball: str, pockets: Sequence[str]) -> Deviation | None:
    """
    Compare the direction of a ball after its first contact with the ideal one.

    Returns None if the cue ball never meets that ball, or meets it during the strike, after a
    cushion, or together with other balls. Also None if a straight cue ball would miss the ball, or
    if the nearest pocket is behind.
    """
    event = next((e for e in shot.events if {CUE_BALL, ball} <= {*e.balls}), None)
    if event is None or event.time == 0.0:  # during the strike
        return None
    earlier = (e.kind for e in shot.events if e.time < event.time and CUE_BALL in e.balls)
    if event.kind != EventKind.BALL or EventKind.CUSHION in earlier:
        return None
    start = shot.trajectory.at(0.0)
    before = shot.trajectory.at(np.nextafter(event.time, 0.0))
    state = shot.run.at(event.time)[ball]
    there, touch = state.position[:2], shot.trajectory.at(event.time).position[:2]
    real = _angle(state.velocity)
    holes = outline_of(shot.scene).holes
    ideal = {pocket: _angle(holes[POCKET_NAMES.index(pocket), :2] - there) for pocket in pockets}
    pocket = min(ideal, key=lambda name: abs(wrapped(real - ideal[name])))
    way = _angle(before.velocity)
    # the side on which the ball leaves the path of the cue ball: turning away from it is thin
    side = math.copysign(1.0, wrapped(ideal[pocket] - way))
    lines = [
        _line_of_centres(place[:2], _angle(velocity), there, 2.0 * shot.scene.ball.radius)
        for place, velocity in (
            (shot.position, np.array(shot.stroke.velocity)),
            (start.position, start.velocity),
        )
    ]
    steps = [ideal[pocket], *lines, _angle(there - touch), real]
    if None in steps or abs(wrapped(ideal[pocket] - way)) > 0.5 * math.pi:
        return None
    aim, squirt, swerve, throw = (
        -side * wrapped(other - one)  # type: ignore[operator]
        for one, other in pairwise(steps)
    )
    return Deviation(ball, pocket, aim + squirt + swerve + throw, aim, squirt, swerve, throw=throw)


def why_not_straight(scene: Scene, target: Pot, keep: Sequence[str] = ()) -> str:
    """Say what prevents the best straight pot of a ball outside `keep`; '' if a pot succeeds."""
    reasons = []
    wanted = [each for each in scene.object_balls if target.wants(each) and each not in keep]
    for ball, pocket in product(wanted, target.pocket):
        try:
            shot = predict(scene, aim(scene, ball, pocket=pocket, speed=FIRM))
        except ValueError:  # the pot needs a cut of 90 degrees or more
            continue
        reason = why_missed(shot, ball, [pocket])
        if not reason:
            return ''
        if shot.first_contact == ball:
            found = deviation_of(shot, ball, [pocket])
            if found:
                reasons.append((abs(found.thick), f'a straight shot sends {found}'))
        else:
            reasons.append((math.pi, f'straight at {place_in_words(pocket)}, {reason}'))
    return min(reasons)[1] if reasons else 'no pocket can be reached straight'


def _line_of_centres(start: Array, way: float, there: Array, apart: float) -> float | None:
    """Direction from a ball that goes straight to one that it touches [rad]; None if it misses."""
    away = there - start
    distance, path = math.hypot(*away), wrapped(way - _angle(away))
    if abs(path) >= grazing(distance, apart):
        return None
    return way + cut_of_path(distance, apart, path)


def _gap(shot: Shot, ball: str) -> float:
    """Smallest distance between the surfaces of the cue ball and another one [m]."""
    path = shot.trajectory
    places = path.at(np.linspace(0.0, path.duration, 2000)).position
    return float(
        np.hypot(*(places[:, :2] - shot.scene.balls[ball]).T).min() - 2.0 * shot.scene.ball.radius
    )


def _angle(vector: Array) -> float:
    return math.atan2(vector[1], vector[0])


def _side(angle: float) -> str:
    return f'{"thick" if angle > 0.0 else "thin"} by {math.degrees(abs(angle)):.1f}°'
