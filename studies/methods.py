"""
Errors and work of several methods for the same strikes, at several settings.

    python studies/methods.py [SCENE] [--normal ... --velocity ...] [--picture FILE.png]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
import csv
from dataclasses import asdict, dataclass
from itertools import combinations
import math
from pathlib import Path
from statistics import fmean, median
import sys
from time import process_time

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/methods.py`
from billiard_shot.cli.options import option
from billiard_shot.cli.output import Column, OfFormat, print_rows, progress, wants_text
from billiard_shot.cli.shots import (
    OfUsualScene,
    scene_name,
    STROKE_OPTIONS,
    strokes_from_options,
    strokes_given,
)
from billiard_shot.cli.workers import mapped, OfWork
from billiard_shot.pictures.canvas import (
    add_legend,
    BLACK,
    BLUE,
    GREEN,
    new_figure,
    PURPLE,
    save,
    VERMILION,
)
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import reason
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from studies import impulse_scheme
from studies.closed_form import applies, closed_form
from studies.command import run_study
from studies.paper import PRINTED
from studies.problem import Answer, ContactProblem
from studies.scipy_strike import GaveUpError, ScipyStrike

FLOOR = 1e-13  # tolerance of the truth; the tests compare it with SciPy and the closed form
# Total processor time [s] and number of runs at which a measurement of time ends.
ENOUGH, MAX_RUNS = 0.02, 51
ONLY_ROUNDING = 1e-13  # smaller relative errors are rounding

IMPULSE_STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of impulse, relative to ball mass times cue speed
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)  # relative to the approach speed
SCIPY_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)

TimedRun = Callable[[], Callable[[], Answer]]  # is timed; returns a function that reads the answer

# The strokes by default: the paper's Table 1.
PAPER_STROKES = {name: stroke for name, (stroke, _) in PRINTED.items()}


class NoAnswerError(Exception):
    """A method found no answer to a strike at a setting."""


@dataclass(frozen=True, slots=True)
class Method:
    """
    A way to solve a strike.

    Attributes
    ----------
    name, setting : str
        Names of the method and of its setting.
    settings : tuple of float
    prepare : callable
        Makes a `TimedRun` from a problem and a setting; the `TimedRun` may raise NoAnswerError.
    against : callable
        Says why the method cannot solve a problem; returns '' if it can.

    """

    name: str
    setting: str
    settings: tuple[float, ...]
    prepare: Callable[[ContactProblem, float], TimedRun]
    against: Callable[[ContactProblem], str] = lambda problem: ''


@dataclass(frozen=True, slots=True)
class Measurement:
    """Errors and work of a method at a setting, on one strike; NaN if it found no answer."""

    stroke: str
    method: str
    setting: float
    velocity: float  # error, m/s
    spin: float  # error, rad/s
    rest: float  # error of the resting place, mm
    part: float  # largest error of velocity and surface speed, relative to the cue speed
    evaluations: int
    seconds: float


def _impulse_scheme(problem: ContactProblem, step: float) -> TimedRun:
    model, stroke = problem.model, problem.stroke
    friction, restitution = problem.friction.tolist(), problem.restitution.tolist()

    def run() -> Callable[[], Answer]:
        done = impulse_scheme.solve_strike(
            stroke.normal,
            stroke.velocity,
            model.cue_mass,
            model.surface.mass,
            model.surface.radius,
            (friction[0], friction[1]),
            restitution=(restitution[0], restitution[1]),
            ratio=float(problem.stiffness[0] / problem.stiffness[1]),
            step=step * model.surface.mass * stroke.speed,
            law=problem.law,
        )
        if done.status == Status.BUDGET_EXCEEDED:
            raise NoAnswerError
        return lambda: (done.velocities[1], done.spins[1], done.steps)

    return run


def _against_impulse_scheme(problem: ContactProblem) -> str:
    if not impulse_scheme.IS_COMPILED:
        return 'without numba the impulse scheme is interpreted, and its times say nothing'
    if problem.law == 'bistiffness':
        return 'the impulse scheme does not have law bistiffness'
    surface = problem.model.surface
    solid = math.isclose(surface.inertia, 0.4 * surface.mass * surface.radius**2)
    guided = problem.model.inverse_end_mass == 0.0
    return '' if guided and solid else 'for guided cues and solid balls'


def _adaptive(problem: ContactProblem, tolerance: float) -> TimedRun:
    def run() -> Callable[[], Answer]:
        impulse, steps, status = problem.adaptive(tolerance)
        if status == Status.BUDGET_EXCEEDED:
            raise NoAnswerError
        return lambda: (*problem.motion(impulse)[:2], steps)

    return run


def _closed_form(problem: ContactProblem, _: float) -> TimedRun:
    def run() -> Callable[[], Answer]:
        impulse = closed_form(problem)
        return lambda: (*problem.motion(impulse)[:2], 1)

    return run


def _scipy(method: str) -> Callable[[ContactProblem, float], TimedRun]:
    def prepare(problem: ContactProblem, rtol: float) -> TimedRun:
        def run() -> Callable[[], Answer]:
            strike = ScipyStrike(problem, method)
            try:
                impulse = strike.solve(rtol)
            except (GaveUpError, np.linalg.LinAlgError):
                raise NoAnswerError from None
            return lambda: (*problem.motion(impulse)[:2], strike.evaluations)

        return run

    return prepare


def methods() -> Iterator[Method]:
    """Yield all methods."""
    yield Method('impulse scheme', 'step', IMPULSE_STEPS, _impulse_scheme, _against_impulse_scheme)
    yield Method('this library', 'tolerance', TOLERANCES, _adaptive)
    yield Method(
        'closed form',
        '',
        (0.0,),
        _closed_form,
        lambda problem: '' if applies(problem) else 'only for level, centre-high strokes',
    )
    for name in ('DOP853', 'Radau'):
        yield Method(
            f'SciPy {name}',
            'rtol',
            SCIPY_TOLERANCES,
            _scipy(name),
            lambda problem: '' if problem.model.exponent == (1.0, 1.0) else 'for linear springs',
        )


@dataclass(frozen=True, slots=True)
class Task:
    """A method at a setting on a stroke, with the truth it is measured against."""

    name: str
    problem: ContactProblem
    truth: tuple[Array, Array, Array]  # velocity, spin, place of rest
    method: Method
    setting: float

    def measure(self) -> Measurement:
        """Run it once to warm up, and again for the time."""
        nan, speed = math.nan, self.problem.stroke.speed
        run = self.method.prepare(self.problem, self.setting)
        try:
            velocity, spin, evaluations = run()()
        except NoAnswerError:
            return Measurement(
                self.name,
                self.method.name,
                self.setting,
                nan,
                nan,
                nan,
                part=nan,
                evaluations=0,
                seconds=nan,
            )
        rest = self.problem.resting_place(velocity, spin)
        dv = float(np.abs(velocity - self.truth[0]).max())
        dw = float(np.abs(spin - self.truth[1]).max())
        dx = float(np.linalg.norm(rest - self.truth[2]))
        times: list[float] = []
        while sum(times) < ENOUGH and len(times) < MAX_RUNS:
            begin = process_time()
            run()
            times.append(process_time() - begin)
        return Measurement(
            self.name,
            self.method.name,
            self.setting,
            dv,
            dw,
            1e3 * dx,
            part=max(dv, self.problem.model.surface.radius * dw) / speed,
            evaluations=evaluations,
            seconds=median(times),
        )


def tasks(scene: Scene, strokes: Mapping[str, Stroke]) -> tuple[list[Task], list[str]]:
    """Return all tasks, and a line about each method that cannot solve a stroke."""
    wanted: list[Task] = []
    left_out: list[str] = []
    for name, stroke in strokes.items():
        problem = ContactProblem.of(scene, stroke)
        impulse, _, status = problem.adaptive(FLOOR)
        if status not in (Status.OK, Status.INFINITE_SEQUENCE):
            left_out.append(f'{name}: not solved at {FLOOR:g}: {status.name}')
            continue
        velocity, spin, _ = problem.motion(impulse)
        truth = velocity, spin, problem.resting_place(velocity, spin)
        for method in methods():
            if reason := method.against(problem):
                left_out.append(f'{name}: {method.name}: {reason}')
            else:
                wanted += [Task(name, problem, truth, method, x) for x in method.settings]
    return wanted, left_out


@dataclass(frozen=True, slots=True)
class MethodPoint:
    """A method at a setting, over all strokes: worst errors, typical work."""

    setting: float
    answered: int  # strokes
    velocity: float  # m/s
    spin: float  # rad/s
    rest: float  # mm
    part: float  # relative to the cue speed
    evaluations: float  # mean
    seconds: float  # mean


def curve(measurements: Sequence[Measurement], method: str) -> list[MethodPoint]:
    """Work and precision of a method: one point for each setting at which it found an answer."""
    points = []
    mine = [m for m in measurements if m.method == method]
    for setting in dict.fromkeys(m.setting for m in mine):
        these = [m for m in mine if m.setting == setting and m.seconds == m.seconds]
        if these:
            points.append(
                MethodPoint(
                    setting,
                    len(these),
                    max(m.velocity for m in these),
                    max(m.spin for m in these),
                    max(m.rest for m in these),
                    max(m.part for m in these),
                    evaluations=fmean(m.evaluations for m in these),
                    seconds=fmean(m.seconds for m in these),
                )
            )
    return points


def order(points: Sequence[MethodPoint]) -> float:
    """
    Order of convergence: the power of the setting (step or tolerance) that the error follows.

    It is the median slope over all pairs of settings (Theil 1950), which a single bad answer
    hardly changes. A setting counts if no other one has answers for more strokes, and if its error
    is above rounding. NaN if fewer than two settings count.
    """
    complete = max(p.answered for p in points)
    told = [
        p for p in points if p.answered == complete and p.setting > 0.0 and p.part > ONLY_ROUNDING
    ]
    if len(told) < 2:
        return math.nan
    return median(
        math.log(p.part / q.part) / math.log(p.setting / q.setting)
        for p, q in combinations(told, 2)
    )


def speed_up(measurements: Sequence[Measurement], rest: float) -> float:
    """
    Time of the impulse scheme relative to this library, for an error of the resting place [mm].

    It is the median over the strokes. Between two steps, the time of the scheme is interpolated as
    a power of the error. NaN if the scheme does not reach this error.
    """
    ratios = []
    for stroke in dict.fromkeys(m.stroke for m in measurements):
        slow = [m for m in measurements if m.stroke == stroke and m.method == 'impulse scheme']
        fast = [
            m.seconds
            for m in measurements
            if m.stroke == stroke and m.method == 'this library' and m.rest <= rest
        ]
        if slow and fast and min(m.rest for m in slow) <= rest:
            slow.sort(key=lambda m: m.rest)
            seconds = np.exp(
                np.interp(
                    math.log(rest),
                    [math.log(m.rest) for m in slow],
                    [math.log(m.seconds) for m in slow],
                )
            )
            ratios.append(float(seconds) / min(fast))
    return median(ratios) if ratios else math.nan


ACCURACY_COLUMNS = (
    Column('method'),
    Column('parameter'),
    Column('setting'),
    Column('at', 'method, at'),
    Column('velocity', 'velocity', '(m/s)', '{:.1e}'.format),
    Column('spin', 'spin', '(rad/s)', '{:.1e}'.format),
    Column('rest', 'rests', '(mm)', '{:.1e}'.format),
    Column('evaluations', 'evals', '', '{:.0f}'.format),
    Column('seconds', 'time', '(us)', lambda seconds: f'{1e6 * seconds:.0f}'),
    Column('of', 'solved'),
    Column('answered'),
    Column('strokes'),
)


@dataclass(frozen=True)
class OfFiles:
    """
    The files.

    Parameters
    ----------
    output : FILE.csv
        Write every measurement.
    picture : FILE.png
        Draw errors over work.

    """

    output: Path | None = option('-o')
    picture: Path | None = None


OPTIONS = OfUsualScene('paper'), OfFiles(), *STROKE_OPTIONS, OfFormat(), OfWork()


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    name = scene_name(options)
    scene = Scene.load(name)
    strokes = strokes_from_options(options, scene) if strokes_given(options) else PAPER_STROKES
    wanted, left_out = tasks(scene, strokes)
    measuring = mapped(options, Task.measure, wanted)
    measurements = list(progress(measuring, 'methods', len(wanted)))
    curves = {method.name: curve(measurements, method.name) for method in methods()}
    curves = {name: points for name, points in curves.items() if points}
    about = f'scene {name}, {len(strokes)} stroke{"s" * (len(strokes) > 1)}'
    settings = {method.name: method.setting for method in methods()}
    ratios = {rest: speed_up(measurements, rest) for rest in (0.1, 0.001)}
    findings = [
        f'at {rest:g} mm the impulse scheme takes {ratio:,.0f} times as long'
        for rest, ratio in ratios.items()
        if ratio == ratio
    ]
    rows = [
        {'method': method, 'parameter': settings[method], 'strokes': len(strokes)} | asdict(point)
        for method, points in curves.items()
        for point in points
    ]
    if wants_text(options):
        print(f'{about}: worst error, mean work\n')
        for row in rows:
            row['at'] = f'{row["parameter"]} {row["setting"]:.0e}' if row['parameter'] else ''
            row['of'] = f'{row["answered"]} of {len(strokes)}'
    print_rows(ACCURACY_COLUMNS, rows, options, 'method')
    if wants_text(options):
        _explain(FLOOR)
        for finding in findings:
            print(finding)
        for line in left_out:
            print(f'left out: {line}')
    if options.output:
        _write(options.output, [asdict(m) for m in measurements])
    if options.picture:
        title = '; '.join([*findings[:1], about])
        draw_methods(curves, options.picture, title[0].upper() + title[1:])
    return 0


def _explain(floor: float) -> None:
    print(
        '\nstep: relative to ball mass times cue speed; tolerance: to the approach speed;\n'
        f'this library at {floor:g}'
    )


def _write(path: Path, rows: list[dict[str, object]]) -> None:
    try:
        with path.open('w', newline='') as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise ValueError(f'--output: {reason(error)}') from None


METHOD_COLOURS = {
    'this library': VERMILION,
    'impulse scheme': BLUE,
    'SciPy DOP853': GREEN,
    'SciPy Radau': PURPLE,
    'closed form': BLACK,
}
LEAST_REST, LEAST_PART = 1e-10, 1e-13  # mm; fraction of the cue speed. Less is drawn there.

Quantity = Callable[[MethodPoint], float]


def draw_methods(curves: Mapping[str, Sequence[MethodPoint]], path: Path, title: str) -> None:
    """
    Draw the error of the resting place over time, and the error of velocity over evaluations.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    figure = new_figure(11.0, 4.8)
    panels: tuple[tuple[Quantity, Quantity, str, str], ...] = (
        (
            lambda p: 1e6 * p.seconds,
            lambda p: max(p.rest, LEAST_REST),
            'time of a strike (µs)',
            'largest error of the resting place (mm)',
        ),
        (
            lambda p: p.evaluations,
            lambda p: max(p.part, LEAST_PART),
            'steps, or evaluations of the right-hand side',
            'largest error of velocity and spin\n(part of the cue speed)',
        ),
    )
    for axis, (work, error, work_label, error_label) in zip(
        figure.subplots(1, 2), panels, strict=True
    ):
        axis.set_xscale('log')
        axis.set_yscale('log')
        for name, points in curves.items():
            paying = settings_that_pay(points, work, error)
            others = [p for p in points if p not in paying]
            colour = METHOD_COLOURS[name]
            axis.plot(
                [*map(work, paying)],
                [*map(error, paying)],
                'o-',
                color=colour,
                ms=4,
                lw=1.2,
                label=name,
            )
            axis.plot(
                [*map(work, others)], [*map(error, others)], 'o', color=colour, ms=4, mfc='none'
            )
        axis.set_xlabel(work_label)
        axis.set_ylabel(error_label)
        axis.margins(0.08)
        axis.grid(alpha=0.3)
        axis.tick_params(labelsize='small')
    add_legend(figure, axis)
    figure.suptitle(
        f'{title}\nEach point is a step or a tolerance. Hollow: another setting costs less and '
        'errs less, or not all strokes are solved.',
        fontsize='medium',
    )
    save(figure, path)


def settings_that_pay(
    points: Sequence[MethodPoint], work: Quantity, error: Quantity
) -> list[MethodPoint]:
    """Find points that solve the most strokes, with less error than all cheaper ones; by work."""
    most = max(p.answered for p in points)
    paying: list[MethodPoint] = []
    for point in sorted((p for p in points if p.answered == most), key=work):
        if not paying or error(point) < error(paying[-1]):
            paying.append(point)
    return paying


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())
