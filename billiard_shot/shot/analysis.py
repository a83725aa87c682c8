"""Analyses of a predicted shot: each may take further simulations."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.effects import GATES, model_of, ShotContext
from billiard_shot.shot.predict import predict, predict_batch
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import stroke_at
from billiard_shot.table.effects import Effect, report

DIFFERENCE_STEP = 1e-4  # in radii, radians and parts of the speed
ANALYSIS_TOLERANCE = 1e-9  # m


def effects_of(shot: Shot) -> tuple[Effect, ...]:
    """
    Say of every effect the library knows whether a shot simulated it, and why.

    To say whether an effect was called for that the scene turns off, the stroke is predicted again
    with it, unless the shot tells. No effect was simulated if the stroke was refused.
    """
    if shot.status.refused:
        reason = 'the stroke was not played'
        return tuple(Effect(gate.name, False, reason, False) for gate in GATES)

    def again(scene: Scene) -> ShotContext:
        return predict(scene, shot.stroke, shot.tolerance, shot.position).effect_context

    context = shot.effect_context
    return tuple(report(gate, context, again) for gate in GATES)


def sensitivity_of(shot: Shot) -> NDArray[np.float64]:
    """
    Find how the place of rest (x, y) of the cue ball changes with the stroke (2, 5).

    Per radius of a and of b, radian of elevation and of azimuth, and m/s of speed: all in m.
    (a, b) is where the tip touches the ball. Central differences of eleven strokes; one-sided
    where only one of two neighbours can be played, and zero where neither can, or the stroke was
    refused.
    """
    if shot.status.refused:
        return np.zeros((2, 5))
    model = model_of(shot.scene)
    base = np.array(shot.stroke.touching(model.tip_curvature).offsets)
    steps = np.full(5, DIFFERENCE_STEP)
    steps[4] *= base[4]
    changes = np.vstack([np.zeros(5), np.diag(steps), -np.diag(steps)])
    near = [stroke_at(*(base + change)) for change in changes]
    normals, velocities = np.array([s.normal for s in near]), np.array([s.velocity for s in near])
    ends = predict_batch(shot.scene, normals, velocities, ANALYSIS_TOLERANCE, shot.position)
    played, places = ~ends.refused, ends.final_position[:, 0]
    rest = np.where(played[:, np.newaxis], places, places[0])[:, :2]
    reach = np.where(played, np.concatenate([[0.0], steps, -steps]), 0.0)
    span = reach[1:6] - reach[6:]
    return ((rest[1:6] - rest[6:]) / np.where(span > 0.0, span, 1.0)[:, np.newaxis]).T
