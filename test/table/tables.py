"""Tables for the tests of this folder."""

import dataclasses

import numpy as np

from billiard_shot.scene import BallBall, Cushion, Scene, Table
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.run.simulate import simulate

POOL = Scene.load('pool_table')
R = POOL.ball.radius
ENDLESS = dataclasses.replace(POOL, table=None)
SMOOTH = {'restitution': 1.0, 'friction_fast': 0.0, 'friction_slow': 0.0}


def scene_with(base=POOL, *, ball_ball=None, cushion=None, **changes):
    """Scene like another, with some numbers of its contacts and cushions changed."""
    contacts, table = base.contacts, base.table
    if ball_ball is not None:
        contacts = dataclasses.replace(contacts, ball_ball=BallBall(**ball_ball))
    if cushion is not None:
        table = dataclasses.replace(table or Table(), cushion=Cushion(**cushion))
    return dataclasses.replace(base, contacts=contacts, table=table, **changes)


def state(x, y, velocity=(0, 0, 0), spin=(0, 0, 0), height=0.0):
    """State of a ball on the cloth, or above it."""
    place = np.array([x, y, R + height])
    return BallState(place, np.array(velocity, float), np.array(spin, float))


def rolling(x, y, vx, vy):
    """State of a ball that rolls."""
    return state(x, y, (vx, vy, 0), (-vy / R, vx / R, 0))


def after(run, name, kind, nth=0):
    """State of a ball just after its nth event of a kind, when that is over."""
    event = [e for e in run.events if e.kind == kind and name in e.balls][nth]
    return state_after(run, name, event)


def state_after(run, name, event):
    """State of a ball just after an event: if its impact takes time, when that is over."""
    ball, time = run.balls[name], event.time
    takes_time = event.kind in (EventKind.CUSHION, EventKind.CLUSTER) and name in event.balls
    if takes_time and not event.place.startswith('jaw'):
        time = [segment.end for segment in ball.segments if segment.start == time][-1]
    return ball.at(time)


def play(scene, **balls):
    return simulate(scene, balls)


def random_states(random, table, count):
    """Balls apart from each other and the cushions, about half of them moving."""
    places = []
    while len(places) < count:
        point = random.uniform(-0.5, 0.5, 2) * (table.length - 2.1 * R, table.width - 2.1 * R)
        if all(np.hypot(*(point - other)) > 2 * R for other in places):
            places.append(point)
    states = {}
    for i, point in enumerate(places):
        speed = random.choice([0.0, 0.3, 2.0, 6.0]) if i else 3.0
        states[str(i)] = state(
            *point, (*random.normal(size=2) * speed, 0), random.normal(size=3) * speed * 20
        )
    return states
