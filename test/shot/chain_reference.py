"""
An integration of strikes with a shaft that bends, which shares nothing with the library.

The shaft is a chain of masses: an Euler-Bernoulli beam of maple with a ferrule, free at both ends.
It moves along the cue's axis with the whole cue, and bends across it. The tip, its first mass, has
a spring along the normal and one along the tangents, which slides at Coulomb's cone. Geometry is
true, and all strokes are integrated at once in small semi-implicit steps, until tip and cloth have
left the ball. A second hit is noticed, not integrated.
"""

from typing import NamedTuple

import numpy as np

NODES, LENGTH, FERRULE = 32, 0.8, 0.025  # m
YOUNG, DENSITY, DENSITY_OF_FERRULE = 11e9, 700.0, 1400.0  # Pa, kg/m^3, of maple and of phenolic


class Strike(NamedTuple):
    """The numbers of a strike; springs are in N/m^exponent."""

    mass: float  # kg, of the ball, like the next two
    inertia: float
    radius: float
    cue_mass: float
    shaft_radius: float  # m
    tip: tuple[float, float, float, float]  # stiffness, exponent, restitution, friction
    shear: float  # stiffness of the tip along the tangents, relative to that along the normal
    cloth: tuple[float, float, float]  # stiffness, restitution, friction; linear


def strike(s, axes, normals, speeds, step=2e-7, end=6e-3):
    """
    Strike a ball on the cloth; return velocities, spins (n, 3), times of contact, and hits (n).

    Parameters are unit vectors (n, 3) along the cues and from the ball to the tip, and speeds (n).
    """
    count = len(axes)
    cell = LENGTH / NODES
    edges = np.clip((np.arange(NODES + 1) - 0.5) * cell, 0.0, LENGTH - cell)
    weights = DENSITY * edges + (DENSITY_OF_FERRULE - DENSITY) * np.minimum(edges, FERRULE)
    masses = np.pi * s.shaft_radius**2 * np.diff(weights)
    bending = YOUNG * np.pi / 4.0 * s.shaft_radius**4 / cell**3
    across = np.eye(3) - axes[:, :, np.newaxis] * axes[:, np.newaxis]
    bent, sway = np.zeros((count, NODES, 3)), np.zeros((count, NODES, 3))
    along, cue_speed = np.zeros(count), speeds.astype(float)
    place, velocity, spin = (np.zeros((count, 3)) for _ in range(3))
    y, sheared = np.zeros(count), np.zeros((count, 3))
    depth, touched, hits = np.zeros(count), np.zeros(count), np.ones(count, int)
    pressed = np.ones(count, bool)
    stiffness, exponent, restitution, friction = s.tip
    up = np.array([0.0, 0.0, 1.0])

    def dot(a, b):
        return np.einsum('ij,ij->i', a, b)[:, np.newaxis]

    for _ in range(round(end / step)):
        tip = s.radius * normals + along[:, np.newaxis] * axes + bent[:, 0]
        n = tip - place
        n /= np.sqrt(dot(n, n))
        push = cue_speed[:, np.newaxis] * axes + sway[:, 0]
        u = push - velocity - np.cross(spin, s.radius * n)
        opening = dot(u, n)
        rate = np.where(opening > 0.0, restitution**-2, 1.0)
        y -= step * np.where(pressed, rate[:, 0], 1.0) * opening[:, 0]
        pressed &= (y > 0.0) | (opening[:, 0] < 0.0)
        hits[~pressed & (y > 0.0)] = 2
        touched += step * pressed
        if not (pressed | (depth > 0.0)).any():
            break
        sheared += step * (u - opening * n)
        sheared -= dot(sheared, n) * n
        size = np.sqrt(dot(sheared, sheared))
        closed = np.where(pressed, np.maximum(y, 0.0), 0.0)
        rim = friction / s.shear * closed[:, np.newaxis]
        sheared *= np.minimum(1.0, rim / np.maximum(size, 1e-300))
        q = closed**2 + s.shear * dot(sheared, sheared)[:, 0]
        firm = (stiffness * q ** (0.5 * (exponent - 1.0)))[:, np.newaxis]
        p = step * firm * (closed[:, np.newaxis] * n - s.shear * sheared)
        cue_speed += dot(p, axes)[:, 0] / s.cue_mass
        sway[:, 0] += np.einsum('ijk,ik->ij', across, p) / masses[0]
        velocity -= p / s.mass
        spin -= np.cross(s.radius * n, p) / s.inertia
        curve = bent[:, 2:] - 2.0 * bent[:, 1:-1] + bent[:, :-2]
        pull = np.zeros_like(bent)
        pull[:, 2:] -= curve
        pull[:, 1:-1] += 2.0 * curve
        pull[:, :-2] -= curve
        sway += step * bending * pull / masses[:, np.newaxis]
        of_cloth, bounce, grip = s.cloth
        lift = velocity[:, 2]
        depth -= step * lift * np.where((depth > 0.0) & (lift > 0.0), bounce**-2, 1.0)
        press = step * of_cloth * np.maximum(depth, 0.0)
        velocity[:, 2] += press / s.mass
        slip = velocity - np.cross(spin, s.radius * up)
        slip[:, 2] = 0.0
        rub = -slip / (1.0 / s.mass + s.radius**2 / s.inertia)
        size = np.sqrt(dot(rub, rub))
        rub *= np.minimum(1.0, grip * press[:, np.newaxis] / np.maximum(size, 1e-300))
        velocity += rub / s.mass
        spin -= np.cross(s.radius * up, rub) / s.inertia
        bent += step * sway
        along += step * cue_speed
        place += step * velocity
    return velocity, spin, touched, hits
