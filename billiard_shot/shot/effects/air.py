"""What happens above the cloth: flight, and the bounces after it."""
from billiard_shot.shot.effects.effect import Gate, Look, Seen
from billiard_shot.shot.model import Model
from billiard_shot.table import surface
from billiard_shot.table.motion import ACCELERATION
from billiard_shot.table.trajectory import EventKind


class Flight(Gate):
    """Without, the ball is put back on the cloth with its horizontal motion kept."""

    name = 'flight'
    needs = 'the ball leaves the cloth, by more than the tolerance'

    def seen(self, look: Look) -> Seen:
        """It rises, and not too little."""
        up = float(look.velocity[2])
        if up <= 0.0:
            return Seen(False, 'the ball does not leave the cloth')
        rise = f'the ball rises by {_rise(look, up)}'
        if _flown(look):
            return Seen(True, rise)
        return Seen(False, f'too small to resolve within the tolerance: {rise}')

    def off(self, model: Model) -> Model:
        """Level motion from the start."""
        return model._replace(surface=model.surface._replace(flight=surface.OFF))

    def on(self, model: Model) -> Model:
        """First flight, whatever its height."""
        return model._replace(surface=model.surface._replace(flight=surface.ON))


class Bounce(Gate):
    """Without, the ball stays down where it first lands."""

    name = 'bounce'
    needs = 'a ball that has flown leaves the cloth again, by more than the tolerance'

    def seen(self, look: Look) -> Seen:
        """Bounces that are not done at once."""
        if not _flown(look):
            return Seen(False, 'there is no flight')
        bounces = sum(event.kind == EventKind.BOUNCE for event in look.trajectory.events)
        again = look.scene.contacts.ball_table.restitution * float(look.velocity[2])
        rise = f'the ball rises by {_rise(look, again)} after it first lands'
        if bounces:
            return Seen(True, f'{rise}; bounces until that is too small: {bounces}')
        return Seen(False, f'too small to resolve within the tolerance: {rise}')

    def off(self, model: Model) -> Model:
        """Cloth without rebound, after the strike."""
        return model._replace(surface=model.surface._replace(restitution=0.0))

    def on(self, model: Model) -> Model:
        """Every hop down to rounding."""
        return model._replace(surface=model.surface._replace(bounce=surface.ON))


def _flown(look: Look) -> bool:
    return bool(look.trajectory.rows[0, ACCELERATION + 2] != 0.0)


def _rise(look: Look, up: float) -> str:
    return f'{1e3 * 0.5 * up * up / look.scene.cloth.gravity:.3g} mm'
