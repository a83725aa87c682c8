"""A scene's table laid out: its numbers, and the lines and arcs that balls meet."""

from functools import lru_cache
import math
from typing import Any

from billiard_shot.impact.options import LAWS
from billiard_shot.records import OBJECTS, Storage
from billiard_shot.scene import Scene
from billiard_shot.scene.equipment import Pocket
from billiard_shot.scene.placement import nose_standoff
from billiard_shot.table.contacts.cushion_models import CUSHION_MODELS, HAN, room_for_rebounds
from billiard_shot.table.model.cue import CueParams, NO_CUE
from billiard_shot.table.model.geometry import (
    BallClothParams,
    GATE_ON,
    Jaw,
    Mouth,
    PackedTable,
    PocketGeometry,
    POCKETS,
    stiffness_of,
    TableModel,
    TableNumbers,
    TableParams,
)
from billiard_shot.table.motion.boundaries import DEPTH_IN_MOUTH


def ball_cloth_params(scene: Scene) -> BallClothParams:
    """Collect what the motion of a ball on the cloth depends on, all effects as called for."""
    return BallClothParams(
        **_floats(scene.ball, 'mass', 'radius', 'inertia'),
        **_floats(scene.cloth, 'gravity', 'sliding_friction', 'spin_deceleration'),
        **_floats(scene.cloth, 'rolling_resistance', 'rolling_rise'),
        **_floats(scene.contacts.ball_table, 'restitution', 'friction', of='cloth'),
        law=LAWS[scene.law],
        exponent=float(scene.exponent),
    )


def _floats(section: object, *fields: str, of: str = '') -> dict[str, Any]:
    """Return numbers of a section of a scene, by their names as numbers `of` something."""
    return {f'{of}_{name}' if of else name: float(getattr(section, name)) for name in fields}


# Two balls that collide may be as far apart, or as deep in each other where they were pressed
# together: they must be among those in touch.
ENDLESS = TableParams(cushion_model=HAN, contact_gap=DEPTH_IN_MOUTH)
"""Cloth without end, for one ball."""


def table_params(scene: Scene) -> TableParams:
    """Collect what there is to meet, all effects as called for; without a table no end."""
    table, balls = scene.table, scene.contacts.ball_ball
    params = ENDLESS._replace(
        **_floats(balls, 'friction_fast', 'friction_slow', 'friction_decay'),
        **_floats(balls, 'restitution', 'stiffness', 'duration', of='ball'),
        contact_gap=max(float(balls.gap), DEPTH_IN_MOUTH),
    )
    if table is None:
        return params
    cushion, corner, side = table.cushion, table.corner, table.side
    return params._replace(
        **_floats(table, 'length', 'width'),
        **_floats(cushion, 'restitution', 'friction', 'depth', of='cushion'),
        **_floats(cushion, 'early_fading', 'fading', of='cushion'),
        **_floats(cushion, 'frequency_ratio', 'stiffness', 'duration', of='cushion'),
        pockets=table.pockets,
        cushion_model=CUSHION_MODELS[cushion.model],
        nose_height=2.0 * scene.ball.radius * cushion.height,
        corner=_mouth(corner),
        side=_mouth(side),
        corner_hole=(corner.shelf + corner.radius - 0.5 * corner.mouth, float(corner.radius)),
        side_hole=(side.shelf + side.radius, float(side.radius)),
    )


def _mouth(pocket: Pocket) -> Mouth:
    """Mouth, sine and cosine of the turn from nose to facing, radius and setback of the jaws."""
    turn, radius = math.radians(180.0 - pocket.cut_deg), float(pocket.jaw_radius)
    setback = pocket.jaw_radius * math.tan(0.5 * turn)
    return float(pocket.mouth), math.sin(turn), math.cos(turn), radius, setback


@lru_cache(maxsize=64)
def lay_out(
    storage: Storage,
    params: BallClothParams,
    table: TableParams,
    hop_tolerance: float = 1.0,
    fast_rebounds: bool = False,
    cue: CueParams = NO_CUE,
) -> PackedTable:
    """
    Lay out a table; not to be changed.

    `hop_tolerance` [m] is for simulations, see `TableNumbers`; for `fast_rebounds` see
    `TableTask`.
    """
    numbers: list[TableNumbers] = storage.records(TableNumbers, 1)
    n = numbers[0]
    standoff = nose_standoff(table.nose_height, params.radius)
    n.endless = table.length == math.inf
    n.nose_standoff = standoff
    n.centre_half_length = 0.5 * table.length - standoff
    n.centre_half_width = 0.5 * table.width - standoff
    n.nose_half_length = n.centre_half_length + standoff
    n.nose_half_width = n.centre_half_width + standoff
    if table.pockets:
        n.corner_end = math.sqrt(0.5) * table.corner[0] + table.corner[4]
        n.side_end = 0.5 * table.side[0] + table.side[4]
    for name, value in table._asdict().items():
        setattr(n, name, value)
    if table.ball_duration > 0.0:
        n.impact_stiffness = stiffness_of(params.mass, table.ball_duration, params.exponent)
    n.hop_tolerance = hop_tolerance
    sine = (n.nose_height - params.radius) / params.radius
    rebounds = (
        room_for_rebounds(storage, params, table, sine) if fast_rebounds else storage.zeros(0)
    )
    return PackedTable(params, numbers, *edges_of(storage, table, params.radius), rebounds, cue)


