"""
The classical laws for several contacts, with which the paper compares its own.

Both solve the same strike in contact space as the library; neither uses stiffnesses.
"""

import numpy as np

from billiard_shot.impact.friction import minimize_over_disc
from billiard_shot.impact.kernel import Properties, solve_in_contact_space
from billiard_shot.records import Array
from studies.problem import ContactProblem

APPROACH = 1e-12  # of the approach speed: slower than this, contacts are at rest
MAX_CLASSICAL_ROUNDS = 1000
MAX_FRICTION_SWEEPS = 10_000


class NoEndError(Exception):
    """The contacts still approach after very many rounds."""


def pairwise(problem: ContactProblem) -> Array:
    """
    Impulses (6,) [N s] of collisions one at a time: the tip, then the table, and so on.

    Each is solved exactly, as if the other contact were not there, until none approaches.
    """
    u, total = problem.velocity.copy(), np.zeros(6)
    for turn in range(MAX_CLASSICAL_ROUNDS):
        if u[::3].min() >= -APPROACH * problem.speed:
            return total
        j = turn % 2
        part = slice(3 * j, 3 * j + 3)
        if u[3 * j] < -APPROACH * problem.speed:
            alone = Properties(
                problem.friction[j : j + 1],
                problem.restitution[j : j + 1],
                np.ones(1),
                problem.model.law,
                problem.model.exponent[j],
            )
            impulse = (
                solve_in_contact_space(
                    alone, problem.response[np.newaxis, part, part], u[np.newaxis, part], [1e-12]
                )
                .contacts['impulse']
                .ravel()
            )
            total[part] += impulse
            u += problem.response[:, part] @ impulse
    raise NoEndError


def newton(problem: ContactProblem) -> Array:
    """
    Impulses (6,) [N s] of Newton's law at all contacts at once (Moreau 1988).

    0 <= J_n complementary to u_n(after) + e u_n(before) >= 0, and Coulomb's law between the whole
    impulses and the slip after, by sweeps from contact to contact (Jourdan, Alart, Jean 1998).
    """
    w, u = problem.response, problem.velocity
    target = np.minimum(u[::3], 0.0) * problem.restitution
    impulse = np.zeros(6)
    for _ in range(MAX_FRICTION_SWEEPS):
        before = impulse.copy()
        for j in (0, 1):
            n, x, y = 3 * j, 3 * j + 1, 3 * j + 2
            rest = u + w @ impulse
            impulse[n] = max(0.0, impulse[n] - (rest[n] + target[j]) / w[n, n])
            old = impulse[[x, y]].copy()
            impulse[[x, y]] = 0.0
            free = u + w @ impulse
            impulse[[x, y]] = minimize_over_disc(
                w[x, x], w[x, y], w[y, y], free[x], free[y], problem.friction[j] * impulse[n]
            )
            impulse[[x, y]] = 0.5 * (impulse[[x, y]] + old)  # damped, for strong coupling
        if np.abs(impulse - before).max() <= 1e-14 * np.abs(impulse).max():
            return impulse
    raise NoEndError
