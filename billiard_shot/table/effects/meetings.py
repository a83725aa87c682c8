"""What balls meet on the table: cushions, pockets, each other, with friction, and in clusters."""

from itertools import combinations
import math
from typing import ClassVar

import numpy as np

from billiard_shot.numerics import rounding
from billiard_shot.table import params
from billiard_shot.table.effects.effect import Gate, Look, OFF, ON, Seen
from billiard_shot.table.run import TableEvent
from billiard_shot.table.trajectory import BallState, EventKind

JAW = 'jaw of'
TOGETHER = 'the ball is struck together with what it touches'


class Cushion(Gate[Look]):
    """Without, the cloth goes on for ever; without cushions there are no pockets either."""

    name = 'cushion'
    needs = 'the path of a ball reaches one'
    changes: ClassVar = {OFF: {'length': math.inf, 'pockets': False}}

    def seen(self, look: Look) -> Seen:
        """Events with a nose."""
        if look.scene.table is None:
            return Seen(False, 'the scene has no table: the cloth is endless')
        events = [
            event for event in look.events(EventKind.CUSHION) if not event.place.startswith(JAW)
        ]
        return _count(events, 'a cushion')


class Pocket(Gate[Look]):
    """Without, the cushions go on where the pockets would be."""

    name = 'pocket'
    needs = 'the path of a ball reaches one'
    changes: ClassVar = {OFF: {'pockets': False}, ON: {'pocket_gate': params.ON}}

    def seen(self, look: Look) -> Seen:
        """Balls in pockets, and jaws that were hit."""
        table = look.scene.table
        if table is None or not table.pockets:
            what = 'scene has no table' if table is None else 'table has none'
            return Seen(False, f'the {what}')
        fallen = [f'{event.balls[0]} in {event.place}' for event in look.events(EventKind.POCKET)]
        if fallen:
            return Seen(True, f'balls that fall: {", ".join(fallen)}')
        jaws = [event for event in look.events(EventKind.CUSHION) if event.place.startswith(JAW)]
        return _count(jaws, 'a jaw of a pocket')


class BallBall(Gate[Look]):
    """Without, balls go through each other."""

    name = 'ball_ball'
    needs = 'the path of a ball reaches another one'
    changes: ClassVar = {OFF: {'pair_gate': params.OFF}, ON: {'pair_gate': params.ON}}

    def seen(self, look: Look) -> Seen:
        """Events of two balls or more."""
        if len(look.trajectories) == 1:
            return Seen(False, 'there is no other ball')
        if _in_touch(look):
            return Seen(True, TOGETHER)
        return _count(look.events(EventKind.BALL, EventKind.CLUSTER), 'another ball')


class Throw(Gate[Look]):
    """Without, balls that meet are smooth: no throw, no spin from one to the other."""

    name = 'throw'
    needs = 'balls meet with slip, and have friction'
    changes: ClassVar = {OFF: {'friction_fast': 0.0, 'friction_slow': 0.0}}

    def seen(self, look: Look) -> Seen:
        """Find the fastest slip in which two balls met."""
        balls = look.scene.contacts.ball_ball
        if balls.friction_fast == balls.friction_slow == 0.0:
            return Seen(False, 'balls have no friction on each other')
        slips = [_slip(look, event) for event in look.events(EventKind.BALL, EventKind.CLUSTER)]
        if _in_touch(look):
            return Seen(True, TOGETHER)
        if not slips:
            return Seen(False, 'no ball meets another one')
        if max(slips) < 1e-9:
            return Seen(False, 'the balls meet without slip')
        return Seen(True, f'balls meet with slip, of {max(slips):.3g} m/s at most')


class Cluster(Gate[Look]):
    """Without, bodies in touch meet two by two, one pair after the other."""

    name = 'cluster'
    needs = 'a ball meets one that touches others, or a cushion'
    changes: ClassVar = {OFF: {'contact_gap': -1e-3}}  # m: nothing is ever so deep in another

    def seen(self, look: Look) -> Seen:
        """Events of more than two bodies."""
        events = look.events(EventKind.CLUSTER)
        if look.struck_together:
            return Seen(True, f'{TOGETHER}; later impacts of more than two bodies: {len(events)}')
        if not events:
            return Seen(False, 'no more than two bodies ever meet')
        most = max(events, key=lambda event: len(event.balls))
        return Seen(
            True,
            f'impacts of more than two bodies: {len(events)}, of up to {len(most.balls)} balls',
        )


def _count(events: list[TableEvent], what: str) -> Seen:
    if not events:
        return Seen(False, f'no path reaches {what}')
    first = events[0]
    times = f'{len(events)} time{"s" * (len(events) > 1)}'
    return Seen(True, f'balls meet {what} {times}, first {first.balls[0]} at {first.time:.3g} s')


def _in_touch(look: Look) -> bool:
    """Whether the ball was struck together with another one."""
    if not look.struck_together:
        return False
    places = [ball.at(0.0).position for ball in look.trajectories.values()]
    here = look.trajectory.at(0.0).position
    near = [np.linalg.norm(place - here) <= _reach(look) for place in places]
    return bool(sum(near) > 1)  # with itself


def _reach(look: Look) -> float:
    """How far apart the centres of balls in touch are at most [m]."""
    return 2.0 * look.scene.ball.radius + look.scene.contacts.ball_ball.gap + rounding.PLACE


def _slip(look: Look, event: TableEvent) -> float:
    """Slip of balls just before they meet [m/s]; in a cluster, the largest."""
    radius = look.scene.ball.radius
    states = [_just_before(look, name, event.time) for name in event.balls]
    largest = 0.0
    for one, other in combinations(states, 2):
        between = one.position - other.position
        distance = float(np.linalg.norm(between))
        if distance <= _reach(look):
            normal = between / distance
            slip = one.velocity - other.velocity
            slip = slip - radius * np.cross(one.spin + other.spin, normal)
            largest = max(largest, float(np.linalg.norm(slip - (slip @ normal) * normal)))
    return largest


def _just_before(look: Look, name: str, time: float) -> BallState:
    """State of a ball at the end of what it did before an event."""
    return look.trajectories[name].at(np.nextafter(time, -np.inf))
