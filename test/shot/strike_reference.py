"""
An integration of strikes that shares nothing with the library: true geometry, tiny steps, 3-D.

A cue's tip, balls, the cloth and the edges of cushions are bodies with linear or Hertzian springs
between them. In each step:

1. A pressed spring closes as fast as its bodies approach, or opens 1/e^2 times as fast as they
   part (Liu, Zhao, Brogliato 2008). A cushion's restitution is that of the energy at the peak of
   its spring: e / (1 + early v + (softening v)^2), with the speed v of a ball of that energy.
2. A spring that is empty ends its contact. Contacts close when the bodies are as near as they were
   when the contact ended, or as they touched at first.
3. Friction is the impulse of each step that brings the slips nearest to zero within Coulomb's
   discs, found contact by contact, in sweeps.
4. Normals are those of the positions of the step; a cushion keeps the normal of its closing.

The light end of the cue moves across the cue's axis while the tip touches the ball. If a shaft
holds it, a spring and a dashpot pull it back all the time, and the tip touches the ball wherever
they meet. Then the integration goes on for the time of a swing after nothing was pressed first.
Without a shaft the end is back on the axis at once when tip and ball part, and the tip at least as
far back as to touch the ball. If the ball then comes toward the tip, they touch again only after
they were apart, or once the ball presses a ball or cushion.
"""

import math
from typing import NamedTuple

import numpy as np

try:
    from numba import njit
except ImportError:

    def njit(cache):
        return lambda function: function


BALL, CLOTH, EDGE, ARC = range(4)
SWEEPS = 12


class Springs(NamedTuple):
    """N contacts: TIP with ball 0, ball 0 with the cloth, and others of a ball with something."""

    kind: np.ndarray  # of the other body
    a: np.ndarray  # ball
    b: np.ndarray  # other ball, if it is one
    point: np.ndarray  # (N, 3) m, of an edge; centre of an arc
    along: np.ndarray  # (N, 3) unit vector of an edge
    size: np.ndarray  # (N,) m, radius of an arc
    friction: np.ndarray
    fading: np.ndarray
    decay: np.ndarray  # s/m
    restitution: np.ndarray
    early: np.ndarray  # s/m
    softening: np.ndarray  # s/m
    stiffness: np.ndarray  # N/m^exponent
    exponent: np.ndarray


@njit(cache=True)
def _way(s, j, tip, place):
    """From what is touched to the ball a; for contact 0 from the ball to the tip."""
    if j == 0:
        return tip - place[0]
    at = place[s.a[j]]
    if s.kind[j] == BALL:
        return at - place[s.b[j]]
    if s.kind[j] == CLOTH:
        return np.array([0.0, 0.0, at[2]])
    way = at - s.point[j]
    if s.kind[j] == EDGE:
        return way - (way * s.along[j]).sum() * s.along[j]
    flat = math.hypot(way[0], way[1])
    keep = 1.0 - s.size[j] / flat
    return np.array([way[0] * keep, way[1] * keep, way[2]])


@njit(cache=True)
def _cross(a, b):
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@njit(cache=True)
def _relative(s, j, n, radius, push, velocity, spin):
    """Velocity at the contact, of the body into which the normal points against the other."""
    a = s.a[j]
    if j == 0:
        return push - velocity[0] - _cross(spin[0], radius * n)
    u = velocity[a] + _cross(spin[a], -radius * n)
    if s.kind[j] == BALL:
        u = u - velocity[s.b[j]] - _cross(spin[s.b[j]], radius * n)
    return u


@njit(cache=True)
def _apply(s, j, n, p, cue, mass, inertia, radius, push, velocity, spin):
    """Let an impulse p act at a contact; `cue` as of `integrate`."""
    a = s.a[j]
    if j == 0:
        along = (p * cue[2:5]).sum()
        push += cue[1] * (p - along * cue[2:5]) + cue[0] * along * cue[2:5]
        velocity[0] -= p / mass
        spin[0] -= _cross(radius * n, p) / inertia
        return
    velocity[a] += p / mass
    spin[a] += _cross(-radius * n, p) / inertia
    if s.kind[j] == BALL:
        velocity[s.b[j]] -= p / mass
        spin[s.b[j]] -= _cross(radius * n, p) / inertia


