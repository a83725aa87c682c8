"""`calibrate`: the numbers of a scene that recorded shots decide."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
import math

import numpy as np

from billiard_shot.calibration import settle
from billiard_shot.calibration.fit import (
    at_bounds,
    BETTER,
    decided,
    differing,
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
    with_all_samples,
)
from billiard_shot.calibration.launch import (
    calibration_model,
    CalibrationModel,
    FIRST_SCALES,
    prior_of,
    spins_of,
)
from billiard_shot.calibration.reader import read_recordings, Recordings
from billiard_shot.calibration.recording import (
    check_enough,
    Floats,
    Recording,
    Samples,
    usable_shots,
)
from billiard_shot.calibration.result import Calibration, Check, Estimate, searched_check
from billiard_shot.calibration.simulator import (
    fit_to_simulator,
    MOST_STEPS,
    RATIO,
    recording_of,
    SHOTS,
    SimulatorFit,
    TrackSimulator,
    without_obstacles,
)
from billiard_shot.scene import fields, Noise, Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.player import NOISES

FIRST_HORIZON, HORIZON, GROWTH = 0.8, 8.0, 3.0
"""First and last time after the strike that count for common numbers [s], and their ratio."""

FAR = 10.0
"""How many deviations away numbers elsewhere lie, if these are within half of their ranges."""

WITNESSES = 8
"""Number of shots that tell whether numbers elsewhere are better."""

BEGINNING, MODEL_SIGMA, UNEXPLAINED = 0.5, 8e-3, 6.0
"""
A shot is not explained if the median square of the errors of its struck ball, until the first time
[s] after the strike, exceeds by the last factor that of the tracker together with that of models
of real tables, whose deviation is the second number [m].
"""

MOST_UNEXPLAINED = 0.1
"""Part of the shots that may not be explained."""

GAIN, LOSS = 0.95, 1.25
"""
Median ratios of the errors of shots held out, now to before: a fit that changes the scene must be
below the first one, and one that confirms it below the second one.
"""


def calibrate(
    recordings: Recordings | TrackSimulator,
    scene: SceneLike | None = None,
    *,
    names: Sequence[str] | None = None,
    held_out: float = 0.25,
    horizon: float = HORIZON,
    seed: int = 1,
    executor: Executor | None = None,
    progress: Callable[[settle.FitProgress], object] | None = None,
    noise: Noise | None = None,
    shots: int = SHOTS,
) -> Calibration:
    """
    Fit a scene to recorded shots.

    Each shot has a launch of its own: velocity and spin of the struck ball, the time of the
    strike, and the places of the balls. What all shots have in common is fitted with a horizon
    that grows. A number that the shots do not decide keeps the value of the scene. If strokes were
    commanded, launches follow from them, and numbers of the cue are fitted, too.

    Parameters
    ----------
    recordings : Recording, str, Path, or sequence of these; or TrackSimulator
        Recordings of one table, or their files, see `read_recording`. Or a simulator, which is
        asked for shots, see `recording_of`, and with which models are compared, see
        simulator.py.
    scene : Scene, str or Path, optional
        With which the fit begins; by default the one that the first recording names.
    names : sequence of str, optional
        Numbers to be fitted, see `Scene.parameters`; by default `USUAL_NAMES`, and `CUE_NAMES` if
        strokes were commanded.
    held_out : float
        Part of the shots that are not fitted, but tell how well the scene predicts, 0 to 0.9.
    horizon : float
        Longest time after the strike that counts [s], above 0.
    seed : int
        The same seed gives the same result.
    executor : concurrent.futures.Executor, optional
        Does the work; by default this thread does.
    progress : callable, optional
        Called with a `FitProgress`.
    noise : Noise, optional
        Errors of the strokes of a simulator, or of a robot that is called as one. By default there
        are none: whoever plays for the scene may have others, those of its `noise`.
    shots : int
        Number of strokes that a simulator is asked for.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError
        If an argument or a file makes no sense, or too few shots can be used.

    """
    exact: Scene | None = None
    if callable(recordings):
        if scene is None:
            raise refused(scene, 'given for a simulator', 'scene')
        scene = Scene.load(scene)
        played = replace(scene, noise=noise or NOISES['none'])
        if noise is None:
            exact = played = without_obstacles(recordings, played)
        recordings = recording_of(recordings, played, shots, seed)
    read = read_recordings(recordings)
    scene = _named_scene(read) if scene is None else Scene.load(scene)
    share = fields.as_float(held_out)
    if not 0.0 <= share <= 0.9:
        raise refused(held_out, 'a number from 0 to 0.9', 'held_out')
    horizons = _horizons(fields.positive('horizon', horizon, 's'))
    seed = fields.whole('seed', seed, 0)
    sought = sought_in(scene, read, names)
    usable, ignored, notes = usable_shots(scene, read)
    order = np.random.default_rng(seed).permutation(len(usable)).tolist()
    count = round(share * len(usable))
    tested, used = ([usable[k] for k in sorted(part)] for part in (order[:count], order[count:]))
    hint = '; --held-out 0 (held_out=0) holds none out' if count else ''
    check_enough(
        len(used), settle.LEAST_SHOTS, 'usable shots beside those held out', ignored, hint
    )
    mapped: MapFunction = map if executor is None else executor.map
    if exact is not None:
        wanted = [each.name for each in sought] + ([RATIO] if names is None else [])
        work = settle.Work(mapped, progress, MOST_STEPS)
        task = SimulatorFit(read[0], wanted, used, tested, horizons, work)
        result = fit_to_simulator(task, exact, scene.noise)
        return replace(result, ignored=tuple(ignored))
    stages = len(horizons) + settle.ROUNDS
    work = settle.Work(mapped, progress, stages * len(used) + 2 * len(tested))
    model = calibration_model(scene, read)
    launches = [Launch(each, prior_of(each)[0]) for each in used]
    begin = FitProblem(model, sought, horizons[0], mapped)
    found, doubts = settle.fit_settled(
        begin,
        begin.start,
        launches,
        horizons,
        seed=seed,
        work=work,
        elsewhere=partial(looked_elsewhere, work),
    )
    work.reach(stages * len(used))
    found = decided(found, settle.STEPS, work.say_error)
    fitted = found.problem.model_at(found.values)
    checks, checks_before = (_checked(by, tested, seed, work) for by in (fitted, model))
    estimates = estimates_of(found, sought)
    doubts += unexplained(found)
    doubts += no_gain(checks, checks_before, estimates)
    if bounded := at_bounds(found):
        notes.append(f'at a bound of its allowed values: {", ".join(bounded)}')
    return Calibration(
        scene=replace(fitted.scene, balls=scene.balls),
        estimates=estimates,
        frames=fitted.frames,
        recordings=tuple(each.name for each in read),
        doubts=tuple(doubts),
        fitted=tuple(each.samples.name for each in found.launches),
        spins=spins_of([each.numbers for each in found.launches if each.samples.command is None]),
        checks=checks,
        checks_before=checks_before,
        notes=tuple(notes),
        ignored=tuple(ignored),
    )


def _named_scene(recordings: Sequence[Recording]) -> Scene:
    """Load the scene that a recording names; ValueError if none does."""
    for each in recordings:
        if each.scene is not None:
            return Scene.load(each.scene)
    raise ValueError(
        f'scene is missing: {recordings[0].name} has no description (.yaml) that names one'
    )


def _horizons(last: float) -> list[float]:
    """Return the horizons of a fit [s]."""
    horizons, horizon = [last], last / GROWTH
    while horizon >= FIRST_HORIZON:
        horizons.insert(0, horizon)
        horizon /= GROWTH
    return horizons


def looked_elsewhere(
    work: settle.Work, found: JointFit, seed: Sequence[int]
) -> tuple[Floats | None, list[str]]:
    """
    Return numbers elsewhere that fit some of the shots better; None if there are none.

    Launches may hide that numbers are wrong, and no small step then leads away: launches would
    have to jump. So fits begin anew at two pairs of opposite places. All samples until the horizon
    judge them, also those that a fit leaves out. Returns also in which numbers a fit differs that
    is as good.
    """
    problem = found.problem
    doubts: list[str] = []
    launches = with_all_samples(found.launches[:WITNESSES])

    def cost(values: Floats, launches: Sequence[Launch]) -> float:
        there = problem._replace(model=problem.model_at(values), sought=())
        return followed(there, np.zeros(0), with_all_samples(launches), FIRST_SCALES).cost

    if not len(found.values):
        return None, []
    least = cost(found.values, launches)
    reach = np.minimum(0.5 * problem.widths, FAR * found.deviations)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], len(reach))
    others = signs * np.resize([1.0, -1.0], len(reach))  # half of them are turned round
    for away in (signs, -signs, others, -others):
        values = np.clip(found.values + reach * away, *problem.bounds)
        moved = searched(problem, values, launches, FIRST_SCALES, seed, True)
        if len(moved) < len(launches):
            continue  # these numbers cannot be
        there = rescaled(followed(problem, values, moved, FIRST_SCALES))
        there = fit(there, settle.STEPS, work.say_error)
        more = cost(there.values, there.launches) - least
        if more < -BETTER:
            return there.values, []
        if more < BETTER and not doubts and (both := differing(found, there)):
            doubts.append(f'ambiguous: another fit is as good, with {"; ".join(both)}')
    return None, doubts


def unexplained(found: JointFit) -> list[str]:
    """Name the shots whose beginning is not explained, if these are too many."""
    names, launches = [], with_all_samples(found.launches)
    for each in followed(found.problem, found.values, launches, found.scales).shots:
        samples = each.launch.samples.until(found.problem.horizon)
        ratios = each.errors**2 / (2.0 * (samples.sigma**2 + MODEL_SIGMA**2))
        first = (each.times < BEGINNING) & (samples.ball == 0)
        if first.any() and np.median(ratios[first]) > UNEXPLAINED:
            names.append(samples.name)
    if len(names) > MOST_UNEXPLAINED * len(launches):
        return [f'no launch explains the first {BEGINNING:g} s of shots {", ".join(names)}']
    return []


def _checked(
    model: CalibrationModel, tested: Sequence[Samples], seed: int, work: settle.Work
) -> tuple[Check, ...]:
    """Predict shots that were not fitted; leave out those without any launch."""
    work.begin('shots held out')
    items = [(each, (seed, number)) for number, each in enumerate(tested)]
    found = work.ticking(partial(searched_check, model, np.inf), items)
    return tuple(each for each in found if each is not None)


def no_gain(
    checks: Sequence[Check], before: Sequence[Check], estimates: Sequence[Estimate]
) -> list[str]:
    """
    Say that shots held out are predicted no better than before, if they are not.

    A fit confirms the scene, and may be as good, if no number moves by more than the width of its
    interval.
    """
    confirms = all(
        each.interval is None
        or abs(each.value - each.before) <= each.interval[1] - each.interval[0]
        for each in estimates
    )
    errors = {each.samples.key: max(each.rmse(), _tracking(each)) for each in before}
    ratios = {
        each.samples.name: each.rmse() / errors[each.samples.key]
        for each in checks
        if each.samples.key in errors
    }
    if not ratios or np.median([*ratios.values()]) < (LOSS if confirms else GAIN):
        return []
    worse = ', '.join(name for name, ratio in ratios.items() if ratio > GAIN)
    return [f'shots held out are predicted no better than by the scene before: {worse}']


def _tracking(shot: Check) -> float:
    """Return an error of a shot that those of the tracker explain, twice their mean [m]."""
    return 2.0 * math.sqrt(2.0) * float(np.median(shot.samples.sigma))
