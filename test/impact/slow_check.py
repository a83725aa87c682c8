"""
A slow second opinion on `collide`: the same model, solved in the least clever way.

Fixed small steps in time: springs by leapfrog, friction by projecting onto the Coulomb discs
contact after contact until nothing moves, so that stick, slide, onset and reversal need no cases.
Ends of compression and restitution and new contacts are bisected within the step. Three step sizes
are extrapolated (Richardson); their spread says how good the result is. Nothing here is shared
with the library.
"""

from dataclasses import dataclass

import numba
import numpy as np

LAWS = ('bistiffness', 'energetic')
TOO_LONG, OVER = 1, 0


@dataclass(frozen=True)
class Answer:
    velocities: np.ndarray
    spins: np.ndarray
    impulses: np.ndarray  # (contacts, 3), common frame
    states: tuple  # sets of active contacts, in order
    spread: float  # of the contact velocities, relative to the largest approach speed
    finished: bool


def inverse_mass(body):
    """(6, 6) generalized inverse mass of a body: its velocity and spin per impulse and twist."""
    inverse = np.zeros((6, 6))
    if np.isfinite(body['mass']):
        guide = body.get('guide')
        if guide is None:
            inverse[:3, :3] = np.eye(3) / body['mass']
        else:
            along = np.outer(guide, guide) / np.dot(guide, guide)
            inverse[:3, :3] = along / body['mass']
            if body.get('end_mass') is not None:
                inverse[:3, :3] += (np.eye(3) - along) / body['end_mass']
        inertia = body.get('inertia')
        if inertia is not None:
            turn = rotation(body.get('orientation', (0.0, 0.0, 0.0, 1.0)))
            inertia = np.asarray(inertia, float)
            inertia = inertia if inertia.ndim == 2 else np.diag(np.broadcast_to(inertia, 3))
            inverse[3:, 3:] = turn @ np.linalg.inv(inertia) @ turn.T
    return inverse


def rotation(quaternion):
    """Rotation matrix of a quaternion x y z w."""
    x, y, z, w = np.asarray(quaternion, float) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def frame(n):
    """Rows: n and two tangents."""
    n = np.asarray(n, float) / np.linalg.norm(n)
    t = np.cross(np.eye(3)[np.argmin(np.abs(n))], n)
    t /= np.linalg.norm(t)
    return np.array([n, t, np.cross(n, t)])


def jacobian(bodies, contacts):
    """(3 contacts, 6 bodies): contact velocities of the bodies' velocities and spins."""
    rows = np.zeros((3 * len(contacts), 6 * len(bodies)))
    for j, contact in enumerate(contacts):
        axes = frame(contact['normal'])
        for body, sign in ((contact['a'], 1.0), (contact['b'], -1.0)):
            lever = np.asarray(contact['point'], float)
            lever = lever - bodies[body].get('position', (0.0, 0.0, 0.0))
            rows[3 * j : 3 * j + 3, 6 * body : 6 * body + 3] = sign * axes
            rows[3 * j : 3 * j + 3, 6 * body + 3 : 6 * body + 6] = sign * np.cross(lever, axes)
    return rows


def slow_collide(bodies, contacts, law='bistiffness', exponent=1.0, steps=2000, periods=60):
    """
    Solve a collision given as lists of dictionaries with the arguments of Body and Contact.

    Contacts without their own exponent have the given one.

    In `steps` steps, twice and four times as many for each period of the fastest spring, and for
    so many `periods` at most.
    """
    rows = jacobian(bodies, contacts)
    inverse = np.zeros((6 * len(bodies), 6 * len(bodies)))
    motion = np.zeros(6 * len(bodies))
    for i, body in enumerate(bodies):
        inverse[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] = inverse_mass(body)
        motion[6 * i : 6 * i + 3] = body.get('velocity', 0.0)
        motion[6 * i + 3 : 6 * i + 6] = body.get('spin', 0.0)
    response = rows @ inverse @ rows.T
    start = rows @ motion
    speed = max(-start[::3].min(), 0.0)
    friction = np.array([float(c.get('friction', 0.0)) for c in contacts])
    restitution = np.array([float(c.get('restitution', 1.0)) for c in contacts])
    stiffness = np.array([float(c.get('stiffness', 1.0)) for c in contacts])
    exponents = np.array([float(c.get('exponent', exponent)) for c in contacts])
    hardest = stiffness.argmax()
    power = -1.0 / (exponents[hardest] + 1.0)
    unit = (stiffness[hardest] * speed ** (exponents[hardest] - 1.0)) ** power if speed else 1.0
    springs = stiffness * speed ** (exponents - 1.0) * unit ** (exponents + 1.0)
    model = (response, friction, restitution, springs, LAWS.index(law), exponents)
    runs, finished = [], True
    for factor in (1, 2, 4):
        log = np.zeros((20_000, len(contacts)), np.bool_)
        end, impulse, phases = march(model, start / speed, factor * steps, periods, log)
        finished = finished and end == OVER
        states = tuple(tuple(np.flatnonzero(row).tolist()) for row in log[:phases])
        runs.append((impulse * speed, states))
    (x1, _), (x2, s2), (x4, s4) = runs
    best = (8.0 * x4 - 6.0 * x2 + x1) / 3.0
    spread = np.abs(response @ (best - (2.0 * x4 - x2))).max() / speed if s2 == s4 else np.inf
    out = motion + inverse @ (rows.T @ best)
    impulses = best.reshape(-1, 3)
    vectors = np.array([x @ frame(c['normal']) for x, c in zip(impulses, contacts, strict=True)])
    out = out.reshape(-1, 6)
    return Answer(out[:, :3], out[:, 3:], vectors, s4, spread, finished)


