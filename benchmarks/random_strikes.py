"""
Random strikes over very wide ranges: all solved, all energy accounted for.

Seeded; log-uniform over mass ratios 1e-6 to 1e6, stiffness ratios 1e-8 to 1e8, friction 1e-3 to
10, speeds 1e-9 to 1e3 m/s, n.c from -1e-12 to -1; restitution 0 to 1, and one in ten each exactly
0 or 1, or without friction; guided cues and light ends, both laws. The tolerance is 1e-12 of the
approach speed.

    python benchmarks/random_strikes.py --count 1000000 [--mild] [--failures CSV] [--picture PNG]

The default count is ten thousand, for a first look; a million strikes take an hour or two.
Ctrl+C ends the run with a report of the strikes solved so far.

`--mild` keeps to the published ranges: mass ratios 0.3 to 10, stiffness ratios 0.1 to 10, n.c from
-0.3, friction 0 or 0.05 to 1, restitution 0, 0.3 to 0.95 or 1.
"""

import argparse
from collections import Counter
from concurrent.futures import as_completed, ProcessPoolExecutor
import csv
import os
import sys
from time import perf_counter

import numpy as np
from tools.timing import Report

from billiard_shot import Scene
from billiard_shot.cli.output import progress
from billiard_shot.cli.workers import begin_work
from billiard_shot.impact.collide import contact_space, properties_of, system_of, velocity_changes
from billiard_shot.impact.kernel import solve_in_contact_space
from billiard_shot.impact.options import BISTIFFNESS, ENERGETIC
from billiard_shot.shot.effects import strike_model
from billiard_shot.status import Status
from studies.collisions import collision_of

TIGHT = 1e-12
LEDGER = 1e-10  # of the energy before
UNSOLVED = 1e-3  # fraction of the strikes
PAPER = strike_model(Scene.load('paper'))
BALL = PAPER.surface.mass
CHUNK = 2000
CHANCE = 0.1  # of each special value

NAMES = (
    'law',
    'mass ratio',
    'stiffness ratio',
    'tip friction',
    'table friction',
    'tip e',
    'table e',
    'speed',
    '-n.c',
    'n.z',
    'elevation',
    'end mass',
)
LOGARITHMIC = {
    'mass ratio',
    'stiffness ratio',
    'tip friction',
    'table friction',
    'speed',
    '-n.c',
    'end mass',
}
STATUS, STATES, STEPS, SECONDS, GAP, GAIN = range(len(NAMES), len(NAMES) + 6)


