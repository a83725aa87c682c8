"""
A simulator of others as a table: it is asked for shots, and a scene is fitted to them.

A simulator plays commanded strokes without errors, and tells places exactly. So no launch is
searched. First the cue: its numbers, and the friction of a sliding ball, follow from the cue ball
until it meets anything, in the first half second; and so do the options of the strike. What then
is left of the launches is kept, so that it does not pull the numbers of the table. These are
fitted with each model of the cushion, with contacts that take time and with contacts that take
none. The models compete on strokes that are held out, from the command alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.calibration import launch
from billiard_shot.calibration.fit import (
    at_bounds,
    estimates_of,
    FitProblem,
    followed,
    JointFit,
    Launch,
    sought_in,
)
from billiard_shot.calibration.recording import Floats, RecordedShot, Recording, Samples, Track
from billiard_shot.calibration.result import Calibration, Check, check_of
from billiard_shot.calibration.settle import fit_settled, SETTLED, Work
from billiard_shot.planning.problem import limits_of, raise_for_clearance
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.equipment import CUSHIONS
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import as_floats, check_type, whole
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.scene.player import ModelError
from billiard_shot.shot.stroke import Stroke

SHOTS = 40
"""Number of shots that a simulator is asked for."""

OBJECT_BALL = '1'

FROM_NOSES, APART = 3.0, 6.0
"""Least distances of the balls from the noses and from each other, in ball radii."""

SLOWEST, FASTEST = 0.5, 4.0
"""Speeds of the cue [m/s], as far as the robot of the scene allows them."""

STEEPEST = math.radians(10.0)
"""Largest elevation, unless the cue needs more for clearance [rad]."""

OFF_CENTRE = 0.6
"""Largest offsets of the tip to each side, relative to the robot's limit."""

ASIDE = 2.2
"""How far beside the middle of a ball the strokes at it aim, at most, in ball radii."""

TRIES = 1000
"""How many strokes are drawn until the cue has room."""

BEHIND, LEVEL_SPEED, BEFORE_RETURN = 2.5, 1.0, 0.3
"""
Distance of a ball in the way of the cue from the cue ball, in ball radii; speed of the cue [m/s];
time within which the cue ball does not come back [s].
"""

SIGMA = 1e-4
"""Standard deviation of places that a simulator tells [m]."""

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

DURATIONS = 'contacts.ball_ball.duration', 'table.cushion.duration'
"""Numbers that are 0 if contacts take no time."""

FIRST_WAY = 0.5
"""Time after the strike until which the first way of the cue ball counts [s]."""

TRIED_HORIZON = 3.0
"""Models compete after a fit until so long after the strike [s]."""

TRIED_ROUNDS = 2
"""How often a fit is repeated at its last horizon while models compete, at most."""

WIDE = np.full(len(launch.FIRST_SCALES), 0.05)
"""
Scales of errors while numbers may be far from those of the simulator [m].

Samples before the first cushion are nearly exact, so usual errors are small beside those of a
wrong cushion.
"""

MOST_STEPS = 1 + len(STRIKE_EFFECTS) + len(CUSHIONS) + 2
"""Number of steps that are told, at most."""

CLOSE = 1e-3
"""Errors of a prediction below this count as if they were as large [m]."""


class TrackSimulator(Protocol):
    """A function that plays a stroke, by simulation or with a robot."""

    def __call__(
        self, scene: Scene, stroke: Stroke, errors: np.random.Generator
    ) -> Mapping[str, ArrayLike]:
        """
        Play a stroke with the errors of the player.

        Parameters
        ----------
        scene : Scene
            With the balls as they lie.
        stroke : Stroke
            As it is commanded.
        errors : numpy.random.Generator
            Source of the errors of the execution.

        Returns
        -------
        mapping of str to (n, 3) array_like
            Of each ball, as long as it is on the table: times since the strike, ascending [s], x
            and y [m]. 20 a second are enough.

        Raises
        ------
        ValueError
            If the stroke cannot be played, as when a ball is in the way of the cue.

        """