@numba.njit(cache=True)
def leap(model, active, h, u, y, push, new_u, new_y):
    """One step of length h; push: its impulses, on entry a guess for the tangential ones."""
    response, friction, restitution, stiffness, law, exponent = model
    count = friction.shape[0]
    half = np.zeros(count)
    for j in range(count):
        n = 3 * j
        if not active[j]:
            push[n : n + 3] = 0.0
            continue
        rate = 1.0 / restitution[j] ** 2 if law == 0 and u[n] > 0.0 else 1.0
        half[j] = y[j] - 0.5 * h * rate * u[n]
        push[n] = h * stiffness[j] * max(half[j], 0.0) ** exponent[j]
    for _ in range(3000):
        moved, size = 0.0, 0.0
        for j in range(count):
            if not active[j] or friction[j] == 0.0:
                continue
            n = 3 * j
            a, b, c = response[n + 1, n + 1], response[n + 1, n + 2], response[n + 2, n + 2]
            stretch = 0.5 * (a + c) + np.sqrt(0.25 * (a - c) ** 2 + b * b)
            s, t = u[n + 1], u[n + 2]
            for i in range(3 * count):
                s += response[n + 1, i] * push[i]
                t += response[n + 2, i] * push[i]
            x, z = push[n + 1] - s / stretch, push[n + 2] - t / stretch
            length, rim = np.sqrt(x * x + z * z), friction[j] * push[n]
            if length > rim:
                x *= rim / length
                z *= rim / length
            moved = max(moved, abs(x - push[n + 1]), abs(z - push[n + 2]))
            size = max(size, push[n])
            push[n + 1], push[n + 2] = x, z
        if moved <= 1e-15 * size:
            break
    for row in range(3 * count):
        total = u[row]
        for i in range(3 * count):
            total += response[row, i] * push[i]
        new_u[row] = total
    for j in range(count):
        new_y[j] = 0.0
        if active[j]:
            rate = 1.0 / restitution[j] ** 2 if law == 0 and new_u[3 * j] > 0.0 else 1.0
            new_y[j] = half[j] - 0.5 * h * rate * new_u[3 * j]


@numba.njit(cache=True)
def event(active, restoring, goal, u, y):
    """Whether some contact has turned, ended or joined."""
    for j in range(active.shape[0]):
        if not active[j]:
            if u[3 * j] < -1e-13:
                return True
        elif not restoring[j]:
            if u[3 * j] >= 0.0:
                return True
        elif u[3 * j] < -1e-13 or y[j] <= goal[j]:
            return True
    return False


@numba.njit(cache=True)
def march(model, start, steps, periods, log):
    """March to the end of the collision; (0 if over, impulses, number of states)."""
    response, friction, restitution, stiffness, law, exponent = model
    count = friction.shape[0]
    u, y, impulse = start.copy(), np.zeros(count), np.zeros(3 * count)
    new_u, new_y = u.copy(), y.copy()
    push, trial = np.zeros(3 * count), np.zeros(3 * count)
    active, restoring, goal = u[::3] < 0.0, np.zeros(count, np.bool_), np.zeros(count)
    period = np.inf
    for j in range(count):
        w, k = response[3 * j, 3 * j], stiffness[j]
        p = exponent[j] + 1.0
        period = min(period, 3.0 * (0.5 * p / (w * k)) ** (1.0 / p))
    h = period / steps
    phases, idle, lasted = 0, True, 0.0
    last = 1.0
    for _ in range(periods * steps):
        if not active.any():
            return 0, impulse, phases
        for i in range(3 * count):
            trial[i] = push[i] / last
        leap(model, active, h, u, y, trial, new_u, new_y)
        length = h
        if event(active, restoring, goal, new_u, new_y):
            low = 0.0
            for _ in range(60):
                middle = 0.5 * (low + length)
                leap(model, active, middle, u, y, trial, new_u, new_y)
                if event(active, restoring, goal, new_u, new_y):
                    length = middle
                else:
                    low = middle
            leap(model, active, length, u, y, trial, new_u, new_y)
        last = length / h
        push[:] = trial
        u[:] = new_u
        y[:] = new_y
        impulse += push
        lasted += length
        idle = idle and lasted < 0.01 * h  # a contact that joins at once leaves no state behind
        before = active.copy()
        changed = False
        for j in range(count):
            if not active[j]:
                if u[3 * j] < -1e-13:
                    active[j] = True
                    restoring[j] = False
                    y[j] = 0.0
                    changed = True
                continue
            if not restoring[j] and u[3 * j] >= 0.0:
                restoring[j] = True
                part = (1.0 - restitution[j] ** 2) ** (1.0 / (exponent[j] + 1.0))
                goal[j] = y[j] * part if law == 1 else (y[j] if restitution[j] == 0.0 else 0.0)
            elif restoring[j] and u[3 * j] < -1e-13:
                restoring[j] = False
            if restoring[j] and y[j] <= goal[j]:
                active[j] = False
                y[j] = 0.0
                changed = True
        if changed:
            if not idle:
                if phases == log.shape[0]:
                    return 1, impulse, phases
                log[phases] = before
                phases += 1
            idle, lasted = True, 0.0
            push[:] = 0.0
    return 1, impulse, phases
