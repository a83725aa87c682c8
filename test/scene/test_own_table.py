"""The formulas of docs/scenes.md, "Measure your own table", give back the numbers of a scene."""

from math import atan2, exp, sqrt, tan

import pytest

from billiard_shot import BallState, EventKind, predict, Scene, simulate, Stroke

G = 9.81
POOL = Scene.load('pool')
TABLE = Scene.load('pool_table')
RADIUS = POOL.ball.radius


def rolling(x, y, speed, heading=(1.0, 0.0)):
    along, aside = heading
    return BallState(
        (x, y, RADIUS),
        (speed * along, speed * aside, 0),
        (-speed * aside / RADIUS, speed * along / RADIUS, 0),
    )


def resting(x, y):
    return BallState((x, y, RADIUS))


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
    away = 0.1 + 2 * RADIUS
    run = simulate(
        POOL,
        {
            'cue': rolling(-away * c, -away * c, speed, (c, c)),
            '1': resting(0, 0),
            '2': resting(2 * RADIUS + 3e-4, 0),
        },
    )
    x, y, _ = run.final_position['2']
    slow = (y / (x - 2 * RADIUS) - 0.01) * exp(0.77 * speed)
    assert slow == pytest.approx(balls.friction_slow, rel=0.12)

    run = simulate(POOL, {'cue': rolling(-away, 0, speed), '1': resting(0, 0)})
    k = sqrt((run.final_position['cue'][0] + 2 * RADIUS) / run.final_position['1'][0])
    friction = 0.01 + slow * exp(-1.088 * speed)
    measured = 14 / (5 * (1 + friction + k * (1 - friction))) - 1
    assert measured == pytest.approx(balls.restitution, abs=0.02)
