"""What a ball may reach while the tip touches it: other balls, and cushions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.cue_contact import UP
from billiard_shot.shot.model import StrikeModel
from billiard_shot.table.ball_collision import friction_of_balls
from billiard_shot.table.flight_boundary import edge_at, projects_onto_edge
from billiard_shot.table.geometry import layout_of, Table
from billiard_shot.table.params import OFF, TableParams
from billiard_shot.table.rolling_boundary import ARCS, FACINGS

Array = NDArray[np.float64]

REACH = 0.03  # m: farther than a ball goes while the tip of a cue at 10 m/s touches it
FIXED = -1  # in place of the number of a ball: what cannot move


class Neighbour(NamedTuple):
    """A contact of a ball, beside those of TIP and TABLE."""

    a: int  # number of the ball into which the normal points
    b: int  # number of the other ball, or FIXED
    normal: Array  # (3,)
    gap: float  # m, along the normal
    restitution: float
    friction: float  # without slip
    stiffness: float
    fading: float = 0.0  # of the friction, see `Properties`
    decay: float = 0.0  # s/m


def neighbours_of(
    table: TableParams, model: StrikeModel, places: Array
) -> tuple[list[int], list[Neighbour]]:
    """
    Find the balls that may take part in a strike on the first one, and their contacts.

    Parameters
    ----------
    table : TableParams
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
    takes_time = table.ball_duration > 0.0
    near = REACH if takes_time else table.contact_gap
    members = [0]
    if table.pair_gate != OFF:
        for member in members:
            gaps = np.linalg.norm(places - places[member], axis=1) - 2.0 * model.surface.radius
            found = np.flatnonzero(gaps <= near).tolist()
            members += [i for i in found if i not in members]
    layout = layout_of(model.surface, table)
    contacts = [
        ball_contact(layout, places[members], a, b)
        for a in range(len(members))
        for b in range(a + 1, len(members))
    ]
    contacts = [contact for contact in contacts if contact.gap <= near]
    for i, member in enumerate(members):
        contacts += cushion_contacts(layout, places[member], i, near)
    return members, contacts


def ball_contact(table: Table, places: Array, a: int, b: int) -> Neighbour:
    """Contact of two balls at rest; those within the gap of touching bodies touch."""
    n, between = table.numbers, places[a] - places[b]
    distance = float(np.linalg.norm(between))
    gap = distance - 2.0 * table.params.radius
    return Neighbour(
        a,
        b,
        between / distance,
        gap if gap > n.contact_gap else 0.0,
        n.ball_restitution,
        friction_of_balls(n, 0.0),
        n.ball_stiffness,
        n.friction_slow,
        n.friction_decay,
    )


def cushion_contacts(table: Table, place: Array, ball: int, reach: float) -> list[Neighbour]:
    """Contacts of a ball with the cushions within reach and, if it is not the first, the cloth."""
    n, params, (x, y, z) = table.numbers, table.params, place.tolist()
    outside = max(abs(x) - n.nose_half_length, abs(y) - n.nose_half_width)
    if z != params.radius or outside + n.nose_standoff + reach < 0.0:
        return []
    jaws, contacts = len(table.jaws), []
    for feature in (*range(4), *range(FACINGS, FACINGS + jaws), *range(ARCS, ARCS + jaws)):
        nx, ny, away = edge_at(table, feature, x, y)
        level = n.nose_standoff / params.radius
        gap = (away - n.nose_standoff) * level
        if -n.contact_gap <= gap <= reach and projects_onto_edge(table, feature, x, y):
            normal = np.array([nx * level, ny * level, 1.0 - n.nose_height / params.radius])
            contacts.append(
                Neighbour(
                    ball,
                    FIXED,
                    normal,
                    gap if gap > n.contact_gap else 0.0,
                    n.cushion_restitution,
                    n.cushion_friction,
                    n.cushion_stiffness,
                )
            )
    if contacts and ball != 0:
        contacts.append(
            Neighbour(
                ball,
                FIXED,
                UP,
                0.0,
                params.cloth_restitution,
                params.cloth_friction,
                params.cloth_stiffness,
            )
        )
    return contacts
