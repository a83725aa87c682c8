"""
Plans: their success, the accuracy of the predicted success, and their speed.

Seeded scenes:
- pots in bins of cut angle and distance, at half, normal and twice the noise of the computer pool
  tournaments, measured by fresh strokes and compared with a player who aims at the ghost ball and
  hits the middle;
- balls that only a curve, massé or jump reaches, compared with brute force;
- cues that are raised beside other balls, where the intervals of plans must hold;
- pots that leave the cue ball at a place;
- the same pots from several seeds;
- tables of 15 balls, with one ball to be potted, two, or any; and the time of a cancellation.

    python benchmarks/plan.py [--full]

`--full`: 200 pots at each noise, 50 blocked balls against a million strokes each, 100 places; that
takes hours. Otherwise a small sample of each.
"""

import argparse
from collections import defaultdict
import os
from time import perf_counter

import numpy as np
from tools.plan_scenes import (
    baseline,
    blocked_scene,
    brute_force,
    crowded_scene,
    CUTS,
    LENGTHS,
    measured,
    noisy,
    position_scene,
    pot_scene,
    raised_scene,
    TOURNAMENT,
)
from tools.timing import QUICK, Report, Time

from billiard_shot import plan

BINS = len(CUTS) - 1, len(LENGTHS) - 1
SEEDS = 5
LATE = 0.2  # of a plan: from a cancellation to the result
HELD_OUT_TRIALS = 1000  # strokes with fresh errors by which a plan is measured


class Clock:
    """Times, simulations and use of cores of plans."""

    def __init__(self):
        self.seconds, self.simulations, self.cores = [], [], []

    def time(self, percent):
        """Time within which so many of the plans end; ratios of such times are of CPU times."""
        wall, cpu = self.seconds, np.multiply(self.cores, self.seconds)
        return Time(*(float(np.percentile(each, percent)) for each in (wall, cpu)))

    def plan(self, *arguments, **options):
        """Plan, and take the time."""
        begin, busy = perf_counter(), os.times()
        result = plan(*arguments, **options)
        took, now = perf_counter() - begin, os.times()
        self.seconds.append(took)
        self.simulations.append(result.simulations)
        self.cores.append((now.user + now.system - busy.user - busy.system) / took)
        return result


def pots(report, clock, count, factor, seed):
    """Compare predicted success with measured success, and measured success with the baseline."""
    noise = TOURNAMENT.times(factor)
    draw = np.random.default_rng(seed)
    said, found, base, bins = [], [], [], defaultdict(list)
    for i in range(count):
        place = i % BINS[0], i // BINS[0] % BINS[1]
        scene, target = pot_scene(draw, *place)
        result = clock.plan(scene, target, noise=noise, seed=i)
        said.append(result.best.success if result.best else 0.0)
        found.append(0.0)
        if result.best:
            strokes = noisy(result.best.stroke.offsets, noise, HELD_OUT_TRIALS, 10_000 + i)
            found[-1] = measured(scene, target, strokes)[0].mean()
        stroke = baseline(scene, target, noise, result.simulations, 20_000 + i)
        strokes = noisy(stroke, noise, HELD_OUT_TRIALS, 30_000 + i)
        base.append(measured(scene, target, strokes)[0].mean())
        bins[place].append((found[-1], base[-1]))
    said, found, base = np.array(said), np.array(found), np.array(base)
    name = f'{count} pots, {factor:g} times the noise: '
    error = 100.0 * (said - found)
    off = f'{name}stated minus measured success'
    report.row(f'{off}, mean size', np.abs(error).mean(), 'points', 3.0)
    # two standard errors: that of either success is at most 2 points
    report.row(f'{off}, mean', abs(error.mean()), 'points', 4.8 / count**0.5)
    report.row(f'{name}measured success', 100.0 * found.mean(), '%')
    report.row(f'{name}of the baseline', 100.0 * base.mean(), '%')
    gains = {place: 100.0 * np.subtract(*np.mean(each, axis=0)) for place, each in bins.items()}
    # two standard errors of the success in HELD_OUT_TRIALS strokes, at least 0.1 points
    unsure = {
        place: 0.1
        + 200.0
        * np.sqrt(np.sum(np.multiply(each, np.subtract(1.0, each))) / HELD_OUT_TRIALS)
        / len(each)
        for place, each in bins.items()
    }
    middle = [gain for place, gain in gains.items() if 0.2 < np.mean(bins[place], axis=0)[1] < 0.8]
    report.row(f' {name}gain in the worst class', min(gains.values()), 'points')
    report.row(
        f' {name}gain in the worst class, plus two standard errors',
        min(gains[place] + unsure[place] for place in bins),
        'points',
        -1e-9,
    )
    even = f'{name}gain where the baseline has 20 to 80 %'
    report.row(even, np.mean(middle), 'points', -10.0)
    print('    points over the baseline, cut down, distance across:')
    for cut in range(BINS[0]):
        row = (f'{gains.get((cut, length), np.nan):+7.1f}' for length in range(BINS[1]))
        print(f'    {CUTS[cut]:3d} to {CUTS[cut + 1]:2d} degrees', *row)


