"""
Strokes at a cue ball within 2 mm of cushions and balls, in all scenes: what the dearest one costs.

    python benchmarks/near_strokes.py [--count 100000] [--workers 1]

The cost of a stroke is the CPU time of `predict`, in medians of its scene. Strokes that seem to be
far above the median are timed three times more, and the least time counts. The status may say that
a stroke is dear: BUDGET_EXCEEDED. Strokes that are refused do not count.
"""

import argparse
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from time import process_time

import numpy as np
from tools.timing import QUICK, Report

from billiard_shot import predict, Scene, Status
from billiard_shot.cli.workers import begin_work
from billiard_shot.scene.files import scene_names
from studies.near_strokes import near_scene, near_stroke

LIMIT, LIMIT_OF_RACK = 50.0, 150.0  # medians
RACK = 9  # so many balls are a rack
DEAR, REPEATS = 20.0, 3  # medians from which on strokes are timed again, and how often


def timed(scene, stroke):
    """Shot, and CPU time of its prediction [s]."""
    begin = process_time()
    shot = predict(scene, stroke)
    return shot, process_time() - begin


def play(name, own, count, seed):
    """Times of random strokes [s], the strokes, statuses, and whether each says it is dear."""
    scene, draw = Scene.load(name), np.random.default_rng(seed)
    strokes, times, statuses, says = [], [], Counter(), []
    while len(strokes) < count:
        where = near_scene(scene, draw, own=own)
        stroke = near_stroke(where, draw)
        shot, time = timed(where, stroke)
        if shot.status.refused:
            continue
        strokes.append((where, stroke))
        times.append(time)
        statuses[shot.status.name] += 1
        says.append(Status.BUDGET_EXCEEDED in (shot.status, shot.run.status))
    return np.array(times), strokes, statuses, np.array(says)


def examine(name, own, count, seed):
    """Median time [s], dearest stroke in medians and in words, and statuses of random strokes."""
    times, strokes, statuses, says = play(name, own, count, seed)
    median = np.median(times)
    for number in np.flatnonzero(times > DEAR * median):
        again = [timed(*strokes[number])[1] for _ in range(REPEATS)]
        times[number] = min(times[number], *again)
    costs = np.where(says, 0.0, times / median)
    where, stroke = strokes[costs.argmax()]
    return median, costs.max(), f'{dict(where.balls)}, {stroke.offsets}', statuses


def main():
    """Play all strokes; exit code 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=1_000 if QUICK else 10_000)
    parser.add_argument('--workers', type=int, default=1)
    options = parser.parse_args()
    report = Report('Strokes near cushions and balls')
    balls = {name: len(Scene.load(name).balls) for name in scene_names()}
    kinds = [(name, False) for name in balls]
    kinds += [(name, True) for name in balls if balls[name] > 1]
    count = -(-options.count // len(kinds))
    statuses = Counter()
    with ProcessPoolExecutor(options.workers, initializer=begin_work) as pool:
        tasks = [pool.submit(examine, *kind, count, seed) for seed, kind in enumerate(kinds)]
        for (name, own), task in zip(kinds, tasks, strict=True):
            median, dearest, which, found = task.result()
            statuses += found
            limit = LIMIT_OF_RACK if own and balls[name] >= RACK else LIMIT
            layout = f'{name}, its own balls' if own else name
            report.row(f' {layout}: median', 1e3 * median, 'ms')
            report.row(f'{layout}: the dearest one', dearest, 'medians', limit)
            if dearest > limit:
                report.note(which)
    report.row('strokes', sum(statuses.values()), '')
    for status, number in statuses.most_common():
        report.row(f'    {status}', number, '')
    report.end()


if __name__ == '__main__':
    main()
