"""
The strike as one would write it with SciPy: `solve_ivp`, a restart at every event.

The same model as the kernel's, in time and contact space: two springs, Coulomb friction, laws
`energetic` and `bistiffness`. Stops of slip, the cone, ends of restitution and new contacts are
terminal events. Slip far below the tolerance counts as zero. If a stroke still chatters near zero
slip, the solver gives up.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from billiard_shot.impact.friction import minimize_over_disc
from billiard_shot.records import Array
from studies.problem import ContactProblem

OPEN = 1e-13  # approach slower than this is rounding
MOST_CALLS = 20_000
SLIP_MODE, STICK_MODE = 0, 1


EventFunction = Callable[[float, Array], float]


class GaveUpError(Exception):
    """No end after very many events."""


class ScipyStrike:
    """
    One strike; `solve` returns the impulses.

    Parameters
    ----------
    strike : ContactProblem
    method : str
        Of `solve_ivp`.

    """

    def __init__(self, strike: ContactProblem, method: str = 'DOP853') -> None:
        self.method = method
        self.speed = strike.speed
        self.unit = strike.response.diagonal().max()
        self.w = strike.response / self.unit
        self.u0 = strike.velocity / self.speed
        self.mu, self.e = strike.friction, strike.restitution
        self.k = strike.stiffness / strike.stiffness.max()
        self.bistiff = strike.law == 'bistiffness'
        self.evaluations = 0

    def solve(self, rtol: float) -> Array:
        """Return the impulses (6,) [N s]; raise GaveUpError if there is no end."""
        self.still = 0.1 * rtol  # slip below it (relative to the approach speed) counts as zero
        self.onset = [False, False]
        self.active, self.restoring = [True, False], [False, False]
        self.goal, self.mode = [0.0, 0.0], [SLIP_MODE, SLIP_MODE]
        self.direction = np.zeros((2, 2))
        state = np.zeros(8)
        self.settle(state)
        if self.u0[3] == 0.0 and (self.w @ self.forces_at(np.array([1.0, 0.0]), self.u0))[3] < 0.0:
            self.active[1] = True
            self.settle(state)
        time = 0.0
        for _ in range(300):
            names, events = self.events()
            result = solve_ivp(
                self.rate, (time, time + 1e3), state, self.method, rtol=rtol, atol=1e-2 * rtol,
                events=events, first_step=1e-3,
            )  # fmt: skip
            if result.status != 1:
                raise GaveUpError
            time, state = result.t[-1], result.y[:, -1]
            for name, times in zip(names, result.t_events, strict=True):
                if len(times):
                    self.handle(*name, state)
            if not any(self.active):
                return state[2:] * self.speed / self.unit
        raise GaveUpError

    def velocity(self, state: Array) -> Array:
        """Contact velocities."""
        return self.u0 + self.w @ state[2:]

    def forces_at(self, normal: Array, u: Array) -> Array:
        """Find all forces from the normal ones: friction of sliding, then that of sticking."""
        force = np.zeros(6)
        stuck = []
        for j in (0, 1):
            if not self.active[j]:
                continue
            force[3 * j] = normal[j]
            if self.mode[j] == STICK_MODE:
                stuck += [3 * j + 1, 3 * j + 2]
                continue
            slip = u[3 * j + 1 : 3 * j + 3]
            size = np.sqrt(slip @ slip)
            if size > self.still:
                d = slip / size
            else:  # continuous: an overshooting step comes to rest there, and the event is found
                d = self.direction[j] if self.onset[j] else slip / self.still
            force[3 * j + 1 : 3 * j + 3] = -self.mu[j] * normal[j] * d
        if stuck:
            force[stuck] = np.linalg.solve(self.w[np.ix_(stuck, stuck)], -self.w[stuck] @ force)
        return force

    def rate(self, time: float, state: Array) -> Array:
        """Right-hand side: springs and impulses."""
        self.evaluations += 1
        if self.evaluations > MOST_CALLS:
            raise GaveUpError
        u = self.velocity(state)
        rate = np.zeros(8)
        for j in (0, 1):
            if self.active[j]:
                fast = self.bistiff and self.restoring[j]
                rate[j] = -u[3 * j] * (1.0 / self.e[j] ** 2 if fast else 1.0)
        rate[2:] = self.forces_at(self.k * state[:2], u)
        return rate

    def events(self) -> tuple[list[tuple[str, int]], list[EventFunction]]:
        """Terminal events of the present state, with their names."""
        names: list[tuple[str, int]] = []
        functions: list[EventFunction] = []

        def add(name: tuple[str, int], function: Any, direction: int) -> None:
            function.terminal, function.direction = True, direction
            names.append(name)
            functions.append(function)

        for j in (0, 1):
            n = 3 * j
            if not self.active[j]:
                add(('join', j), lambda t, s, n=n: self.velocity(s)[n] + OPEN, -1)
                continue
            if self.restoring[j]:
                add(('end', j), lambda t, s, j=j: s[j] - self.goal[j], -1)
                add(('again', j), lambda t, s, n=n: self.velocity(s)[n], -1)
            else:
                add(('turn', j), lambda t, s, n=n: self.velocity(s)[n], 1)
            if self.mode[j] == STICK_MODE:
                add(('slip', j), lambda t, s, j=j: self.margin(s, j), -1)
            else:
                add(('stop', j), lambda t, s, j=j: self.slip(s, j) - self.still, -1)
                if self.onset[j]:
                    add(('free', j), lambda t, s, j=j: self.slip(s, j) - 2.0 * self.still, 1)
        return names, functions

    def slip(self, state: Array, j: int) -> float:
        """Size of a contact's slip."""
        return np.hypot(*self.velocity(state)[3 * j + 1 : 3 * j + 3])

    def margin(self, state: Array, j: int) -> float:
        """Margin of the force of a sticking contact inside its cone."""
        force = self.forces_at(self.k * state[:2], self.velocity(state))[3 * j : 3 * j + 3]
        return self.mu[j] * force[0] - np.hypot(force[1], force[2])

    def handle(self, name: str, j: int, state: Array) -> None:
        """Change the state after an event."""
        if name == 'join':
            self.active[j], self.restoring[j], state[j] = True, False, 0.0
        elif name == 'turn':
            self.restoring[j] = True
            keep = 0.0 if self.bistiff else np.sqrt(1.0 - self.e[j] ** 2)
            self.goal[j] = keep * state[j]
        elif name == 'again':
            self.restoring[j] = False
        elif name == 'end':
            self.active[j], state[j] = False, 0.0
        if name == 'stop':
            self.u0[3 * j + 1 : 3 * j + 3] -= self.velocity(state)[3 * j + 1 : 3 * j + 3]
        elif name == 'free':
            self.onset[j] = False
        if name == 'slip':
            force = self.forces_at(self.k * state[:2], self.velocity(state))[3 * j + 1 : 3 * j + 3]
            self.u0[3 * j + 1 : 3 * j + 3] -= self.velocity(state)[3 * j + 1 : 3 * j + 3]
            self.mode[j], self.direction[j] = SLIP_MODE, -force / np.hypot(*force)
            self.onset[j] = True
        elif name in ('join', 'end', 'stop'):
            self.settle(state)

    def settle(self, state: Array) -> None:
        """Let contacts without slip stick, or start to slide if friction cannot hold them."""
        u = self.velocity(state)
        normal = self.k * state[:2]
        if not state[:2].any():
            normal = np.maximum(-self.k * u[::3], 0.0) * self.active
        still = [j for j in (0, 1) if self.active[j] and self.slip(state, j) <= self.still]
        force = np.zeros(6)
        for j in (0, 1):
            if self.active[j]:
                force[3 * j] = normal[j]
                if j not in still:
                    self.mode[j] = SLIP_MODE
                    slip = u[3 * j + 1 : 3 * j + 3]
                    force[3 * j + 1 : 3 * j + 3] = -self.mu[j] * normal[j] * slip / np.hypot(*slip)
        for _ in range(200):
            before = force.copy()
            for j in still:
                x, y = 3 * j + 1, 3 * j + 2
                force[[x, y]] = 0.0
                b = self.w @ force
                force[[x, y]] = minimize_over_disc(
                    self.w[x, x], self.w[x, y], self.w[y, y], b[x], b[y],
                    self.mu[j] * normal[j],
                )  # fmt: skip
            if np.abs(force - before).max() <= 1e-15:
                break
        push = self.w @ force
        for j in still:
            used = np.hypot(*force[3 * j + 1 : 3 * j + 3])
            acceleration = push[3 * j + 1 : 3 * j + 3]
            if used < self.mu[j] * normal[j] * (1.0 - 1e-9) or np.hypot(*acceleration) < 1e-12:
                self.mode[j] = STICK_MODE
            else:
                self.mode[j], self.onset[j] = SLIP_MODE, True
                self.direction[j] = acceleration / np.hypot(*acceleration)