def blocked(report, timed, count, strokes):
    """Measure plans if only a curve or jump reaches the ball; compare some with brute force."""
    draw, clock = np.random.default_rng(3), Clock()
    said, found, ratios = [], [], []
    for i in range(timed):
        scene, target = blocked_scene(draw)
        planned = clock.plan(scene, target, noise=TOURNAMENT, seed=i).best
        said.append(planned.success if planned else 0.0)
        found.append(0.0)
        if planned:  # the same errors in every version
            played = noisy(planned.stroke.offsets, TOURNAMENT, HELD_OUT_TRIALS, 10_000 + i)
            found[-1] = measured(scene, target, played)[0].mean()
        best = brute_force(scene, target, TOURNAMENT, strokes, i) if i < count else 0.0
        if best:
            ratios.append(found[-1] / best)
    name = f'{count} blocked balls, best of {strokes:,} random strokes: '
    report.row(f' {name}it finds a way in', len(ratios), '')
    good = 100.0 * np.mean(np.array(ratios) >= 0.9)
    report.row(f'{name}plans with 0.9 of its success', good, '%', -90.0)
    report.row(f' {name}success over its, median', float(np.median(ratios)), '')
    name = f'{timed} blocked balls: '
    report.row(f'{name}measured success', 100.0 * np.mean(found), '%')
    error = 100.0 * np.abs(np.subtract(said, found)).mean()
    report.row(f'{name}stated minus measured success, mean size', error, 'points', 2.0)
    report.row(f'{name}time to a plan, median', clock.time(50), 's', 2.0)
    report.row(f'{name}time to a plan, 95 %', clock.time(95), 's', 3.0)


def raised(report, count):
    """Check stated intervals where a raised cue may hit twice, beside blockers."""
    draw, held = np.random.default_rng(13), 0
    for i in range(count):
        scene, target, limits = raised_scene(draw)
        best = plan(scene, target, budget=1200, seed=i, constraints=limits).best
        played = noisy(best.stroke.offsets, TOURNAMENT, HELD_OUT_TRIALS, 10_000 + i)
        share = measured(scene, target, played)[0].mean()
        # two standard errors of the share
        sure = 2.0 * max(share * (1.0 - share), 1e-3) ** 0.5 / HELD_OUT_TRIALS**0.5
        low, high = best.interval
        held += low - sure <= share <= high + sure
    report.row(f'{count} raised cues beside blockers: intervals that hold', held, '', -0.9 * count)


def positions(report, clock, count):
    """Measure the distance of the cue ball from its wanted place."""
    draw = np.random.default_rng(11)
    distances = []
    for i in range(count):
        scene, target, place = position_scene(draw)
        result = clock.plan(
            scene, {**target, 'leave': place, 'radius': 0.1}, noise=TOURNAMENT, seed=i
        )
        if result.best is None:
            distances.append(np.inf)
            continue
        good, rest = measured(
            scene,
            target,
            noisy(result.best.stroke.offsets, TOURNAMENT, HELD_OUT_TRIALS, 10_000 + i),
        )
        distances.append(np.median(np.hypot(*(rest[good] - place).T)))
    report.row(
        f'{count} pots with a place for the cue ball: distance, median of medians',
        1e3 * float(np.median(distances)),
        'mm',
        100.0,
    )


