"""
Errors of predictions, compared with `tolerance` and with the error estimate.

Random shots (0.05 to 10 m/s, log-uniform) in scenes `paper` and `pool` and in random scenes, at
six tolerances. The true error is the largest distance, at equal times, from the trajectory of a
run at the floor of the tolerance. If SciPy finishes, that run is compared with SciPy.

    python benchmarks/tolerance.py [--count N]
"""

import argparse
from collections import Counter
from dataclasses import replace
from statistics import median

import numpy as np
from tools.timing import Report

from billiard_shot import predict, Scene, Status, Stroke
from billiard_shot.table.model.motion import Cause
from studies.problem import ContactProblem
from studies.scipy_strike import GaveUpError, ScipyStrike

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-7, 1e-9)  # m
FLOOR = 1e-15
WITHIN = 0.99  # fraction of the shots
GROWTH = 4.0  # of the time from 1e-3 to 1e-9
CHECKED, AGREED = 40, 1e-7  # strokes of each scene; fraction of the cue's speed


def gap(one, other):
    """Largest distance of two trajectories at equal times, before the cue hits again [m]."""
    rows = np.concatenate([one.rows, other.rows])
    again = rows['time'][rows['cause'] == Cause.CUE].min(initial=np.inf)
    knots = np.concatenate([one.rows['time'], other.rows['time']])
    end = 1.01 * max(one.duration, other.duration)
    knots = np.unique(np.concatenate([knots[knots < np.inf], np.linspace(0.0, end, 200)]))
    times = np.sort(np.concatenate([knots, 0.5 * (knots[1:] + knots[:-1])]))
    times = times[times < again]
    return np.linalg.norm(one.at(times).position - other.at(times).position, axis=1).max()


def random_stroke(rng):
    """Random stroke anywhere on the ball that a tip may hit, from level to nearly vertical."""
    while True:
        a, b = rng.uniform(-0.7, 0.7, 2)
        if np.hypot(a, b) < 0.7:
            elevation = rng.uniform(0.0, 1.4) if rng.random() < 0.5 else rng.uniform(0.0, 0.15)
            speed = np.exp(rng.uniform(np.log(0.05), np.log(10.0)))
            return Stroke.from_offsets(a, b, elevation, rng.uniform(-3.0, 3.0), speed)


def random_scene(rng):
    """Random scene with another cue, tip, cloth and law."""
    cue = (
        {'mass': rng.uniform(0.1, 2.0), 'guided': True}
        if rng.random() < 0.5
        else {'mass': rng.uniform(0.3, 0.8), 'end_mass': rng.uniform(0.003, 0.05)}
    )
    tip, table = (
        {
            'restitution': rng.uniform(0.3, 0.95),
            'friction': rng.uniform(*friction),
            'stiffness': np.exp(rng.uniform(-2.0, 2.0)),
        }
        for friction in ((0.2, 0.9), (0.1, 0.4))
    )
    return Scene.from_dict(
        {
            'ball': {'mass': 0.17, 'radius': 0.0286},
            'cue': cue,
            'contacts': {'cue_ball': tip, 'ball_table': table},
            'law': str(rng.choice(('bistiffness', 'energetic'))),
        }
    )


def checked(scenes, strokes, floors):
    """Count runs at the floor that agree with SciPy, differ, or are not finished by SciPy."""
    counts = Counter()
    for scene, stroke, floor in zip(scenes, strokes, floors, strict=True):
        problem = ContactProblem.of(scene, stroke)
        try:
            impulse = ScipyStrike(problem).solve(1e-9)
        except (GaveUpError, np.linalg.LinAlgError):
            counts['unfinished'] += 1
            continue
        velocity, spin, _ = problem.motion(impulse)
        off = max(
            np.abs(velocity - floor.velocity).max(),
            scene.ball.radius * np.abs(spin - floor.spin).max(),
        )
        counts['agreed' if off < AGREED * stroke.speed else 'differed'] += 1
    return counts


def study(report, name, scenes, rng):
    """Measure all tolerances, with one stroke in each scene."""
    strokes, floors, kept = [], [], []
    for scene in scenes:
        stroke = random_stroke(rng)
        floor = predict(scene, stroke, FLOOR)
        if not floor.status.refused:
            strokes.append(stroke)
            floors.append(floor)
            kept.append(scene)
    counts = checked(kept[:CHECKED], strokes[:CHECKED], floors[:CHECKED])
    report.row(f'{name}: shots', len(kept), '')
    report.row('    the floor agrees with SciPy', counts['agreed'], f'of {CHECKED}')
    report.row('    it differs', counts['differed'], '')
    report.row('    SciPy finds no end', counts['unfinished'], '')
    times = {}
    for tolerance in TOLERANCES:
        shots = [predict(*pair, tolerance) for pair in zip(kept, strokes, strict=True)]
        errors = np.array(
            [
                gap(shot.trajectory, floor.trajectory)
                for shot, floor in zip(shots, floors, strict=True)
            ]
        )
        estimates = np.array([shot.error_estimate for shot in shots])
        lowest = np.array([floor.error_estimate for floor in floors])  # errors of the reference
        said = np.array(
            [
                shot.status in (Status.TOLERANCE_NOT_REACHED, Status.BUDGET_EXCEEDED)
                for shot in shots
            ]
        )
        times[tolerance] = median(shot.wall_time for shot in shots)
        report.row(
            f'    at {tolerance:g} m: error within the estimate',
            100 * np.mean(errors <= estimates + lowest),
            '%',
            -100 * WITHIN,
        )
        report.row(
            '        within the tolerance',
            100 * np.mean(errors <= tolerance + lowest),
            '%',
            -100 * WITHIN,
        )
        report.row(
            '        beyond it without a word',
            ((errors > tolerance + lowest) & ~said).sum(),
            '',
            0.5,
        )
        report.row('        largest error over tolerance', (errors / tolerance).max(), '')
        report.row('        median time of a prediction', 1e6 * times[tolerance], 'us')
    report.row('    time at 1e-9 over time at 1e-3', times[1e-9] / times[1e-3], 'x', GROWTH)


def main():
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=1000)
    count = parser.parse_args().count
    report = Report('Tolerance and error estimate')
    rng = np.random.default_rng(1)
    for name in ('paper', 'pool'):
        scene = replace(Scene.load(name), table=None)
        study(report, name, [scene] * count, rng)
    study(report, 'random scenes', [random_scene(rng) for _ in range(count)], rng)
    report.end()


if __name__ == '__main__':
    main()
