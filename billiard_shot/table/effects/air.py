"""What happens above the cloth: flight, and the bounces after it."""

from typing import ClassVar

from billiard_shot.table import params
from billiard_shot.table.effects.effect import Gate, Look, OFF, ON, Seen
from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import EventKind, Trajectory


class Flight(Gate[Look]):
    """Without, the ball is put back on the cloth with its horizontal motion kept."""

    name = 'flight'
    needs = 'a ball leaves the cloth, by more than the tolerance'
    changes: ClassVar = {OFF: {'flight_gate': params.OFF}, ON: {'flight_gate': params.ON}}

    def seen(self, look: Look) -> Seen:
        """Look for a ball that rises, and not too little."""
        up = float(look.velocity[2])
        rise = f'the ball rises by {_rise(look, up)}'
        if up > 0.0 and _flies(look.trajectory, first=True):
            return Seen(True, rise)
        fliers = [name for name, ball in look.trajectories.items() if _flies(ball)]
        if fliers:
            return Seen(True, f'in an impact, a ball leaves the cloth: {", ".join(fliers)}')
        if up > 0.0:
            return Seen(False, f'too small to resolve within the tolerance: {rise}')
        return Seen(False, 'the ball does not leave the cloth')


class Bounce(Gate[Look]):
    """Without, a ball stays down where it first lands."""

    name = 'bounce'
    needs = 'a ball that has flown leaves the cloth again, by more than the tolerance'
    changes: ClassVar = {
        OFF: {'cloth_restitution': 0.0},
        ON: {'bounce_gate': params.ON},
    }

    def seen(self, look: Look) -> Seen:
        """Bounces that are not done at once."""
        bounces = sum(
            event.kind == EventKind.BOUNCE
            for ball in look.trajectories.values()
            for event in ball.events
        )
        if bounces:
            return Seen(True, f'bounces until those that follow are too small: {bounces}')
        if not any(map(_flies, look.trajectories.values())):
            return Seen(False, 'there is no flight')
        again = look.scene.contacts.ball_table.restitution * max(float(look.velocity[2]), 0.0)
        rise = f'the ball rises by {_rise(look, again)} after it first lands'
        return Seen(False, f'too small to resolve within the tolerance: {rise}')


def _flies(ball: Trajectory, first: bool = False) -> bool:
    """Whether a ball falls freely, in its first piece of motion or in any."""
    rows = ball.rows[:1] if first else ball.rows
    flights = (rows['motion'] == Motion.FLIGHT) & (rows['acceleration'][:, 2] != 0.0)
    return bool(flights.any())


def _rise(look: Look, up: float) -> str:
    return f'{1e3 * 0.5 * up * up / look.scene.cloth.gravity:.3g} mm'
