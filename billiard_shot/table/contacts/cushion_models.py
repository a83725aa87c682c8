"""
Models of the cushion: how a ball that lies on the cloth leaves it.

Searches and batches interpolate rebounds in a table. A ball that meets a nose has five velocities:
two of its centre, three of its spin. The forces depend on four combinations of these only: the
speed of approach, the slip at the nose along the cushion, and the two slips at the cloth. The
other slip at the nose follows from these, because the ball lies. All velocities scale alike. So
the changes of velocity, relative to the speed of approach, depend on three ratios and on the
nose's restitution, in which the speed matters. Left and right are alike.

The table is linear between its nodes. A node is solved by `follow` when it is first needed. The
numbers of a node do not depend on the rebound that needs them: threads may fill a table together,
and results do not depend on the order.

Friction at the nose may lift the ball. A node whose ball is in the air at the end has no numbers,
and all rebounds near that node are solved. docs/accuracy.md lists the errors.
"""

from __future__ import annotations

from functools import lru_cache
import math
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import Floats, ROWS, Storage, Vector
from billiard_shot.table.contacts.rebound import (
    ALONG,
    cloth_slip,
    follow,
    nose_slip,
    VX,
    VY,
    VZ,
    WX,
    WY,
    WZ,
    Y,
    Z,
)
from billiard_shot.table.model.geometry import BallClothParams, TableParams
from billiard_shot.table.model.motion import Rebound
from billiard_shot.table.motion.ball_impact import collide_fixed

if TYPE_CHECKING:
    from billiard_shot.table.model.geometry import TableModel, TableNumbers
    from billiard_shot.table.model.motion import BallRecord

MATHAVAN, HAN, STRONGE = 0, 1, 2
CUSHION_MODELS = {'mathavan': MATHAVAN, 'han': HAN, 'stronge': STRONGE}
LEAST_RESTITUTION = 0.05  # that of scenes


@innermost
def restitution_at(n: TableNumbers, ball: BallRecord, x: float, y: float, z: float) -> float:
    """Restitution of a cushion with the normal (x, y, z) for a ball as fast as this one."""
    speed = abs(x * ball.velocity[0] + y * ball.velocity[1] + z * ball.velocity[2])
    late, early = n.cushion_fading * speed, n.cushion_early_fading * speed
    return max(n.cushion_restitution / (1.0 + early + late * late), LEAST_RESTITUTION)