def log_uniform(rng, low, high):
    """Random number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_strike(rng, mild):
    """Parameters in the order of NAMES, the normal and the direction of the stroke."""
    power = rng.uniform(0.0, 0.5 if mild else 12.0)
    cosine = -(10.0**-power)
    elevation = rng.uniform(0.0, 0.5 * np.pi) if rng.random() < 0.7 else 0.0
    c = np.array([np.cos(elevation), 0.0, -np.sin(elevation)])
    across = np.cross(c, rng.normal(size=3))
    across /= np.linalg.norm(across)
    if rng.random() < CHANCE:  # in the vertical plane of the stroke
        across = np.array([np.sin(elevation), 0.0, np.cos(elevation)])
    n = cosine * c + np.sqrt(max(1.0 - cosine * cosine, 0.0)) * across

    def friction():
        if rng.random() < CHANCE:
            return 0.0
        return log_uniform(rng, 0.05, 1.0) if mild else log_uniform(rng, 1e-3, 10.0)

    def restitution():
        if rng.random() < 2.0 * CHANCE:
            return float(rng.integers(2))
        return rng.uniform(0.3, 0.95) if mild else rng.uniform(0.0, 1.0)

    mass = log_uniform(rng, 0.3, 10.0) if mild else log_uniform(rng, 1e-6, 1e6)
    end = np.inf if rng.random() < 0.5 else BALL * log_uniform(rng, 1e-2, 1.0)
    return (
        (
            int(rng.choice((BISTIFFNESS, ENERGETIC))),
            mass,
            log_uniform(rng, 0.1, 10.0) if mild else log_uniform(rng, 1e-8, 1e8),
            friction(),
            friction(),
            restitution(),
            restitution(),
            log_uniform(rng, 1e-9, 1e3),
            -float(n @ c),
            n[2],
            elevation,
            min(end, mass * BALL) if end < np.inf else end,
        ),
        n / np.linalg.norm(n),
        c,
    )


def solved(parameters, n, c):
    """Row of parameters and results."""
    law, mass, ratio, tip, table, tip_e, table_e, speed, _, _, _, end = parameters
    model = PAPER._replace(
        cue_mass=mass * BALL,
        inverse_end_mass=1.0 / end,
        friction=(tip, table),
        restitution=(tip_e, table_e),
        stiffness=(ratio, 1.0),
        law=law,
    )
    collision = collision_of(model, n, speed * c)
    system = system_of(collision.bodies, collision.contacts)
    properties = properties_of(collision.contacts, law, collision.exponent)
    space = contact_space(system)
    begin = perf_counter()
    done = solve_in_contact_space(
        properties, space.delassus[np.newaxis], space.approach[np.newaxis], [TIGHT]
    )
    seconds = perf_counter() - begin
    impulses = np.einsum('ik,ikl->il', done.contacts['impulse'][0], space.axes)
    changes = velocity_changes(system, impulses)
    status, states, steps = (int(done.outcomes[name][0]) for name in ('status', 'phases', 'steps'))
    lost = sum(done.contacts[name].sum() for name in ('restitution_loss', 'friction_loss'))
    before = 0.5 * mass * BALL * speed**2
    # From velocities: tip and table may press the ball with a million times its net impulse, so
    # the energy would be lost in the rounding errors of their works.
    after = collision.energy(system.velocities + changes[:, :3], changes[:, 3:])
    gap = abs(after - before + lost) / before
    return (*parameters, status, states, steps, seconds, gap, after / before - 1.0)


def chunk(seed, count, mild):
    """Rows of random strikes."""
    rng = np.random.default_rng(seed)
    return np.array([solved(*random_strike(rng, mild)) for _ in range(count)])


def run(count, seed, workers, mild):
    """Rows of all strikes; after Ctrl+C, rows of the strikes solved so far."""
    sizes = [min(CHUNK, count - i) for i in range(0, count, CHUNK)]
    seeds = np.random.SeedSequence(seed).spawn(len(sizes))
    with ProcessPoolExecutor(workers, initializer=begin_work) as pool:
        tasks = [pool.submit(chunk, seeds[i], sizes[i], mild) for i in range(len(sizes))]
        try:
            for _ in progress(as_completed(tasks), f'strikes / {CHUNK}', len(tasks)):
                pass
        except KeyboardInterrupt:
            print('ends with what is being done', file=sys.stderr)
            pool.shutdown(cancel_futures=True)
    return np.concatenate([task.result() for task in tasks if not task.cancelled()])


def region(rows, failed, name):
    """Failure rates in the worst ranges of a parameter, as text."""
    values, special = rows[:, NAMES.index(name)], {}
    if name in LOGARITHMIC:
        with np.errstate(divide='ignore'):
            values = np.floor(np.log10(values))
        special = {-np.inf: '0', np.inf: 'inf'}
    else:
        values = np.round(values, 1)
    all_of, bad = Counter(values.tolist()), Counter(values[failed].tolist())
    worst = sorted(bad, key=lambda value: bad[value] / all_of[value], reverse=True)[:4]

    def text(value):
        plain = f'1e{value:g}..' if name in LOGARITHMIC else f'{value:g}'
        return f'{special.get(value, plain)}: {100 * bad[value] / all_of[value]:.2g} %'

    return ', '.join(text(value) for value in worst)


def picture(path, rows):
    """Cost against number of states."""
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4.5), layout='constrained')
    for law, colour in ((BISTIFFNESS, 'tab:blue'), (ENERGETIC, 'tab:orange')):
        some = rows[rows[:, 0] == law][:20_000]
        axes.loglog(
            some[:, STATES] + 1,
            1e6 * some[:, SECONDS],
            '.',
            color=colour,
            markersize=2,
            alpha=0.4,
            label=('bistiffness', 'energetic')[law],
        )
    axes.set_xlabel('states, plus one')
    axes.set_ylabel('time of a strike (µs)')
    axes.set_title('What a strike costs at 1e-12, over very wide ranges', fontsize='medium')
    axes.legend(markerscale=6, frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=120)


def main():
    """Run all strikes; exit code 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=10_000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--workers', type=int, default=os.cpu_count())
    parser.add_argument('--mild', action='store_true')
    parser.add_argument('--failures', metavar='FILE.csv')
    parser.add_argument('--picture', metavar='FILE.png')
    options = parser.parse_args()
    report = Report('Random strikes' + (', mild ranges' if options.mild else ', wide ranges'))
    begin = perf_counter()
    rows = run(options.count, options.seed, options.workers, options.mild)
    wall = perf_counter() - begin
    finite = np.isfinite(rows[:, STATUS:]).all(axis=1)
    failed = np.isin(rows[:, STATUS], (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED))
    done = rows[finite & ~failed]
    report.row('strikes', len(rows), '')
    report.row('exceptions', 0, '', 0.5)  # an exception would have ended this program
    report.row('not finite', (~finite).sum(), '', 0.5)
    report.row('not solved', 100 * failed.mean(), '%', 100 * UNSOLVED)
    report.row('largest gap in the ledger of a solved one', done[:, GAP].max(), '', LEDGER)
    report.row('solved ones with a larger gap than that', (done[:, GAP] > LEDGER).sum(), '', 0.5)
    report.row('largest gain of energy', done[:, GAIN].max(), '', LEDGER)
    for status, count in Counter(rows[:, STATUS].astype(int).tolist()).items():
        report.row(f'    {Status(status).name}', count, '')
    report.row('wall time', wall, 's')
    report.row('median strike', 1e6 * np.median(rows[:, SECONDS]), 'us')
    report.row('slowest strike', 1e3 * rows[:, SECONDS].max(), 'ms')
    slowest = rows[rows[:, SECONDS].argmax()]
    print('    ' + ', '.join(f'{name} {value:.3g}' for name, value in
                             zip(NAMES, slowest[:len(NAMES)], strict=True)))  # fmt: skip
    odd = ~finite | failed | (rows[:, GAP] > LEDGER)
    if odd.any():
        print('  where they fail (share of the strikes in each worst part of a range):')
        for name in NAMES:
            print(f'    {name:<16} {region(rows, odd, name)}')
    if options.failures:
        with open(options.failures, 'w', newline='') as file:
            writer = csv.writer(file)
            writer.writerow([*NAMES, 'status', 'states', 'steps', 'seconds', 'gap', 'gain'])
            writer.writerows(rows[odd].tolist())
    if options.picture:
        picture(options.picture, rows)
    report.end()


if __name__ == '__main__':
    main()