def seeds(report, clock, count):
    """Measure how much the success of a plan depends on its random numbers."""
    draw = np.random.default_rng(5)
    ranges = []
    for i in range(count):
        scene, target = pot_scene(draw, i % BINS[0], i % BINS[1])
        found = []
        for seed in range(SEEDS):
            best = clock.plan(scene, target, noise=TOURNAMENT, seed=seed).best
            strokes = noisy(best.stroke.offsets, TOURNAMENT, 2000, 40_000 + i) if best else []
            found.append(100.0 * measured(scene, target, strokes)[0].mean() if best else 0.0)
        ranges.append(np.ptp(found))
    name = f'{count} pots from {SEEDS} seeds: range of success, '
    report.row(f' {name}median', float(np.median(ranges)), 'points', 6.0)
    report.row(f'{name}largest', max(ranges), 'points', 15.0)


def crowded(report, count):
    """Measure the time for any of 15 balls, the loss for two balls, and a cancellation."""
    draw = np.random.default_rng(17)
    clock, losses, late = Clock(), [], []
    time_of_cancel(crowded_scene(draw), 1.0)  # loads the library
    for i in range(count):
        scene = crowded_scene(draw)
        clock.plan(scene, {'pot': 'any'}, noise=TOURNAMENT, seed=i)
        two = draw.choice(range(1, 15), 2, replace=False).astype(str).tolist()
        alone = [plan(scene, {'pot': each}, noise=TOURNAMENT, seed=i).best for each in two]
        both = plan(scene, {'pot': two}, noise=TOURNAMENT, seed=i).best
        losses.append(
            100.0 * max((each.interval[0] for each in alone if each), default=0.0)
            - 100.0 * (both.interval[1] if both else 0.0)
        )
        late.append(time_of_cancel(scene, draw.uniform(0.05, 1.0)))
    name = f'{count} tables of 15 balls: '
    median = clock.time(50)
    report.row(f'{name}time of any pot, median', median, 's')
    report.row(f'{name}the same, 95 %', clock.time(95) / median, 'medians', 3.0)
    report.row(
        f' {name}two balls worse than one, beyond the intervals: largest',
        max(losses),
        'points',
    )
    report.row(f' {name}the same: tables', sum(each > 0.0 for each in losses), '')
    report.row(f' {name}from a cancellation to the result, median', float(np.median(late)), 'ms')
    report.row(f' {name}the same, longest', max(late), 'ms')
    report.row(
        f'{name}from a cancellation to the result, longest',
        1e-3 * max(late) / float(median),
        'medians',
        LATE,
    )


def time_of_cancel(scene, after):
    """Time [ms] in which a plan ends if it is cancelled `after` a time [s]."""
    begin = perf_counter()
    plan(
        scene,
        {'pot': '8', 'leave': (0.0, 0.0), 'radius': 0.01},
        budget=10**7,
        cancel=lambda: perf_counter() - begin > after,
    )
    return 1e3 * (perf_counter() - begin - after)


def main():
    """Run everything."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--full', action='store_true')
    full = parser.parse_args().full
    report, clock, others = Report('Plans'), Clock(), Clock()
    pots(report, clock, 200 if full else 15 if QUICK else 30, 1.0, 7)
    for factor in () if QUICK else (0.5, 2.0):
        pots(report, others, 200 if full else 15, factor, 8)
    timed, compared = (50, 50) if full else (3, 1) if QUICK else (20, 3)
    blocked(report, timed, compared, 1_000_000 if full else 60_000)
    raised(report, 3 if QUICK else 30)
    positions(report, clock, 100 if full else 2 if QUICK else 5)
    seeds(report, Clock(), 45 if full else 2 if QUICK else 6)
    crowded(report, 50 if full else 3 if QUICK else 8)
    median = clock.time(50)
    report.row('time to a plan, median', median, 's')
    report.row('the same, 95 %', clock.time(95) / median, 'medians', 3.0)
    rate = np.sum(clock.simulations) / np.sum(clock.seconds)
    report.row(' strokes simulated a second', rate, '1/s')
    cores = np.average(clock.cores, weights=clock.seconds)
    report.row('cores used', cores, '', -0.85 * (os.cpu_count() or 1))
    report.end()


if __name__ == '__main__':
    main()
