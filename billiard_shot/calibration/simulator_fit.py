"""
A scene that is fitted to a simulator: which models fit, and how well the best of them predicts.

A simulator plays commanded strokes without errors, and tells places exactly. So no launch is
searched. First the cue: its numbers, and the friction of a sliding ball, follow from the cue ball
until it meets anything, in the first half second; and so do the options of the strike. What then
is left of the launches is kept, so that it does not pull the numbers of the table. These are
fitted with each model of the cushion, with contacts that take time and with contacts that take
none. The models compete on strokes that are held out, from the command alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
import math
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.calibration.fit import (
    at_bounds,
    estimates_of,
    fit,
    FitProblem,
    followed,
    JointFit,
    Launch,
    MapFunction,
    rescaled,
    searched,
    sought_in,
)
from billiard_shot.calibration.launch import (
    calibration_model,
    CalibrationModel,
    contacts_of,
    FIRST_SCALES,
    PLACES,
    prior_of,
    sigmas_of,
    spins_of,
)
from billiard_shot.calibration.recording import Floats, Recording, Samples
from billiard_shot.calibration.result import Calibration, Check, check_of
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.equipment import CUSHIONS
from billiard_shot.scene.player import ModelError

STRIKE_NAMES = (
    'contacts.cue_ball.restitution',
    'cue.mass',
    'cue.end_mass',
    'cloth.sliding_friction',
)
"""
Numbers that follow from the first way of the cue ball.

