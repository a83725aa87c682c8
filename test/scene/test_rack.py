"""Racks and the bundled scenes: as the rules say, and the same everywhere."""

import dataclasses
from itertools import combinations
import math
from math import atan2, exp, sqrt, tan
import pickle
import sys

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from programs import ran
import pytest

from billiard_shot import BallState, EventKind, predict, Scene, simulate, Stroke
from billiard_shot.scene import CornerPocket, Cushion, Rack, Table
from billiard_shot.scene.files import scene_names

RADIUS = 0.028575
GAMES = {'nine_ball': 9, 'eight_ball': 15, 'snooker': 21}
games = st.sampled_from(sorted(GAMES))
seeds = st.integers(0, 2**40)


def rack(game, **numbers):
    table = Table(length=3.569, width=1.778) if game == 'snooker' else Table()
    scene = dataclasses.replace(
        Scene.load('pool'), table=table, rack=Rack(game, **numbers), balls={'cue': (-0.9, 0.1)}
    )
    balls = dict(scene.balls)
    assert balls.pop('cue') == (-0.9, 0.1)
    return balls


def distances(balls):
    return sorted(math.dist(*pair) for pair in combinations(balls.values(), 2))


@given(games, seeds, st.floats(0, 1e-3))
def test_gaps(game, seed, gap):
    """Neighbours are between one diameter and one and two gaps apart; all others are far."""
    balls = rack(game, seed=seed, gap=gap)
    assert len(balls) == GAMES[game]
    neighbours = {'nine_ball': 16, 'eight_ball': 30, 'snooker': 31}[game]
    apart = distances(balls)
    assert apart[0] >= 2 * RADIUS - 1e-12
    assert apart[neighbours - 1] <= 2 * RADIUS + 2 * gap + 1e-12
    assert apart[neighbours] > 3 * RADIUS


def test_a_tight_rack_touches_and_is_symmetric():
    balls = rack('eight_ball', gap=0)
    assert distances(balls)[:30] == pytest.approx([2 * RADIUS] * 30, rel=1e-14)
    for x, y in balls.values():
        assert min(math.dist((x, -y), other) for other in balls.values()) < 1e-15


@given(seeds)
def test_nine_ball_rules(seed):
    balls = rack('nine_ball', seed=seed, gap=0)
    assert balls['1'] == (0.635, 0)
    assert balls['9'] == pytest.approx((0.635 + 2 * RADIUS * math.sqrt(3), 0), abs=1e-15)


@given(seeds)
def test_eight_ball_rules(seed):
    balls = rack('eight_ball', seed=seed, gap=0)
    assert balls['8'] == pytest.approx((0.635 + 2 * RADIUS * math.sqrt(3), 0), abs=1e-15)
    back = max(x for x, _ in balls.values())
    corners = [
        int(name) for name, (x, y) in balls.items() if x > back - 1e-9 and abs(y) > 3.9 * RADIUS
    ]
    assert len(corners) == 2
    assert min(corners) < 8 < max(corners)


def test_every_ball_comes_everywhere():
    apexes = {
        min(rack('eight_ball', seed=seed).items(), key=lambda item: item[1])[0]
        for seed in range(200)
    }
    assert apexes == {str(ball) for ball in range(1, 16)} - {'8'}


def test_snooker_spots():
    balls = Scene.load('snooker').balls
    assert balls['black'] == pytest.approx((1.4605, 0))
    assert balls['pink'] == pytest.approx((0.89225, 0))
    assert balls['brown'] == pytest.approx((-1.0475, 0))
    assert balls['yellow'] == pytest.approx((-1.0475, -0.292))  # right, seen from the baulk
    assert 0 < balls['red1'][0] - 0.89225 - 0.0525 < 2e-4