def without_obstacles(simulator: TrackSimulator, scene: Scene) -> Scene:
    """
    Return the scene with a cue that passes through balls and cushions, if the simulator's does.

    A level cue strikes the cue ball through another one. The cue of the simulator passes if the
    cue ball leaves, and the other ball stays.
    """
    gap = BEHIND * scene.ball.radius
    balls = {CUE_BALL: (0.0, 0.0), OBJECT_BALL: (-gap, 0.0)}
    there = replace(scene, balls=balls, cue=replace(scene.cue, length=0.0))
    stroke = Stroke.from_offsets(0.0, 0.0, 0.0, 0.0, LEVEL_SPEED)
    try:
        tracks = _tracks(balls, simulator(there, stroke, np.random.default_rng(0)))
    except ValueError:
        return scene
    cue, other = (
        float(np.ptp(track.place[track.time < BEFORE_RETURN, 0])) for track in tracks.values()
    )
    return replace(there, balls=scene.balls) if cue > gap and other < SIGMA else scene


def recording_of(
    simulator: TrackSimulator, scene: SceneLike, shots: int = SHOTS, seed: int = 1
) -> Recording:
    """
    Record shots of a simulator, slow and fast ones, at a ball and at cushions.

    Parameters
    ----------
    simulator : TrackSimulator
    scene : Scene, str or Path
        Its table, the limits of its strokes, and its noise: the errors of the simulator.
    shots : int
        At least 1.
    seed : int
        Of places, strokes and errors.

    Raises
    ------
    ValueError
        If an argument makes no sense, or what the simulator returns.

    """
    scene, shots = Scene.load(scene), whole('shots', shots, 1)
    draw = np.random.default_rng(whole('seed', seed, 0))
    played = []
    for number, speed in enumerate(draw.permutation(np.geomspace(SLOWEST, FASTEST, shots))):
        there, stroke = _shot(scene, float(speed), number % 2 == 0, draw)
        tracks = _tracks(there.balls, simulator(there, stroke, draw))
        played.append(RecordedShot(str(number + 1), tracks, CUE_BALL, stroke, scene.noise, 0.0))
    return Recording('simulator', tuple(played), exact=True)


def _shot(
    scene: Scene, speed: float, hits: bool, draw: np.random.Generator
) -> tuple[Scene, Stroke]:
    """Draw places of two balls, and a stroke at the other one or in any direction."""
    if scene.table is None:
        raise ValueError('scene must have a table, got an endless cloth')
    radius, limits = scene.ball.radius, limits_of(scene, None, scene.noise)
    half = 0.5 * np.array([scene.table.length, scene.table.width]) - FROM_NOSES * radius
    for _ in range(TRIES):
        cue, other = draw.uniform(-half, half, (2, 2))
        distance = float(np.linalg.norm(other - cue))
        aside = draw.uniform(-ASIDE, ASIDE) * radius
        azimuth = draw.uniform(-math.pi, math.pi)
        if hits:
            azimuth = math.atan2(*(other - cue)[::-1]) + math.atan2(aside, distance)
        a, b = scene.robot.offset_max * draw.uniform(-OFF_CENTRE, OFF_CENTRE, 2)
        stroke = np.array([[a, b, draw.uniform(0.0, STEEPEST), azimuth, speed]])
        if distance < APART * radius:
            continue
        balls = {CUE_BALL: tuple(cue.tolist()), OBJECT_BALL: tuple(other.tolist())}
        there = replace(scene, balls=balls)
        (stroke,) = raise_for_clearance(there, limits, limits.clip(stroke))
        if np.isfinite(stroke).all():
            return there, Stroke.from_offsets(*stroke.tolist())
    raise ValueError(
        'scene must have room for two balls and the cue, within the limits of its robot'
    )


