"""
Places where balls can lie, from sightings with errors.

Balls that touch each other or a cushion are seen to overlap by the errors of the camera. They are
moved apart, and out of the cushion.
"""

from itertools import combinations
import math

from billiard_shot.perception.sightings import Balls, distance_between, Sighting, SURE_SIGMAS
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_place
from billiard_shot.scene.rack import Place
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.geometry import layout_of

MAX_MOVE_ROUNDS = 200
"""Largest number of rounds in which balls are moved: a rack takes 32."""

GAP_AFTER_MOVE = 1e-7
"""Gap between balls, and to a cushion, after they were moved [m]."""


def positions_of(balls: Balls, scene: Scene) -> dict[str, Place]:
    """
    Positions (x, y) [m] of balls on the table of a scene, by name.

    Balls that overlap each other or a cushion by no more than `SURE_SIGMAS` standard deviations
    are moved until they touch. Larger overlaps are kept; the caller must reject them.
    """
    places = {name: ball.position for name, ball in balls.items()}
    diameter = 2.0 * scene.ball.radius
    pairs = []
    for one, other in combinations(balls, 2):
        distance, deviation = distance_between(balls[one], balls[other])
        if diameter - distance <= SURE_SIGMAS * deviation:
            pairs.append((one, other))
    bed = _bed(scene)
    for _ in range(MAX_MOVE_ROUNDS):
        moved = [_push(places, *pair, diameter) for pair in pairs]
        moved += [_pull(places, name, ball, scene, bed) for name, ball in balls.items()]
        if not any(moved):
            break
    return places


def _bed(scene: Scene) -> Place:
    """Half of the length and width of the rectangle in which centres of balls can be [m]."""
    numbers = layout_of(*params_on_table(scene)).numbers
    return numbers.centre_half_length - GAP_AFTER_MOVE, numbers.centre_half_width - GAP_AFTER_MOVE


def _push(places: dict[str, Place], one: str, other: str, diameter: float) -> bool:
    """Move two balls apart, by the same distance each; return whether they overlapped."""
    (x, y), (u, v) = places[one], places[other]
    distance = math.hypot(u - x, v - y)
    if not 0.0 < distance < diameter:
        return False
    part = 0.5 * (diameter + GAP_AFTER_MOVE - distance) / distance
    places[one] = x - part * (u - x), y - part * (v - y)
    places[other] = u + part * (u - x), v + part * (v - y)
    return True


def _pull(places: dict[str, Place], name: str, ball: Sighting, scene: Scene, bed: Place) -> bool:
    """Move a ball out of a cushion, if it may lie at it; return whether it has moved."""
    x, y = places[name]
    if not no_place(scene.table, x, y, scene.ball.radius):
        return False
    along, across = bed
    inside = min(max(x, -along), along), min(max(y, -across), across)
    xx, _, yy = ball.covariance
    if not 0.0 < math.dist(inside, (x, y)) <= SURE_SIGMAS * math.sqrt(max(xx, yy)):
        return False
    places[name] = inside
    return True
