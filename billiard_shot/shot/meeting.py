"""What meetings of cues and balls begin with and leave, and how the pieces of one add up."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import Ending, Phase
from billiard_shot.impact.solve import Properties, Solved
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import ROWS
from billiard_shot.shot.model import TIP
from billiard_shot.status import OK

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Meeting(NamedTuple):
    """Balls and cues that meet: n cues, each with k balls, of which it meets the first."""

    position: Array  # (n, k, 3) m, of the balls' centres; frame `table`
    velocity: Array  # (n, k, 3) m/s
    spin: Array  # (n, k, 3) rad/s
    tip: Array  # (n, 3) m, centre of the tip's sphere
    speed: Array  # (n,) m/s, of the cues along their axes


class Outcome(NamedTuple):
    """What n meetings leave, until none of N contacts is pressed any more."""

    after: Meeting
    duration: Array  # (n,) s
    hits: Rows  # (n,) how often the tip met the ball
    closings: Rows  # (n, N) how often each contact closed
    impulses: Array  # (n, N, 3) N s, on the body into which the normal points; TIP: on the cue
    losses: Array  # (n, N, 2) J: restitution, friction
    slips: Array  # (n, N) m/s, of contacts when they last ended
    first_slip: Array  # (n,) m/s, of the tip when it left the ball for the first time
    lengths: Array  # (n, N) m, compressed, or minus the distance
    steps: Rows  # (n,)
    status: Rows  # (n,) Status
    phases: Rows  # (n,)
    log: list[Phase]  # of the last meeting


def nothing_yet(before: Meeting, count: int) -> Outcome:
    """Make the outcome of meetings with `count` contacts in which nothing has happened yet."""
    n = len(before.tip)
    hits, steps, phases = np.zeros((3, n), np.int64)
    return Outcome(
        after=before,
        duration=np.zeros(n),
        hits=hits,
        closings=np.zeros((n, count), np.int64),
        impulses=np.zeros((n, count, 3)),
        losses=np.zeros((n, count, 2)),
        slips=np.zeros((n, count)),
        first_slip=np.zeros(n),
        lengths=np.zeros((n, count)),
        steps=steps,
        status=np.full(n, OK),
        phases=phases,
        log=[],
    )


def add_piece(
    done: Outcome, at: Rows, solved: Solved, frames: Array, given: Array, in_pieces: bool
) -> None:
    """Add impulses, losses and counts of a piece to the outcome."""
    ended = _ended(solved, given)
    closed = solved.closings - (given > 0.0)
    first = ended[:, TIP] & (done.hits[at] + closed[:, TIP] <= 1)
    done.first_slip[at[first]] = solved.final_slips[first, TIP]
    done.slips[at] = np.where(ended, solved.final_slips, done.slips[at])
    done.hits[at] += closed[:, TIP]
    done.closings[at] += closed
    done.duration[at] += solved.durations if in_pieces else 0.0
    done.impulses[at] += (solved.impulses[:, :, np.newaxis] @ frames)[:, :, 0]
    done.losses[at] += solved.losses
    done.steps[at] += solved.steps
    done.status[at] = np.maximum(done.status[at], solved.status)
    done.phases[at] += ended.any(axis=1)


def _ended(solved: Solved, given: Array) -> Flags:
    """Whether each contact (n, N) was active in a piece, and is not any more."""
    ended: Flags = ((given > 0.0) | (solved.closings > 0)) & (solved.lengths <= 0.0)
    return ended


def log_last(springs: Properties, done: Outcome, at: Rows, solved: Solved, given: Array) -> None:
    """Log the phase of the last meeting that has ended in a piece."""
    ended = _ended(solved, given)[-1]
    if at[-1] == len(done.hits) - 1 and ended.any():
        active = (given[-1] > 0.0) | (solved.closings[-1] > 0)
        power = springs.exponent + 1.0
        pressed = np.maximum(solved.lengths[-1], 0.0)
        energies = np.asarray(springs.stiffness) * pressed**power / power
        contacts = tuple(np.flatnonzero(active).tolist())
        contact = int(np.flatnonzero(ended)[0])
        phase = Phase(contacts, Ending.RESTITUTION, contact, done.impulses[-1].copy(), energies)
        done.log.append(phase)


def log_of(phases: list[Phase], frames: Array) -> NDArray[np.void]:
    """Write phases as a log (phases, 2); `frames`: (2, 3, 3), normal and tangents as rows."""
    log = ROWS.records(PhaseLog, 2 * len(phases)).reshape(-1, 2)
    for row, phase in zip(log, phases, strict=True):
        row['ending'], row['contact'], row['energy'] = phase.ending, phase.contact, phase.energies
        row['active'][list(phase.active)] = 1
        along = np.einsum('kij,kj->ki', frames, phase.impulses)
        row['impulse'], row['impulse_1'], row['impulse_2'] = along.T
    return log
