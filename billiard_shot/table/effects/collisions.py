"""What balls meet on the table: cushions, pockets, each other, with friction, and in clusters."""

from itertools import combinations
import math
from typing import ClassVar

import numpy as np

from billiard_shot.numerics import rounding
from billiard_shot.table import params
from billiard_shot.table.effects.effect import EffectContext, EffectGate, GateDecision, OFF, ON
from billiard_shot.table.run import TableEvent
from billiard_shot.table.trajectory import BallState, EventKind

JAW = 'jaw of'
TOGETHER = 'the ball reaches what is near during the strike'


class CushionEffect(EffectGate[EffectContext]):
    """If off, the cloth is unbounded, and there are no pockets."""

    name = 'cushion'
    condition = 'the path of a ball reaches a cushion'
    overrides: ClassVar = {OFF: {'length': math.inf, 'pockets': False}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Events with a nose."""
        if context.scene.table is None:
            return GateDecision(False, 'the scene has no table: the cloth is endless')
        if context.struck_together and not _balls_in_strike(context):
            return GateDecision(True, TOGETHER)
        events = [
            event for event in context.events(EventKind.CUSHION) if not event.place.startswith(JAW)
        ]
        decision = _count(events, 'a cushion')
        in_the_air = sum(event.position[2] > context.scene.ball.radius for event in events)
        if context.scene.table.cushion.model == 'han' and in_the_air:
            return decision._replace(
                reason=f'{decision.reason}; {in_the_air} in the air, where `han` does not hold: '
                'with the default model'
            )
        return decision


class PocketEffect(EffectGate[EffectContext]):
    """If off, the cushions go on where the pockets would be."""

    name = 'pocket'
    condition = 'the path of a ball reaches a pocket'
    overrides: ClassVar = {OFF: {'pockets': False}, ON: {'pocket_gate': params.GATE_ON}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Balls in pockets, and jaws that were hit."""
        table = context.scene.table
        if table is None or not table.pockets:
            what = 'scene has no table' if table is None else 'table has none'
            return GateDecision(False, f'the {what}')
        fallen = [
            f'{event.balls[0]} in {event.place}' for event in context.events(EventKind.POCKET)
        ]
        if fallen:
            return GateDecision(True, f'balls that fall: {", ".join(fallen)}')
        jaws = [
            event for event in context.events(EventKind.CUSHION) if event.place.startswith(JAW)
        ]
        return _count(jaws, 'a jaw of a pocket')


class BallBallEffect(EffectGate[EffectContext]):
    """If off, balls go through each other."""

    name = 'ball_ball'
    condition = 'the path of a ball reaches another one'
    overrides: ClassVar = {OFF: {'pair_gate': params.GATE_OFF}, ON: {'pair_gate': params.GATE_ON}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Events of two balls or more."""
        if len(context.run.balls) == 1:
            return GateDecision(False, 'there is no other ball')
        if _balls_in_strike(context):
            return GateDecision(True, TOGETHER)
        return _count(context.events(EventKind.BALL, EventKind.CLUSTER), 'another ball')


class Throw(EffectGate[EffectContext]):
    """If off, balls that meet are smooth: no throw, no spin from one to the other."""

    name = 'throw'
    condition = 'balls meet with slip, and have friction'
    overrides: ClassVar = {OFF: {'friction_fast': 0.0, 'friction_slow': 0.0}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Find the fastest slip in which two balls met."""
        balls = context.scene.contacts.ball_ball
        if balls.friction_fast == balls.friction_slow == 0.0:
            return GateDecision(False, 'balls have no friction on each other')
        slips = [
            _slip(context, event) for event in context.events(EventKind.BALL, EventKind.CLUSTER)
        ]
        if _balls_in_strike(context):
            return GateDecision(True, TOGETHER)
        if not slips:
            return GateDecision(False, 'no ball meets another one')
        if max(slips) < 1e-9:
            return GateDecision(False, 'the balls meet without slip')
        return GateDecision(True, f'balls meet with slip, of {max(slips):.3g} m/s at most')


class Cluster(EffectGate[EffectContext]):
    """If off, bodies in touch meet two by two, one pair after the other."""

    name = 'cluster'
    condition = 'a ball meets another one that is within reach of others'
    # Nothing is ever so deep in another one; and contacts take no time.
    overrides: ClassVar = {OFF: {'contact_gap': -1e-3, 'ball_duration': 0.0}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Events of more than two bodies."""
        events = context.events(EventKind.CLUSTER)
        if context.struck_together:
            return GateDecision(
                True, f'{TOGETHER}; later impacts of more than two bodies: {len(events)}'
            )
        if not events:
            return GateDecision(False, 'no more than two bodies ever meet')
        most = max(events, key=lambda event: len(event.balls))
        return GateDecision(
            True,
            f'impacts of more than two bodies: {len(events)}, of up to {len(most.balls)} balls',
        )


def _count(events: list[TableEvent], what: str) -> GateDecision:
    if not events:
        return GateDecision(False, f'no path reaches {what}')
    first = events[0]
    times = f'{len(events)} time{"s" * (len(events) > 1)}'
    return GateDecision(
        True, f'balls meet {what} {times}, first {first.balls[0]} at {first.time:.3g} s'
    )


def _balls_in_strike(context: EffectContext) -> bool:
    """Whether balls met during the strike."""
    meetings = context.events(EventKind.BALL, EventKind.CLUSTER)
    return context.struck_together and any(event.time == 0.0 for event in meetings)


def _slip(context: EffectContext, event: TableEvent) -> float:
    """Slip of balls just before they meet [m/s]; in a cluster, the largest."""
    radius, balls = context.scene.ball.radius, context.scene.contacts.ball_ball
    reach = 2.0 * radius + balls.gap + rounding.PLACE
    states = [_just_before(context, name, event.time) for name in event.balls]
    largest = 0.0
    for one, other in combinations(states, 2):
        between = one.position - other.position
        distance = float(np.linalg.norm(between))
        if distance <= reach:
            normal = between / distance
            slip = one.velocity - other.velocity
            slip = slip - radius * np.cross(one.spin + other.spin, normal)
            largest = max(largest, float(np.linalg.norm(slip - (slip @ normal) * normal)))
    return largest


def _just_before(context: EffectContext, name: str, time: float) -> BallState:
    """State of a ball at the end of what it did before an event."""
    return context.run.balls[name].at(np.nextafter(time, -np.inf))
