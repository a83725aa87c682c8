"""
Outcomes of impact laws over uncertain parameters, and their discontinuities.

At a discontinuity, an arbitrarily small change of a parameter changes the outcome by a finite
amount.

    python studies/laws.py [SCENE] [STROKE] [--picture FILE.png] [--random N]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
import math
from pathlib import Path
import sys

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/laws.py`
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
    BLUE,
    GREEN,
    GREY,
    new_figure,
    save,
    VERMILION,
)
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from studies.classical_laws import newton, NoEndError, pairwise
from studies.command import run_study
from studies.paper import PRINTED
from studies.problem import ContactProblem

LAWS_TOLERANCE = 1e-11
CLOSEST = 1e-11  # relative width to which a discontinuity is bracketed
BEND_RATIO = 3.0  # an interval that bends this many times as much as those around is examined
SMALLEST = 1e-6  # discontinuity that is reported, relative to the cue speed
COMPARED_LAWS = ('bistiffness', 'energetic')
WAYS = (*COMPARED_LAWS, 'pairwise', 'newton')
StrokeOutcome = Callable[[float], Array]


@dataclass(frozen=True, slots=True)
class Discontinuity:
    """Place and size (largest component, relative to the cue speed) of a discontinuity."""

    place: float
    size: float


@dataclass(frozen=True, slots=True)
class ParameterSweep:
    """A stroke in a scene, of which one parameter is varied."""

    name: str
    values: Array
    at: Callable[[float], tuple[Scene, Stroke]]

    def problem(self, value: float, law: str) -> ContactProblem:
        """State the stroke at a value."""
        scene, stroke = self.at(value)
        return ContactProblem.of(replace(scene, law=law), stroke)

    def solved(self, value: float, way: str) -> tuple[ContactProblem, Array]:
        """State the stroke at a value, and find its impulses (6,) [N s] by law or way."""
        if way in COMPARED_LAWS:
            problem = self.problem(value, way)
            return problem, problem.adaptive(LAWS_TOLERANCE)[0]
        problem = self.problem(value, 'bistiffness')  # the laws agree for one contact alone
        return problem, pairwise(problem) if way == 'pairwise' else newton(problem)

    def outcome(self, way: str) -> StrokeOutcome:
        """Return a function from the value to the motion (7,) of ball and cue after the strike."""

        def motion(value: float) -> Array:
            problem, impulses = self.solved(value, way)
            velocity, spin, cue = problem.motion(impulses)
            parts = (velocity, problem.model.surface.radius * spin, [cue])
            return np.concatenate(parts) / problem.stroke.speed

        return motion

    def distances(self, way: str) -> Array:
        """Distances from the ball's start to its place of rest, at all values [m]; or NaN."""
        found = []
        for value in self.values.tolist():
            try:
                problem, impulses = self.solved(value, way)
                velocity, spin, _ = problem.motion(impulses)
                rest = problem.resting_place(velocity, spin)
                found.append(math.hypot(rest[0], rest[1]))
            except NoEndError:
                found.append(math.nan)
        return np.array(found)


def sweeps(scene: Scene, stroke: Stroke, count: int = 201) -> Iterator[ParameterSweep]:
    """Sweeps through a stroke: stiffness ratio, offsets a and b, elevation, speed."""
    a, b, elevation, azimuth, speed = stroke.offsets

    def with_ratio(ratio: float) -> tuple[Scene, Stroke]:
        table = replace(scene.contacts.ball_table, stiffness=1.0, duration=None)
        tip = replace(scene.contacts.cue_ball, stiffness=ratio, duration=None)
        return replace(
            scene, contacts=replace(scene.contacts, cue_ball=tip, ball_table=table)
        ), stroke

    def varied(index: int, unit: float = 1.0) -> Callable[[float], tuple[Scene, Stroke]]:
        def at(value: float) -> tuple[Scene, Stroke]:
            offsets = [a, b, elevation, azimuth, speed]
            offsets[index] = unit * value
            return scene, Stroke.from_offsets(*offsets)

        return at

    limits = 0.95 * math.sqrt(max(1.0 - b * b, 0.0)), 0.95 * math.sqrt(max(1.0 - a * a, 0.0))
    yield ParameterSweep('stiffness ratio', np.geomspace(0.1, 10.0, count), with_ratio)
    yield ParameterSweep('offset a (radii)', np.linspace(-limits[0], limits[0], count), varied(0))
    yield ParameterSweep('offset b (radii)', np.linspace(-limits[1], limits[1], count), varied(1))
    degree = math.radians(1.0)
    yield ParameterSweep('elevation (degrees)', np.linspace(0.0, 86.0, count), varied(2, degree))
    yield ParameterSweep('speed (m/s)', np.geomspace(0.05, 10.0, count), varied(4))


