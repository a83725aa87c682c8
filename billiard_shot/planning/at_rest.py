"""Whether a target was reached, as far as the balls at rest show it."""

from collections.abc import Mapping
import math

from billiard_shot.planning.targets import ANY, Pot, Rest, Target
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.rack import Place


def reached_at_rest(target: Target, places: Mapping[str, Place]) -> tuple[bool, str]:
    """Judge by the places [m] of the balls that are left; return whether, and a sentence."""
    if CUE_BALL not in places:
        return False, 'not reached: the cue ball is not on the table'
    wanted = target.pot if isinstance(target, Pot) and ANY not in target.pot else ()
    fallen = sorted(set(wanted) - set(places))
    if wanted and not fallen:
        return False, f'not reached: still on the table: {", ".join(wanted)}'
    match target:
        case Rest(rest=point) | Pot(leave=point) if point is not None:
            apart = math.dist(places[CUE_BALL], point)
            reached = apart <= target.radius
            return reached, (
                f'{"reached" if reached else "not reached"}: the cue ball rests '
                f'{1e3 * apart:.1f} mm from the point, {1e3 * target.radius:g} mm are allowed'
            )
    if fallen:
        return True, f'reached: pocketed: {", ".join(fallen)}'
    return True, 'not judged: the balls at rest do not show whether it was reached'
