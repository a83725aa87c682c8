"""
What a prediction costs beyond the strike: the Python call, batches, the first one, the import.

    python benchmarks/prediction.py
"""
import os
from pathlib import Path
import subprocess
import sys
import tempfile

import numpy as np
from tools.timing import Report, seconds, yardstick

from billiard_shot import predict, predict_batch, Scene, Stroke
from billiard_shot.impact.kernel import solve
from billiard_shot.shot.accuracy import inner_tolerance
from billiard_shot.shot.contacts import levers, response_of
from billiard_shot.shot.model import numbers_of

OVERHEAD = 100.0  # us on a machine where np.cross takes CROSS
CROSS = 15.0  # us; the limit scales with what it takes here
BATCH = 3.0  # times the kernel alone
COLD, WARM, IMPORT = 12.0, 1.0, 0.3  # s

FIRST = """
from time import perf_counter
begin = perf_counter()
from billiard_shot import predict, Scene, Stroke
predict(Scene.load('paper'), Stroke(normal=(-2, -1, 12), velocity=(4, 0, -16)))
print(perf_counter() - begin)
"""
BARE = """
from time import perf_counter
begin = perf_counter()
import billiard_shot
print(perf_counter() - begin)
import sys
print([name for name in ('scipy', 'matplotlib', 'numba') if name in sys.modules])
"""


def fresh(program, **environment):
    """Output lines of a program in a process of its own."""
    root = str(Path(__file__).parent.parent)
    path = os.pathsep.join([root, os.environ.get('PYTHONPATH', '')])
    done = subprocess.run(
        [sys.executable, '-c', program], text=True, capture_output=True, check=True,
        env={**os.environ, 'PYTHONPATH': path, **environment},
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
    """Time per strike of the kernel alone, at the accuracy that the shots' tolerance asks for."""
    model = numbers_of(scene)
    work = []
    for normal, velocity in zip(normals, velocities, strict=True):
        n, speed = normal / np.linalg.norm(normal), np.linalg.norm(velocity)
        c = velocity / speed
        lever = levers(model.surface.radius, n, c)
        approach = np.zeros(6)
        approach[0], approach[1] = speed * (n @ c), speed * (lever[0, 1] @ c)
        accuracy = inner_tolerance(model, speed, tolerance)
        work.append((response_of(model, c, lever), approach, accuracy))
    impulse, account, log = np.zeros(6), np.zeros((2, 4)), np.zeros((0, 12))

    def run():
        for response, approach, accuracy in work:
            solve(
                response, approach, model.friction, model.restitution, model.stiffness, model.law,
                model.exponent, accuracy, impulse, account, log,
            )  # fmt: skip

    return seconds(run, repeats=5) / len(work)


def main():
    """Measure everything."""
    report = Report('One prediction')
    cross = yardstick()
    report.row('yardstick: np.cross of two vectors', 1e6 * cross, 'us')

    normals, velocities = ordinary(2000)
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
        report.row(f'{name}: kernel alone', 1e6 * kernel, 'us')
        beyond = (call - kernel) / cross
        report.row('    predict() beyond it', beyond, 'np.cross', OVERHEAD / CROSS)
        cores = os.cpu_count() or 1
        batch = seconds(predict_batch, scene, normals, velocities, repeats=5) / len(normals)
        kernel = strike_time(scene, normals, velocities, 1e-4)
        report.row('    predict_batch, per stroke and core', 1e6 * batch * cores, 'us')
        report.row('    the same over the kernel alone', batch * cores / kernel, 'x', BATCH)

    with tempfile.TemporaryDirectory() as cache:
        cold = float(fresh(FIRST, NUMBA_CACHE_DIR=cache)[0])
        warm = min(float(fresh(FIRST, NUMBA_CACHE_DIR=cache)[0]) for _ in range(3))
    report.row('first prediction, new process, empty cache', cold, 's', COLD)
    report.row('first prediction, new process, filled cache', warm, 's', WARM)
    bare = [fresh(BARE) for _ in range(5)]
    report.row('import billiard_shot', min(float(lines[0]) for lines in bare), 's', IMPORT)
    loaded = float(bare[0][1] != '[]')
    report.row(f'    imported with it: {bare[0][1]}', loaded, '', 0.5)
    report.end()


if __name__ == '__main__':
    main()