@inner
def change_velocity(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> None:
    """Change velocity and spin of a ball at a cushion with the normal (x, y, z) by its model."""
    if table.numbers.cushion_model == HAN:
        collide_han(table, ball, x, y, z)


@inner
def collide_han(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> None:
    """Let a ball collide with a cushion as if there were no cloth (Han 2005)."""
    restitution = restitution_at(table.numbers, ball, x, y, z)
    collide_fixed(
        table.params, ball, x, y, z, restitution, friction=table.numbers.cushion_friction
    )


@inner
def collide_lying(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> float:
    """
    Write how a lying ball leaves a cushion whose normal is (x, y, z), by a model in closed form.

    Velocity and spin after the contact are its `exit_velocity` and `exit_spin`. Return the way
    along the cushion during the contact [m].
    """
    v, w = ball.velocity, ball.spin
    vx, vy, wx, wy, wz = v[0], v[1], w[0], w[1], w[2]
    change_velocity(table, ball, x, y, z)
    for i in range(3):
        ball.exit_velocity[i], ball.exit_spin[i] = v[i], w[i]
    ball.exit_velocity[2] = 0.0  # the cloth holds it
    along = (x * (vy + v[1]) - y * (vx + v[0])) / math.sqrt(x * x + y * y)
    v[0], v[1], v[2], w[0], w[1], w[2] = vx, vy, 0.0, wx, wy, wz
    return 0.5 * table.numbers.cushion_duration * along


# Intervals of the ratios of slips at nose and cloth, and of the restitution.
NOSE_INTERVALS, CLOTH_INTERVALS, RESTITUTION_INTERVALS = 24, 32, 20
TABLES = 8  # kept, of different balls, cloths and cushions
LEAST_TABLED_RESTITUTION = 0.05
NODE_ERROR = 5e-5  # of a step, relative to the ball's speed
NEGLIGIBLE = 1e-9  # weight of a node
# Numbers of a node: changes of velocity and spin relative to the speed of approach, the time, and
# the way along the cushion beyond that of the first velocity. 0: not solved yet.
D_VX, D_VY, D_WX, D_WZ, TIME, WAY_BEYOND = range(6)
NUMBERS = 6
UNSOLVED_YET, ZERO = 0.0, 1e-300


def room_for_rebounds(
    storage: Storage, params: BallClothParams, table: TableParams, sine: float
) -> Floats:
    """
    Return the table of a cushion, or an empty one if all its rebounds are to be solved.

    Interpreted functions use no table: to fill the nodes around a rebound takes sixteen times as
    long as to solve it.

    Parameters
    ----------
    storage : Storage
    params, table : BallClothParams, TableParams
    sine : float
        Of the angle of the nose above the ball's centre.

    """
    if storage is not ROWS or table.cushion_model != MATHAVAN:
        return storage.zeros(0)
    return _table(
        sine,
        params.mass * params.radius**2 / params.inertia,
        params.sliding_friction,
        params.cloth_restitution,  # of a ball that friction lifts, and that lands
        params.cloth_friction,
        table.cushion_friction,
        table.cushion_frequency_ratio,
    )


@lru_cache(TABLES)
def _table(sine: float, *others: float) -> Floats:
    """Return a table without solved nodes; the first number is the sine."""
    del others
    # The system gives memory only to pages that are written to.
    table = ROWS.zeros(
        1 + NOSE_INTERVALS * (CLOTH_INTERVALS - 1) ** 2 * (RESTITUTION_INTERVALS + 1) * NUMBERS
    )
    table[0] = sine
    return table


@innermost
def part_of_axis(ratio: float) -> float:
    """Return where a ratio, of any size and sign, is on an axis from 0 to 1."""
    return 0.5 + 0.5 * ratio / (1.0 + abs(ratio))


@innermost
def ratio_at(part: float) -> float:
    """Return the ratio that is at a part of the axis."""
    t = 2.0 * part - 1.0
    return t / (1.0 - abs(t))


@innermost
def node_at(nose: int, across: int, into: int, layer: int) -> int:
    """Return where the numbers of a node begin."""
    place = (nose * (CLOTH_INTERVALS - 1) + across - 1) * (CLOTH_INTERVALS - 1) + into - 1
    return 1 + NUMBERS * (place * (RESTITUTION_INTERVALS + 1) + layer)


@inner
def is_solved(table: Vector, node: int) -> bool:
    """Whether this thread or another one has written all numbers of a node."""
    left = 0
    for i in range(NUMBERS):
        left += table[node + i] == UNSOLVED_YET
    return left == 0


@inner
def solve_node(table: Floats, r: Rebound, nose: int, across: int, into: int, layer: int) -> None:
    """Solve the rebound of a node; if that fails, its numbers are NaN."""
    slip, p = ratio_at(0.5 + 0.5 * nose / NOSE_INTERVALS), ratio_at(across / CLOTH_INTERVALS)
    state = r.state
    for i in range(len(state)):
        state[i] = 0.0
    # of all balls with these slips the one that does not move along the cushion
    state[VY], state[WX], state[WY] = 1.0, ratio_at(into / CLOTH_INTERVALS) - 1.0, -p
    state[WZ] = -(slip + r.sine * p) / r.cosine
    speed = max(1.0, abs(state[WX]), abs(state[WY]), abs(state[WZ]))
    for i in range(VX, WZ + 1):
        state[i] /= speed
    wx, wz = state[WX], state[WZ]
    r.restitution = max(layer / RESTITUTION_INTERVALS, LEAST_TABLED_RESTITUTION)
    r.time, r.held = 0.0, True
    solved = follow(r, NODE_ERROR) and r.held
    node = node_at(nose, across, into, layer)
    for i in range(NUMBERS):
        value = r.time
        if i == D_VX:
            value = state[VX] * speed
        elif i == D_VY:
            value = state[VY] * speed - 1.0
        elif i == D_WX:
            value = (state[WX] - wx) * speed
        elif i == D_WZ:
            value = (state[WZ] - wz) * speed
        elif i == WAY_BEYOND:
            value = state[ALONG] * speed
        if value == UNSOLVED_YET:
            value = ZERO
        table[node + i] = value if solved else nan


@inner
def interpolate_rebound(table: Floats, r: Rebound) -> bool:
    """
    Let a lying ball leave the nose as the table says; return whether it says anything.

    Parameters
    ----------
    table : list of float
        Nodes that are needed and not solved yet are solved.
    r : Rebound, changed
        As for `follow`, which it must be left to if this returns False.

    """
    # The direction of the cushion rounds these otherwise, and nodes would depend on it.
    r.sine, r.cosine = table[0], sqrt(1.0 - table[0] * table[0])
    state, restitution, speed = r.state, r.restitution, r.state[VY]
    vx, vy, wx, wy, wz = state[VX], state[VY], state[WX], state[WY], state[WZ]
    slip, _ = nose_slip(r, state)
    p, q = cloth_slip(state)
    side = 1.0 if slip >= 0.0 else -1.0
    if speed <= 0.0 or not abs(slip) + abs(p) + abs(q) < inf:
        return False
    x = (2.0 * part_of_axis(side * slip / speed) - 1.0) * NOSE_INTERVALS
    y, z = (
        part_of_axis(side * p / speed) * CLOTH_INTERVALS,
        part_of_axis(q / speed) * CLOTH_INTERVALS,
    )
    e = restitution * RESTITUTION_INTERVALS
    nose = min(int(x), NOSE_INTERVALS - 2)
    across, into = (
        min(max(int(y), 1), CLOTH_INTERVALS - 2),
        min(max(int(z), 1), CLOTH_INTERVALS - 2),
    )
    layer = min(int(e), RESTITUTION_INTERVALS - 1)
    x, y, z = min(x - nose, 1.0), min(max(y - across, 0.0), 1.0), min(max(z - into, 0.0), 1.0)
    e -= layer
    d_vx, d_vy, d_wx, d_wz, time, beyond = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for corner in range(16):
        i, j, k, m = corner >> 3, corner >> 2 & 1, corner >> 1 & 1, corner & 1
        weight = (x if i else 1.0 - x) * (y if j else 1.0 - y)
        weight *= (z if k else 1.0 - z) * (e if m else 1.0 - e)
        if weight < NEGLIGIBLE:
            continue
        node = node_at(nose + i, across + j, into + k, layer + m)
        if not is_solved(table, node):
            solve_node(table, r, nose + i, across + j, into + k, layer + m)
        d_vx += weight * table[node + D_VX]
        d_vy += weight * table[node + D_VY]
        d_wx += weight * table[node + D_WX]
        d_wz += weight * table[node + D_WZ]
        time += weight * table[node + TIME]
        beyond += weight * table[node + WAY_BEYOND]
    at_nose = -d_wz / (r.turn * r.cosine)  # impulse along the cushion; the rest is the cloth's
    at_cloth = d_vx - at_nose
    for i in range(len(state)):
        state[i] = 0.0
    state[VX], state[VY], state[VZ] = vx + side * speed * d_vx, vy + speed * d_vy, 0.0
    state[WX], state[WZ] = wx + speed * d_wx, wz + side * speed * d_wz
    state[WY] = wy + side * speed * r.turn * (r.sine * at_nose - at_cloth)
    state[ALONG] = vx * time + side * speed * beyond
    r.time, r.held, r.restitution = time, True, restitution
    if time < inf:
        return True
    state[VX], state[VY], state[WX], state[WY], state[WZ] = vx, vy, wx, wy, wz
    state[Y] = state[Z] = state[ALONG] = r.time = 0.0
    return False
