"""
The strike in closed form, if only the tip acts and its slip stays on a line.

Contact velocities are then linear in the normal impulse N as long as the slip keeps its sign. Each
such interval ends at the root of a linear or quadratic equation: zero slip, end of compression, or
end of restitution. Under the laws energetic and bistiffness alike, and for any exponent of its
spring, a single contact ends when it has given back e^2 of the energy that it stored.
"""

import math

import numpy as np

from billiard_shot.records import Array
from studies.problem import ContactProblem

ZERO_VELOCITY = 1e-15  # of a velocity, relative to the approach speed


def applies(problem: ContactProblem) -> bool:
    """Whether the table is never pressed and the slip has one direction only, for any impulse."""
    w, u = problem.response, problem.velocity
    return (
        problem.law != 'poisson'
        and u[2] == 0.0
        and w[2, 0] == 0.0
        and w[2, 1] == 0.0
        and w[3, 0] == 0.0
        and w[3, 1] == 0.0
    )


def closed_form(problem: ContactProblem) -> Array:
    """Return the impulses (6,) [N s]; raise ValueError if `applies` is false."""
    if not applies(problem):
        raise ValueError('stroke: the closed form is for level ones at the height of the centre')
    w = problem.response
    (a, b), d = w[0, :2], w[1, 1]
    mu, e = float(problem.friction[0]), float(problem.restitution[0])
    u, slip = float(problem.velocity[0]), float(problem.velocity[1])
    normal = tangential = stored = 0.0
    goal = math.inf  # energy still to be given back; infinite during compression
    for _ in range(10):  # compression, restitution, and slip that stops or reverses in each
        if abs(slip) <= ZERO_VELOCITY * problem.speed:
            pull = b / d if mu > 0.0 else 0.0  # friction that holds, per normal impulse
            slope = -math.copysign(min(abs(pull), mu), pull)
            slip = 0.0
        else:
            slope = -math.copysign(mu, slip)
        rate, drift = a + b * slope, b + d * slope  # of u and of the slip, per normal impulse
        stop = -slip / drift if slip * drift < 0.0 else math.inf
        if u < 0.0:  # if friction drives the bodies together, only after the slip stops
            end = -u / rate if rate > 0.0 else math.inf
        else:  # u N + rate N^2 / 2 = goal, without cancellation
            end = 2.0 * goal / (u + math.sqrt(u * u + 2.0 * rate * goal))
        part = min(stop, end)
        work = part * (u + 0.5 * rate * part)
        normal, tangential = normal + part, tangential + slope * part
        u, slip = u + rate * part, 0.0 if part == stop else slip + drift * part
        if goal == math.inf:
            stored -= work
            if part == end:
                u, goal = 0.0, e * e * stored
        else:
            goal -= work
            if part == end:
                break
    return np.array([normal, tangential, 0.0, 0.0, 0.0, 0.0])
