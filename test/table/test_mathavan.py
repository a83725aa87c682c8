"""
The cushion of Mathavan, Jackson and Parkin (2010) against their own scheme, in very fine steps.

The paper prints plots, no tables: so its equations 12 to 17 are integrated here as it says, with
its parameters, over the rebounds that it plots.
"""

import numpy as np
import pytest

from billiard_shot.table.mathavan import rebound

# Snooker (section 4): restitution, friction at cushion and cloth, height of the nose (eq. 1).
RESTITUTION, CUSHION, CLOTH, SINE = 0.98, 0.14, 0.212, 0.4
COSINE = np.sqrt(1 - SINE**2)
TURN = 2.5  # m r^2 / I of a solid ball
STEPS = 20_000  # of the compression, about


def rates(state):
    """Change of (vx, vy, wx, wy, wz) per impulse, for unit mass and radius; equations 12 to 17."""
    vx, vy, wx, wy, wz = state
    at_cushion = np.arctan2(-vy * SINE + wx, vx + wy * SINE - wz * COSINE)
    at_cloth = np.arctan2(vy + wx, vx - wy)
    x, y = np.cos(at_cushion), np.sin(at_cushion)
    press = CLOTH * (SINE + CUSHION * y * COSINE)
    h, k = press * np.cos(at_cloth), press * np.sin(at_cloth)
    return np.array(
        [
            -CUSHION * x - h,
            -COSINE + CUSHION * SINE * y - k,
            -TURN * (CUSHION * y + k),
            -TURN * (CUSHION * x * SINE - h),
            TURN * CUSHION * x * COSINE,
        ]
    )


def reference(speed, angle, topspin, sidespin):
    """Rebounds (n, 5), by Heun's method; the work-energy restitution of section 3.3."""
    cos, sin = np.cos(angle), np.sin(angle)
    state = speed * np.array([cos, sin, -topspin * sin, topspin * cos, sidespin])
    step = state[1] / COSINE / STEPS
    work, goal = np.zeros_like(speed), np.full_like(speed, np.inf)
    active = np.full(speed.shape, True)
    while active.any():
        slope = rates(state)
        after = state + 0.5 * step * (slope + rates(state + step * slope))
        done = 0.5 * step * COSINE * np.abs(state[1] + after[1])
        turned = (state[1] > 0) & (after[1] <= 0)
        work = np.where(active, work + done, work)
        goal = np.where(turned & active, RESTITUTION**2 * work, goal)
        work = np.where(turned & active, 0.0, work)
        state = np.where(active, after, state)
        active = active & (work < goal)
    return state.T


# Angles, topspins (1: it rolls) and sidespins of the paper's plots.
@pytest.mark.parametrize('topspin', [-1.0, 0.0, 0.5, 1.0, 2.0])
def test_rebounds_are_those_of_the_published_equations(topspin):
    angle, sidespin = (
        each.ravel()
        for each in np.meshgrid(np.radians([5, 15, 30, 45, 60, 75, 85]), [-2, -1, -0.3, 0.4, 1, 2])
    )
    speed = np.ones_like(angle)
    expected = reference(speed, angle, topspin, sidespin)
    for i, row in enumerate(expected):
        cos, sin = np.cos(angle[i]), np.sin(angle[i])
        found = rebound(
            cos,
            sin,
            -topspin * sin,
            topspin * cos,
            sidespin[i],
            SINE,
            RESTITUTION,
            CUSHION,
            CLOTH,
            TURN,
        )
        # the scheme's own slip directions tremble about zero slip, by its step
        assert found == pytest.approx(row, abs=1e-3)
