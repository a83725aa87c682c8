"""
Whole tables: their cost, against pooltool 0.6.0 in the same run, and whether both agree.

    python benchmarks/table.py [--pooltool PYTHON]

PYTHON: interpreter of an environment that has pooltool; by default the variable POOLTOOL_PYTHON.
Without one, the program reports that the comparison is skipped.
"""

import argparse
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile

import numpy as np
from tools.pooltool_table import scene, states
from tools.timing import Report, seconds, yardstick

from billiard_shot import BallState, simulate, simulate_batch
from billiard_shot.scene.equipment import BallBall

RATIOS = {'one ball': 600.0, 'cut shot': 290.0, '9-ball break': 85.0, '8-ball break': 80.0}
SPREAD = 4.0  # p95 of the cost of racks over the median
OVERHEAD, CROSS = 150.0, 15.0  # us on a machine where np.cross takes CROSS
FAR = 1e-3  # m: shots that end farther apart are listed
DURATION = BallBall().duration  # s, of contacts between balls

FIRST_BREAK = """
from time import perf_counter
begin = perf_counter()
from billiard_shot import BallState, Scene, simulate
scene = Scene.load('nine_ball')
states = {name: BallState((x, y, scene.ball.radius)) for name, (x, y) in scene.balls.items()}
x, y = scene.balls['cue']
states['cue'] = BallState((x, y, scene.ball.radius), (8, -0.8, 0))
simulate(scene, states)
print(perf_counter() - begin)
"""


def per_shot(where, given, count=None):
    """Time of a run in a batch of many on one core [s]."""
    count = count or (4000 if len(given) < 3 else 200)
    many = {
        name: BallState(np.tile(s.position, (count, 1)), s.velocity, s.spin)
        for name, s in given.items()
    }
    return seconds(lambda: simulate_batch(where, many, workers=1)) / count


def first_break():
    """Time of the first break in a new process with an empty cache [s]."""
    root = str(Path(__file__).parent.parent)
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {'BILLIARD_SHOT_CACHE': folder, 'PYTHONPATH': root}
        done = subprocess.run(
            [sys.executable, '-c', FIRST_BREAK],
            text=True,
            capture_output=True,
            check=True,
            env=environment,
        )
    return float(done.stdout)


def ask_pooltool(python):
    """Run pooltool; return its simulated shots and their times."""
    worker = Path(__file__).parent / 'tools' / 'pooltool_worker.py'
    environment = {k: v for k, v in os.environ.items() if k != 'PYTHONPATH'}
    done = subprocess.run(
        [python, str(worker), '15', '100'],
        text=True,
        capture_output=True,
        check=True,
        env=environment | {'PYTHONHASHSEED': '0'},
    )
    return json.loads(done.stdout)


def compare_speed(report, answer):
    """Compare times of the layouts: with the same cushion model in both, and with defaults."""
    for name, layout in answer['layouts'].items():
        given = states(layout['begin'])
        ours = per_shot(scene('han'), given)
        report.row(f' {name}: microseconds', ours, 'us')
        report.row(
            f'{name}: pooltool over ours, cushions after Han',
            layout['seconds'] / float(ours),
            'times',
            -RATIOS[name],
        )
        default = per_shot(scene('mathavan', duration=DURATION), given)
        report.row(f' {name}: microseconds, by default', default, 'us')
        report.row(
            f'{name}: with defaults of each',
            layout['seconds_default'] / float(default),
            'times',
        )


def compare_ends(report, answer):
    """Compare the final positions of random shots with up to three impacts."""
    where = scene('han')
    gaps = []
    for number, shot in enumerate(answer['shots']):
        run = simulate(where, states(shot['begin']))
        ends = {name: s.position for name, s in states(shot['end']).items()}
        fallen = set(shot['pocketed'])
        gap = max(
            (
                float(np.hypot(*(run.final_position[name] - ends[name])[:2]))
                for name in ends
                if name not in fallen
            ),
            default=0.0,
        )
        if set(run.pocketed) != fallen:
            gap = np.inf
        gaps.append(gap)
        if gap > FAR:
            print(
                f'    shot {number}: {1e3 * gap:.3g} mm apart; {shot["events"]}, '
                f'here {[str(e.kind) for e in run.events]}'
            )
    report.row(' random shots: median distance of the ends', 1e3 * float(np.median(gaps)), 'mm')
    near = sum(gap <= FAR for gap in gaps)
    report.row('random shots that end within 1 mm', near, f'of {len(gaps)}', -len(gaps))


def spread(report, racks):
    """Cost of racks that differ by their random gaps."""
    for name, given in racks.items():
        where = scene('mathavan', duration=DURATION)
        costs = [per_shot(where, states(rack), 20).cpu for rack in given]
        report.row(
            f' {name}: 95 % of {len(costs)} racks within, in medians',
            float(np.percentile(costs, 95) / np.median(costs)),
            '',
            SPREAD,
        )


def main():
    """Run everything."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--pooltool', default=os.environ.get('POOLTOOL_PYTHON'))
    python = parser.parse_args().pooltool
    report = Report('Tables')
    cross = yardstick()
    report.row(' yardstick: np.cross', cross, 'us')
    where = scene('mathavan')
    cue = {'cue': BallState((0.0, 0.0, where.ball.radius), (1.0, 0.3, 0.0), (0.0, 0.0, 20.0))}
    beyond = seconds(simulate, where, cue) - per_shot(where, cue)
    added = beyond / cross
    report.row(' simulate() adds to the table itself', added, 'cross products', OVERHEAD / CROSS)
    report.row(' first break in a new process, empty cache', first_break(), 's')
    if python is None:
        report.note('The comparison with pooltool was not measured: give --pooltool PYTHON')
        report.end()
    answer = ask_pooltool(python)
    compare_speed(report, answer)
    spread(report, answer['racks'])
    compare_ends(report, answer)
    report.end()


if __name__ == '__main__':
    main()