def test_the_same_in_every_process():
    code = (
        'from billiard_shot import Scene; import hashlib; '
        "print(repr(Scene.load('eight_ball').balls))"
    )
    answers = {
        ran([sys.executable, '-c', code], check=True, env={'PYTHONHASHSEED': seed}).stdout
        for seed in ('0', '1')
    }
    assert answers == {repr(Scene.load('eight_ball').balls) + '\n'}


def test_the_order_of_a_seed_never_changes():
    assert list(rack('nine_ball', seed=3)) == ['1', '7', '2', '6', '9', '4', '8', '5', '3']
    assert list(rack('eight_ball', seed=3))[:5] == ['12', '13', '4', '1', '8']


def test_racks_leave_nothing_behind():
    """The balls of a rack are balls like others: replacing the rest of the scene keeps them."""
    scene = Scene.load('nine_ball')
    assert dataclasses.replace(scene, law='energetic').balls == scene.balls
    moved = dataclasses.replace(scene, balls={**scene.balls, '9': (0, 0)})
    assert moved.balls['9'] == (0, 0)
    assert len(moved.balls) == 10
    assert Scene.from_dict(scene.to_dict()) == scene


def test_a_seed_may_be_a_number_of_numpy():
    assert Rack('nine_ball', seed=np.int64(3)) == Rack('nine_ball', seed=3)


@pytest.mark.parametrize(
    ('change', 'text'),
    [
        (
            {'rack': {'game': 'nineball'}},
            r"rack\.game must .*one of nine_ball, eight_ball.*, got 'nineball'",
        ),
        ({'rack': {}}, r'rack\.game is missing'),
        (
            {'rack': {'game': 'nine_ball', 'gap': -1e-3}},
            r'rack\.gap must .*at least 0.*, got -0\.001',
        ),
        (
            {'rack': {'game': 'nine_ball', 'seed': 1.5}},
            r'rack\.seed must .*whole number.*, got 1\.5',
        ),
        ({'rack': 'nine_ball'}, "rack must be a mapping, got 'nine_ball'"),
        ({'table': None}, r'rack needs a table; table is missing'),
        ({'balls': {'9': [0, 0]}}, r'balls\.9 is there twice; the rack has a ball of this name'),
        ({'balls': {'cue': [0.69, 0.03]}}, r"balls\.cue overlaps ball '.' of the rack"),
        (
            {'like': 'snooker', 'balls': {'cue': [0, 0.01]}, 'rack': {'game': 'snooker'}},
            r"balls\.cue overlaps ball 'blue' of the rack",
        ),
        ({'rack': {'game': 'snooker'}}, r"rack puts balls '.*' and '.*' into each other"),
        (
            {'table': {'length': 0.5, 'width': 0.5, 'pockets': False}},
            r"rack must put ball '.' between",
        ),
    ],
)
def test_mistakes_with_racks(change, text):
    data = {'like': 'pool_table', 'rack': {'game': 'nine_ball'}, **change}
    with pytest.raises(ValueError, match=text):
        Scene.from_dict(data)


def test_a_rack_sees_a_cue_ball_that_is_not_placed():
    data = {**Scene.load('snooker').to_dict(), 'balls': {}, 'rack': {'game': 'snooker'}}
    with pytest.raises(ValueError, match=r"balls\.cue overlaps ball 'blue' of the rack"):
        Scene.from_dict(data)


