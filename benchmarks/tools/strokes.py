"""Strokes to measure with: the paper's four, and ordinary ones at random, in contact space."""

from dataclasses import replace

import numpy as np

from billiard_shot import Scene, Stroke
from billiard_shot.impact.kernel import solve_in_contact_space
from billiard_shot.status import Status
from studies.paper import PRINTED
from studies.problem import ContactProblem

PAPER = Scene.load('paper')


def paper_strikes(law):
    """Return the paper's four shots by name."""
    scene = replace(PAPER, law=law)
    return {name: ContactProblem.of(scene, stroke) for name, (stroke, _) in PRINTED.items()}


def random_strikes(count, law, seed=0):
    """Ordinary strokes: level or downward, offset up to 0.7 radii, usual tips and cloths."""
    rng = np.random.default_rng(seed)
    strikes = []
    while len(strikes) < count:
        n, c = rng.normal(size=(2, 3))
        n, c = n / np.linalg.norm(n), c / np.linalg.norm(c)
        if n @ c > -0.7 or c[2] > 0.0 or n[2] < -0.5:
            continue
        stroke = Stroke(n, c * rng.uniform(0.3, 8.0))
        end_mass = rng.uniform(0.004, 0.02) if rng.random() < 0.5 else None
        ratio = float(np.exp(rng.uniform(-1.5, 1.5)))
        friction = rng.uniform((0.3, 0.1), (0.8, 0.3)).tolist()
        restitution = rng.uniform((0.6, 0.4), (0.9, 0.7)).tolist()
        tip, table = (
            replace(contact, friction=mu, restitution=e, stiffness=k)
            for contact, mu, e, k in zip(
                (PAPER.contacts.cue_ball, PAPER.contacts.ball_table),
                friction,
                restitution,
                (ratio, 1.0),
                strict=True,
            )
        )
        scene = replace(
            PAPER,
            law=law,
            cue=replace(PAPER.cue, guided=end_mass is None, end_mass=end_mass),
            contacts=replace(PAPER.contacts, cue_ball=tip, ball_table=table),
        )
        strikes.append(ContactProblem.of(scene, stroke))
    return strikes


class Kernel:
    """The compiled kernel, on enough copies of a strike to make the cost of a call negligible."""

    COPIES = 20

    def __call__(self, strike: ContactProblem, tolerance: float) -> Status:
        """Solve a strike."""
        n = self.COPIES
        solved = solve_in_contact_space(
            strike.properties,
            np.repeat(strike.response[np.newaxis], n, axis=0),
            np.repeat(strike.velocity[np.newaxis], n, axis=0),
            np.full(n, tolerance),
        )
        self.impulse = solved.contacts['impulse'][0].ravel()
        return Status(solved.outcomes['status'][0])

    def error(self, strike: ContactProblem, impulse: np.ndarray) -> float:
        """Error of impulses from the last solution: contact speed over approach speed."""
        return np.abs(strike.response @ (impulse - self.impulse)).max() / strike.speed
