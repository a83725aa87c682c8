"""Arrays of any layout: compiled code takes one, and nobody looks at that of an argument."""

import numpy as np
import pytest

from billiard_shot import (
    lowest_elevation,
    predict_batch,
    predict_within_noise,
    Scene,
    shots,
    simulate_batch,
    Stroke,
    TableStates,
)

SCENE = Scene.load('robot_table')
NAMES = tuple(SCENE.balls)


def strided(array):
    return np.repeat(array, 2, axis=0)[::2]


def reversed_rows(array):
    return array[::-1].copy()[::-1]


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def broadcast(array):
    """The first row in place of all rows, without a copy, if all are equal."""
    return np.broadcast_to(array[:1], array.shape) if (array == array[0]).all() else array


LAYOUTS = [np.asfortranarray, strided, reversed_rows, read_only, broadcast, np.ndarray.tolist]


def offsets_of(count):
    draw = np.random.default_rng(5)
    lowest = [-0.3, -0.3, 0.05, -3.0, 0.5]
    return draw.uniform(lowest, [0.3, 0.3, 0.8, 3.0, 4.0], (count, 5))


def states_of(layout, count=4):
    draw = np.random.default_rng(6)
    place = [place[:2] for place in SCENE.balls.values()]
    position = np.zeros((count, len(NAMES), 3))
    position[..., :2], position[..., 2] = place, SCENE.ball.radius
    velocity, spin = np.zeros_like(position), np.zeros_like(position)
    velocity[:, 0, :2] = draw.uniform(-3.0, 3.0, (count, 2))
    present = np.ones(position.shape[:2], bool)
    present[1, -1] = False
    arrays = {'position': position, 'velocity': velocity, 'spin': spin, 'present': present}
    return TableStates(NAMES, **{name: layout(array) for name, array in arrays.items()})


def same(one, other):
    for name in ('velocity', 'spin', 'final_position', 'status', 'chance', 'offsets', 'balls'):
        if hasattr(one, name):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize('layout', LAYOUTS)
def test_strokes(layout):
    offsets = offsets_of(30)
    same(predict_batch(SCENE, offsets=layout(offsets)), predict_batch(SCENE, offsets=offsets))
    np.testing.assert_array_equal(
        lowest_elevation(SCENE, layout(offsets)), lowest_elevation(SCENE, offsets)
    )
    vectors = [Stroke.from_offsets(*each) for each in offsets]
    normals = np.array([each.normal for each in vectors])
    velocities = np.array([each.velocity for each in vectors])
    same(
        predict_batch(SCENE, layout(normals), layout(velocities)),
        predict_batch(SCENE, normals, velocities),
    )


@pytest.mark.parametrize('layout', LAYOUTS)
def test_strokes_within_noise(layout):
    offsets = np.repeat(offsets_of(3), 40, axis=0)
    same(predict_within_noise(SCENE, layout(offsets)), predict_within_noise(SCENE, offsets))


@pytest.mark.parametrize('layout', LAYOUTS)
def test_tables(layout):
    plain = states_of(np.array)
    times, restitution = np.array([0.1, 0.5, 2.0]), np.linspace(0.6, 0.9, 4)
    other = simulate_batch(
        SCENE,
        states_of(layout),
        at=layout(times),
        parameters={'table.cushion.restitution': layout(restitution)},
    )
    one = simulate_batch(
        SCENE, plain, at=times, parameters={'table.cushion.restitution': restitution}
    )
    np.testing.assert_array_equal(one.status, other.status)
    np.testing.assert_array_equal(one.position_at, other.position_at)
    np.testing.assert_array_equal(one.final_position, other.final_position)


@pytest.mark.parametrize('layout', LAYOUTS)
def test_direct_shots(layout):
    resting = states_of(np.array)
    resting.velocity[:] = 0.0
    moved = states_of(layout)
    moved = TableStates(NAMES, moved.position, present=moved.present)
    legal = np.ones((4, len(NAMES)), bool)
    legal[2, 1] = False
    same(shots(SCENE, moved, layout(legal)), shots(SCENE, resting, legal))