def test_scenes_like_others(tmp_path):
    (tmp_path / 'base.yaml').write_text('like: pool_table\nballs: {8: [0.5, 0.1]}\n')
    own = tmp_path / 'own.yaml'
    own.write_text('like: base.yaml\nball: {mass: 0.16}\ncontacts: {cue_ball: {friction: 0.5}}\n')
    scene, pool = Scene.load(own), Scene.load('pool_table')
    assert scene.ball.mass == 0.16
    assert scene.ball.radius == pool.ball.radius
    assert scene.contacts.cue_ball == dataclasses.replace(pool.contacts.cue_ball, friction=0.5)
    assert scene.balls == {**pool.balls, '8': (0.5, 0.1)}
    assert Scene.from_dict({'like': 'paper'}) == Scene.load('paper')


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('like: ghost', r"line 1: like: scene must be one of blocked, .*, got 'ghost'"),
        ('like: none.yaml', 'line 1: like: .*No such file'),
        (
            'like: own.yaml',
            "like must be a scene that does not inherit from this one, got 'own.yaml'",
        ),
        ('like: [1]', 'like: '),
        ('like: pool\nball: {mass: -1}', r'line 2: ball\.mass must be .*, got -1'),
        ('like: pool\nball: 3', 'line 2: ball must be a mapping, got 3'),
        (
            'like: blocked\n\nball: {radius: 0.21}',
            r"balls\.1 must be .* from ball 'cue', which it overlaps by",
        ),
    ],
)
def test_mistakes_in_scenes_like_others(tmp_path, text, message):
    path = tmp_path / 'own.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        Scene.load(path)


@pytest.mark.parametrize('name', sorted(set(scene_names()) - {'paper', 'pool'}))
def test_bundled_tables_are_to_scale(name):
    scene = Scene.load(name)
    assert scene.table.length == pytest.approx(2 * scene.table.width, rel=0.01)
    assert 'cue' in scene.balls


def test_the_frozen_combination_is_frozen():
    scene = Scene.load('frozen_combination')
    assert math.dist(scene.balls['1'], scene.balls['8']) == pytest.approx(
        2 * scene.ball.radius, abs=1e-15
    )


@pytest.fixture
def data():
    return Scene.load('pool').to_dict()


def test_a_scene_without_table_has_an_endless_cloth(data):
    assert 'table' not in data
    assert Scene.from_dict(data).table is None


def test_default_table_is_nine_feet_of_the_wpa(data):
    scene = Scene.from_dict(data | {'table': {}})
    assert scene.table == Table()
    assert (scene.table.length, scene.table.width) == (2.54, 1.27)
    assert Scene.from_dict(scene.to_dict()) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_a_cushion_model_brings_its_numbers():
    assert (Cushion().restitution, Cushion().friction) == (0.98, 0.14)
    assert (Cushion('han').restitution, Cushion('han').friction) == (0.85, 0.2)
    assert Cushion('han', 0.7).restitution == 0.7


def test_cushions_are_slower_than_balls(data):
    """So the one contact acts at once within the other."""
    data['contacts']['ball_ball']['duration'] = 3e-4
    assert Scene.from_dict(data | {'table': {'cushion': {'duration': 3e-3}}})
    assert Scene.from_dict(data | {'table': {'cushion': {'duration': 0}}})
    with pytest.raises(
        ValueError, match=r'cushion\.duration must .*ten times .* 0\.003.*, got 0\.002'
    ):
        Scene.from_dict(data | {'table': {'cushion': {'duration': 0.002}}})


def test_carom_table(data):
    scene = Scene.from_dict(data | {'table': {'length': 2.84, 'width': 1.42, 'pockets': False}})
    assert not scene.table.pockets


@pytest.mark.parametrize(
    ('table', 'mistake'),
    [
        ({'length': 0}, r'table\.length must .* above 0 and at most 20, got 0 \(m\)'),
        ({'lenght': 2}, r'table\.lenght is unknown; the nearest key is length'),
        ({'corner': {'cut_deg': 90}}, r'table\.corner\.cut_deg must .*above 90.*, got 90'),
        (
            {'cushion': {'model': 'rubber'}},
            r"table\.cushion\.model must .* mathavan, han, stronge, got 'rubber'",
        ),
        ({'width': 0.17}, r'table\.width must be above 0\.1785 with these pockets, got 0\.17'),
    ],
)
def test_mistakes_are_named(data, table, mistake):
    with pytest.raises(ValueError, match=mistake):
        Scene.from_dict(data | {'table': table})


def test_pockets_need_room_only_where_there_are_any():
    assert Table(width=0.17, pockets=False).width == 0.17
    with pytest.raises(ValueError, match='width must be above'):
        Table(corner=CornerPocket(mouth=1.0))