def discontinuities(
    outcome: StrokeOutcome, values: Sequence[float] | Array
) -> list[Discontinuity]:
    """
    Find the discontinuities of an outcome over sorted values, each bracketed to rounding.

    An interval is examined if its change differs from the mean of its neighbours' by more than is
    usual around it. At most one discontinuity is found in each interval.
    """
    x = np.asarray(values, float)
    results = np.array([outcome(value) for value in x.tolist()])
    slopes = np.diff(results, axis=0) / np.diff(x)[:, np.newaxis]
    padded = np.concatenate([slopes[1:2], slopes, slopes[-2:-1]])
    usual = 0.5 * (padded[:-2] + padded[2:])
    bends = np.abs(slopes - usual).max(axis=1) * np.diff(x)
    found = []
    for i, bend in enumerate(bends):
        around = np.concatenate([bends[max(i - 4, 0) : max(i - 1, 0)], bends[i + 2 : i + 5]])
        if bend > BEND_RATIO * np.median(around) + SMALLEST:
            discontinuity = _bracketed(outcome, float(x[i]), float(x[i + 1]), usual[i])
            found += [discontinuity] if discontinuity.size > SMALLEST else []
    return found


def _bracketed(outcome: StrokeOutcome, low: float, high: float, slope: Array) -> Discontinuity:
    """Halve an interval, keeping the half whose change is further from the usual slope's."""
    p, q = outcome(low), outcome(high)
    while high - low > CLOSEST * max(abs(low), abs(high)):
        middle = 0.5 * (low + high)
        m = outcome(middle)
        step = slope * (middle - low)
        if np.abs(m - p - step).max() > np.abs(q - m - step).max():
            high, q = middle, m
        else:
            low, p = middle, m
    return Discontinuity(0.5 * (low + high), float(np.abs(q - p).max()))


def wedges(problem: ContactProblem) -> bool:
    """
    Whether the tip can wedge: W_nn < mu |W_nt| (Painleve 1895).

    The friction of a sliding tip then presses it against the ball more than the spring parts them.
    """
    w, mu = problem.response, float(problem.friction[0])
    return bool(w[0, 0] < mu * math.hypot(w[0, 1], w[0, 2]))


def random_strokes(count: int, seed: int) -> list[Stroke]:
    """Strokes of all kinds, to look for discontinuities around them."""
    rng = np.random.default_rng(seed)
    return [
        Stroke.from_offsets(a, b, elevation, 0.0, 2.0)
        for a, b, elevation in rng.uniform((-0.6, -0.6, 0.0), (0.6, 0.6, 1.4), (count, 3))
    ]


def _places(found: list[tuple[float, float]], values: int) -> str:
    """Text of places and sizes; a sweep finds only what lies between values that differ."""
    places = ', '.join(f'{place:.6g} ({size:.2g})' for place, size in found)
    return places or f'none found at these {values} values'


LAW_SWEEPS = (
    Column('stroke'),
    Column('varied', 'varied'),
    Column('law', 'law'),
    Column('from', 'from', '', '{:.3g}'.format),
    Column('to', 'to', '', '{:.3g}'.format),
    Column('discontinuities'),
    Column('values'),
    Column('found', 'discontinuous at', '(size / cue speed)'),
)
COUNTS = (
    Column('law', 'law'),
    Column('discontinuities', 'discontinuities'),
    Column('wedging', 'where the tip can wedge'),
    Column('largest', 'largest / cue speed', '', '{:.2g}'.format),
)


@dataclass(frozen=True)
class OfSweeps:
    """
    What to vary, and the picture.

    Parameters
    ----------
    count : N
        Number of values of each varied parameter (default: %(default)d).
    random : N
        Count the discontinuities around N random strokes instead (--workers, --dask).
    picture : FILE.png
        Draw the outcomes.

    """

    count: int = 201
    random: int = 0
    picture: Path | None = None


OPTIONS = OfUsualScene('paper'), OfSweeps(), *STROKE_OPTIONS, OfFormat(), OfWork()


