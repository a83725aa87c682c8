"""The camera: projection, outlines of balls, and fits."""

from dataclasses import replace

import cv2
from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot.film.lens import (
    Camera,
    camera_of_corners,
    Edges,
    fit_camera,
    SIGHT_AWAY,
    sight_places,
    SIGHT_UP,
    Sights,
)

HALF, HEIGHT, SIZE = np.array([1.42, 0.71]), 0.037, (1280, 720)


def camera(x=0.1, y=-0.2, z=2.6, tilt=0.1, k1=-0.06, k2=0.02, focal=1000.0):
    rotation = cv2.Rodrigues(np.array([np.pi - tilt, 0.02, 0.03]))[0]
    return Camera(focal, np.array([k1, k2]), rotation, np.array([x, y, z]), SIZE, HALF)


cameras = st.builds(
    camera,
    x=st.floats(-0.5, 0.5),
    y=st.floats(-2.0, 0.5),
    z=st.floats(1.5, 4.0),
    tilt=st.floats(-0.5, 0.7),
    k1=st.floats(-0.1, 0.1),
    k2=st.floats(-0.02, 0.02),
)


@given(cameras, st.floats(0.0, 0.1))
@settings(max_examples=40, deadline=None)
def test_a_plane_is_seen_where_it_is_projected(made, height):
    pixels = np.stack(np.meshgrid([300.0, 640.0, 900.0], [200.0, 360.0, 500.0]), -1)
    places = made.to_plane(pixels, height)
    back = made.project(np.concatenate([places, np.full((3, 3, 1), height)], -1))
    np.testing.assert_allclose(back, pixels, atol=1e-6)


@given(cameras, st.floats(-0.6, 0.6), st.floats(-0.3, 0.3))
@settings(max_examples=40, deadline=None)
def test_rays_of_an_outline_touch_the_ball(made, x, y):
    centre, radius = np.array([x, y, 0.03]), 0.03
    pixels = made.outlines(centre[np.newaxis], radius, 16)[0]
    ends = np.column_stack([made.to_plane(pixels, 0.0), np.zeros(16)])
    rays = ends - made.place
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    away = centre - made.place
    off = np.linalg.norm(away - (rays @ away)[:, np.newaxis] * rays, axis=1)
    np.testing.assert_allclose(off, radius, rtol=1e-6)


def seen_by(made):
    """What a camera sees of a table: noses and sights, without errors."""
    signs = [(axis, sign) for axis in (0, 1) for sign in (-1.0, 1.0)]
    at = np.full((4, 15, 2), 0.0)
    for k, (axis, sign) in enumerate(signs):
        at[k, :, axis], at[k, :, 1 - axis] = sign, np.linspace(-0.9, 0.9, 15)
    at = at.reshape(-1, 2)
    pixels = made.project(np.column_stack([at * made.half, np.full(len(at), HEIGHT)]))
    across = np.eye(2)[np.repeat([0, 0, 1, 1], 15)]
    dots = np.array([(x, y) for x in (-0.75, -0.25, 0.5) for y in (-1.0, 1.0)])
    places = sight_places(dots, made.half, SIGHT_AWAY, HEIGHT + SIGHT_UP)
    return Edges(at, pixels, across), Sights(dots, made.project(places))


@pytest.mark.parametrize('tilt', [0.05, 0.5])
def test_a_fit_finds_the_camera(tilt):
    truth = camera(y=-2.6 * np.tan(tilt), tilt=tilt)
    edges, sights = seen_by(truth)
    begin = replace(truth, focal=900.0, radial=np.zeros(2), place=truth.place + 0.05)
    found, errors = fit_camera(begin, HALF, HEIGHT, edges, sights)
    assert np.abs(errors).max() < 0.02
    grid = np.stack(np.meshgrid(np.linspace(-1.3, 1.3, 5), np.linspace(-0.6, 0.6, 5)), -1)
    lifted = np.concatenate([grid, np.full((5, 5, 1), 0.03)], -1)
    np.testing.assert_allclose(found.to_plane(truth.project(lifted), 0.03), grid, atol=2e-4)


def test_wrong_dots_do_not_count():
    truth = camera()
    edges, sights = seen_by(truth)
    moved = sights.pixel.copy()
    moved[0] += (9.0, -7.0)
    found, errors = fit_camera(truth, HALF, HEIGHT, edges, Sights(sights.at, moved))
    assert np.median(np.abs(errors)) < 0.05
    assert np.abs(errors[len(edges.at) :][:2]).min() > 5.0
    corner = np.array([[1.3, 0.6, 0.03]])
    np.testing.assert_allclose(
        found.to_plane(truth.project(corner), 0.03), corner[:, :2], atol=1e-3
    )


@pytest.mark.parametrize('first', range(4))
def test_corners_tell_the_camera_whatever_the_first_is(first):
    truth = camera(tilt=0.5, y=-1.6, k1=0.0, k2=0.0)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    corners = truth.project(np.column_stack([signs * HALF, np.full(4, HEIGHT)]))
    found = camera_of_corners(np.roll(corners, first, axis=0), HALF, HEIGHT, SIZE)
    np.testing.assert_allclose(found.place, truth.place, atol=0.12)
    middle = found.to_plane(truth.project(np.array([[0.5, 0.2, 0.03]])), 0.03)
    np.testing.assert_allclose(middle, [[0.5, 0.2]], atol=0.01)
