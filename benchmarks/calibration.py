"""
Calibrations of simulated recordings: how many converge, and whether their intervals hold.

    python benchmarks/calibration.py [--shots 8] [--minutes 60] [--state FILE.jsonl] [--workers 1]

Tables are drawn from ranges of published values, and calibrated from scene `carom`, without shots
held out. Results are appended to the state, and the same command goes on from there: `--minutes 0`
only states what is known. For each number: how many tables decide it, the share of the 95 %
intervals that hold the truth, the median error, and whether the truth has uniform ranks among the
values that other shots would have given (simulation-based calibration, Talts et al.,
arXiv:1804.06788; here by the test of Kolmogorov and Smirnov, at the 1 % level).
"""

import argparse
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
import json
from pathlib import Path
import sys
from time import perf_counter, process_time

import numpy as np
from scipy.stats import kstest
from scipy.stats import t as student
from tools.timing import Report

from billiard_shot import calibrate, Scene
from billiard_shot.calibration.fit import LEVEL
from billiard_shot.calibration.recording import Frame

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test' / 'calibration'))
from simulated import simulated_recording

RANGES = {
    'cloth.sliding_friction': (0.15, 0.25),
    'cloth.rolling_resistance': (0.0035, 0.008),
    'cloth.rolling_rise': (0.0, 0.002),
    'cloth.spin_deceleration': (4.0, 11.0),
    'contacts.ball_ball.restitution': (0.92, 0.98),
    'contacts.ball_ball.friction_fast': (0.005, 0.06),
    'contacts.ball_ball.friction_slow': (0.04, 0.14),
    'table.cushion.restitution': (0.84, 0.94),
    'table.cushion.friction': (0.18, 0.28),
    'table.cushion.early_fading': (0.0, 0.05),
    'table.cushion.fading': (0.0, 0.1),
    'table.cushion.frequency_ratio': (0.5, 0.8),
    'table.length': (2.835, 2.845),
    'table.width': (1.415, 1.425),
}
FRAME = Frame(0.002, -0.001, 0.001)
HORIZON, SIGMA, RATE = 3.0, 1e-3, 50.0  # s, m, 1/s
LEAST_COVERED, MOST_COVERED, LEVEL_OF_RANKS = 0.90, 0.99, 0.01


def calibrated(table, shots):
    """Draw a table and record it, and fit a scene to its shots; return truth and estimates."""
    draw = np.random.default_rng((1, table))
    truth = {name: float(draw.uniform(*bounds)) for name, bounds in RANGES.items()}
    scene = replace(Scene.load('carom'), balls={})
    there = scene.with_parameters(list(truth), list(truth.values()))
    seen = simulated_recording(there, shots, 1000 + table, SIGMA, RATE, FRAME)
    begin = process_time()
    found = calibrate(
        replace(seen, frame=Frame()), scene, names=list(truth), horizon=HORIZON, held_out=0.0
    )
    truth |= {f'frame.{name}': getattr(FRAME, name) for name in ('x', 'y', 'angle')}
    numbers = [
        (each.name, truth[each.name], each.value, each.interval) for each in found.estimates
    ]
    return {
        'table': table,
        'shots': len(found.fitted),
        'converged': found.converged,
        'cpu': process_time() - begin,
        'numbers': numbers,
    }


def rank(truth, value, interval, shots):
    """Return which part of the values that other shots give are below the truth."""
    reach = max(value - interval[0], interval[1] - value)  # a bound may be that of the number
    deviation = reach / student.ppf(0.5 + 0.5 * LEVEL, shots - 1)
    return float(student.cdf((truth - value) / deviation, shots - 1))


def state(results):
    """State the results of tables."""
    report = Report('calibrations of simulated recordings')
    converged = [each for each in results if each['converged']]
    report.row('tables', len(results), '')
    report.row('tables that converged', len(converged), '')
    report.row('median CPU time of a table', np.median([each['cpu'] for each in results]), 's')
    numbers = defaultdict(list)
    for each in converged:
        for name, *known in each['numbers']:
            numbers[name].append((*known, each['shots']))
    inside = []
    for name, rows in numbers.items():
        known = [row for row in rows if row[2] is not None]
        report.row(f'{name}: tables that decide it', len(known), '')
        if not known:
            continue
        held = [low <= truth <= high for truth, _, (low, high), _ in known]
        inside += held
        report.row(f' {name}: intervals that hold', np.mean(held), '')
        errors = [abs(value - truth) for truth, value, *_ in known]
        scale = 1.0 if name.startswith('frame') else np.mean([row[0] for row in known])
        unit = 'm or rad' if name.startswith('frame') else 'relative'
        report.row(f' {name}: median error', np.median(errors) / scale, unit)
        level = kstest([rank(*row) for row in known], 'uniform').pvalue
        report.row(f'{name}: level of the ranks', level, '', -LEVEL_OF_RANKS)
    if inside:
        report.row('intervals that hold', np.mean(inside), '', -LEAST_COVERED)
        report.row('intervals that hold, not too wide', np.mean(inside), '', MOST_COVERED)
    report.end()


def main():
    """Calibrate tables until the time is over."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--shots', type=int, default=8)
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--state', type=Path, default=Path('calibration.jsonl'))
    parser.add_argument('--workers', type=int, default=1)
    options = parser.parse_args()
    begin, results = perf_counter(), []
    if options.state.exists():
        results = [json.loads(line) for line in options.state.read_text().splitlines()]
    with ProcessPoolExecutor(options.workers) as executor, options.state.open('a') as file:
        while perf_counter() - begin < 60.0 * options.minutes:
            tables = range(len(results), len(results) + options.workers)
            for found in executor.map(calibrated, tables, [options.shots] * len(tables)):
                results.append(found)
                file.write(json.dumps(found) + '\n')
                file.flush()
    state(results)


if __name__ == '__main__':
    main()
