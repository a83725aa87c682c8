"""
Strikes on a ball that touches, or nearly touches, other balls or a cushion.

The tip presses the ball for about a millisecond. During this time the ball may reach another ball
or a cushion. Tip, balls, cushion and cloth therefore collide at once, with the distances between
them (cue_contact.py).

All strokes of a call have the same balls in the same places, and so the same contacts: first TIP
and TABLE, as in every strike, then those of balls with each other and with cushions.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import CollisionResult
from billiard_shot.shot.cue_contact import meet, Meeting, OTHERS, Outcome, TOLERANCE
from billiard_shot.shot.model import StrikeModel, TABLE, TIP_DURATION, tip_reach
from billiard_shot.shot.neighbours import FIXED, Neighbour
from billiard_shot.shot.strike import MISCUE_SLIP, strike_status
from billiard_shot.status import Status
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.motion import NOTHING

Array = NDArray[np.float64]

FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


class GroupStrike(NamedTuple):
    """What n strikes on a ball among others do."""

    reached: NDArray[np.bool_]  # (n,) whether a contact beside TIP and TABLE closed
    starts: NDArray[np.void]  # (n, balls) BallStart: the balls afterwards
    # Of the last strike, if its phases were asked for: in detail, and the balls that met.
    result: CollisionResult | None
    met: tuple[tuple[int, int], ...]


def may_reach(distance: float, speeds: Array) -> NDArray[np.bool_]:
    """Whether a ball can reach a distance [m] while the tip of a cue [m/s] touches it."""
    reached: NDArray[np.bool_] = distance <= FARTHEST * TIP_DURATION * speeds
    return reached


def strike_group(
    model: StrikeModel,
    members: list[int],
    neighbours: list[Neighbour],
    velocities: Array,
    strikes: NDArray[np.void],
    places: Array,
    phases: int,
) -> GroupStrike:
    """
    Strike the first ball together with its neighbours.

    Parameters
    ----------
    model : StrikeModel
    members, neighbours
        See `neighbours_of`.
    velocities : (n, 3) float array
        Of the cue [m/s].
    strikes : (n,) Strike, changed
        The strikes of the ball alone; afterwards these.
    places : (balls, 3) float array
        Centres [m].
    phases : int
        Of the last strike that are logged; 0: there is no `result`.

    """
    n, speeds = len(strikes), np.linalg.norm(velocities, axis=1)
    axes = velocities / speeds[:, np.newaxis]
    positions = np.tile(places[members], (n, 1, 1))
    still, tip = np.zeros_like(positions), places[0] + tip_reach(model) * strikes['axes'][:, :3]
    before = Meeting(positions, still, still, tip, speeds)
    met = meet(model, axes, before, np.full(n, TOLERANCE), neighbours, phases)
    _write(strikes, met, speeds)
    starts = ball_starts(n, len(places))
    starts['position'] = places
    starts['position'][:, members] = met.after.position
    starts['velocity'][:, members] = met.after.velocity
    starts['spin'][:, members] = met.after.spin
    pushes = sum_of_squares(met.impulses[OTHERS])
    starts['first_contact'] = _first_met(members, neighbours, pushes, len(places))
    pairs = [
        (members[each.a], members[each.b])
        for closings, each in zip(met.closings[-1, TABLE + 1 :].tolist(), neighbours, strict=True)
        if closings and each.b != FIXED
    ]
    reached = np.any(met.closings[OTHERS] > 0, axis=1)
    return GroupStrike(
        reached,
        starts,
        _result(met) if phases else None,
        tuple(pairs) if phases else (),
    )


def _write(strikes: NDArray[np.void], met: Outcome, speeds: Array) -> None:
    """Write what the strikes did to cue, struck ball, tip and table."""
    frames = strikes['axes'].reshape(-1, 2, 3, 3)
    strikes['velocity'], strikes['spin'] = met.after.velocity[:, 0], met.after.spin[:, 0]
    strikes['cue_speed'] = met.after.speed
    strikes['losses'] = met.losses[:, : TABLE + 1].reshape(-1, 4)
    along = frames @ met.impulses[:, : TABLE + 1, :, np.newaxis]
    strikes['impulses'] = along.reshape(-1, 6)
    strikes['tip'] = met.after.tip - met.after.position[:, 0]
    strikes['hits'] = np.maximum(met.hits, 1)
    strikes['phases'], strikes['steps'] = met.phases, met.steps
    miscue = met.first_slip > MISCUE_SLIP * speeds
    strikes['status'] = [
        strike_status(status, slips)
        for status, slips in zip(met.status.tolist(), miscue.tolist(), strict=True)
    ]


def sum_of_squares(vectors: Array) -> Array:
    """Squares of the lengths of vectors on the last axis."""
    total: Array = (vectors**2).sum(axis=-1)
    return total


def _first_met(
    members: list[int], neighbours: list[Neighbour], pushes: Array, balls: int
) -> NDArray[np.int64]:
    """Ball (n, balls) that each one met, the one that it pushed most; or NOTHING."""
    met = np.full((len(pushes), balls), NOTHING)
    most = np.zeros((len(pushes), balls))
    for push, each in zip(pushes.T, neighbours, strict=True):
        if each.b != FIXED:
            a, b = members[each.a], members[each.b]
            for one, other in ((a, b), (b, a)):
                met[:, one] = np.where(push > most[:, one], other, met[:, one])
                most[:, one] = np.maximum(push, most[:, one])
    return met


def _result(met: Outcome) -> CollisionResult:
    """Collect the last strike in detail."""
    return CollisionResult(
        Status(int(met.status[-1])),
        met.after.velocity[-1],
        met.after.spin[-1],
        met.impulses[-1],
        met.losses[-1],
        met.slips[-1],
        met.lengths[-1],
        float(met.duration[-1]),
        met.log,
        int(met.steps[-1]),
    )