# --- the formulas of docs/scenes.md, "Measure your own table", give back the numbers of a scene

G = 9.81
POOL = Scene.load('pool')
TABLE = Scene.load('pool_table')
BALL_RADIUS = POOL.ball.radius


def rolling(x, y, speed, heading=(1.0, 0.0)):
    along, aside = heading
    return BallState(
        (x, y, BALL_RADIUS),
        (speed * along, speed * aside, 0),
        (-speed * aside / BALL_RADIUS, speed * along / BALL_RADIUS, 0),
    )


def resting(x, y):
    return BallState((x, y, BALL_RADIUS))


def test_rolling_resistance():
    run = simulate(POOL, {'cue': rolling(0, 0, 0.6)})
    measured = 2 * run.final_position['cue'][0] / (G * run.events[-1].time ** 2)
    assert measured == pytest.approx(POOL.cloth.rolling_resistance, rel=1e-3)


@pytest.mark.parametrize('speed', [1.5, 2.0])
def test_restitution_of_a_cushion(speed):
    run = simulate(TABLE, {'cue': rolling(0.9, 0.2, speed)})
    hit = next(event.time for event in run.events if event.kind is EventKind.CUSHION)
    before = run.at(hit - 1e-3)['cue'].velocity[0]
    seconds = TABLE.table.cushion.duration, TABLE.table.cushion.duration + 0.028
    places = [run.at(hit + after)['cue'].position[0] for after in seconds]
    after = (places[0] - places[1]) / (seconds[1] - seconds[0])
    measured = after / before * (1 + (0.11 * before) ** 2)
    assert measured == pytest.approx(TABLE.table.cushion.restitution, rel=0.04)


@pytest.mark.parametrize('a', [0.25, 0.35, 0.5])
def test_end_mass(a):
    shot = predict(POOL, Stroke.from_offsets(a=a, b=0, elevation=0, azimuth=0, speed=3))
    x, y, _ = shot.run.at(0.8 / shot.velocity[0])['cue'].position
    s2 = 1 - a * a
    lighter = 2.5 * a * sqrt(s2) / tan(atan2(y, x)) - 1 - 2.5 * s2
    measured = 0.75 * POOL.ball.mass / lighter
    assert measured == pytest.approx(POOL.cue.end_mass, rel=0.1)


def test_restitution_of_the_tip():
    speed = 2.0
    shot = predict(POOL, Stroke.from_offsets(a=0, b=0, elevation=0, azimuth=0, speed=speed))
    measured = (1 + POOL.ball.mass / POOL.cue.mass) * shot.velocity[0] / speed - 1
    assert measured == pytest.approx(POOL.contacts.cue_ball.restitution, rel=0.01)


@pytest.mark.parametrize('speed', [0.5, 1.0])
def test_friction_and_restitution_of_balls(speed):
    balls = POOL.contacts.ball_ball
    c = sqrt(0.5)
    away = 0.1 + 2 * BALL_RADIUS
    run = simulate(
        POOL,
        {
            'cue': rolling(-away * c, -away * c, speed, (c, c)),
            '1': resting(0, 0),
            '2': resting(2 * BALL_RADIUS + 3e-4, 0),
        },
    )
    x, y, _ = run.final_position['2']
    slow = (y / (x - 2 * BALL_RADIUS) - 0.01) * exp(0.77 * speed)
    assert slow == pytest.approx(balls.friction_slow, rel=0.12)

    run = simulate(POOL, {'cue': rolling(-away, 0, speed), '1': resting(0, 0)})
    k = sqrt((run.final_position['cue'][0] + 2 * BALL_RADIUS) / run.final_position['1'][0])
    friction = 0.01 + slow * exp(-1.088 * speed)
    measured = 14 / (5 * (1 + friction + k * (1 - friction))) - 1
    assert measured == pytest.approx(balls.restitution, abs=0.02)
