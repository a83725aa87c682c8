"""Recordings of shots that were simulated: their truth is known."""

import math

import numpy as np

from billiard_shot import Scene, simulate_batch, TableStates
from billiard_shot.calibration.recording import Frame, RecordedShot, Recording, Track

NAMES = 'white', 'yellow', 'red'
BEFORE = 0.3  # s of rest before the strike
AS_IT_IS = Frame()


def simulated_recording(
    scene: Scene, shots: int, seed: int, sigma=1e-3, rate=50.0, frame=AS_IT_IS, longest=8.0
):
    """Shots of three balls on a table, seen in a frame at a rate [1/s] with an error [m]."""
    draw = np.random.default_rng(seed)
    radius = scene.ball.radius
    half = np.array([scene.table.length, scene.table.width]) / 2 - 3.0 * radius
    times = np.arange(1, int(longest * rate)) / rate
    position, velocity, spin = (np.zeros((shots, len(NAMES), 3)) for _ in range(3))
    for k in range(shots):
        apart = 0.0
        while apart < 6.0 * radius:
            position[k, :, :2] = draw.uniform(-half, half, (len(NAMES), 2))
            between = position[k, :, np.newaxis] - position[k]
            apart = np.linalg.norm(between, axis=-1)[np.triu_indices(len(NAMES), 1)].min()
        # at another ball, or at a cushion
        to = position[k, draw.integers(1, len(NAMES)), :2] - position[k, 0, :2]
        direction = math.atan2(to[1], to[0]) + draw.normal(0.0, 0.06)
        speed = draw.uniform(1.5, 4.5)
        ahead = np.array([math.cos(direction), math.sin(direction)])
        velocity[k, 0, :2] = speed * ahead
        follow, side = speed * draw.uniform([-0.4, -0.6], [1.0, 0.6]) / radius
        spin[k, 0] = -follow * ahead[1], follow * ahead[0], side
    position[..., 2] = radius
    batch = simulate_batch(scene, TableStates(NAMES, position, velocity, spin), at=times)
    assert (batch.status == 0).all()
    seen = frame.to_recording(batch.position_at[..., :2])
    rests = np.repeat(
        frame.to_recording(position[:, :, np.newaxis, :2]), int(BEFORE * rate), axis=2
    )
    places = np.concatenate([rests, seen], axis=2)
    places += draw.normal(0.0, sigma, places.shape)
    all_times = BEFORE + np.concatenate([np.arange(1 - int(BEFORE * rate), 1) / rate, times])
    return Recording(
        'simulated',
        tuple(
            RecordedShot(
                str(k),
                {
                    name: Track(all_times, places[k, i], np.full(len(all_times), sigma))
                    for i, name in enumerate(NAMES)
                },
            )
            for k in range(shots)
        ),
        frame,
    )