def edges_of(
    storage: Storage, table: TableParams, radius: float
) -> tuple[list[Jaw], list[PocketGeometry]]:
    """Lay out the jaws and pockets of a table for balls of a radius [m]."""
    count = POCKETS if table.pockets else 0
    jaws: list[Jaw] = storage.records(Jaw, 2 * count)
    pockets: list[PocketGeometry] = storage.records(PocketGeometry, count)
    x, y = 0.5 * table.length, 0.5 * table.width
    at_corner = math.sqrt(0.5) * table.corner[0]
    out = math.sqrt(0.5) * table.corner_hole[0]
    half = 0.5 * table.side[0]
    for i in range(count):
        one, other, pocket = jaws[2 * i], jaws[2 * i + 1], pockets[i]
        if i < 4:
            mouth, sx, sy = table.corner, 1.0 if i in (0, 3) else -1.0, 1.0 if i < 2 else -1.0
            place_jaw(table, one, mouth, (sx * (x - at_corner), sy * y), (sx, 0.0), (0.0, sy))
            place_jaw(table, other, mouth, (sx * x, sy * (y - at_corner)), (0.0, sy), (sx, 0.0))
            pocket.hole_x, pocket.hole_y = sx * (x + out), sy * (y + out)
            pocket.hole_radius = table.corner_hole[1]
        else:
            mouth, sy = table.side, 1.0 if i == 4 else -1.0
            place_jaw(table, one, mouth, (half, sy * y), (-1.0, 0.0), (0.0, sy))
            place_jaw(table, other, mouth, (-half, sy * y), (1.0, 0.0), (0.0, sy))
            pocket.hole_x, pocket.hole_y = 0.0, sy * (y + table.side_hole[0])
            pocket.hole_radius = table.side_hole[1]
        bound_pocket(pocket, (one, other), nose_standoff(table.nose_height, radius))
        if table.pocket_gate == GATE_ON:
            pocket.bounds_half_length, pocket.bounds_half_width = math.inf, math.inf
    return jaws, pockets


Pair = tuple[float, float]


def place_jaw(
    table: TableParams, jaw: Jaw, mouth: Mouth, at: Pair, along: Pair, outward: Pair
) -> None:
    """Place a jaw whose nose runs `along` to a place, where its line meets that of the facing."""
    (x, y), (dx, dy), (ox, oy) = at, along, outward
    _, sine, cosine, radius, setback = mouth
    fx, fy = cosine * dx + sine * ox, cosine * dy + sine * oy
    jaw.arc_x = x - setback * dx + radius * ox
    jaw.arc_y = y - setback * dy + radius * oy
    jaw.arc_radius = radius
    jaw.start_x = x + setback * fx
    jaw.start_y = y + setback * fy
    jaw.end_x = x + table.cushion_depth / sine * fx
    jaw.end_y = y + table.cushion_depth / sine * fy
    jaw.normal_x = sine * dx - cosine * ox
    jaw.normal_y = sine * dy - cosine * oy


def bound_pocket(pocket: PocketGeometry, jaws: tuple[Jaw, Jaw], standoff: float) -> None:
    """Find the rectangle in which a ball's centre can meet anything of the pocket."""
    centres = [(pocket.hole_x, pocket.hole_y, pocket.hole_radius)]
    for jaw in jaws:
        centres += [
            (jaw.arc_x, jaw.arc_y, jaw.arc_radius + standoff),
            (jaw.start_x, jaw.start_y, standoff),
            (jaw.end_x, jaw.end_y, standoff),
        ]
    low_x, high_x = min(x - r for x, _, r in centres), max(x + r for x, _, r in centres)
    low_y, high_y = min(y - r for _, y, r in centres), max(y + r for _, y, r in centres)
    pocket.bounds_x, pocket.bounds_y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
    pocket.bounds_half_length = 0.5 * (high_x - low_x)
    pocket.bounds_half_width = 0.5 * (high_y - low_y)


def layout_of(params: BallClothParams, table: TableParams, cue: CueParams = NO_CUE) -> TableModel:
    """Lay out a table for those who look at it, but simulate nothing."""
    layout = lay_out(OBJECTS, params, table, cue=cue)
    return TableModel(layout.params, layout.numbers[0], *layout[2:])
