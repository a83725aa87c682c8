"""Cost of accuracy: methods for the same strike, at several settings, against the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import combinations
import math
from statistics import fmean, median
from time import process_time

import numpy as np

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.study import impulse_scheme
from billiard_shot.study.closed_form import applies, closed_form
from billiard_shot.study.memory import peak, reset_peak
from billiard_shot.study.mujoco_strike import mujoco_strike
from billiard_shot.study.problem import Answer, ContactProblem
from billiard_shot.study.reproduction import PRINTED
from billiard_shot.study.resting_place import resting_place
from billiard_shot.study.scipy_strike import GaveUpError, ScipyStrike

FLOOR = 1e-13  # tolerance of the truth; the tests compare it with SciPy and the closed form
# Total processor time [s] and number of runs at which a measurement of time ends.
ENOUGH, MAX_RUNS = 0.02, 51
ONLY_ROUNDING = 1e-13  # smaller relative errors are rounding

IMPULSE_STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of impulse, relative to ball mass times cue speed
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)  # relative to the approach speed
SCIPY_TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
TIME_STEPS = (2e-4, 5e-5, 1e-5, 2e-6)  # s

TimedRun = Callable[[], Callable[[], Answer]]  # is timed; returns a function that reads the answer

# The strokes of `billiard-shot study accuracy` by default: the paper's Table 1.
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
    memory: float  # largest growth of the memory of the process, kB


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
    """Yield all methods that can be compared here; MuJoCo only if it is installed."""
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
    if find_spec('mujoco'):
        yield Method(
            'MuJoCo',
            'time step',
            TIME_STEPS,
            mujoco_strike,
            lambda problem: 'for guided cues' if problem.model.inverse_end_mass else '',
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
        """Run it once to warm up, once for the memory, and again for the time."""
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
                memory=nan,
            )
        rest = resting_place(self.problem.scene, velocity, spin)
        dv = float(np.abs(velocity - self.truth[0]).max())
        dw = float(np.abs(spin - self.truth[1]).max())
        dx = float(np.linalg.norm(rest - self.truth[2]))
        before = reset_peak()
        run()
        memory = max(peak() - before, 0.0)
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
            memory=memory,
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
        truth = velocity, spin, resting_place(problem.scene, velocity, spin)
        for method in methods():
            if reason := method.against(problem):
                left_out.append(f'{name}: {method.name}: {reason}')
            else:
                wanted += [Task(name, problem, truth, method, x) for x in method.settings]
    return wanted, left_out


@dataclass(frozen=True, slots=True)
class AccuracyPoint:
    """A method at a setting, over all strokes: worst errors, typical work."""

    setting: float
    answered: int  # strokes
    velocity: float  # m/s
    spin: float  # rad/s
    rest: float  # mm
    part: float  # relative to the cue speed
    evaluations: float  # mean
    seconds: float  # mean
    memory: float  # largest, kB


def curve(measurements: Sequence[Measurement], method: str) -> list[AccuracyPoint]:
    """Work and precision of a method: one point for each setting at which it found an answer."""
    points = []
    mine = [m for m in measurements if m.method == method]
    for setting in dict.fromkeys(m.setting for m in mine):
        these = [m for m in mine if m.setting == setting and m.seconds == m.seconds]
        if these:
            points.append(
                AccuracyPoint(
                    setting,
                    len(these),
                    max(m.velocity for m in these),
                    max(m.spin for m in these),
                    max(m.rest for m in these),
                    max(m.part for m in these),
                    evaluations=fmean(m.evaluations for m in these),
                    seconds=fmean(m.seconds for m in these),
                    memory=max(m.memory for m in these),
                )
            )
    return points


def order(points: Sequence[AccuracyPoint]) -> float:
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