Restitution e and mass M of the cue are nearly one number: strokes at the middle of a ball of the
mass m have (1 + e) M / (M + m). Strokes beside the middle tell them apart, so neither is left out.
"""

STRIKE_EFFECTS = 'shaft', 'flight', 'table_contact'
"""Effects of the strike that a simulator may lack: the first one, the first two, or all."""

RATIO = 'table.cushion.frequency_ratio'
"""A number that only some models of the cushion have."""

FIRST_WAY = 0.5
"""Time after the strike until which the first way of the cue ball counts [s]."""

TRIED_HORIZON = 3.0
"""Models compete after a fit until so long after the strike [s]."""

TRIED_ROUNDS, ROUNDS, SETTLED, STEPS = 2, 8, 0.25, 6
"""
How often a fit is repeated at its last horizon while models compete, and at the end, until it
moves no number by more than this part of its deviation; and the steps of each.
"""

WIDE = np.full(len(FIRST_SCALES), 0.05)
"""Scales of errors while numbers may be far from those of the simulator [m]."""

MOST_STEPS = 1 + len(STRIKE_EFFECTS) + len(CUSHIONS) + 2
"""Number of steps that are told, at most."""

CLOSE = 1e-3
"""Errors of a prediction below this count as if they were as large [m]."""


class Tried(NamedTuple):
    """A model that was fitted, and its predictions of commanded strokes that were held out."""

    words: str
    found: JointFit
    checks: tuple[Check, ...]

    @property
    def score(self) -> float:
        """The mean logarithm of the errors of the cue ball at rest; without strokes the cost."""
        if not self.checks:
            return self.found.cost
        return float(np.log(np.maximum(rest_errors(self.checks), CLOSE)).mean())

    def __str__(self) -> str:
        return f'{self.words}: {errors_in_words(self.checks)}' if self.checks else self.words


class SimulatorFit(NamedTuple):
    """
    What all steps of a fit share.

    Attributes
    ----------
    recording : Recording
        Of commanded strokes without errors.
    names : list of str
        Numbers to be fitted.
    fitted, held_out : list of Samples
    horizons : sequence of float
        Of the fit of the table [s], ascending.
    mapped : callable
        Does the work.
    say : callable
        Called with what is done.

    """

    recording: Recording
    names: list[str]
    fitted: list[Samples]
    held_out: list[Samples]
    horizons: Sequence[float]
    mapped: MapFunction
    say: Callable[[str], object]

    def problem(self, scene: Scene, names: Sequence[str], horizon: float) -> FitProblem:
        """Return the problem to fit numbers of a scene."""
        sought = sought_in(scene, [self.recording], names)
        return FitProblem(self.model(scene), sought, horizon, self.mapped)

    def model(self, scene: Scene) -> CalibrationModel:
        """Return the model of a scene."""
        return calibration_model(scene, [self.recording])

    def checked(self, model: CalibrationModel) -> tuple[Check, ...]:
        """Predict the strokes that were held out, from the command alone."""
        return tuple(check_of(model, each, prior_of(each)[0]) for each in self.held_out)


def fit_to_simulator(work: SimulatorFit, scene: Scene, noise: Noise) -> Calibration:
    """
    Fit a scene to the shots of a simulator.

    Parameters
    ----------
    work : SimulatorFit
    scene : Scene
        With which the fit begins.
    noise : Noise
        Of the player, for the scene that is returned.

    """
    before = work.checked(work.model(scene))
    strike, launches = _fit_strike(work, scene)
    there = strike.problem.model_at(strike.values).scene
    found, tried = _fit_tables(work, there, launches)
    fitted = found.problem.model_at(found.values)
    checks = work.checked(fitted)
    estimates = (
        *estimates_of(strike, strike.problem.sought),
        *estimates_of(found, found.problem.sought),
    )
    error = _model_error(work, fitted)
    notes = [f'effects off: {_effects_off(fitted.scene)}', *map(str, tried)]
    notes.append(
        f'left to errors: speed {1e3 * error.speed:.2g} mm/s, azimuth {error.azimuth_deg:.2g} '
        f'degrees, tip {1e3 * max(error.a, error.b):.2g} mm, balls {1e3 * error.balls:.2g} mm'
    )
    for each in (strike, found):
        if bounded := at_bounds(each):
            notes.append(f'at a bound of its allowed values: {", ".join(bounded)}')
    return Calibration(
        scene=replace(fitted.scene, balls=scene.balls, noise=noise, model_error=error),
        estimates=estimates,
        frames=fitted.frames,
        recordings=(work.recording.name,),
        doubts=tuple(_doubts(found, checks, before)),
        fitted=tuple(each.name for each in work.fitted),
        spins=spins_of([]),
        checks=checks,
        checks_before=before,
        notes=tuple(notes),
        ignored=(),
    )


def _fit_strike(work: SimulatorFit, scene: Scene) -> tuple[JointFit, list[Launch]]:
    """
    Fit the numbers of the cue, and leave out the effects of the strike that the simulator lacks.

    Returns also the launches: what the command is to have more, so that the first way is right.
    """
    names = [name for name in STRIKE_NAMES if name in work.names]
    model = work.model(scene)
    launches = [Launch(each, prior_of(each)[0], known=True) for each in work.fitted]
    firsts = []
    for each in launches:
        contacts = contacts_of(model, each.samples, each.numbers)
        firsts.append(replace(each, until=float(contacts.min(initial=FIRST_WAY))))
    scenes = [scene]
    for name in STRIKE_EFFECTS:
        if getattr(scene.effects, name) != 'off':
            effects = replace(scenes[-1].effects, **{name: 'off'})
            scenes.append(replace(scene, effects=effects))
    tried = []
    for there in scenes:
        work.say(f'cue, effects off: {_effects_off(there)}')
        tried.append(_settled(work.problem(there, names, FIRST_WAY), firsts))
    strike = min(tried, key=lambda each: each.cost)
    free = [replace(each, known=False) for each in strike.launches]
    there = strike.problem.model_at(strike.values).scene
    launched = followed(work.problem(there, [], FIRST_WAY), np.zeros(0), free, strike.scales)
    found = {each.samples.name: each.numbers for each in launched.launches}
    return strike, [
        replace(each, numbers=found.get(each.samples.name, each.numbers)) for each in launches
    ]


def _fit_tables(
    work: SimulatorFit, scene: Scene, launches: Sequence[Launch]
) -> tuple[JointFit, list[Tried]]:
    """Fit the table with each model, and the best one with all horizons; the best one first."""
    names = [name for name in work.names if name not in STRIKE_NAMES]
    rigid = [name for name in names if name != RATIO]
    horizon = min(TRIED_HORIZON, work.horizons[-1])

    def tried(there: Scene, words: str) -> Tried:
        work.say(f'table, {words}')
        assert there.table is not None
        has_spring = there.table.cushion.frequency_ratio > 0.0
        start = work.problem(there, names if has_spring else rigid, horizon)
        found = _settled(start, launches, work.horizons)
        return Tried(words, found, work.checked(found.problem.model_at(found.values)))

    scenes = {model: _with_cushion(scene, model) for model in CUSHIONS}
    all_tried = [tried(there, model) for model, there in scenes.items()]
    best = min(all_tried, key=lambda each: each.score)
    if (instant := _instant(scenes[best.words])) != scenes[best.words]:
        all_tried.append(tried(instant, f'{best.words}, contacts take no time'))
    all_tried.sort(key=lambda each: each.score)
    best = all_tried[0]
    work.say(f'table, {best.words}')
    problem = best.found.problem._replace(horizon=work.horizons[-1])
    return _settled(problem, launches, values=best.found.values, rounds=ROUNDS), all_tried


def _with_cushion(scene: Scene, model: str) -> Scene:
    """Return the scene with another model of the cushion, and the usual numbers of that."""
    assert scene.table is not None
    cushion = scene.table.cushion
    if model == cushion.model:
        return scene
    usual: dict[str, Any] = dict.fromkeys(('restitution', 'friction', 'fading', 'frequency_ratio'))
    other = replace(cushion, model=model, early_fading=0.0, **usual)
    return replace(scene, table=replace(scene.table, cushion=other))


def _instant(scene: Scene) -> Scene:
    """Return the scene with contacts that take no time."""
    assert scene.table is not None
    balls = replace(scene.contacts.ball_ball, duration=0.0)
    cushion = replace(scene.table.cushion, duration=0.0)
    return replace(
        scene,
        contacts=replace(scene.contacts, ball_ball=balls),
        table=replace(scene.table, cushion=cushion),
    )


def _model_error(work: SimulatorFit, model: CalibrationModel) -> ModelError:
    """
    Return the errors of strokes and places that would explain what the fit leaves.

    They are those of the launches that explain shots best, as root mean squares.
    """
    samples = work.held_out or work.fitted
    free = [Launch(each, prior_of(each)[0]) for each in samples]
    problem = FitProblem(model, (), min(TRIED_HORIZON, work.horizons[-1]), work.mapped)
    launches = followed(problem, np.zeros(0), free, FIRST_SCALES).launches
    radius = model.scene.ball.radius
    command = samples[0].command
    assert command is not None
    rows = np.array([each.numbers[:PLACES] for each in launches])
    errors = np.sqrt((rows**2).mean(axis=0)) * sigmas_of(command, radius)
    a, b, elevation, azimuth, speed = errors.tolist()
    places = np.concatenate([each.numbers[PLACES + 2 :] for each in launches])
    return ModelError(
        a=a * radius,
        b=b * radius,
        elevation_deg=math.degrees(elevation),
        azimuth_deg=math.degrees(azimuth),
        speed=speed,
        balls=float(np.sqrt((places**2).mean())),
    )


def _effects_off(scene: Scene) -> str:
    """List the effects of the strike that are off, and whether the cue passes through balls."""
    names = [name for name in STRIKE_EFFECTS if getattr(scene.effects, name) == 'off']
    if not scene.cue.length:
        names.append('the cue as an obstacle')
    return ', '.join(names) or 'none'


def _doubts(found: JointFit, checks: Sequence[Check], before: Sequence[Check]) -> list[str]:
    """Say why a fit did not converge, and what to change; nothing if it did."""
    doubts = []
    if found.next_step()[1] >= SETTLED:
        doubts.append('the numbers still move: ask for more shots, or for none with errors')
    if checks and np.median(rest_errors(checks)) >= np.median(rest_errors(before)):
        doubts.append(
            'strokes held out are predicted no better than before: state the noise if strokes '
            'have errors; else none of the models is that of the simulator'
        )
    return doubts


def _settled(
    problem: FitProblem,
    launches: Sequence[Launch],
    horizons: Sequence[float] = (),
    values: Floats | None = None,
    rounds: int = TRIED_ROUNDS,
) -> JointFit:
    """
    Fit with horizons that grow, with the last one until the numbers stay.

    Samples before the first cushion are nearly exact, so usual errors are small beside those of a
    wrong cushion. The first fit with each horizon has wide scales, which leave no sample out.
    """
    last, scales = problem.horizon, WIDE
    values = np.clip(problem.start if values is None else values, *problem.bounds)
    ladder = [*(each for each in horizons if each < last), last]
    for number, horizon in enumerate([*ladder, *rounds * [last]]):
        wide = number < len(ladder)
        problem = problem._replace(horizon=horizon)
        cut = [
            each
            for each in searched(problem, values, launches, scales, (0,), True)
            if len(each.compared(scales, horizon).samples.times)
        ]
        found = followed(problem, values, cut, WIDE if wide else scales)
        found = fit(found if wide else rescaled(found), STEPS)
        change = np.abs(found.values - values) / found.deviations
        values, scales = found.values, found.scales
        if not wide and change.max(initial=0.0) < SETTLED:
            break
    return found


def rest_errors(checks: Sequence[Check]) -> Floats:
    """Return how far the cue ball is from where it was seen last (shots,) [m]."""
    return np.array([each.errors[each.samples.ball == 0][-1] for each in checks])


def errors_in_words(checks: Sequence[Check]) -> str:
    """Say how far the cue ball is predicted from where it comes to rest."""
    median, most = (100.0 * np.quantile(rest_errors(checks), [0.5, 0.9])).tolist()
    return (
        f'cue ball at rest, {len(checks)} commanded strokes held out: median {median:.1f} cm, '
        f'90 % {most:.1f} cm'
    )
