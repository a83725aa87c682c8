"""Plans whose balls lie elsewhere than the scene says: drawn places, and what comes of them."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import plan, predict, Scene, Stroke
from billiard_shot.cue.plan import tip_at
from billiard_shot.planning.problem import as_struck, draw_places, limits_of, problem_of
from billiard_shot.planning.runner import simulate_strokes
from billiard_shot.planning.targets import target_of
from billiard_shot.scene import Noise

SIGMAS = (0.0005, 0.0023)
"""Errors of a good camera, of a usual one, and of a poor one [m]."""

POINTS = 0.03
SCENES, REPLAYS = 20, 50
APART = 0.15  # m, of balls


def problem(scene, sigma):
    noise = replace(scene.noise, balls=sigma)
    target = target_of(scene, {'pot': '8'})
    return problem_of(scene, target, limits_of(scene, None, noise), noise)


@pytest.fixture(scope='module')
def table():
    balls = {'cue': (-0.4, 0.1), '8': (0.5, 0.2), '3': (0.56, 0.2), '5': (0.0, -0.6)}
    return replace(Scene.load('pool_table'), balls=balls)


def test_exact_places_are_not_drawn(table):
    draw = np.random.default_rng(1)
    assert draw_places(problem(table, 0.0), draw, 10) is None
    assert draw.random() == np.random.default_rng(1).random(), 'the other errors stay the same'


def test_drawn_places_are_possible(table):
    """No overlaps, none in a cushion; the balls with room around them have the stated errors."""
    here, sigma = problem(table, 0.002), 0.002
    places = draw_places(here, np.random.default_rng(2), 4000)
    assert places.shape == (4000, 4, 2)
    for i in range(4):
        for k in range(i):
            gaps = np.hypot(*(places[:, i] - places[:, k]).T) - 2.0 * here.radius
            assert gaps.min() > -1e-8
    assert (np.abs(places) <= here.half_sizes).all()
    away = places[:, 0] - here.cue_ball
    np.testing.assert_allclose(away.std(axis=0), sigma, rtol=0.05)
    np.testing.assert_allclose(away.mean(axis=0), 0.0, atol=4.0 * sigma / np.sqrt(4000))


def test_a_stroke_meets_a_ball_that_lies_aside(table):
    """The same pose of the cue, read relative to where the cue ball lies."""
    here, rng = problem(table, 0.001), np.random.default_rng(3)
    strokes = rng.uniform((-0.3, -0.3, 0.0, -3.0, 1.0), (0.3, 0.3, 0.8, 3.0, 3.0), (20, 5))
    places = draw_places(here, rng, 20)
    met = as_struck(here, strokes, places)
    for stroke, there, found in zip(strokes, places[:, 0], met, strict=True):
        tip = tip_at(Stroke.from_offsets(*stroke), tuple(here.cue_ball), table)
        before = tuple(tip.position - 0.05 * tip.along)
        radius = table.ball.radius
        pose = Stroke.from_pose(before, tip.quaternion, stroke[4], ball=(*there, radius))
        curvature = table.cue.tip_curvature_radius / radius
        normal = np.array(pose.touching(curvature).normal)
        again = Stroke(normal=tuple(normal), velocity=pose.velocity)
        np.testing.assert_allclose(again.offsets[:2], found[:2], atol=1e-9)


def test_strikes_near_a_ball_are_those_where_the_balls_really_lie(table):
    """Some reach the ball in the strike and some do not, by where it was drawn."""
    near = {'cue': (0.0, 0.0), '8': (2.0 * table.ball.radius + 0.002, 0.0)}
    scene, count = replace(table, balls=near), 30
    here, rng = problem(scene, 0.001), np.random.default_rng(6)
    places = draw_places(here, rng, count)
    strokes = as_struck(here, np.tile((0.0, 0.1, 0.1, 0.0, 1.0), (count, 1)), places)
    played, usable = simulate_strokes(here, strokes, places=places)
    assert usable.all()
    for i, (stroke, there) in enumerate(zip(strokes, places, strict=True)):
        balls = dict(zip(here.names, map(tuple, there.tolist()), strict=True))
        shot = predict(replace(scene, balls=balls), Stroke.from_offsets(*stroke))
        assert played.cues['velocity'][i] == pytest.approx(shot.velocity, abs=1e-4)
        assert played.cues['others'][i] == bool(shot._cue['others'])
    assert 0 < np.count_nonzero(played.cues['others']) < count


def random_table(rng):
    while True:
        places = rng.uniform((-1.1, -0.5), (1.1, 0.5), (3, 2))
        if min(np.hypot(*(places[i] - places[k])) for i in range(3) for k in range(i)) > APART:
            balls = dict(zip(('cue', '8', '3'), map(tuple, places.tolist()), strict=True))
            return replace(Scene.load('pool_table'), balls=balls)


def is_reached(scene, planned, noise, rng):
    """Play a plan once: the robot moves the cue to where the scene has the cue ball."""
    lie = {
        name: (x + rng.normal(0.0, noise.balls), y + rng.normal(0.0, noise.balls))
        for name, (x, y) in scene.balls.items()
    }
    played = noise.perturb(planned.stroke, rng, scene.ball.radius)
    tip = tip_at(played, scene.balls['cue'], scene)
    before, centre = tip.position - 0.05 * tip.along, (*lie['cue'], scene.ball.radius)
    stroke = Stroke.from_pose(tuple(before), tip.quaternion, played.speed, ball=centre)
    shot = predict(replace(scene, balls=lie), stroke)
    return '8' in shot.pocketed and 'cue' not in shot.pocketed and not shot.off_table


@pytest.mark.parametrize('sigma', SIGMAS)
def test_stated_success_is_what_comes(sigma):
    """Twenty tables, replayed with fresh errors of balls and strokes by `predict`."""
    rng, stated, measured = np.random.default_rng(4), [], []
    for _ in range(SCENES):
        scene = random_table(rng)
        noise = replace(Noise(), balls=sigma)
        best = plan(scene, {'pot': '8'}, noise, budget=6000, seed=2).best
        if best is None:
            continue
        stated.append(best.success)
        measured.append(np.mean([is_reached(scene, best, noise, rng) for _ in range(REPLAYS)]))
    assert len(stated) >= SCENES - 2
    assert np.mean(stated) - np.mean(measured) <= POINTS
