"""
Runs in a Python that has pooltool 0.6.0: times simulations and writes their results as JSON.

    python benchmarks/tools/pooltool_worker.py REPEATS SHOTS

Both libraries then play from the same ball velocities and spins. The layouts: one ball with spin,
a cut, and the breaks of nine- and eight-ball, on pooltool's default table; then random shots of
one to three balls, with cushions after Han (2005) in both. Frame: pooltool's, x across the table.
"""

import json
import random
import statistics
import sys
from time import perf_counter

import numpy as np
import pooltool as pt
from pooltool.physics.resolve.ball_cushion.han_2005 import Han2005Circular, Han2005Linear


def engine():
    """Pooltool's engine with Han's cushions; the rest is its default."""
    made = pt.physics.PhysicsEngine()
    made.resolver.ball_linear_cushion = Han2005Linear()
    made.resolver.ball_circular_cushion = Han2005Circular()
    return made


ENGINE = engine()


def struck(balls, **cue):
    """System with the cue ball as it leaves the tip."""
    system = pt.System(cue=pt.Cue(cue_ball_id='cue'), table=pt.Table.default(), balls=balls)
    if 'at' in cue:
        cut = cue.pop('cut', None)
        cue['phi'] = pt.aim.at_ball(system, cue.pop('at'), **({} if cut is None else {'cut': cut}))
    system.cue.set_state(**cue)
    ENGINE.resolver.stick_ball.resolve(system.cue, system.balls['cue'], inplace=True)
    system.cue.set_state(V0=0.0)
    return system


def rack(game, seed):
    """Break at 8 m/s."""
    np.random.seed(seed)  # noqa: NPY002 (the generator that pooltool uses)
    random.seed(seed)
    balls = pt.get_rack(game, pt.Table.default(), spacing_factor=1e-3)
    return struck(balls, V0=8.0, at='1', a=0.0, b=0.0, theta=0.0)


def layouts():
    """The four layouts."""
    cue = pt.Ball.create('cue', xy=(0.5, 0.5))
    return {
        'one ball': struck({'cue': cue}, V0=3.0, phi=75.0, theta=10.0, a=0.3, b=-0.3),
        'cut shot': struck(
            {'cue': cue.copy(), '1': pt.Ball.create('1', xy=(0.55, 1.2))},
            V0=2.5,
            at='1',
            cut=30.0,
            a=0.0,
            b=0.0,
            theta=0.0,
        ),
        '9-ball break': rack(pt.GameType.NINEBALL, 7),
        '8-ball break': rack(pt.GameType.EIGHTBALL, 7),
    }


def shot(draw):
    """Random shot of one to three balls, rolling or sliding with spin, not too hard."""
    places = []
    while len(places) < draw.integers(1, 4):
        x, y = draw.uniform(0.1, 0.89), draw.uniform(0.1, 1.88)
        if all(np.hypot(x - p, y - q) > 0.08 for p, q in places):
            places.append((x, y))
    balls = {
        name: pt.Ball.create(name, xy=place)
        for name, place in zip(('cue', '1', '2'), places, strict=False)
    }
    system = pt.System(cue=pt.Cue(cue_ball_id='cue'), table=pt.Table.default(), balls=balls)
    if len(balls) > 1 and draw.random() < 0.7:
        angle = np.radians(pt.aim.at_ball(system, '1', cut=draw.uniform(-60, 60)))
    else:
        angle = draw.uniform(0, 2 * np.pi)
    speed, radius = draw.uniform(0.3, 1.5), 0.028575
    velocity = speed * np.array([np.cos(angle), np.sin(angle), 0])
    spin = draw.uniform(-1, 1, 3) * speed / radius * (0.7, 0.7, 1)
    system.balls['cue'].state.rvw[1:] = velocity, spin
    system.balls['cue'].state.s = 2
    system.cue.set_state(V0=0.0)
    return system


def states(system):
    """Positions, velocities and spins."""
    return {name: ball.state.rvw.tolist() for name, ball in system.balls.items()}


def played(system):
    """Simulate a system: first and last states, pocketed balls, events."""
    copy = system.copy()
    begin = states(copy)
    pt.simulate(copy, engine=ENGINE, inplace=True)
    kinds = [str(event.event_type) for event in copy.events]
    return {
        'begin': begin,
        'end': states(copy),
        'pocketed': [name for name, ball in copy.balls.items() if ball.state.s == 4],
        'events': kinds,
    }


def timed(system, repeats, engine):
    """Median time of a simulation [s]; the copy is made outside."""
    series = []
    for _ in range(repeats):
        copy = system.copy()
        begin = perf_counter()
        pt.simulate(copy, engine=engine, inplace=True)
        series.append(perf_counter() - begin)
    return statistics.median(series)


def main():
    """Write everything as one JSON object."""
    repeats, shots = int(sys.argv[1]), int(sys.argv[2])
    draw = np.random.default_rng(5)
    result = {'version': pt.__version__, 'layouts': {}, 'shots': []}
    for name, system in layouts().items():
        result['layouts'][name] = played(system) | {
            'seconds': timed(system, repeats, ENGINE),
            'seconds_default': timed(system, repeats, pt.physics.PhysicsEngine()),
        }
    contacts = {'ball_ball', 'ball_linear_cushion', 'ball_circular_cushion'}
    while len(result['shots']) < shots:
        run = played(shot(draw))
        if 0 < sum(kind in contacts for kind in run['events']) <= 3:
            result['shots'].append(run)
    result['racks'] = {
        name: [states(rack(game, 100 + seed)) for seed in range(60)]
        for name, game in (
            ('9-ball break', pt.GameType.NINEBALL),
            ('8-ball break', pt.GameType.EIGHTBALL),
        )
    }
    json.dump(result, sys.stdout)


if __name__ == '__main__':
    main()
