"""
An integration of jump shots that shares nothing with the library: true geometry, small steps.

The cue, the ball and the cloth move in the vertical plane of the cue, without friction and
gravity. Each contact is a linear spring whose restoring phase is 1/e^2 times as fast (Liu, Zhao,
Brogliato 2008). The normal is that of the present positions. The end of the cue is free to move
across it while it touches the ball, and is back on the axis when they part.
"""

import math

TIP_DURATION, CLOTH_DURATION = 1.3e-3, 0.7e-3  # s, from touch to parting
STEP = 1e-6  # s
END = 0.012  # s


def rising_speed(
    elevation: float,
    speed: float,
    cue_mass: float,
    restitution: float,
    *,
    mass: float = 0.17,
    radius: float = 0.028575,
    table_restitution: float = 0.5,
    end_mass: float = 0.0042,
) -> float:
    """
    Upward speed of a ball that is hit in its middle [m/s].

    Parameters
    ----------
    elevation, speed : float
        Of the cue [rad], [m/s].
    cue_mass, restitution : float
        [kg], of the tip.

    """
    cos, sin = math.cos(elevation), math.sin(elevation)
    half_turn = 0.5 * math.pi * (1.0 + restitution)  # omega times the duration
    k_tip = (half_turn / TIP_DURATION) ** 2 / (1.0 / cue_mass + 1.0 / mass)
    half_turn = 0.5 * math.pi * (1.0 + table_restitution)
    k_table = (half_turn / CLOTH_DURATION) ** 2 * mass
    x = z = vx = vz = 0.0  # of the ball
    along, across, v_along, v_across = -radius, 0.0, speed, 0.0  # of the tip
    y_tip = y_table = 0.0
    closed = True
    for _ in range(int(END / STEP)):
        dx, dz = cos * along + sin * across - x, -sin * along + cos * across - z
        distance = math.hypot(dx, dz)
        nx, nz = dx / distance, dz / distance
        parting = nx * (cos * v_along + sin * v_across - vx)
        parting += nz * (-sin * v_along + cos * v_across - vz)
        if not closed and distance <= radius:
            closed, y_tip = True, 0.0
        force = k_tip * max(y_tip, 0.0) if closed else 0.0
        push = k_table * max(y_table, 0.0)
        if closed:
            y_tip -= STEP * parting * (restitution**-2 if parting > 0.0 else 1.0)
        restoring = vz > 0.0 and y_table > 0.0
        y_table -= STEP * vz * (table_restitution**-2 if restoring else 1.0)
        v_along += STEP * force * (nx * cos - nz * sin) / cue_mass
        v_across += STEP * force * (nx * sin + nz * cos) / end_mass
        vx -= STEP * force * nx / mass
        vz += STEP * (push - force * nz) / mass
        x, z = x + STEP * vx, z + STEP * vz
        along, across = along + STEP * v_along, across + STEP * v_across
        if closed and y_tip <= 0.0 and parting > 0.0:
            closed, across, v_across = False, 0.0, 0.0
            dx, dz = cos * along - x, -sin * along - z
            ahead = dx * cos - dz * sin
            inside = dx * dx + dz * dz - radius * radius
            if inside < 0.0:  # the spring ends in a dent: they just touch
                along -= ahead + math.sqrt(ahead * ahead - inside)
    return vz
