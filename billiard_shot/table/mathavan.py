"""
A lying ball against a cushion, with the cloth's friction: Mathavan, Jackson and Parkin (2010).

Ball, cushion (I) and cloth (C) meet; friction acts at both, and the ball stays on the cloth, whose
normal force takes what the cushion and its friction do downwards. All is linear in the cushion's
normal impulse P as long as the two slips keep their directions. Compression ends when the ball
stops approaching, restitution when the cushion gave back e^2 of the work put in. Units here: the
ball's mass and radius are 1; x along the cushion, y into it, z up, as in the paper's equations 1
to 17.
"""
import numpy as np

from billiard_shot.compiled import compiled

STEPS = 24  # of the compression; the ball's velocity errs by 3e-4 of its speed at most
MAX_STEPS = 4000
SWEEPS = 50  # until the frictions at cushion and cloth agree0
FINE = 16  # a step in which a slip may stop or turn is made in so many


@compiled
def grip(
    x: float, y: float, step: float, along: float, across: float, most: float, near: bool
) -> tuple[float, float]:
    """
    Friction per P that opposes a slip (x, y), of at most a size.

    Near zero slip (x, y) is what the slip would be at the step's end without friction; which then
    either stops it, by the responses along and across the cushion, or opposes it.
    """
    if near:
        f, g = -x / (along * step), -y / (across * step)
        if f * f + g * g <= most * most:
            return f, g
    size = np.sqrt(x * x + y * y)
    if size == 0.0:
        return 0.0, 0.0
    return -most / size * x, -most / size * y


@compiled
def forces(
    a: float, b: float, p: float, q: float, step: float, s: float, c: float,
    cushion: float, cloth: float, turn: float,
) -> tuple[float, float, float, float]:
    """
    Friction per P at the cushion (f, g) and at the cloth (h, k), for slips (a, b) and (p, q).

    s, c: sine and cosine of the nose's angle above the ball's centre; turn = m r^2 / I.
    """
    reach = 4.0 * step * step
    near_cushion = a * a + b * b < reach
    near_cloth = p * p + q * q < reach
    f, g, h, k = 0.0, 0.0, 0.0, 0.0
    for _ in range(SWEEPS):
        x, y, last_f, last_g = a, b, f, g
        if near_cushion:
            x += step * h * (1.0 - turn * s)
            y += step * (s * c + k * (turn - s))
        f, g = grip(x, y, step, 1.0 + turn, s * s + turn, cushion, near_cushion)
        x, y = p, q
        if near_cloth:
            x += step * f * (1.0 - turn * s)
            y += step * (g * (turn - s) - c)
        most = cloth * max(s - c * g, 0.0)
        h, k = grip(x, y, step, 1.0 + turn, 1.0 + turn, most, near_cloth)
        if not near_cushion or abs(f - last_f) + abs(g - last_g) < 1e-12:
            break
    return f, g, h, k


@compiled
def bounce_of(
    vx: float, vy: float, wx: float, wy: float, wz: float, s: float, restitution: float,
    cushion: float, cloth: float, turn: float,
) -> tuple[float, float, float, float, float]:
    """Velocity (x, y) and spin of a ball after it met the cushion with vy > 0."""
    c = np.sqrt(1.0 - s * s)
    coarse = vy / (STEPS * c)
    held, rolling = False, False  # a slip that has stopped needs no short steps
    work, goal = 0.0, -1.0  # the work is done by the ball until goal, e^2 of it, is given back
    for _ in range(MAX_STEPS):
        a, b = vx + s * wy - c * wz, wx - s * vy
        p, q = vx - wy, vy + wx
        first, second = a * a + b * b, p * p + q * q
        slip = np.sqrt(min(np.inf if held else first, np.inf if rolling else second))
        step = min(max(0.25 * slip, coarse / FINE), coarse)
        f, g, h, k = forces(a, b, p, q, step, s, c, cushion, cloth, turn)
        # Directions in the middle of the step make it exact to second order.
        half = 0.5 * step
        f, g, h, k = forces(
            a + half * (f * (1.0 + turn) + h * (1.0 - turn * s)),
            b + half * (s * c + g * (s * s + turn) + k * (turn - s)),
            p + half * (f * (1.0 - turn * s) + h * (1.0 + turn)),
            q + half * (g * (turn - s) - c + k * (1.0 + turn)),
            step, s, c, cushion, cloth, turn,
        ) if slip > 2.0 * step else (f, g, h, k)
        rate = k - c - s * g  # of vy
        done = False
        if goal < 0.0:
            if vy + rate * step <= 0.0:
                step = -vy / rate
                work += 0.5 * vy * c * step
                goal = restitution * restitution * work
                done = goal == 0.0
                work = 0.0
            else:
                work += (vy + 0.5 * rate * step) * c * step
        else:
            gain = -(vy + 0.5 * rate * step) * c * step
            if work + gain >= goal and rate < 0.0:
                left = 2.0 * (goal - work) / (-rate * c)
                step = (vy + np.sqrt(vy * vy + left * rate * rate)) / -rate
                done = True
            work += gain
        held = f * f + g * g < (0.99 * cushion) ** 2
        rolling = h * h + k * k < (0.99 * cloth * (s - c * g)) ** 2
        vx += (f + h) * step
        vy += rate * step
        wx += turn * (g + k) * step
        wy += turn * (s * f - h) * step
        wz -= turn * c * f * step
        if done:
            break
    return vx, vy, wx, wy, wz
