"""Tables as strokes leave them whose strikes come from maps: many strokes in one compiled call."""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Array, as_rows, Floats, Storage
from billiard_shot.scene.player import A, B, ELEVATION, SPEED
from billiard_shot.shot.clear_elevation import write_vectors
from billiard_shot.shot.clearance import NOTHING_AROUND, Surroundings
from billiard_shot.shot.model import StrikeModel, tip_reach
from billiard_shot.shot.strike import EXAMPLE_MODEL, refusal
from billiard_shot.status import OK
from billiard_shot.table.cue import CueRecord, follow_through_time
from billiard_shot.table.initial_states import BallStart

MOTION = 7  # numbers of a motion: velocity [m/s] and spin [rad/s]; speed of the cue [m/s]
VARIED = [A, B, ELEVATION, SPEED]  # columns of strokes that a polynomial depends on
# The polynomials are cubic. They have fewer terms with the speed, which changes less: it counts as
# of second degree.
DEGREE = 3
EXPONENTS = np.array(
    [
        (i, j, k, n)
        for i in range(DEGREE + 1)
        for j in range(DEGREE + 1 - i)
        for k in range(DEGREE + 1 - i - j)
        for n in range((DEGREE - i - j - k) // 2 + 1)
    ]
)  # of `VARIED` in each term, in the order of `write_motion`
TERMS = len(EXPONENTS)


class Mapped(NamedTuple):
    """
    Strikes of n strokes by maps of k cells, see strike_map.py.

    Attributes
    ----------
    number : (n,) int array
        The cell of each stroke; SOLVED if its strike is to be solved.
    middles, half_sizes : (k, 4) float arrays
        Of the cells: a and b (ball radii), elevation (rad), speed (m/s).
    coefficients : (k, TERMS, MOTION) float array
        Of the polynomials: the motion after strikes along +x, over the speed of the cue.

    """

    number: NDArray[np.int64]
    middles: Array
    half_sizes: Array
    coefficients: Array

    def part(self, part: slice) -> 'Mapped':
        """Return some of the strokes."""
        return self._replace(number=self.number[part])


SOLVED = -1
MIRROR = 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0  # of a motion, if a changes sign


def all_solved(count: int) -> Mapped:
    """Return strikes (count,) that are all to be solved."""
    none = np.zeros((0, len(VARIED)))
    return Mapped(np.full(count, SOLVED), none, none, np.zeros((0, TERMS, MOTION)))


class Ground(NamedTuple):
    """What all strokes have in common."""

    model: StrikeModel
    around: Surroundings
    place: Floats  # (3,) m, centre of the cue ball


class Begun(NamedTuple):
    """How n tables of the same balls begin."""

    balls: list[BallStart]  # tables by balls
    cues: list[CueRecord]  # n
    status: Any  # (n,) ints: Status, OK or why the stroke is refused


class Room(NamedTuple):
    """Scratch."""

    normal: Floats  # (3,)
    axis: Floats  # (3,)
    motion: Floats  # (MOTION,)


@inner
def write_motion(stroke: Floats, mapped: Mapped, cell: int, motion: Floats) -> None:
    """Write the motion of ball and cue after a stroke, by the polynomial of its cell."""
    middle, half, coefficients = (
        mapped.middles[cell],
        mapped.half_sizes[cell],
        mapped.coefficients[cell],
    )
    x = (abs(stroke[0]) - middle[0]) / half[0]
    y, z = (stroke[1] - middle[1]) / half[1], (stroke[2] - middle[2]) / half[2]
    faster = (stroke[4] - middle[3]) / half[3]
    for m in range(MOTION):
        motion[m] = 0.0
    term, in_x = 0, 1.0
    for i in range(DEGREE + 1):
        in_y = in_x
        for j in range(DEGREE + 1 - i):
            in_z = in_y
            for k in range(DEGREE + 1 - i - j):
                product = in_z
                for _ in range((DEGREE - i - j - k) // 2 + 1):
                    for m in range(MOTION):
                        motion[m] += product * coefficients[term][m]
                    term += 1
                    product *= faster
                in_z *= z
            in_y *= y
        in_x *= x
    for m in range(MOTION):
        motion[m] *= stroke[4] * (MIRROR[m] if stroke[0] < 0.0 else 1.0)
    sin_t, cos_t = sin(stroke[3]), cos(stroke[3])
    for m in (0, 3):
        along, across = motion[m], motion[m + 1]
        motion[m], motion[m + 1] = cos_t * along - sin_t * across, sin_t * along + cos_t * across


def _example(storage: Storage) -> tuple[Any, ...]:
    zeros, numbers = storage.zeros, storage.array(np.zeros(1, np.int64))
    around = NOTHING_AROUND.stored(storage)
    return (
        Ground(EXAMPLE_MODEL, around, zeros(3)),
        zeros(1, 5),
        Mapped(numbers, zeros(1, 4), zeros(1, 4), zeros(1, TERMS, MOTION)),
        Begun(storage.records(BallStart, 1), storage.records(CueRecord, 1), numbers),
        Room(zeros(3), zeros(3), zeros(MOTION)),
    )


@entry(_example)
def write_starts(
    ground: Ground, strokes: Floats, mapped: Mapped, begun: Begun, room: Room
) -> None:
    """Write cue balls, cues and statuses of the strokes (n, 5) that are mapped."""
    model, reach, count = ground.model, tip_reach(ground.model), len(mapped.number)
    balls = len(begun.balls) // max(count, 1)
    for i in range(count):
        if mapped.number[i] == SOLVED:
            continue
        stroke, cue, ball = strokes[i], begun.cues[i], begun.balls[i * balls]
        write_vectors(stroke, stroke[2], room.normal, room.axis)
        status = refusal(model, ground.around, room.normal, room.axis, ground.place)
        begun.status[i] = status
        if status != OK:
            continue
        motion = room.motion
        write_motion(stroke, mapped, mapped.number[i], motion)
        for k in range(3):
            ball.velocity[k], ball.spin[k] = motion[k], motion[3 + k]
            cue.axis[k] = room.axis[k]
            cue.tip[k] = ground.place[k] + reach * room.normal[k]
        if not model.table:  # the ball, which may go down, is put onto the cloth
            ball.velocity[2] = max(ball.velocity[2], 0.0)
        cue.speed = motion[6]
        cue.end = follow_through_time(model.follow_through, motion[6])


def start_mapped(
    ground: Ground,
    strokes: Array,
    mapped: Mapped,
    starts: NDArray[np.void],
    cues: NDArray[np.void],
    status: NDArray[np.int64],
) -> tuple[NDArray[np.void], NDArray[np.void], NDArray[np.int64]]:
    """
    Return starts (n, balls), cues (n,) and statuses (n,), with those that are mapped written.

    Parameters
    ----------
    ground : Ground
    strokes : (n, 5) float array
    mapped : Mapped
    starts : (n, balls) BallStart
    cues : (n,) CueRecord
    status : (n,) int array
        Of the strikes that were solved.

    """
    run = write_starts.current()
    storage, array, zeros = run.storage, run.storage.array, run.storage.zeros
    ground = Ground(ground.model, ground.around.stored(storage), array(ground.place))
    begun = Begun(
        storage.from_rows(BallStart, starts.reshape(-1)),
        storage.from_rows(CueRecord, cues),
        array(status),
    )
    room = Room(zeros(3), zeros(3), zeros(MOTION))
    run(ground, array(strokes), Mapped(*map(array, mapped)), begun, room)
    return (
        as_rows(BallStart, begun.balls).reshape(starts.shape),
        as_rows(CueRecord, begun.cues),
        np.array(begun.status, np.int64),
    )
