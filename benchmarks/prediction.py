"""
Cost of a prediction beyond the strike: Python call, batches, first prediction, import.

    python benchmarks/prediction.py
"""

import os
from pathlib import Path
import subprocess
import sys

import numpy as np
from tools.timing import once, QUICK, Report, seconds, Time, yardstick

from billiard_shot import predict, predict_batch, Scene, Stroke
from billiard_shot.impact.kernel import solve_in_contact_space
from billiard_shot.table.strike.placement import strike_tolerance
from studies.problem import ContactProblem

OVERHEAD = 100.0  # us on a machine where np.cross takes CROSS
CROSS = 15.0  # us; the limit scales with the time of np.cross here
BATCH = 3.0  # times the kernel alone
# Of the time in which a new process imports NumPy: first predictions, with the import; the import
# alone. The time to check and load the library [ms], and that of a plan, with its process [s].
FIRST_LIMITS = {'paper': 12.0, 'pool_table': 12.0, 'eight_ball': 25.0}
IMPORT = 0.5
LOADED = 15.0
FIRST_PLAN = 3.0

FIRST = """
from time import perf_counter
begin = perf_counter()
import sys
from billiard_shot import predict, Scene, Stroke
stroke = Stroke.from_offsets(a=0, b=0.1, elevation=0.08, azimuth=0, speed=8.0)
predict(Scene.load(sys.argv[1]), stroke)
print(perf_counter() - begin)
"""
LOAD = """
from time import perf_counter
from billiard_shot import machine_code
begin = perf_counter()
assert machine_code.is_loaded()
print(perf_counter() - begin)
"""
PLAN = """
from billiard_shot.cli import main
main(['plan', 'blocked', '--pot', '8'])
"""
NUMPY = """
from time import perf_counter, process_time
begin, busy = perf_counter(), process_time()
import numpy
print(perf_counter() - begin)
print(process_time() - busy)
"""
BARE = """
from time import perf_counter
begin = perf_counter()
import billiard_shot
print(perf_counter() - begin)
import sys
print([name for name in ('scipy', 'matplotlib', 'numba') if name in sys.modules])
"""


def fresh(program, *arguments):
    """Output lines of a program in a process of its own."""
    root = str(Path(__file__).parent.parent)
    path = os.pathsep.join([root, os.environ.get('PYTHONPATH', '')])
    done = subprocess.run(
        [sys.executable, '-c', program, *arguments], text=True, capture_output=True, check=True,
        env={**os.environ, 'PYTHONPATH': path},
    )  # fmt: skip
    return done.stdout.splitlines()


def ordinary(count, seed=3):
    """Normals and velocities of ordinary strokes."""
    rng = np.random.default_rng(seed)
    n, v = np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        stroke = Stroke.from_offsets(
            a=rng.uniform(-0.4, 0.4), b=rng.uniform(-0.4, 0.4), elevation=rng.uniform(0.02, 0.6),
            azimuth=rng.uniform(-3.0, 3.0), speed=rng.uniform(0.5, 6.0),
        )  # fmt: skip
        n[i], v[i] = stroke.normal, stroke.velocity
    return n, v


def strike_time(scene, normals, velocities, tolerance):
    """Time per strike of the kernel alone, at the accuracy that the shots' tolerance needs."""
    work = []
    for normal, velocity in zip(normals, velocities, strict=True):
        strike = ContactProblem.of(scene, Stroke(normal, velocity))
        accuracy = strike_tolerance(strike.model.surface, strike.stroke.speed, tolerance)
        work.append((strike.response, strike.velocity, accuracy))
    arrays = [np.array(column) for column in zip(*work, strict=True)]
    return seconds(solve_in_contact_space, strike.properties, *arrays, repeats=5) / len(work)


def main():
    """Measure everything."""
    report = Report('One prediction')
    cross = yardstick()
    report.row(' yardstick: np.cross of two vectors', cross, 'us')

    normals, velocities = ordinary(400 if QUICK else 2000)
    for name in ('paper', 'pool'):
        scene = Scene.load(name)
        some = slice(0, 200)
        kernel = strike_time(scene, normals[some], velocities[some], 1e-4)
        strokes = [
            Stroke(normal=n, velocity=v)
            for n, v in zip(normals[some], velocities[some], strict=True)
        ]

        def each(scene=scene, strokes=strokes):
            for stroke in strokes:
                predict(scene, stroke)

        call = seconds(each, repeats=5) / len(strokes)
        report.row(f'scene {name}: the strike alone', kernel, 'us')
        beyond = (call - kernel) / cross
        report.row('    predict() adds', beyond, 'cross products', OVERHEAD / CROSS)
        batch = seconds(predict_batch, scene, normals, velocities, repeats=5) / len(normals)
        kernel = strike_time(scene, normals, velocities, 1e-4)
        report.row('    predict_batch, per stroke, on all cores', batch, 'us')
        report.row(
            '    predict_batch on all cores, over the strike alone', batch / kernel, 'x', BATCH
        )

    wall, cpu = min(tuple(map(float, fresh(NUMPY))) for _ in range(5))
    bare = Time(wall, cpu)
    report.row(' yardstick: import of NumPy in a new process', bare, 's')
    for name, limit in FIRST_LIMITS.items():
        first = min(float(fresh(FIRST, name)[0]) for _ in range(3))
        report.row(f'scene {name}: first prediction', first, 's')
        report.row('    over the import of NumPy', first / float(bare), 'x', limit)
    loading = 1e3 * min(float(fresh(LOAD)[0]) for _ in range(5))
    report.row('library checked and loaded', loading, 'ms', LOADED)
    took = min(float(once(fresh, PLAN)) for _ in range(3))
    report.row('billiard-shot plan blocked --pot 8, in a new process', took, 's', FIRST_PLAN)
    alone = [fresh(BARE) for _ in range(5)]
    took = min(float(lines[0]) for lines in alone)
    report.row(' import billiard_shot', took, 's')
    report.row('    over the import of NumPy', took / float(bare), 'x', IMPORT)
    loaded = float(alone[0][1] != '[]')
    report.row('    SciPy, matplotlib or numba imported with it', loaded, '', 0.5)
    report.end()


if __name__ == '__main__':
    main()