def run(options: argparse.Namespace) -> int:
    """Compare, print, draw."""
    about = scene_name(options)
    scene = Scene.load(about)
    if options.count < 2:
        raise ValueError(f'--count must be at least 2, got {options.count}')
    if options.random < 0:
        raise ValueError(f'--random must be at least 0, got {options.random}')
    if options.random and (strokes_given(options) or options.picture):
        raise ValueError('--random must not be given together with a stroke or --picture')
    if options.random:
        return _count(scene, about, options)
    massé, _ = PRINTED['massé']
    strokes = (
        strokes_from_options(options, scene)
        if strokes_given(options)
        else {'massé at 3 m/s': Stroke(massé.normal, 3.0 / massé.speed * np.array(massé.velocity))}
    )
    if len(strokes) > 1 and options.picture:
        raise ValueError(f'--picture must be given with one stroke, got {len(strokes)}')
    for name, stroke in strokes.items():
        swept = list(sweeps(scene, stroke, options.count))
        found = {
            (sweep.name, way): discontinuities(sweep.outcome(way), sweep.values)
            for sweep, way in progress(
                [(sweep, way) for sweep in swept for way in COMPARED_LAWS], 'discontinuities'
            )
        }
        rows = []
        for (varied, way), those in found.items():
            values = next(sweep.values for sweep in swept if sweep.name == varied)
            places = [(each.place, each.size) for each in those]
            rows.append(
                {
                    'stroke': name,
                    'varied': varied,
                    'law': way,
                    'from': values[0],
                    'to': values[-1],
                    'discontinuities': places,
                    'values': len(values),
                }
                | ({'found': _places(places, len(values))} if wants_text(options) else {})
            )
        if wants_text(options):
            print(f'stroke {name}, scene {about}\n')
        print_rows(LAW_SWEEPS, rows, options)
        if options.picture:
            pairs = [(sweep, way) for sweep in swept for way in WAYS]
            distances = {
                (sweep.name, way): sweep.distances(way)
                for sweep, way in progress(pairs, 'outcomes')
            }
            draw_laws(
                swept,
                distances,
                found,
                options.picture,
                f'stroke {name}, scene {about}',
            )
    return 0


def _around(scene: Scene, count: int, stroke: Stroke) -> tuple[int, list[tuple[str, bool, float]]]:
    """Find the discontinuities around a stroke: number of sweeps; law, wedging, size of each."""
    swept = list(sweeps(scene, stroke, count))
    return len(swept), [
        (law, wedges(sweep.problem(each.place, law)), each.size)
        for sweep in swept
        for law in COMPARED_LAWS
        for each in discontinuities(sweep.outcome(law), sweep.values)
    ]


def _count(scene: Scene, about: str, options: argparse.Namespace) -> int:
    strokes = random_strokes(options.random, seed=1)
    searches = mapped(options, partial(_around, scene, options.count), strokes)
    found = {law: [0, 0, 0.0] for law in COMPARED_LAWS}
    swept = 0
    for number, those in progress(searches, 'discontinuities', len(strokes)):
        swept += number
        for law, wedging, size in those:
            row = found[law]
            row[0] += 1
            row[1] += wedging
            row[2] = max(row[2], size)
    if wants_text(options):
        print(
            f'scene {about}: {swept} sweeps through {options.random} random strokes, '
            f'{options.count} values each\n'
        )
    print_rows(
        COUNTS,
        [
            {'law': law, 'discontinuities': row[0], 'wedging': row[1], 'largest': row[2]}
            for law, row in found.items()
        ],
        options,
    )
    return 0


PANELS_PER_ROW = 3
STYLES = {
    'bistiffness': (BLUE, '-'),
    'energetic': (VERMILION, '-'),
    'pairwise': (GREEN, '--'),
    'newton': (GREY, ':'),
}


def draw_laws(
    sweeps: Sequence[ParameterSweep],
    distances: Mapping[tuple[str, str], Array],
    discontinuities: Mapping[tuple[str, str], Sequence[Discontinuity]],
    path: Path,
    about: str,
) -> None:
    """
    Write a picture with a panel for each sweep: distance from start to rest, over the parameter.

    Keys of `distances` and `discontinuities` are the name of the sweep and the law or method.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    rows = math.ceil(len(sweeps) / PANELS_PER_ROW)
    figure = new_figure(3.3 * PANELS_PER_ROW, 2.6 * rows + 0.6)
    panels = figure.subplots(rows, PANELS_PER_ROW, squeeze=False).ravel()
    for axes in panels[len(sweeps) :]:
        axes.set_axis_off()
    for axes, sweep in zip(panels, sweeps, strict=False):
        for way, (colour, dashes) in STYLES.items():
            if (sweep.name, way) in distances:
                axes.plot(
                    sweep.values,
                    distances[sweep.name, way],
                    dashes,
                    color=colour,
                    linewidth=1.2,
                    label=way,
                )
        for way in COMPARED_LAWS:
            for discontinuity in discontinuities.get((sweep.name, way), ()):
                axes.axvline(discontinuity.place, color=STYLES[way][0], linewidth=0.6, alpha=0.6)
        if sweep.values[0] > 0.0 and sweep.values[-1] > 50.0 * sweep.values[0]:
            axes.set_xscale('log')
        axes.set_xlabel(sweep.name)
        axes.tick_params(labelsize='small')
        axes.grid(alpha=0.3)
    figure.supylabel('distance from start to rest (m)', fontsize='medium')
    count = {
        way: sum(len(discontinuities.get((sweep.name, way), ())) for sweep in sweeps)
        for way in COMPARED_LAWS
    }
    findings = ', '.join(f'{number} of {way}' for way, number in count.items())
    figure.suptitle(f'{about}; discontinuities (thin lines): {findings}', fontsize='medium')
    add_legend(figure, panels[0])
    save(figure, path)


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())
