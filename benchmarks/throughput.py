"""
Batches: strokes, tables and plans in a CPU second, and ratios of calls that take turns.

    python benchmarks/throughput.py
"""

from concurrent.futures import Future

import numpy as np
from tools.plan_scenes import crowded_scene, pot_scene, table, TOURNAMENT
from tools.timing import in_turns, once, QUICK, Report

from billiard_shot import (
    BallState,
    plan,
    predict_batch,
    predict_within_noise,
    Scene,
    shots,
    simulate,
    simulate_batch,
    Stroke,
)

STROKES = 1000 if QUICK else 4000
TABLES = 500 if QUICK else 2000
PLANS = 6 if QUICK else 30
CROWDED_PLANS = 3 if QUICK else 8
ON_TABLE = 1.5  # exact strokes on a table with cushions over those without
WITHIN_NOISE = 3.0  # strokes at the accuracy of the noise over exact ones
PLANNED = 1.0  # a stroke of a plan over an exact one
ONE_TABLE = 2.0  # simulate() of 15 balls over one
SHOTS = 0.5  # `shots` of a state over one exact stroke there


class Here:
    """Runs tasks when they are submitted, so that a plan takes one core."""

    def submit(self, work, *arguments):
        """Do the work."""
        done = Future()
        done.set_result(work(*arguments))
        return done


def strokes(count, seed=3):
    """Ordinary strokes (n, 5) of a player: a, b, elevation, azimuth, speed."""
    draw = np.random.default_rng(seed)
    low, high = (-0.4, -0.4, 0.05, -3.1, 0.5), (0.4, 0.4, 0.2, 3.1, 4.0)
    return draw.uniform(low, high, (count, 5))


def around(scene, count):
    """Strokes (n, 5) as a player executes one of them, at the middle of the cue ball."""
    return scene.noise.sample(
        (0.0, 0.1, 0.06, 0.3, 2.0), count, np.random.default_rng(1), scene.ball.radius
    )


def batches(report, name, scene):
    """Exact strokes and strokes at the accuracy of the noise, with the noise of a player."""
    played = around(scene, STROKES)
    exact, near = in_turns(
        lambda: predict_batch(scene, offsets=played[: STROKES // 4]),
        lambda: predict_within_noise(scene, played),
    )
    exact = 4.0 * exact
    report.row(f'{name}: exact strokes in a CPU second', STROKES / exact.cpu, '1/s')
    report.row(f' {name}: strokes within noise in a CPU second', STROKES / near.cpu, '1/s')
    report.row(f'{name}: strokes within noise over exact ones', exact / near, 'x', -WITHIN_NOISE)
    return exact / STROKES


def tables(report, crowded):
    """Table runs: exact strokes with and without a table, one and 15 balls, the break, `shots`."""
    played = strokes(STROKES // 4)
    on_table, bare = in_turns(
        lambda: predict_batch('pool_table', offsets=played),
        lambda: predict_batch('pool', offsets=played),
    )
    report.row('predict_batch, pool_table over pool', on_table / bare, 'x', ON_TABLE)
    lying = BallState(places_of(crowded))
    names = list(crowded.balls)
    few, many = {'cue': rolling(crowded)}, {}
    for name, place in zip(names, lying.position, strict=True):
        many[name] = BallState(place)
    many['cue'] = rolling(crowded)
    one, all_15 = in_turns(
        lambda: [simulate(crowded, few) for _ in range(20)],
        lambda: [simulate(crowded, many) for _ in range(20)],
    )
    report.row('simulate() of 15 balls over one', all_15 / one, 'x', ONE_TABLE)
    alone = BallState(np.tile(places_of(crowded)[0], (TABLES, 1)), few['cue'].velocity)
    moving = {
        name: BallState(np.tile(s.position, (TABLES, 1)), s.velocity) for name, s in many.items()
    }
    one, all_15 = in_turns(
        lambda: simulate_batch(crowded, {'cue': alone}, workers=1),
        lambda: simulate_batch(crowded, moving, workers=1),
    )
    report.row('simulate_batch: tables of 1 ball in a CPU second', TABLES / one.cpu, '1/s')
    report.row('simulate_batch: tables of 15 balls in a CPU second', TABLES / all_15.cpu, '1/s')
    broken = Stroke.from_offsets(elevation=0.05, speed=4.5)
    scene = Scene.load('eight_ball')
    strike = predict_batch(scene, [broken.normal], [broken.velocity])
    given = {name: BallState((*place, scene.ball.radius)) for name, place in scene.balls.items()}
    x, y = scene.balls['cue']
    given['cue'] = BallState((x, y, scene.ball.radius), strike.velocity[0], strike.spin[0])
    (took,) = in_turns(lambda: simulate(scene, given))
    report.row('simulate() of a break of eight_ball, defaults', took, 'ms')


def places_of(scene):
    """Places (balls, 3) of the balls of a scene [m]."""
    return np.array([(*place, scene.ball.radius) for place in scene.balls.values()])


def rolling(scene):
    """The cue ball of a scene as it rolls."""
    r = scene.ball.radius
    x, y = scene.balls['cue']
    return BallState((x, y, r), (1.6, 0.7, 0.0), (-0.7 / r, 1.6 / r, 0.0))


def direct_shots(report, crowded, exact):
    """`shots` of many states with 15 balls."""
    draw, count = np.random.default_rng(5), TABLES
    others = [crowded_scene(draw) for _ in range(count // 20)]
    position = np.array([places_of(each) for each in others])
    position = np.tile(position, (20, 1, 1))
    states = {name: BallState(position[:, i]) for i, name in enumerate(others[0].balls)}
    (took,) = in_turns(lambda: shots(crowded, states))
    report.row('shots() of a state with 15 balls', took / len(position), 'us')
    report.row('    over an exact stroke there', took / len(position) / exact, 'x', SHOTS)


def plans(report, exact):
    """Strokes that plans simulate in a CPU second."""
    draw = np.random.default_rng(7)
    pots = [pot_scene(draw, i % 5, i // 5 % 3) for i in range(PLANS)]
    draw = np.random.default_rng(17)
    crowds = [(crowded_scene(draw), {'pot': 'any'}) for _ in range(CROWDED_PLANS)]
    plan(*pots[0], budget=500)  # loads the library
    for name, given in (('pots', pots), ('tables of 15 balls', crowds)):
        simulations, success = [], []

        def all_plans(given=given, simulations=simulations, success=success):
            for i, each in enumerate(given):
                found = plan(*each, noise=TOURNAMENT, seed=i, executor=Here())
                simulations.append(found.simulations)
                success.append(found.best.success if found.best else 0.0)

        took = once(all_plans)
        report.row(
            f' plans, {len(given)} {name}: strokes in a CPU second',
            sum(simulations) / took.cpu,
            '1/s',
        )
        share = took / sum(simulations) / exact[len(given[0][0].balls) > 2]
        report.row('    a stroke over an exact one', share, 'x', PLANNED)
        report.row('    a plan', took / len(given), 's')
        report.row('    success, mean', 100.0 * float(np.mean(success)), '%')


def main():
    """Measure everything."""
    report = Report('Batches')
    lone = table({'cue': (-0.4, 0.1)})
    crowded = crowded_scene(np.random.default_rng(17))
    alone = batches(report, '1 ball', lone)
    exact = batches(report, '15 balls', crowded)
    tables(report, crowded)
    direct_shots(report, crowded, exact)
    plans(report, (alone, exact))
    report.end()


if __name__ == '__main__':
    main()
