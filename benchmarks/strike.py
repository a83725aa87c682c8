"""
Cost of one strike: the kernel, the same model in SciPy, and the paper's impulse scheme.

All in one run, medians, errors checked against the kernel at 1e-12.

    python benchmarks/strike.py
"""

import statistics
from time import perf_counter

import numpy as np
from tools.strokes import Kernel, paper_strikes, random_strikes
from tools.timing import once, QUICK, Report, seconds, Time, yardstick

from billiard_shot.status import Status
from studies.impulse_scheme import solve_strike as impulse_strike
from studies.scipy_strike import GaveUpError, ScipyStrike

ACCURACY = 1e-8
SPEED_UP = 300.0  # over SciPy
MEDIAN, TAIL = 5.3, 8.0  # at 1e-8: the median in np.cross; p99 over the median
STROKES = 200 if QUICK else 2000
SAMPLE = 3 if QUICK else 12  # random strokes that SciPy solves


def scipy_time(strike, exact):
    """Time of the fastest SciPy run that is as accurate; None if no run is."""
    best = None
    for rtol in (3e-8, 1e-8, 3e-9, 1e-9, 3e-10, 1e-10, 1e-11):
        begin = perf_counter()
        try:
            impulse = ScipyStrike(strike).solve(rtol)
        except (GaveUpError, np.linalg.LinAlgError):
            continue
        time = perf_counter() - begin
        if exact.error(strike, impulse) <= ACCURACY and (best is None or time < best):
            best = time
    return best


def time_of(kernel, strike, tolerance):
    """Time of one strike in the kernel [s]."""
    return seconds(kernel, strike, tolerance, at_least=0.02, repeats=3) / kernel.COPIES


def against_scipy(report, law):
    """Compare with SciPy at equal error; return the ratio."""
    exact, fast = Kernel(), Kernel()
    ratios, failed = [], 0
    for strike in [*paper_strikes(law).values(), *random_strikes(SAMPLE, law, seed=1)]:
        exact(strike, 1e-12)
        fast(strike, ACCURACY)
        error = exact.error(strike, fast.impulse)
        if error > ACCURACY:
            report.row(f'{law}: a stroke of the sample exceeds the accuracy', error, '', ACCURACY)
        slow = scipy_time(strike, exact)
        if slow is None:
            failed += 1
            continue
        ratios.append(slow / time_of(fast, strike, ACCURACY))
    name = f'law {law}: SciPy (DOP853 with events) over ours, equal errors'
    report.row(name, statistics.median(ratios), 'x', -SPEED_UP)
    report.row(f'    slowest to fastest of {len(ratios)} strokes: from', min(ratios), 'x')
    report.row('    to', max(ratios), 'x')
    report.row('    strokes that SciPy did not finish at that error', failed, f'of {4 + SAMPLE}')


def distribution(report, law, cross):
    """Times and errors over many ordinary strokes."""
    kernel, exact = Kernel(), Kernel()
    times, errors, ends = [], [], []
    for strike in random_strikes(STROKES, law, seed=2):
        kernel(strike, ACCURACY)
        status = kernel(strike, ACCURACY)
        times.append(min(once(kernel, strike, ACCURACY).cpu for _ in range(3)) / kernel.COPIES)
        ends.append(status)
        if status == Status.OK and exact(strike, 1e-12) == Status.OK:
            errors.append(exact.error(strike, kernel.impulse))
    median = statistics.median(times)
    name = f'law {law}: a strike, median of {STROKES}'
    report.row(name, Time(median, median), 'us')
    report.row('    the same', median / cross.cpu, 'cross products', MEDIAN)
    report.row(
        '    99 % of the strikes within', np.quantile(times, 0.99) / median, 'medians', TAIL
    )
    report.row('    worst', max(times) / median, 'medians')
    report.row('    99.9 % of the errors below', np.quantile(errors, 0.999), '')
    report.row('    worst error', max(errors), '')
    endless = ends.count(Status.INFINITE_SEQUENCE)
    report.row('    infinite sequences ended by the floor', endless, '')
    report.row('    without an answer', ends.count(Status.BUDGET_EXCEEDED), '')


def against_the_paper(report):
    """Compare with the paper's scheme at equal error, on its four shots."""
    exact, fast = Kernel(), Kernel()
    for shot, strike in paper_strikes('energetic').items():
        exact(strike, 1e-12)
        model, stroke = strike.model, strike.stroke
        answer, _, _ = strike.motion(exact.impulse)
        for step in (1e-3, 1e-4, 1e-5):
            arguments = (
                stroke.normal, stroke.velocity, model.cue_mass, model.surface.mass,
                model.surface.radius, tuple(strike.friction), tuple(strike.restitution), 1.5,
                step * model.surface.mass * stroke.speed,
            )  # fmt: skip
            found = impulse_strike(*arguments).velocities[1]
            error = np.abs(found - answer).max() / stroke.speed
            tolerance = min(max(error, 1e-10), 1e-4)
            slow = seconds(impulse_strike, *arguments, repeats=3)
            ratio = slow / time_of(fast, strike, tolerance)
            report.row(
                f' impulse scheme over the kernel at equal error, {error:.0e}, {shot}', ratio, 'x'
            )


def main():
    """Measure everything."""
    report = Report('One strike')
    cross = yardstick()
    report.row(' yardstick: np.cross of two vectors', cross, 'us')
    for law in ('energetic', 'bistiffness'):
        against_scipy(report, law)
        distribution(report, law, cross)
    against_the_paper(report)
    report.end()


if __name__ == '__main__':
    main()
