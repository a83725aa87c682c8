"""Rebounds that are interpolated in a table: their errors, and what they depend on."""

from dataclasses import replace

import numpy as np
import pytest
from tables import after, POOL, R, scene_with

from billiard_shot import EventKind, machine_code, Scene
from billiard_shot.records import OBJECTS, ROWS
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.layout import lay_out
from billiard_shot.table.run.simulate import run_many, run_one
from billiard_shot.table.run.states import ball_starts
from billiard_shot.table.run.task import TableTask

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')


CAROM = Scene.load('carom')  # friction at its noses may lift a ball


def starts_at_nose(kind, count, seed=3, scene=POOL):
    """Balls (count, 1) just before the nose of the foot cushion, up to 80 degrees from it."""
    random, radius = np.random.default_rng(seed), scene.ball.radius
    starts = ball_starts(count, 1)
    angle, speed = np.radians(random.uniform(-80, 80, count)), random.uniform(0.3, 5, count)
    vx, vy = speed * np.cos(angle), speed * np.sin(angle)
    starts['position'][:, 0] = 0.5 * scene.table.length - 1.02 * radius, 0.2, radius
    starts['velocity'][:, 0, 0], starts['velocity'][:, 0, 1] = vx, vy
    side = speed * random.uniform(-1, 1, count) * random.choice([0, 0.3, 1], count)
    share = {'rolling': 1.0, 'stunned': random.uniform(0, 1, count)}
    if kind == 'sliding':
        spin = speed[:, np.newaxis] * random.uniform(-1.2, 1.2, (count, 2))
    else:
        spin = np.column_stack([-vy, vx]) * np.reshape(share[kind], (-1, 1))
    starts['spin'][:, 0] = np.column_stack([spin, side]) / radius
    return starts


def leaving(scene, starts, *, fast):
    """Velocities and spins (n, 3) [m/s, rad/s] with which balls leave the cushion."""
    states = []
    for row in starts:
        task = TableTask(*params_on_table(scene), row[np.newaxis], 1e-3, fast_rebounds=fast)
        states.append(after(run_one(task, ('cue',)), 'cue', EventKind.CUSHION))
    return np.array([each.velocity for each in states]), np.array([each.spin for each in states])


@pytest.mark.parametrize('scene', [POOL, CAROM], ids=['pool', 'carom'])
@pytest.mark.parametrize(
    ('kind', 'half', 'most'),
    [('rolling', 1e-3, 4e-3), ('stunned', 2e-3, 8e-3), ('sliding', 3e-3, 2e-2)],
)
def test_errors_are_those_of_the_documentation(kind, half, most, scene):
    """Relative to the speed of the ball: median, and in 95 % of rebounds."""
    starts = starts_at_nose(kind, 300, scene=scene)
    speed = np.linalg.norm(starts['velocity'][:, 0], axis=-1)
    for fast, exact, size in zip(
        leaving(scene, starts, fast=True),
        leaving(scene, starts, fast=False),
        (1, scene.ball.radius),
        strict=True,
    ):
        error = size * np.linalg.norm(fast - exact, axis=-1) / speed
        assert (error > 0.0).any()
        assert np.median(error) < half
        assert np.quantile(error, 0.95) < most


def test_a_cushion_with_a_tangential_spring_has_a_table():
    scene = scene_with(cushion={'frequency_ratio': 1.2})
    starts = starts_at_nose('rolling', 100)
    fast, exact = (leaving(scene, starts, fast=each)[0] for each in (True, False))
    error = np.linalg.norm(fast - exact, axis=-1) / np.linalg.norm(exact, axis=-1)
    assert 0.0 < np.quantile(error, 0.95) < 1e-2


def test_left_and_right_are_alike():
    starts = starts_at_nose('sliding', 40)
    mirrored = starts.copy()
    mirrored['position'][..., 1] *= -1
    mirrored['velocity'][..., 1] *= -1
    mirrored['spin'][..., [0, 2]] *= -1
    velocity, spin = leaving(POOL, starts, fast=True)
    other, turned = leaving(POOL, mirrored, fast=True)
    assert other == pytest.approx(velocity * (1, -1, 1), abs=1e-12)
    assert turned == pytest.approx(spin * (-1, 1, -1), abs=1e-9)


def test_rows_do_not_depend_on_each_other():
    """The order of the rows decides who fills the table; and so do the threads."""
    starts = starts_at_nose('sliding', 400, seed=5)
    scene = scene_with(cushion={'friction': 0.1234})  # a table that nothing has filled yet
    task = TableTask(*params_on_table(scene), starts, 1e-3, fast_rebounds=True)
    one = run_many(task, ('cue',), workers=2)
    scene = scene_with(cushion={'friction': 0.1234, 'restitution': 0.97})
    other = TableTask(*params_on_table(scene), starts[::-1], 1e-3, fast_rebounds=True)
    run_many(other, ('cue',))
    again = run_many(task._replace(starts=starts[::-1]), ('cue',), workers=1)
    assert np.array_equal(one.final_position, again.final_position[::-1])


@pytest.mark.parametrize('kind', ['rolling', 'sliding'])
def test_a_rebound_that_lifts_the_ball_is_solved(kind):
    """The friction of the noses of this table lifts balls, by less than a millimetre."""
    starts = starts_at_nose(kind, 200, scene=CAROM)
    fast, exact = (leaving(CAROM, starts, fast=each)[0] for each in (True, False))
    solved, lifted = (fast == exact).all(axis=-1), exact[:, 2] > 0.01
    assert solved[lifted].all()
    assert lifted.sum() > 20
    assert not solved.all()


def test_cloths_on_which_lifted_balls_bounce_alike_alone_share_a_table():
    """Friction may lift a ball that lands again while the nose presses it."""
    base = scene_with(cushion={'friction': 0.6})
    starts, found = starts_at_nose('sliding', 200), []
    for restitution in (0.0, 0.9):
        cloth = replace(base.contacts.ball_table, restitution=restitution)
        scene = replace(base, contacts=replace(base.contacts, ball_table=cloth))
        found.append([leaving(scene, starts, fast=each)[0] for each in (True, False)])
    (one, exact), (other, another) = found
    interpolated = (one != exact).any(axis=-1) & (other != another).any(axis=-1)
    assert (one != other).any(axis=-1)[interpolated].any()


def test_a_ball_in_the_air_is_solved():
    starts = starts_at_nose('sliding', 20)
    starts['position'][..., 2] += 0.2 * R
    for fast, exact in zip(
        leaving(POOL, starts, fast=True), leaving(POOL, starts, fast=False), strict=True
    ):
        assert np.array_equal(fast, exact)


def test_interpreted_code_and_han_have_no_table():
    params, table = params_on_table(POOL)
    assert len(lay_out(ROWS, params, table, fast_rebounds=True).rebounds) > 0
    assert len(lay_out(ROWS, params, table).rebounds) == 0
    assert len(lay_out(OBJECTS, params, table, fast_rebounds=True).rebounds) == 0
    han = replace(POOL.table.cushion, model='han', restitution=None, friction=None, fading=None)
    params, table = params_on_table(replace(POOL, table=replace(POOL.table, cushion=han)))
    assert len(lay_out(ROWS, params, table, fast_rebounds=True).rebounds) == 0
