"""
Shots of which only the places of the balls before and after are known, as a camera shows them.

Pictures do not show the first contact, the cushions, and which pocket took a ball. Often the game
goes on in the same way whatever these were; otherwise somebody has to say.
"""

from collections.abc import Collection, Mapping
from itertools import product
import math
from typing import NamedTuple

from billiard_shot.game.call import Call
from billiard_shot.game.checks import check_names
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.referee import judge
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene.placement import CUE_BALL, head_string
from billiard_shot.table.run import POCKET_NAMES

MOVED = 0.005
"""Distance that shows that a ball has moved [m]; smaller ones may be errors of the camera."""

Places = Mapping[str, tuple[float, float]]


def possible_rulings(state: State, call: Call, places: Places) -> tuple[Ruling, ...]:
    """
    Return the rulings that pictures allow, one for each way in which the game may go on.

    Parameters
    ----------
    state : State
        Before the shot.
    call : Call
    places : mapping of str to (x, y)
        The balls that are left, at rest [m]; all others have fallen into pockets.

    """
    gone = [ball for ball in state.balls if ball not in places]
    moved = [
        ball
        for ball in state.object_balls
        if ball in gone or math.dist(state.balls[ball], places[ball]) > MOVED
    ]
    met: list[tuple[str, ...]] = [(ball,) for ball in moved] or [()]
    cushions = frozenset[str](), frozenset((*moved, CUE_BALL))
    kitchens = (False, True) if state.in_hand == 'kitchen' else (False,)
    pockets = (call.pocket, '') if call.ball in gone else ('',)  # of the called ball
    found: list[Ruling] = []
    for first, driven, kitchen, pocket in product(met, cushions, kitchens, pockets):
        outcome = Outcome(
            first_contact=first[0] if first else None,
            pocketed=tuple((ball, pocket if ball == call.ball else '') for ball in gone),
            to_cushion=driven,
            from_kitchen=kitchen,
            met=first,
            cushions_before=(0,) * len(first),
            places=places,
        )
        ruling = judge(state, call, outcome)
        if all(ruling.state != each.state for each in found):
            found.append(ruling)
    return tuple(found)


class Told(NamedTuple):
    """What somebody saw of a shot."""

    first_contact: str = ''  # ball that the cue ball met first; '' if it met none
    to_cushion: Collection[str] = ()  # balls driven to a cushion after the first contact
    pockets: Mapping[str, str] = {}  # of each ball that fell; others that are gone left the table
    double_hit: bool = False  # the cue hit the cue ball twice


def told_outcome(state: State, places: Places, told: Told) -> Outcome:
    """
    Complete what pictures show of a shot by what somebody saw.

    Parameters
    ----------
    state : State
        Before the shot.
    places : mapping of str to (x, y)
        The balls that are left, at rest [m].
    told : Told

    Raises
    ------
    ValueError
        With the field, its value and the allowed names.

    """
    first_contact, to_cushion, pockets, double_hit = told
    gone = [ball for ball in state.balls if ball not in places]
    check_names(
        ('first_contact', (first_contact,), ('', *state.object_balls)),
        ('to_cushion', to_cushion, tuple(state.balls)),
        ('pocketed', pockets, tuple(gone)),
        ('pockets', pockets.values(), POCKET_NAMES),
    )
    return Outcome(
        first_contact=first_contact or None,
        pocketed=tuple(pockets.items()),
        off_table=tuple(ball for ball in gone if ball not in pockets),
        to_cushion=frozenset(to_cushion),
        from_kitchen=bool(first_contact) and state.balls[first_contact][0] < head_string(state),
        double_hit=double_hit,
        met=(first_contact,) if first_contact else (),
        cushions_before=(0,) if first_contact else (),
        places=places,
    )
