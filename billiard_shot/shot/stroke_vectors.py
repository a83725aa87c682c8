"""Strokes as players state them, as the vectors with which they are played."""

from math import cos, hypot, sin, sqrt
from typing import Any

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Floats, Storage, Triple
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED


@inner
def axes(elevation: float, azimuth: float) -> tuple[Triple, Triple, Triple]:
    """Find unit vectors to the right, up and along a stroke [rad], as seen by who plays it."""
    sin_e, cos_e, sin_t, cos_t = sin(elevation), cos(elevation), sin(azimuth), cos(azimuth)
    right, up = (sin_t, -cos_t, 0.0), (sin_e * cos_t, sin_e * sin_t, cos_e)
    return right, up, (cos_e * cos_t, cos_e * sin_t, -sin_e)


@inner
def write_vectors(stroke: Floats, elevation: float, normal: Floats, axis: Floats) -> None:
    """
    Write the unit normal and the axis of a stroke (5,) at an elevation [rad].

    If the tip misses the ball, the normal is at a right angle to the stroke.
    """
    a, b = stroke[A], stroke[B]
    right, up, along = axes(elevation, stroke[AZIMUTH])
    depth = sqrt(max(1.0 - a * a - b * b, 0.0))
    length = hypot(hypot(a, b), depth)
    for k in range(3):
        axis[k] = along[k]
        normal[k] = (a * right[k] + b * up[k] - depth * along[k]) / length


def _example(storage: Storage) -> tuple[Any, ...]:
    return storage.zeros(1, 5), storage.zeros(1, 3), storage.zeros(1, 3)


@entry(_example)
def write_strokes(offsets: Floats, normals: Floats, velocities: Floats) -> None:
    """
    Find the vectors of strokes; those of equal strokes are equal to the last bit on all machines.

    Parameters
    ----------
    offsets : (n, 5) floats
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.
    normals, velocities : (n, 3) floats, written
        Unit vectors from the centre of the ball to the tip; velocities of the cue [m/s].

    """
    for i in range(len(offsets)):
        stroke, velocity = offsets[i], velocities[i]
        write_vectors(stroke, stroke[ELEVATION], normals[i], velocity)
        for k in range(3):
            velocity[k] *= stroke[SPEED]
