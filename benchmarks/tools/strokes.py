"""Strokes to measure with: the paper's four, and ordinary ones at random, in contact space."""

from typing import NamedTuple

import numpy as np

from billiard_shot.impact.laws import LAWS
from billiard_shot.impact.solve import Properties, solve_in_contact_space
from billiard_shot.status import Status

BALL, CUE, RADIUS = 0.1673, 0.5018, 0.0286  # kg, kg, m
ROOT = 2**-0.5
PAPER = (
    ((-1, -2, 1), (0, 0, -2)),
    ((-ROOT, -ROOT, 0), (0.8, 0, 0)),
    ((-ROOT, 0, ROOT), (1, 0, -1)),
    ((-2, -1, 12), (4, 0, -16)),
)


class Strike(NamedTuple):
    """A strike in contact space: what `solve_in_contact_space` takes."""

    response: np.ndarray
    velocity: np.ndarray
    friction: np.ndarray
    restitution: np.ndarray
    stiffness: np.ndarray
    law: str
    ball: np.ndarray  # (3, 6): the ball's velocity per contact impulse [1/kg]

    @property
    def speed(self) -> float:
        """Approach speed [m/s]."""
        return -self.velocity[0]


def frame(n, first):
    """Rows n, t1 (in the plane of n and `first` if there is one), t2."""
    for direction in (first, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)):
        t = np.asarray(direction, float) - np.dot(direction, n) * n
        if np.linalg.norm(t) > 1e-9:
            t /= np.linalg.norm(t)
            return np.array([n, t, np.cross(n, t)])
    raise AssertionError


def strike_of(normal, velocity, law, end_mass=np.inf, ratio=1.5, friction=(0.4, 0.152479),
              restitution=(0.656532, 0.51625)):  # fmt: skip
    """Build a strike from a stroke; equations 16 to 18 of the paper."""
    n, v_c = np.array(normal, float), np.array(velocity, float)
    n /= np.linalg.norm(n)
    c, z = v_c / np.linalg.norm(v_c), np.array([0.0, 0.0, 1.0])
    tip, table = frame(n, c), frame(z, n)
    rows = np.zeros((6, 9))
    rows[:3, :3], rows[:3, 3:6], rows[3:, 3:6] = tip, -tip, table
    rows[:3, 6:] = np.cross(tip, RADIUS * n)
    rows[3:, 6:] = np.cross(table, RADIUS * z)
    inverse = np.eye(9) / BALL
    inverse[:3, :3] = np.outer(c, c) / CUE + (np.eye(3) - np.outer(c, c)) / end_mass
    inverse[6:, 6:] = np.eye(3) * 2.5 / (BALL * RADIUS**2)
    response = rows @ inverse @ rows.T
    response[np.abs(response) < 1e-13 * response.max()] = 0.0
    approach = rows[:, :3] @ v_c
    approach[np.abs(approach) < 1e-15 * np.linalg.norm(v_c)] = 0.0
    stiffness = np.array([ratio, 1.0])
    mu, e, ball = np.array(friction), np.array(restitution), rows[:, 3:6].T / BALL
    return Strike(response, approach, mu, e, stiffness, law, ball)


def paper_strikes(law):
    """Return the paper's four shots."""
    return [strike_of(*shot, law) for shot in PAPER]


def random_strikes(count, law, seed=0):
    """Ordinary strokes: level or down, offset up to 0.7 of the radius, usual tips and cloths."""
    rng = np.random.default_rng(seed)
    strikes = []
    while len(strikes) < count:
        n, c = rng.normal(size=(2, 3))
        n, c = n / np.linalg.norm(n), c / np.linalg.norm(c)
        if n @ c > -0.7 or c[2] > 0.0 or n[2] < -0.5:
            continue
        strikes.append(strike_of(
            n, c * rng.uniform(0.3, 8.0), law,
            end_mass=rng.uniform(0.004, 0.02) if rng.random() < 0.5 else np.inf,
            ratio=np.exp(rng.uniform(-1.5, 1.5)),
            friction=rng.uniform((0.3, 0.1), (0.8, 0.3)),
            restitution=rng.uniform((0.6, 0.4), (0.9, 0.7)),
        ))  # fmt: skip
    return strikes


class Kernel:
    """The compiled kernel, on as many copies of a strike as make its calls count for nothing."""

    COPIES = 20

    def __call__(self, strike: Strike, tolerance: float) -> Status:
        """Solve a strike."""
        n = self.COPIES
        solved = solve_in_contact_space(
            Properties(strike.friction, strike.restitution, strike.stiffness, LAWS[strike.law]),
            np.repeat(strike.response[np.newaxis], n, axis=0),
            np.repeat(strike.velocity[np.newaxis], n, axis=0),
            np.full(n, tolerance),
        )
        self.impulse = solved.impulses[0].ravel()
        return Status(solved.status[0])

    def error(self, strike: Strike, impulse: np.ndarray) -> float:
        """Error of impulses against this one's last, in contact speeds over approach speed."""
        return np.abs(strike.response @ (impulse - self.impulse)).max() / strike.speed
