"""What happens above the cloth: flight, and the bounces after it."""

from typing import ClassVar

from billiard_shot.table import params
from billiard_shot.table.effects.effect import EffectContext, EffectGate, GateDecision, OFF, ON
from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import EventKind, Trajectory


class Flight(EffectGate[EffectContext]):
    """If off, the ball is put back on the cloth with its horizontal motion kept."""

    name = 'flight'
    condition = 'a ball leaves the cloth, by more than the tolerance'
    overrides: ClassVar = {
        OFF: {'flight_gate': params.GATE_OFF},
        ON: {'flight_gate': params.GATE_ON},
    }

    def evaluate(self, context: EffectContext) -> GateDecision:
        """EffectContext for a ball that rises, and not too little."""
        up = float(context.velocity[2])
        rise = f'the ball rises by {_rise(context, up)}'
        if up > 0.0 and _flies(context.run.balls[context.run.names[0]], first=True):
            return GateDecision(True, rise)
        fliers = [name for name, ball in context.run.balls.items() if _flies(ball)]
        if fliers:
            return GateDecision(
                True, f'in an impact, a ball leaves the cloth: {", ".join(fliers)}'
            )
        if up > 0.0:
            return GateDecision(False, f'too small to resolve within the tolerance: {rise}')
        return GateDecision(False, 'the ball does not leave the cloth')


class Bounce(EffectGate[EffectContext]):
    """If off, a ball stays down where it first lands."""

    name = 'bounce'
    condition = 'a ball that has flown leaves the cloth again, by more than the tolerance'
    overrides: ClassVar = {
        OFF: {'cloth_restitution': 0.0},
        ON: {'bounce_gate': params.GATE_ON},
    }

    def evaluate(self, context: EffectContext) -> GateDecision:
        """Bounces that are not done at once."""
        bounces = sum(
            event.kind == EventKind.BOUNCE
            for ball in context.run.balls.values()
            for event in ball.events
        )
        if bounces:
            return GateDecision(True, f'bounces until those that follow are too small: {bounces}')
        if not any(map(_flies, context.run.balls.values())):
            return GateDecision(False, 'there is no flight')
        again = context.scene.contacts.ball_table.restitution * max(
            float(context.velocity[2]), 0.0
        )
        rise = f'the ball rises by {_rise(context, again)} after it first lands'
        return GateDecision(False, f'too small to resolve within the tolerance: {rise}')


def _flies(ball: Trajectory, first: bool = False) -> bool:
    """Whether a ball falls freely, in its first piece of motion or in any."""
    rows = ball.rows[:1] if first else ball.rows
    flights = (rows['motion'] == Motion.FLIGHT) & (rows['acceleration'][:, 2] != 0.0)
    return bool(flights.any())


def _rise(context: EffectContext, up: float) -> str:
    return f'{1e3 * 0.5 * up * up / context.scene.cloth.gravity:.3g} mm'