def _tracks(lying: Mapping[str, Place], seen: Mapping[str, ArrayLike]) -> dict[str, Track]:
    """Check the result of a simulator; put the places before the strike first."""
    check_type('the result of the simulator', seen, Mapping)
    tracks = {}
    for name, place in lying.items():
        if name not in seen:
            raise ValueError(f'simulator must return all balls, got {sorted(seen)} without {name}')
        rows = as_floats(seen[name])
        if rows.ndim != 2 or rows.shape[1] != 3 or not np.isfinite(rows).all():
            wanted = must_be('(n, 3) finite times, x and y', rows.shape)
            raise ValueError(f'simulator: ball {name!r} {wanted} (s, m, m)')
        rows = np.concatenate([[(0.0, *place)], rows[rows[:, 0] > 0.0]])
        if not (np.diff(rows[:, 0]) > 0.0).all():
            raise ValueError(f'simulator: times of ball {name!r} must ascend')
        tracks[name] = Track(rows[:, 0], rows[:, 1:], np.full(len(rows), SIGMA))
    return tracks


class TriedModel(NamedTuple):
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
    work : Work
        Does the work, and is told each step.

    """

    recording: Recording
    names: list[str]
    fitted: list[Samples]
    held_out: list[Samples]
    horizons: Sequence[float]
    work: Work

    def problem(self, scene: Scene, names: Sequence[str]) -> FitProblem:
        """Return the problem to fit numbers of a scene to the first ways of the cue ball."""
        sought = sought_in(scene, [self.recording], names)
        return FitProblem(self.model(scene), sought, FIRST_WAY, self.work.mapped)

    def model(self, scene: Scene) -> launch.CalibrationModel:
        """Return the model of a scene."""
        return launch.calibration_model(scene, [self.recording])

    def checked(self, model: launch.CalibrationModel) -> tuple[Check, ...]:
        """Predict the strokes that were held out, from the command alone."""
        return tuple(check_of(model, each, launch.prior_of(each)[0]) for each in self.held_out)


def fit_to_simulator(task: SimulatorFit, scene: Scene, noise: Noise) -> Calibration:
    """
    Fit a scene to the shots of a simulator.

    Parameters
    ----------
    task : SimulatorFit
    scene : Scene
        With which the fit begins.
    noise : Noise
        Of the player, for the scene that is returned.

    """
    before = task.checked(task.model(scene))
    strike, launches = _fit_strike(task, scene)
    there = strike.problem.model_at(strike.values).scene
    found, tried = _fit_tables(task, there, launches)
    fitted = found.problem.model_at(found.values)
    checks = task.checked(fitted)
    estimates = (
        *estimates_of(strike, strike.problem.sought),
        *estimates_of(found, found.problem.sought),
    )
    error = _model_error(task, fitted)
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
        recordings=(task.recording.name,),
        doubts=tuple(_doubts(found, checks, before)),
        fitted=tuple(each.name for each in task.fitted),
        spins=launch.spins_of([]),
        checks=checks,
        checks_before=before,
        notes=tuple(notes),
        ignored=(),
    )


def _fit_strike(task: SimulatorFit, scene: Scene) -> tuple[JointFit, list[Launch]]:
    """
    Fit the numbers of the cue, and leave out the effects of the strike that the simulator lacks.

    Returns also the launches: what the command is to have more, so that the first way is right.
    """
    names = [name for name in STRIKE_NAMES if name in task.names]
    model = task.model(scene)
    launches = [Launch(each, launch.prior_of(each)[0], known=True) for each in task.fitted]
    firsts = []
    for each in launches:
        contacts = launch.contacts_of(model, each.samples, each.numbers)
        samples = each.samples.until(float(contacts.min(initial=FIRST_WAY)))
        if len(samples.times):
            firsts.append(replace(each, samples=samples))
    scenes = [scene]
    for name in STRIKE_EFFECTS:
        if getattr(scene.effects, name) != 'off':
            effects = replace(scenes[-1].effects, **{name: 'off'})
            scenes.append(replace(scene, effects=effects))
    tried = []
    for there in scenes:
        task.work.begin(f'cue, effects off: {_effects_off(there)}', 1)
        problem = task.problem(there, names)
        tried.append(fit_settled(problem, problem.start, firsts, [FIRST_WAY], wide=WIDE)[0])
    strike = min(tried, key=lambda each: each.cost)
    free = [replace(each, known=False) for each in strike.launches]
    there = strike.problem.model_at(strike.values).scene
    launched = followed(task.problem(there, []), np.zeros(0), free, strike.scales)
    found = {each.samples.name: each.numbers for each in launched.launches}
    return strike, [
        replace(each, numbers=found.get(each.samples.name, each.numbers)) for each in launches
    ]


def _fit_tables(
    task: SimulatorFit, scene: Scene, launches: Sequence[Launch]
) -> tuple[JointFit, list[TriedModel]]:
    """Fit the table with each model, and the best one with all horizons; the best one first."""
    names = [name for name in task.names if name not in STRIKE_NAMES]
    rigid = [name for name in names if name != RATIO]
    horizons = [each for each in task.horizons if each < TRIED_HORIZON]
    horizons.append(min(TRIED_HORIZON, task.horizons[-1]))

    def tried(there: Scene, words: str) -> TriedModel:
        task.work.begin(f'table, {words}', 1)
        assert there.table is not None
        has_spring = there.table.cushion.frequency_ratio > 0.0
        problem = task.problem(there, names if has_spring else rigid)
        found, _ = fit_settled(
            problem, problem.start, launches, horizons, rounds=TRIED_ROUNDS, wide=WIDE
        )
        return TriedModel(words, found, task.checked(found.problem.model_at(found.values)))

    scenes = {model: _with_cushion(scene, model) for model in CUSHIONS}
    all_tried = [tried(there, model) for model, there in scenes.items()]
    best = min(all_tried, key=lambda each: each.score)
    instant = scenes[best.words].with_parameters(DURATIONS, [0.0] * len(DURATIONS))
    if instant != scenes[best.words]:
        all_tried.append(tried(instant, f'{best.words}, contacts take no time'))
    all_tried.sort(key=lambda each: each.score)
    best = all_tried[0]
    task.work.begin(f'table, {best.words}', 1)
    found, _ = fit_settled(
        best.found.problem, best.found.values, launches, task.horizons[-1:], wide=WIDE
    )
    return found, all_tried


def _with_cushion(scene: Scene, model: str) -> Scene:
    """Return the scene with another model of the cushion, and the usual numbers of that."""
    assert scene.table is not None
    cushion = scene.table.cushion
    if model == cushion.model:
        return scene
    usual: dict[str, Any] = dict.fromkeys(('restitution', 'friction', 'fading', 'frequency_ratio'))
    other = replace(cushion, model=model, early_fading=0.0, **usual)
    return replace(scene, table=replace(scene.table, cushion=other))


def _model_error(task: SimulatorFit, model: launch.CalibrationModel) -> ModelError:
    """
    Return the errors of strokes and places that would explain what the fit leaves.

    They are those of the launches that explain shots best, as root mean squares.
    """
    samples = task.held_out or task.fitted
    free = [Launch(each, launch.prior_of(each)[0]) for each in samples]
    problem = FitProblem(model, (), min(TRIED_HORIZON, task.horizons[-1]), task.work.mapped)
    launches = followed(problem, np.zeros(0), free, launch.FIRST_SCALES).launches
    radius = model.scene.ball.radius
    command = samples[0].command
    assert command is not None
    rows = np.array([each.numbers[: launch.PLACES] for each in launches])
    errors = np.sqrt((rows**2).mean(axis=0)) * launch.sigmas_of(command, radius)
    places = np.concatenate([each.numbers[launch.PLACES + 2 :] for each in launches])
    balls = np.sqrt((places**2).mean())
    return ModelError(*np.append(launch.units(radius) * errors, balls).tolist())


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
