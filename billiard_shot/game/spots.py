"""
Spots, balls that go back onto them, and racks.

The foot spot, the middle and the head spot are at a quarter, half and three quarters of the
length, seen from the foot (WPA Equipment Specifications); the foot of the table is at +x.
"""

from collections.abc import Iterable, Mapping
import math

from billiard_shot.game.state import State
from billiard_shot.numerics import rounding
from billiard_shot.scene.placement import CUE_BALL, head_string
from billiard_shot.scene.rack import Place, Rack, racked

SPOT_GAP = 1e-4  # m: a spotted ball must not touch the cue ball (WPA 1.4)


def rack_of(layout: str, state: State, balls: tuple[str, ...]) -> dict[str, Place]:
    """
    Rack balls by the seed of a state [m].

    Parameters
    ----------
    layout : str
        As of `Rack`: `eight_ball` or `nine_ball`.
    state : State
        Gives sizes and seed.
    balls : tuple of str
        Those of the layout that are there.

    """
    places = racked(Rack(layout, seed=state.seed), state, state.radius)
    return {ball: place for ball, place in places.items() if ball in balls}


def foot_spot(state: State) -> Place:
    """Return the foot spot [m]."""
    return -head_string(state), 0.0


def head_spot(state: State) -> Place:
    """Return the head spot [m]."""
    return head_string(state), 0.0


def spotted(state: State, balls: Mapping[str, Place], back: Iterable[str]) -> dict[str, Place]:
    """
    Put balls back onto the table (WPA 1.4).

    Each lies on the long string, as near to the foot spot as it can, towards the foot; if the
    string is blocked there, towards the head.

    Parameters
    ----------
    state : State
        Gives the sizes.
    balls : mapping of str to (x, y)
        The balls on the table [m].
    back : iterable of str
        The balls that go back, in this order.

    """
    found = dict(balls)
    spot = foot_spot(state)[0]
    end = 0.5 * state.length - state.radius
    for ball in back:
        beside = [spot]
        for other, (x, y) in found.items():
            reach = _reach(state, other) ** 2 - y * y
            if reach > 0.0:
                beside += [x - math.sqrt(reach), x + math.sqrt(reach)]
        down = sorted(x for x in beside if spot <= x <= end)
        up = sorted((x for x in beside if -end <= x < spot), reverse=True)
        found[ball] = next((x, 0.0) for x in down + up if is_free(state, found, (x, 0.0)))
    return found


def is_free(state: State, balls: Mapping[str, Place], place: Place) -> bool:
    """Whether a ball at a place [m] overlaps no other, and does not touch the cue ball."""
    return all(
        math.dist(place, other) >= _reach(state, ball) - rounding.PLACE
        for ball, other in balls.items()
    )


def _reach(state: State, ball: str) -> float:
    return 2.0 * state.radius + (SPOT_GAP if ball == CUE_BALL else 0.0)