@njit(cache=True)
def integrate(s, cue, mass, inertia, radius, reach, tip, speed, place, most, step, end):
    """
    Integrate a strike until nothing is pressed.

    Parameters
    ----------
    s : Springs
    cue : (8,) floats
        1 / mass and 1 / end mass [1/kg], and the axis; spring [N/m] and dashpot [kg/s] of the
        shaft, and the time of a swing [s].
    mass, inertia, radius, reach : float
        Of a ball; distance of the centres of tip and ball that touch [m].
    tip, speed : (3,) floats [m], float [m/s]
    place : (balls, 3) floats [m], changed
    most : int
        Hits after which the cue is taken away.
    step, end : float
        [s].

    Returns
    -------
    velocity, spin : (balls, 3) floats
    speed : float
        Of the cue [m/s].
    closings : (N,) ints
    time : float

    """
    count, axis, shaft, first_end = len(s.kind), cue[2:5], cue[5] + cue[6] > 0.0, math.inf
    velocity, spin = np.zeros_like(place), np.zeros_like(place)
    tip, push, origin = tip.copy(), speed * axis, tip.copy()
    y, rate = np.zeros(count), np.ones(count)
    pressed, restores = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    held, closings = False, np.zeros(count, np.int64)
    normal, rub = np.zeros((count, 3)), np.zeros((count, 3))
    slip_before, ends_at = np.zeros(count), np.zeros(count)
    for j in range(count):
        way = _way(s, j, tip, place)
        ends_at[j] = reach if j == 0 else (2.0 * radius if s.kind[j] == BALL else radius)
        gap = math.sqrt((way * way).sum()) - ends_at[j]
        if abs(gap) < 1e-9:
            ends_at[j] += gap
    time = 0.0
    while time < end:
        active = False
        for j in range(count):
            way = _way(s, j, tip, place)
            distance = math.sqrt((way * way).sum())
            if not (pressed[j] and s.kind[j] >= EDGE):
                normal[j] = way / distance
            n = normal[j]
            u = _relative(s, j, n, radius, push, velocity, spin)
            opening = (u * n).sum()
            if j == 0 and held:
                busy = False
                for k in range(2, count):
                    busy = busy or (pressed[k] and (s.a[k] == 0 or s.b[k] == 0))
                if distance > reach or busy:
                    held, ends_at[0] = False, min(reach, distance)
            if not pressed[j]:
                gone = j == 0 and (held or closings[0] >= most)
                if distance <= ends_at[j] and opening < 0.0 and not gone:
                    pressed[j], restores[j], y[j], rate[j] = True, False, 0.0, 1.0
                    closings[j] += 1
            if pressed[j]:
                if opening >= 0.0 and not restores[j]:
                    restores[j] = True
                    power = s.exponent[j] + 1.0
                    energy = s.stiffness[j] * y[j] ** power / power
                    fast = math.sqrt(2.0 * energy / mass)
                    fall = 1.0 + s.early[j] * fast + (s.softening[j] * fast) ** 2
                    rate[j] = max(s.restitution[j] / fall, 0.05) ** -2
                elif opening < 0.0:
                    restores[j] = False
                y[j] -= step * opening * (rate[j] if restores[j] else 1.0)
                if y[j] <= 0.0 and restores[j]:
                    pressed[j], y[j] = False, 0.0
                    ends_at[j] = distance
                    rub[j] = 0.0
                    if j == 0 and not shaft:
                        along = ((tip - origin) * axis).sum()
                        tip = origin + along * axis
                        push = (push * axis).sum() * axis
                        way = tip - place[0]
                        ahead, inside = (way * axis).sum(), (way * way).sum() - reach**2
                        if inside < 0.0:
                            tip = tip - (ahead + math.sqrt(ahead**2 - inside)) * axis
                            way = tip - place[0]
                            held = ((push - velocity[0]) * way).sum() < 0.0
                        ends_at[0] = reach
            slide = u - opening * n
            slip_before[j] = math.sqrt((slide * slide).sum())
            active = active or pressed[j]
        if not active and time > 0.0:
            first_end = min(first_end, time)
        if time >= first_end + (cue[7] if shaft else 0.0):
            break
        aside = tip - origin
        aside = cue[5] * (aside - (aside * axis).sum() * axis)
        aside += cue[6] * (push - (push * axis).sum() * axis)
        push -= step * cue[1] * aside
        for j in range(count):
            if pressed[j]:
                p = step * s.stiffness[j] * y[j] ** s.exponent[j] * normal[j] + rub[j]
                _apply(s, j, normal[j], p, cue, mass, inertia, radius, push, velocity, spin)
        for _ in range(SWEEPS):
            for j in range(count):
                if not pressed[j] or s.friction[j] == 0.0:
                    continue
                n = normal[j]
                u = _relative(s, j, n, radius, push, velocity, spin)
                slide = u - (u * n).sum() * n
                yields = (1.0 / mass + radius**2 / inertia) * (2.0 if s.kind[j] == BALL else 1.0)
                if j == 0:
                    yields = 1.0 / mass + radius**2 / inertia + max(cue[0], cue[1])
                old = rub[j].copy()
                wanted = old - (old * n).sum() * n - slide / yields
                size = math.sqrt((wanted * wanted).sum())
                loss = s.fading[j] * (1.0 - math.exp(-s.decay[j] * slip_before[j]))
                most_rub = (s.friction[j] - loss) * step * s.stiffness[j] * y[j] ** s.exponent[j]
                if size > most_rub:
                    wanted = wanted * (most_rub / size)
                rub[j] = wanted
                _apply(s, j, n, wanted - old, cue, mass, inertia, radius, push, velocity, spin)
        tip = tip + step * push
        place += step * velocity
        time += step
    return velocity, spin, (push * axis).sum(), closings, time
