"""
A lying ball against a cushion, with the cloth's friction: Mathavan, Jackson and Parkin (2010).

Ball, cushion (I) and cloth (C) meet; friction acts at both, and the ball stays on the cloth, whose
normal force takes what the cushion and its friction do downwards. All is linear in the cushion's
normal impulse P as long as the two slips keep their directions. Compression ends when the ball
stops approaching, restitution when the cushion gave back e^2 of the work put in. Units here: the
ball's mass and radius are 1; x along the cushion, y into it, z up, as in the paper's equations 1
to 17.
"""

import math

from billiard_shot.compiled import inner

# The ball's velocity errs by 1e-5 of its speed in the median, 3e-4 at most.
STEPS = 3  # of the compression, to begin with
MAX_REFINEMENT = 1000  # steps that it may take where a slip stops or turns
ERROR = 3e-4  # of a step's friction impulses, in units of the approach
MAX_STEPS = 4000
SWEEPS = 50  # until the frictions at cushion and cloth agree


@inner
def friction_at(
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
    size = math.sqrt(x * x + y * y)
    if size == 0.0:
        return 0.0, 0.0
    return -most / size * x, -most / size * y


@inner
def contact_friction(
    a: float,
    b: float,
    p: float,
    q: float,
    near_cushion: bool,
    near_cloth: bool,
    step: float,
    s: float,
    c: float,
    cushion: float,
    cloth: float,
    inertia_factor: float,
) -> tuple[float, float, float, float]:
    """
    Friction per P at the cushion (f, g) and at the cloth (h, k), for slips (a, b) and (p, q).

    s, c: sine and cosine of the nose's angle above the ball's centre; inertia_factor = m r^2 / I.
    If a slip is near zero, see `friction_at`.
    """
    f, g, h, k = 0.0, 0.0, 0.0, 0.0
    for _ in range(SWEEPS):
        x, y, last_f, last_g = a, b, f, g
        if near_cushion:
            x += step * h * (1.0 - inertia_factor * s)
            y += step * (s * c + k * (inertia_factor - s))
        f, g = friction_at(
            x, y, step, 1.0 + inertia_factor, s * s + inertia_factor, cushion, near_cushion
        )
        x, y = p, q
        if near_cloth:
            x += step * f * (1.0 - inertia_factor * s)
            y += step * (g * (inertia_factor - s) - c)
        most = cloth * max(s - c * g, 0.0)
        h, k = friction_at(
            x, y, step, 1.0 + inertia_factor, 1.0 + inertia_factor, most, near_cloth
        )
        if not near_cushion or abs(f - last_f) + abs(g - last_g) < 1e-12:
            break
    return f, g, h, k


@inner
def slip_rates(
    f: float, g: float, h: float, k: float, s: float, c: float, inertia_factor: float
) -> tuple[float, float, float, float]:
    """Change per P of the slips at cushion and cloth, for friction (f, g) and (h, k)."""
    return (
        f * (1.0 + inertia_factor) + h * (1.0 - inertia_factor * s),
        s * c + g * (s * s + inertia_factor) + k * (inertia_factor - s),
        f * (1.0 - inertia_factor * s) + h * (1.0 + inertia_factor),
        g * (inertia_factor - s) - c + k * (1.0 + inertia_factor),
    )


@inner
def shrinking(x: float, y: float, u: float, v: float) -> float:
    """How fast a slip (x, y) that changes by (u, v) per P comes to an end: one over the P left."""
    size = x * x + y * y
    return max(-(x * u + y * v) / size, 0.0) if size > 0.0 else 0.0


@inner
def rebound(
    vx: float,
    vy: float,
    wx: float,
    wy: float,
    wz: float,
    s: float,
    restitution: float,
    cushion: float,
    cloth: float,
    inertia_factor: float,
) -> tuple[float, float, float, float, float]:
    """Velocity (x, y) and spin of a ball after it met the cushion with vy > 0."""
    c = math.sqrt(1.0 - s * s)
    compression_impulse = vy / c  # about the impulse of the compression
    step, least = compression_impulse / STEPS, compression_impulse / MAX_REFINEMENT
    wrong, still = ERROR * vy, 1e-9 * vy * (1e-9 * vy)
    work, goal, last = 0.0, -1.0, False  # the ball does work until goal, e^2 of it, is given back
    for _ in range(MAX_STEPS):
        if step <= 0.0:  # nothing is left that could be divided by
            break
        a, b = vx + s * wy - c * wz, wx - s * vy
        p, q = vx - wy, vy + wx
        near, near_cloth = a * a + b * b <= still, p * p + q * q <= still
        f, g, h, k = contact_friction(
            a, b, p, q, near, near_cloth, step, s, c, cushion, cloth, inertia_factor
        )
        x, y, u, v = slip_rates(f, g, h, k, s, c, inertia_factor)
        stop = 0.0 if near else shrinking(a, b, x, y)
        stop_cloth = 0.0 if near_cloth else shrinking(p, q, u, v)
        step = min(step, max(0.5 / max(stop, stop_cloth, 1e-9), least))
        first, error = k - c - s * g, 0.0  # first: rate of vy
        middle = first
        if max(stop, stop_cloth) * step > 0.6:  # stops in this step: the directions at its end
            near, near_cloth = near or stop * step > 0.6, near_cloth or stop_cloth * step > 0.6
            f, g, h, k = contact_friction(
                a, b, p, q, near, near_cloth, step, s, c, cushion, cloth, inertia_factor
            )
            first = k - c - s * g
            middle = first
        else:  # third order (Kutta); a slip that begins has its direction by now
            most, most_cloth = 0.999 * cushion, 0.999 * cloth * (s - c * g)
            near = near and f * f + g * g < most * most
            near_cloth = near_cloth and h * h + k * k < most_cloth * most_cloth
            half = 0.5 * step
            f1, g1, h1, k1 = contact_friction(
                a + half * x,
                b + half * y,
                p + half * u,
                q + half * v,
                near,
                near_cloth,
                step,
                s,
                c,
                cushion,
                cloth,
                inertia_factor,
            )
            x1, y1, u1, v1 = slip_rates(f1, g1, h1, k1, s, c, inertia_factor)
            f2, g2, h2, k2 = contact_friction(
                a + step * (2.0 * x1 - x),
                b + step * (2.0 * y1 - y),
                p + step * (2.0 * u1 - u),
                q + step * (2.0 * v1 - v),
                near,
                near_cloth,
                step,
                s,
                c,
                cushion,
                cloth,
                inertia_factor,
            )
            error = step * (
                abs(f - 2.0 * f1 + f2)
                + abs(g - 2.0 * g1 + g2)
                + abs(h - 2.0 * h1 + h2)
                + abs(k - 2.0 * k1 + k2)
            )
            if error > wrong and step > least:
                step, last = 0.5 * step, False
                continue
            middle = k1 - c - s * g1
            f, g = (f + 4.0 * f1 + f2) / 6.0, (g + 4.0 * g1 + g2) / 6.0
            h, k = (h + 4.0 * h1 + h2) / 6.0, (k + 4.0 * k1 + k2) / 6.0
        rate = min(k - c - s * g, -1e-3)
        part = 0.0  # of the step, to the end of compression or restitution
        if goal < 0.0:
            part = -vy / (rate * step)
        else:
            left = 2.0 * max(goal - work, 0.0) / (-rate * c)
            part = (vy + math.sqrt(vy * vy + left * rate * rate)) / (-rate * step)
        if part < 1.0 - 1e-6 and not last:
            step, last = step * part, True
            continue
        last = part < 1.0 + 1e-6 or (last and part < 1.05)
        done = step * part if last else step
        change = (vy + done * (first + 2.0 * middle) / 6.0) * c * done
        vx += (f + h) * done
        vy += rate * done
        wx += inertia_factor * (g + k) * done
        wy += inertia_factor * (s * f - h) * done
        wz -= inertia_factor * c * f * done
        if goal >= 0.0:
            work -= change
        else:
            work += change
        if last:
            if goal >= 0.0 or restitution == 0.0:
                break
            goal, work = restitution * restitution * work, 0.0
            last, step = False, compression_impulse / STEPS
        elif error < 0.1 * wrong:
            step *= 2.0
    return vx, vy, wx, wy, wz
