"""What a ball may reach while the tip touches it: other balls, and cushions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.laws import BISTIFFNESS
from billiard_shot.shot.model import StrikeModel, TIP, tip_stiffness
from billiard_shot.table.ball_collision import friction_of_balls
from billiard_shot.table.contact_duration import stiffness_of
from billiard_shot.table.flight_boundary import edge_at, projects_onto_edge
from billiard_shot.table.geometry import Table, TableNumbers
from billiard_shot.table.params import BallClothParams, OFF
from billiard_shot.table.rolling_boundary import ARCS, FACINGS

Array = NDArray[np.float64]

REACH = 0.03  # m: farther than a ball goes while the tip of a cue at 10 m/s touches it
FIXED = -1  # in place of the number of a ball: what cannot move
UP = np.array([0.0, 0.0, 1.0])


class Nose(NamedTuple):
    """
    The edge of a cushion.

    The horizontal distance of a point from a straight edge is `away` plus the product of (x, y)
    with the point; from a round one it is `away` plus its distance from (x, y).
    """

    x: float
    y: float
    away: float  # m
    is_round: bool
    height: float  # m


class Neighbour(NamedTuple):
    """A contact of a ball, beside those of TIP and TABLE."""

    a: int  # number of the ball into which the normal points
    b: int  # number of the other ball, or FIXED
    nose: Nose | None  # that the ball may meet; if neither ball nor nose, that is the cloth
    restitution: float
    softening: float  # s/m, of the restitution with speed, as of `cushion_fading`
    friction: float  # without slip
    stiffness: float  # N/m^exponent under law `bistiffness`; else only the ratios matter
    fading: float = 0.0  # of the friction, see `Properties`
    decay: float = 0.0  # s/m


def bodies_move(model: StrikeModel) -> bool:
    """Whether bodies move during a strike: only one law defines how contacts close again."""
    return model.law == BISTIFFNESS


def near_distance(model: StrikeModel, table: Table) -> float:
    """Return how far away the neighbours of a ball may be [m]."""
    takes_time = bodies_move(model) and table.numbers.ball_duration > 0.0
    return REACH if takes_time else table.numbers.contact_gap


def neighbours_of(
    table: Table, model: StrikeModel, places: Array
) -> tuple[list[int], list[Neighbour]]:
    """
    Find the balls that may take part in a strike on the first one, and their contacts.

    Parameters
    ----------
    table : Table
    model : StrikeModel
    places : (balls, 3) float array
        Centres [m], the struck ball first.

    Returns
    -------
    members : list of int
        Balls that take part, the struck one first; contacts number them in this order.
    contacts : list of Neighbour
        Beside TIP and TABLE; none if nothing is near.

    """
    near, diameter = near_distance(model, table), 2.0 * model.surface.radius
    members = [0]
    if table.numbers.pair_gate != OFF:
        for member in members:
            gaps = np.linalg.norm(places - places[member], axis=1) - diameter
            found = np.flatnonzero(gaps <= near).tolist()
            members += [i for i in found if i not in members]
    contacts = []
    for a, one in enumerate(members):
        for b, other in enumerate(members[a + 1 :], a + 1):
            if np.linalg.norm(places[one] - places[other]) - diameter <= near:
                contacts.append(ball_contact(table, model, a, b))
    for i, member in enumerate(members):
        contacts += cushion_contacts(table, model, places[member], i, near)
    return members, contacts


def _stiffness(model: StrikeModel, mass: float, duration: float, ratio: float) -> float:
    """Stiffness of a contact with a duration [s], of balls of a mass [kg]; or by its ratio."""
    if not bodies_move(model):
        return ratio
    if duration == 0.0:
        return ratio * tip_stiffness(model) / model.stiffness[TIP]
    return stiffness_of(mass, duration, model.exponent)


def ball_contact(table: Table, model: StrikeModel, a: int, b: int) -> Neighbour:
    """Contact of two balls."""
    n = table.numbers
    stiffness = _stiffness(model, table.params.mass, n.ball_duration, n.ball_stiffness)
    friction = friction_of_balls(n, 0.0)
    fading = n.friction_slow, n.friction_decay
    return Neighbour(a, b, None, n.ball_restitution, 0.0, friction, stiffness, *fading)


def cushion_contacts(
    table: Table, model: StrikeModel, place: Array, ball: int, reach: float
) -> list[Neighbour]:
    """Contacts of a ball with the cushions within reach and, if it is not the first, the cloth."""
    n, params, (x, y, z) = table.numbers, table.params, place.tolist()
    outside = max(abs(x) - n.nose_half_length, abs(y) - n.nose_half_width)
    if outside + params.radius + reach < 0.0:
        return []
    stiffness = _stiffness(model, 2.0 * params.mass, n.cushion_duration, n.cushion_stiffness)
    jaws, contacts = len(table.jaws), []
    for feature in (*range(4), *range(FACINGS, FACINGS + jaws), *range(ARCS, ARCS + jaws)):
        _, _, away = edge_at(table, feature, x, y)
        gap = float(np.hypot(away, z - n.nose_height)) - params.radius
        if away > 0.0 and gap <= reach and projects_onto_edge(table, feature, x, y):
            nose, fading = _nose(table, feature, n), n.cushion_fading
            springs = n.cushion_restitution, fading, n.cushion_friction, stiffness
            contacts.append(Neighbour(ball, FIXED, nose, *springs))
    if contacts and ball != 0:
        contacts.append(_cloth(model, params, ball))
    return contacts


def _nose(table: Table, feature: int, n: TableNumbers) -> Nose:
    if feature < ARCS:
        x, y, away = edge_at(table, feature, 0.0, 0.0)
        return Nose(x, y, away, is_round=False, height=n.nose_height)
    jaw = table.jaws[feature - ARCS]
    return Nose(jaw.arc_x, jaw.arc_y, -jaw.arc_radius, is_round=True, height=n.nose_height)


def _cloth(model: StrikeModel, params: BallClothParams, ball: int) -> Neighbour:
    springs = params.cloth_restitution, 0.0, params.cloth_friction
    stiffness = _stiffness(model, params.mass, 0.0, params.cloth_stiffness)
    return Neighbour(ball, FIXED, None, *springs, stiffness)
